"""Errors of rungs: against the limit of their own ladder, and against a bounded reference of the whole scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from knotfem.study.closed_forms import ClosedForm
from knotfem.study.convergence import Limit, extrapolate, rms
from knotfem.study.ladders import SIZED
from knotfem.study.measured import Measured, values_of
from knotfem.study.quantities import scale_of

NOISE = 1e-5
"""Changes of a quantity below this share of it say nothing: Newton's tolerance allows them."""


APART = 1.1
"""Rungs whose sizes differ by less say nothing about an order."""
MESH = ("section", "slice")
"""Ladders that refine the mesh alone, which another element stands for."""


@dataclass(frozen=True, eq=False)
class Reference:
    """What errors of a quantity are taken against.

    Attributes:
        value: shape [n].
        scale: what errors are divided by, see `scale_of`.
        uncertainty: of the reference itself, as a share of the scale; infinite where nothing bounds it.
        source: for people.
        lacks: ladders without whose limits it is no bound.
    """

    value: np.ndarray
    scale: float
    uncertainty: float
    source: str
    lacks: tuple[str, ...] = ()

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


def added_up(base: np.ndarray, limits: Mapping[str, Limit]) -> Limit:
    """The scene as it is plus what each ladder's limit adds to it: errors of separate choices add up to first order.

    Args:
        base: a quantity in the scene as it is, shape [n].
        limits: by ladder, one at least.
    """
    value = base + sum((limit.value - base for limit in limits.values()), np.zeros_like(base))
    uncertainty = sum(limit.uncertainty for limit in limits.values())
    return Limit(value, uncertainty, None, f"limits of {', '.join(limits)} added up")


def mesh_limit(base: np.ndarray, limits: Mapping[str, Limit]) -> Limit | None:
    """Limit of the mesh with all else as it is; None without the limits of section and slice."""
    found = {ladder: limits[ladder] for ladder in MESH if ladder in limits}
    return added_up(base, found) if len(found) == len(MESH) else None


def references(
    name: str,
    base: np.ndarray,
    limits: dict[str, Limit],
    theory: ClosedForm | None = None,
    needed: Sequence[str] = (),
) -> list[Reference]:
    """References that a quantity has, the least uncertain first.

    Penetrations have an exact one, none. Else: the limit of the ladder that refines everything; the scene as it is
    plus what each other ladder's limit adds to it, uncertain by the sum of theirs, without bound where one is missing;
    the closed form.

    Args:
        name: of the quantity.
        base: its value in the scene as it is, shape [n].
        limits: by ladder.
        theory: the scene's closed form.
        needed: ladders that the scene has, `uniform` left out.
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
        limit, lacks = added_up(base, single), tuple(ladder for ladder in needed if ladder not in single)
        source = f"{limit.verdict}; lacks {', '.join(lacks)}" if lacks else limit.verdict
        found.append(_reference(name, limit.value, float("inf") if lacks else limit.uncertainty, source, lacks))
    if theory is not None and theory.quantity == name:
        found.append(Reference(np.full(1, theory.value), abs(theory.value), theory.bound, theory.source))
    return sorted(found, key=lambda reference: reference.uncertainty)


def _reference(name: str, value: np.ndarray, uncertainty: float, source: str, lacks: tuple[str, ...] = ()) -> Reference:
    scale = scale_of(name, value)
    return Reference(value, scale, uncertainty / scale, source, lacks)


def _said(limit: Limit) -> str:
    return f"extrapolated with order {limit.order:.2f}" if limit.asymptotic else limit.verdict
