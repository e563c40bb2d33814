"""Limits of sequences of solutions: Richardson extrapolation with the observed order, and where it does not hold."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import root_scalar

ORDERS = (0.5, 4.5)
"""Orders that a method can have; an observed one outside is no order."""
ALIGNED = 0.5
"""Smallest cosine between successive changes of a sequence that goes one way."""
LUCK = 0.1
"""Least uncertainty of a limit without an order, over the largest difference among the three finest solutions."""
TWO_GRIDS = 3.0
"""Safety factor on the change between two solutions where no third one gives an order (Roache 1994)."""


@dataclass(frozen=True, eq=False)
class Limit:
    """Where a sequence of solutions goes.

    Attributes:
        value: shape [n].
        uncertainty: root mean square over the n values, in their unit.
        order: observed, from the three finest; None where there is none.
        behaviour: "asymptotic", "no effect", or why the sequence is not in its asymptotic range.
    """

    value: np.ndarray
    uncertainty: float
    order: float | None
    behaviour: str

    @property
    def asymptotic(self) -> bool:
        """Whether extrapolation holds."""
        return self.behaviour == "asymptotic"


def rms(values: np.ndarray) -> float:
    """Root mean square, the discrete L2 norm of a curve on an even grid."""
    return float(np.sqrt(np.mean(np.square(values))))


def observed_order(sizes: np.ndarray, ratio: float) -> float | None:
    """Order p at which errors C h^p change in a given ratio.

    Args:
        sizes: h1 > h2 > h3, in any ratio.
        ratio: |f(h1) - f(h2)| over |f(h2) - f(h3)|.

    Returns:
        p, or None where no p in (0.02, 20) fits: the changes do not shrink as any power would have them.
    """
    a, b = sizes[1] / sizes[0], sizes[2] / sizes[0]

    def gap(p: float) -> float:
        return (1.0 - a**p) - ratio * (a**p - b**p)

    if not np.isfinite(ratio) or gap(0.02) * gap(20.0) >= 0.0:
        return None
    return float(root_scalar(gap, bracket=(0.02, 20.0)).root)


def extrapolate(sizes: np.ndarray, values: np.ndarray, floor: float = 0.0) -> Limit:
    """The limit of solutions at falling sizes.

    Three or more solutions whose last two changes go one way and shrink by an order in `ORDERS` are extrapolated with
    that order. The limit is then uncertain by its distance from the finest solution or, where the three solutions
    before the finest extrapolate too, by the change of the limit (and no less than a quarter of that distance). Else
    the limit is the finest solution, uncertain by the largest difference among the three finest; where the last change
    is no larger than first order would leave of the one before, by what first order would leave of the last.

    Args:
        sizes: falling, shape [m].
        values: solutions, shape [m, n].
        floor: changes below it are noise.

    Raises:
        ValueError: sizes that do not fall.
    """
    sizes, values = np.asarray(sizes, dtype=float), np.asarray(values, dtype=float)
    if sizes.size == 0 or np.any(np.diff(sizes) >= 0.0) or sizes[-1] <= 0.0:
        raise ValueError("sizes must fall and be positive")
    if sizes.size == 1:
        return Limit(values[0], float("inf"), None, "one level only")
    if sizes.size == 2:
        return Limit(values[-1], TWO_GRIDS * rms(values[0] - values[1]), None, "two levels only")
    limit = _extrapolate_three(sizes[-3:], values[-3:], floor)
    if not limit.asymptotic or sizes.size == 3:
        return limit
    before = _extrapolate_three(sizes[-4:-1], values[-4:-1], floor)
    if not before.asymptotic:
        return limit
    uncertainty = max(rms(limit.value - before.value), 0.25 * limit.uncertainty)
    return Limit(limit.value, uncertainty, limit.order, limit.behaviour)


def _extrapolate_three(sizes: np.ndarray, values: np.ndarray, floor: float) -> Limit:
    coarse, fine = (before - after for before, after in pairwise(values))
    sizes_of_changes = rms(coarse), rms(fine)
    spread = max(*sizes_of_changes, rms(values[0] - values[2]))
    first_order = sizes_of_changes[1] * sizes[2] / (sizes[1] - sizes[2])
    shrinks = sizes_of_changes[1] * (sizes[0] - sizes[1]) <= sizes_of_changes[0] * (sizes[1] - sizes[2])
    bound = min(max(first_order, sizes_of_changes[1], LUCK * spread), spread) if shrinks else spread

    def unsettled(why: str, order: float | None = None) -> Limit:
        return Limit(values[2], bound, order, why)

    if spread <= floor:
        return Limit(values[2], spread, None, "no effect")
    if sizes_of_changes[1] == 0.0:
        return unsettled("not asymptotic: the last two are equal")
    if np.mean(coarse * fine) < ALIGNED * sizes_of_changes[0] * sizes_of_changes[1]:
        return unsettled("not asymptotic: goes back and forth")
    order = observed_order(sizes, sizes_of_changes[0] / sizes_of_changes[1])
    if order is None:
        return unsettled("not asymptotic: the changes do not shrink")
    if not ORDERS[0] <= order <= ORDERS[1]:
        return unsettled(f"not asymptotic: order {order:.1f}", order)
    step = fine * sizes[2] ** order / (sizes[1] ** order - sizes[2] ** order)
    return Limit(values[2] - step, rms(step), order, "asymptotic")


def pareto_front(costs: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Entries that no other beats in cost and error at once.

    Args:
        costs: shape [n].
        errors: shape [n]; NaN never counts.

    Returns:
        Their indices by rising cost.
    """
    front: list[int] = []
    best = np.inf
    for i in np.lexsort((errors, costs)):
        if errors[i] < best:
            best = errors[i]
            front.append(int(i))
    return np.array(front, dtype=int)
