"""Errors of rungs: against the limit of their own ladder, and against a bounded reference of the whole scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from knotfem.cost.closed_forms import ClosedForm
from knotfem.cost.convergence import Limit, extrapolate, rms
from knotfem.cost.ladders import SIZED
from knotfem.cost.measured import Measured, values_of
from knotfem.cost.quantities import scale_of

NOISE = 1e-5
"""Changes of a quantity below this share of it say nothing: Newton's tolerance allows them."""


APART = 1.1
"""Rungs whose sizes differ by less say nothing about an order."""


@dataclass(frozen=True, eq=False)
class Reference:
    """What errors of a quantity are taken against.

    Attributes:
        value: shape [n].
        scale: what errors are divided by, see `scale_of`.
        uncertainty: of the reference itself, as a share of the scale.
        source: for people.
    """

    value: np.ndarray
    scale: float
    uncertainty: float
    source: str

    def error(self, value: np.ndarray) -> float:
        """Relative error of a value, in the L2 sense where it is a curve."""
        return rms(value - self.value) / self.scale


def ladder_limits(ladders: dict[str, list[Measured]], name: str) -> dict[str, Limit]:
    """Limit of a quantity in each ladder of sizes.

    Args:
        ladders: rungs that are done, the base among them, by ladder.
        name: of the quantity.
    """
    limits = {}
    for ladder in SIZED:
        rungs = falling(ladders.get(ladder, []))
        if len(rungs) > 1:
            values = values_of(rungs, name)
            limits[ladder] = extrapolate(
                np.array([entry.size for entry in rungs]), values, NOISE * scale_of(name, values[-1])
            )
    return limits


def falling(rungs: Sequence[Measured]) -> list[Measured]:
    """Rungs that are done by falling size; of those closer than `APART`, the finest."""
    found: list[Measured] = []
    for entry in sorted((entry for entry in rungs if entry.done and entry.size), key=lambda entry: entry.size or 0.0):
        if not found or (entry.size or 0.0) > APART * (found[-1].size or 0.0):
            found.append(entry)
    return found[::-1]


def references(
    name: str, base: np.ndarray, limits: dict[str, Limit], theory: ClosedForm | None = None
) -> list[Reference]:
    """References that a quantity has, the least uncertain first.

    Penetrations have an exact one, none. Else: the limit of the ladder that refines everything; the scene as it is
    plus what each other ladder's limit adds to it, uncertain by the sum of theirs (errors of separate choices add up
    to first order); the closed form.

    Args:
        name: of the quantity.
        base: its value in the scene as it is, shape [n].
        limits: by ladder.
        theory: the scene's closed form.
    """
    scale = scale_of(name, base)
    if name == "penetration":
        return [Reference(np.zeros(1), scale, 0.0, "exact: surfaces do not overlap")]
    found = []
    if "uniform" in limits:
        limit = limits["uniform"]
        found.append(_reference(name, limit.value, limit.uncertainty, f"all refined at once, {_said(limit)}"))
    single = {ladder: limit for ladder, limit in limits.items() if ladder != "uniform"}
    if single:
        value = base + sum((limit.value - base for limit in single.values()), np.zeros_like(base))
        uncertainty = sum(limit.uncertainty for limit in single.values())
        found.append(_reference(name, value, uncertainty, f"limits of {', '.join(single)} added up"))
    if theory is not None and theory.quantity == name:
        found.append(Reference(np.full(1, theory.value), abs(theory.value), theory.bound, theory.source))
    return sorted(found, key=lambda reference: reference.uncertainty)


def _reference(name: str, value: np.ndarray, uncertainty: float, source: str) -> Reference:
    scale = scale_of(name, value)
    return Reference(value, scale, uncertainty / scale, source)


def _said(limit: Limit) -> str:
    return f"extrapolated with order {limit.order:.2f}" if limit.asymptotic else limit.verdict
