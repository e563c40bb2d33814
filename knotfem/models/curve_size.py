"""In which size the curves of rods are taken, and what must be said of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from knotfem import shipped
from knotfem.geometry.curve import Curve
from knotfem.geometry.length_units import UNITS
from knotfem.geometry.measures import arclength
from knotfem.models.drawn import Drawn
from knotfem.scene.rods import Rod, is_curve_file

GUESSED = ("m", "cm", "in", "ft", "um")
"""Units that a file without one may seem to have."""
SAME_UNIT = 0.03
"""Relative difference of a factor from that of a unit."""
UNSAID = 0.005
"""Relative change of size that is not worth a word: a spline is longer than the polyline through its points."""
ALIKE = 0.005
"""Relative difference of the factors of two rods that is not."""
ONE_FRAME = "curves drawn in one frame no longer fit"
"""Said of rods whose factors differ by more."""


@dataclass(frozen=True)
class Size:
    """In which size the curve of a rod is taken.

    Attributes:
        curve: file or shipped name.
        factor: mm per unit of the curve; None for a rod that another run has left.
        why: what gives the factor.
        longer: by how much the ends together were made longer [mm]; negative where they were cut.
    """

    curve: str
    factor: float | None
    why: str
    longer: float = 0.0

    def __str__(self) -> str:
        if self.factor is None:
            return self.why
        ends = "made longer" if self.longer > 0.0 else "cut"
        added = f"; its ends are {ends} by {0.5 * abs(self.longer):.4g} mm each" if abs(self.longer) > 5e-5 else ""
        return f"{self.curve}: {self.factor:.5g} mm per unit, from {self.why}{added}"

    @property
    def figures(self) -> dict[str, object]:
        """For the summary."""
        return {"curve": self.curve, "mm_per_unit": self.factor, "from": self.why, "ends_longer_mm": self.longer}


def scaling_warnings(rods: Sequence[Rod], drawn: Sequence[Drawn], sizes: Sequence[Size]) -> list[list[str]]:
    """What must be said of the size in which the curves of the rods are taken, for each rod.

    Args:
        rods: of the scene.
        drawn: their curves.
        sizes: in which they are taken.
    """
    said: list[list[str]] = [[] for _ in rods]
    for index, (rod, curve, size) in enumerate(zip(rods, drawn, sizes, strict=True)):
        said[index] += _scaled_to_length(rod, index, curve, size)
        if abs(size.longer) > UNSAID * rod.length:
            kind = "made longer" if size.longer > 0.0 else "cut"
            goal = f"by {0.5 * abs(size.longer):.4g} mm each to the length of the rod, {rod.length:g} mm"
            said[index].append(f"{rod.centerline}: in the scale of {size.factor:.5g}, its ends are {kind} {goal}")
        first = next((i for i, other in enumerate(rods) if is_curve_file(other.centerline)), index)
        free = is_curve_file(rod.centerline) and curve.factor is None and drawn[first].factor is None
        factors = sizes[first].factor or 1.0, size.factor or 1.0
        if free and abs(factors[1] / factors[0] - 1.0) > ALIKE:
            both = f"{rods[first].name} is scaled by {factors[0]:.5g} and {rod.name} by {factors[1]:.5g}"
            cure = f'rods.{index}.scale = "{rods[first].name}" gives both one scale'
            said[index].append(f"{both}, each to its own length: {ONE_FRAME}; {cure}")
    return said


def _scaled_to_length(rod: Rod, index: int, drawn: Drawn, size: Size) -> list[str]:
    """A curve whose size changes to fit the length of its rod; of a shipped one, that in diameters."""
    factor = size.factor
    if drawn.factor is not None or factor is None:
        return []
    goal = f"about the origin to the length of the rod, {rod.length:g} mm"
    if is_curve_file(rod.centerline):
        changed = abs(factor - 1.0) > UNSAID
        return [f"{rod.centerline}: scaled by {factor:.5g}{_unit(factor)} {goal}"] if changed else []
    as_drawn = rod.diameter / shipped.drawn_diameter(rod.centerline)
    if abs(factor / as_drawn - 1.0) <= UNSAID or _straight(drawn.curve):
        return []
    times = f"its loops are {factor / as_drawn:.4g} times as large, in diameters, as they are drawn"
    cure = f"rods.{index}.scale = {as_drawn:.6g} keeps them and changes the ends instead"
    return [f"{rod.centerline}: scaled by {factor:.5g} {goal}: {times}; {cure}"]


def _unit(factor: float) -> str:
    near = (unit for unit in UNITS if unit.symbol in GUESSED)
    found = next((unit for unit in near if abs(factor / unit.millimetres - 1.0) < SAME_UNIT), None)
    return f" (the file seems to be in {found.plural})" if found else ""


def _straight(curve: Curve) -> bool:
    """Whether a curve has no loops that could change their size."""
    x = curve(curve.spans)
    return bool(np.linalg.norm(x[-1] - x[0]) > (1.0 - 1e-9) * arclength(x)[-1])
