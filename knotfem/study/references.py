"""Errors of levels: against the limit of their own series, and against a bounded reference of the whole scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from knotfem.study.closed_forms import ClosedForm
from knotfem.study.extrapolation import Limit, extrapolate, rms
from knotfem.study.measured import Measured, values_of
from knotfem.study.quantities import scale_of
from knotfem.study.refinement import SIZED

NOISE = 1e-5
"""Relative changes of a quantity below this say nothing: Newton's tolerance allows them."""


APART = 1.1
"""Levels whose sizes differ by less say nothing about an order."""
MESH = ("section", "slice")
"""Series that refine the mesh alone, in whose place another element can stand."""


@dataclass(frozen=True, eq=False)
class Reference:
    """What errors of a quantity are taken against.

    Attributes:
        value: shape [n].
        scale: what errors are divided by, see `scale_of`.
        uncertainty: of the reference itself, as a fraction of the scale; infinite where nothing bounds it.
        source: for people.
        lacks: series without whose limits it is no bound.
    """

    value: np.ndarray
    scale: float
    uncertainty: float
    source: str
    lacks: tuple[str, ...] = ()

    def error(self, value: np.ndarray) -> float:
        """Relative error of a value, in the L2 sense where it is a curve."""
        return rms(value - self.value) / self.scale


def series_limits(series: dict[str, list[Measured]], name: str) -> dict[str, Limit]:
    """Limit of a quantity in each series whose levels have sizes.

    Args:
        series: levels that are done, the base among them, by series.
        name: of the quantity.
    """
    limits = {}
    for one in SIZED:
        levels = falling(series.get(one, []))
        if len(levels) > 1:
            values = values_of(levels, name)
            limits[one] = extrapolate(
                np.array([entry.size for entry in levels]), values, NOISE * scale_of(name, values[-1])
            )
    return limits


def falling(levels: Sequence[Measured]) -> list[Measured]:
    """Levels that are done by falling size; of those closer than `APART`, the finest."""
    found: list[Measured] = []
    for entry in sorted((entry for entry in levels if entry.done and entry.size), key=lambda entry: entry.size or 0.0):
        if not found or (entry.size or 0.0) > APART * (found[-1].size or 0.0):
            found.append(entry)
    return found[::-1]


def added_up(base: np.ndarray, limits: Mapping[str, Limit]) -> Limit:
    """The scene as it is plus what the limit of each series adds: errors of separate choices add up to first order.

    Args:
        base: a quantity in the scene as it is, shape [n].
        limits: by series, one at least.
    """
    value = base + sum((limit.value - base for limit in limits.values()), np.zeros_like(base))
    uncertainty = sum(limit.uncertainty for limit in limits.values())
    return Limit(value, uncertainty, None, f"limits of {', '.join(limits)} added up")


def mesh_limit(base: np.ndarray, limits: Mapping[str, Limit]) -> Limit | None:
    """Limit of the mesh with all else as it is; None without the limits of section and slice."""
    found = {series: limits[series] for series in MESH if series in limits}
    return added_up(base, found) if len(found) == len(MESH) else None


def references(
    name: str,
    base: np.ndarray,
    limits: dict[str, Limit],
    theory: ClosedForm | None = None,
    needed: Sequence[str] = (),
) -> list[Reference]:
    """References that a quantity has, the least uncertain first.

    Penetrations have an exact one, none. Else: the limit of the series that refines everything; the scene as it is
    plus what the limit of each other series adds to it, uncertain by the sum of theirs, without bound where one is
    missing;
    the closed form.

    Args:
        name: of the quantity.
        base: its value in the scene as it is, shape [n].
        limits: by series.
        theory: the scene's closed form.
        needed: series that the scene has, `uniform` left out.
    """
    scale = scale_of(name, base)
    if name == "penetration":
        return [Reference(np.zeros(1), scale, 0.0, "exact: surfaces do not overlap")]
    found = []
    if "uniform" in limits:
        limit = limits["uniform"]
        found.append(_reference(name, limit.value, limit.uncertainty, f"all refined at once, {_said(limit)}"))
    single = {series: limit for series, limit in limits.items() if series != "uniform"}
    if single:
        limit, lacks = added_up(base, single), tuple(series for series in needed if series not in single)
        source = f"{limit.behaviour}; lacks {', '.join(lacks)}" if lacks else limit.behaviour
        found.append(_reference(name, limit.value, float("inf") if lacks else limit.uncertainty, source, lacks))
    if theory is not None and theory.quantity == name:
        found.append(Reference(np.full(1, theory.value), abs(theory.value), theory.bound, theory.source))
    return sorted(found, key=lambda reference: reference.uncertainty)


def _reference(name: str, value: np.ndarray, uncertainty: float, source: str, lacks: tuple[str, ...] = ()) -> Reference:
    scale = scale_of(name, value)
    return Reference(value, scale, uncertainty / scale, source, lacks)


def _said(limit: Limit) -> str:
    return f"extrapolated with order {limit.order:.2f}" if limit.asymptotic else limit.behaviour
