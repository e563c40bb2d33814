"""Mapping with temporary displacements, polynomial in arclength, which keep the stretch of the centreline small.

Source: Aymon, Derveni, Gomez, Crassous and Reis, Extreme Mech. Lett. 81, 102413 (2025), appendix A.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import ArrayLike

from knotfem.errors import InputError, NotConverged
from knotfem.geometry.slices import Slices
from knotfem.geometry.vectors import unit
from knotfem.tie.direction import candidate_directions
from knotfem.tie.extremes import extreme_stretches
from knotfem.tie.minimax import Minimax, Shape
from knotfem.tie.path import CentrelinePath, check_slices, check_target, check_time, straight_rod, stretch_range
from knotfem.types import Array

_STARTS = 4
"""Number of directions halfway to the target from which the search begins."""

_NEARLY = 1.1
"""Results of the search with less than this times the smallest deviation are refined."""

_HIGHEST_DEGREE = 40


@dataclass(frozen=True, kw_only=True)
class PolynomialPath(CentrelinePath):
    """x_i(t) = (1 - t) X_i + t x_i + t (1 - t) v_i, which is Eq. (A.3) with u_i = x_i - X_i.

    Attributes:
        straight: X, the straight rod, shape (n + 1, 3), mm.
        target: x, shape (n + 1, 3), mm.
        temporary: v, shape (n + 1, 3), mm.
        coefficients: v_i = sum_j coefficients[j] P_j(2 s_i / L - 1), Legendre polynomials of the arclength s, shape
            (p + 1, 3), mm.
        direction: unit vector E of the straight rod, shape (3,).
        slices: edges of the straight rod, mm.
        search: how the coefficients were found, as values that JSON can hold.
        kind: name of the mapping.
    """

    straight: Array
    target: Array
    temporary: Array
    coefficients: Array
    direction: Array
    slices: Slices
    search: dict[str, Any]
    kind: str = "polynomial"

    def at(self, t: float) -> Array:
        """Return the vertices at mapping time t, shape (n + 1, 3), mm."""
        t = check_time(t)
        return (1.0 - t) * self.straight + t * self.target + t * (1.0 - t) * self.temporary

    def describe(self) -> dict[str, Any]:
        """Return direction, degree, coefficients, exact extreme stretches over all times, and facts of the search."""
        h = self.slices.lengths[:, None]
        edges, temporary = np.diff(self.target, axis=0) / h, np.diff(self.temporary, axis=0) / h
        return {
            "kind": self.kind,
            "direction": self.direction.tolist(),
            "degree": len(self.coefficients) - 1,
            "coefficients_mm": self.coefficients.tolist(),
            **stretch_range(extreme_stretches(self.direction, edges, temporary)[1]),
            **self.search,
        }


def polynomial_path(
    target: ArrayLike,
    *,
    degree: int = 8,
    threshold: float = 0.3,
    refine: bool = False,
    direction: Literal["best"] | ArrayLike = "best",
    start: ArrayLike | None = None,
    slices: Slices | None = None,
) -> PolynomialPath:
    """Mapping whose temporary displacements minimise max |lambda - 1| over all edges and all mapping times.

    The source bounds |Lambda_max - 1| with the largest stretch Lambda_max, Eqs. (A.4) and (A.5), which does not limit
    compression; here both extension and compression are bounded. The search is deterministic. It begins at the shape
    of the inextensible mapping at t = 1/2, for several directions.

    Args:
        target: vertices of the knotted centreline, shape (n + 1, 3), mm.
        degree: p of the polynomial.
        threshold: largest |lambda - 1| allowed.
        refine: minimise |lambda - 1| instead of stopping at the threshold.
        direction: of the straight rod, or "best" to optimise it too.
        start: position of the straight rod's first vertex, shape (3,), mm; by default the rod's middle lies at the
            target's centroid. It has no influence on the stretch.
        slices: edges of the straight rod, mm; by default all as long as the mean chord of the target.

    Raises:
        InputError: the target, degree, threshold or direction is not valid.
        NotConverged: the search does not reach the threshold; the message says what it has reached.
    """
    began = time.perf_counter()
    points = check_target(target)
    rest = check_slices(slices, points)
    edges = np.diff(points, axis=0) / rest.lengths[:, None]
    _check_arguments(edges, degree, threshold, direction)
    legendre = legvander(_interval(rest), degree)
    h = rest.lengths[0]
    basis, triangle = np.linalg.qr(np.diff(legendre[:, 1:], axis=0) / (rest.lengths / h)[:, None])
    problem = Minimax(edges, basis, isinstance(direction, str), 0.0 if refine else threshold)
    best, descents = _search(problem, direction)
    if best.deviation >= threshold:
        raise NotConverged(
            f"temporary displacements of degree {degree} keep max |lambda - 1| at {best.deviation:.4g}, "
            f"not under the threshold {threshold:g}, from {descents} starts; "
            "a higher degree, the direction 'best' or the inextensible path helps"
        )
    coefficients = np.zeros((degree + 1, 3))
    coefficients[1:] = np.linalg.solve(triangle, best.weights) * h
    coefficients[0] = -(legendre[:, 1:] @ coefficients[1:]).mean(axis=0)
    return PolynomialPath(
        straight=straight_rod(points, best.direction, rest, start),
        target=points,
        temporary=legendre @ coefficients,
        coefficients=coefficients,
        direction=best.direction,
        slices=rest,
        search={
            "threshold": float(threshold),
            "refined": bool(refine),
            "direction_optimised": problem.free_direction,
            "descents": descents,
            "seconds": time.perf_counter() - began,
        },
    )


def _interval(slices: Slices) -> Array:
    """Arclength of the vertices, taken to -1 to 1, shape (n + 1,)."""
    return np.linspace(-1.0, 1.0, slices.count + 1) if slices.equal else 2.0 * slices.fractions - 1.0


def _check_arguments(edges: Array, degree: int, threshold: float, direction: str | ArrayLike) -> None:
    """Raise InputError for what `polynomial_path` cannot use; edges of the target over those it has when straight."""
    highest = min(len(edges), _HIGHEST_DEGREE)
    if isinstance(degree, bool) or not isinstance(degree, int | np.integer) or not 1 <= degree <= highest:
        raise InputError(
            "wrong degree of the temporary displacement", found=degree, expected=f"an integer, 1 to {highest}"
        )
    if not 0.0 < threshold < np.inf:
        raise InputError("wrong stretch threshold", found=threshold, expected="a positive number")
    lengths = np.linalg.norm(edges, axis=1)
    if np.abs(lengths - 1.0).max() >= threshold:
        raise InputError(
            "the target's own chords differ from the straight rod's by more than the stretch threshold",
            found=f"{lengths.min():.4g} to {lengths.max():.4g} of those of the straight rod",
            expected=f"within {threshold:g}: resample by equal chords",
        )
    if isinstance(direction, str) and direction != "best":
        raise InputError("wrong direction of the straight rod", found=direction, expected="'best' or three numbers")


def _search(problem: Minimax, direction: str | ArrayLike) -> tuple[Shape, int]:
    """Best parameters that descents from several first guesses reach, and the number of descents.

    Descents stop at the first that is below the problem's threshold. If none is, the best ones are refined.
    """
    lengths = np.linalg.norm(problem.end, axis=1)
    halfway = list(candidate_directions(problem.end / lengths[:, None], _STARTS))
    if problem.free_direction:
        guesses = [problem.first_guess(towards, towards) for towards in halfway]
    else:
        given = unit(direction)
        guesses = [problem.first_guess(given, towards) for towards in (given, *halfway)]
    guesses.sort(key=lambda guess: guess.deviation)
    reached = guesses[:1]
    descents = 0
    while reached[0].deviation >= problem.threshold and descents < len(guesses):
        reached.append(problem.descend(guesses[descents]))
        reached.sort(key=lambda shape: shape.deviation)
        descents += 1
    best = reached[0]
    if best.deviation >= problem.threshold:
        polished = [problem.polish(shape) for shape in reached if shape.deviation < _NEARLY * best.deviation]
        best = min(polished, key=lambda shape: shape.deviation)
    return best, descents
