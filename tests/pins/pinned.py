"""Pins: what is run, how its curve is stored, how far another may be from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from curves import Curve, force_curve, sag_curve

FLOOR = 0.05
"""Share of a table's largest value below which deviations are not relative to the value itself."""
TOLERANCES = {"fem": 0.005, "rod": 0.002}
"""Largest relative deviation of a model's short curves; that of a rod's is below what 3 % of twisting stiffness do."""
WHOLE_TOLERANCES = {"fem": 0.005, "rod": 0.01}
"""The same of whole ones, in which another rounding may lead to other steps."""
WIDER = {
    "figure-eight-fem": 0.01, "bowline-fem-whole": 0.015, "figure-eight-fem-whole": 0.01, "sheet-bend-fem-whole": 0.01,
}  # fmt: skip
"""Curves that other steps were measured to move by half of that or more, and how wide they are held instead."""


@dataclass(frozen=True)
class Pin:
    """One curve that is held.

    Attributes:
        name: of the table.
        scene: a shipped one.
        overrides: of its keys.
        tolerance: largest relative deviation.
        every: distance of the stored points [mm]; steps of the run must end there.
        sag: whether the sag along the rod is held instead of the force.
    """

    name: str
    scene: str
    overrides: tuple[str, ...]
    tolerance: float
    every: float
    sag: bool = False

    @property
    def path(self) -> Path:
        """Of the table."""
        return Path(__file__).parent / f"{self.name}.csv"

    @property
    def head(self) -> str:
        """Of the table: what was run, the columns."""
        comments = [f"# scene {self.scene}\n", *(f"# {override}\n" for override in self.overrides)]
        return "".join(comments) + ("arclength_mm,sag_mm\n" if self.sag else "displacement_mm,force_N\n")

    def run(self, more: Sequence[str] = ()) -> Curve:
        """The curve as the program gives it now.

        Args:
            more: overrides besides the pin's own.
        """
        return (sag_curve if self.sag else force_curve)(self.scene, (*self.overrides, *more))

    def read(self) -> Curve:
        """The stored curve."""
        rows = np.loadtxt(self.path, delimiter=",", skiprows=self.head.count("\n"))
        return rows[:, 0], rows[:, 1]

    def write(self, curve: Curve) -> None:
        """Store a curve at the points that are held."""
        x, y = curve
        held = self.every * np.arange(1, int(x[-1] / self.every + 1e-6) + 1)
        rows = zip(held.tolist(), np.interp(held, x, y).tolist(), strict=True)
        self.path.write_text(self.head + "".join(f"{a!r},{b!r}\n" for a, b in rows))

    def deviation(self, curve: Curve) -> float:
        """Largest deviation of a curve from the stored one, relative to the value there or `FLOOR` of the largest."""
        return deviation(curve, self.read())


def deviation(curve: Curve, reference: Curve) -> float:
    """Largest relative deviation of a curve from another at the points of that one; see `FLOOR`."""
    x, y = reference
    scale = np.maximum(np.abs(y), FLOOR * np.abs(y).max())
    return float(np.max(np.abs(np.interp(x, *curve) - y) / scale))


def _short(model: str, scene: str, element: float, every: float, *more: str, rods: int = 1) -> Pin:
    overrides = [f"model={model}", "solver.threads=1", "output.fields=false", "tie.increments=2"]
    for rod in range(rods):
        overrides += [f"rods.{rod}.mesh.section_elements=4", f"rods.{rod}.mesh.element_length={element:g} mm"]
    overrides.append(f"output.every_displacement={every:g} mm")
    name = f"{scene}-{model}"
    return Pin(name, scene, (*overrides, *more), WIDER.get(name, TOLERANCES[model]), every)


def _sag(model: str) -> Pin:
    overrides = (f"model={model}", "solver.threads=1", "output.fields=false", "tie.increments=2")
    if model == "fem":
        overrides += ("rods.0.mesh.element_length=2 mm",)
    return Pin(f"cantilever-{model}", "cantilever", overrides, TOLERANCES[model], 4.0, sag=True)


_SPARSE = "contact.sample_spacing_over_diameter=0.25"
_SMOOTH = "contact.ramp_over_diameter=0.1"
_SHORTER = "rods.0.length=400 mm"
_NO_RELEASE = "steps.2=none"

SHORT = [
    _sag("rod"),
    _short("rod", "bowline", 5.0, 1.0, _SPARSE, "steps.1.displacement=12 mm"),
    _short("rod", "overhand", 6.0, 1.0, _SPARSE, _SHORTER, "steps.1.displacement=10 mm"),
    _short("rod", "figure-eight", 6.0, 0.5, _SPARSE, _SHORTER, "steps.1.displacement=10 mm"),
    _short("rod", "clove-hitch", 5.0, 1.0, _SPARSE, "steps.1.displacement=8 mm"),
    _short("rod", "capstan", 5.0, 0.5, _SPARSE, "steps.2.displacement=5 mm"),
    _short("rod", "sheet-bend", 5.0, 1.0, _SPARSE, "steps.1.displacement=10 mm", _NO_RELEASE, rods=2),
    _sag("fem"),
    _short("fem", "bowline", 6.0, 0.25, _SPARSE, _SMOOTH, "steps.1.displacement=1 mm"),
    _short("fem", "overhand", 6.0, 1.0, _SPARSE, _SHORTER, "steps.1.displacement=10 mm"),
    _short("fem", "figure-eight", 6.0, 0.25, _SPARSE, _SMOOTH, _SHORTER, "steps.1.displacement=1 mm"),
    _short("fem", "clove-hitch", 6.0, 0.5, _SPARSE, "steps.1.displacement=3 mm"),
    _short("fem", "capstan", 5.0, 0.5, _SPARSE, "steps.2.displacement=5 mm"),
    _short("fem", "sheet-bend", 6.0, 0.5, _SPARSE, "steps.1.displacement=2 mm", _NO_RELEASE, rods=2),
]
"""Of the quick suite; settings are such that rounding moves no curve by more than a small share of its tolerance."""


def _whole(model: str, scene: str) -> Pin:
    overrides = (f"model={model}", "solver.threads=1")
    sag = scene == "cantilever"
    name = f"{scene}-{model}-whole"
    return Pin(name, scene, overrides, WIDER.get(name, WHOLE_TOLERANCES[model]), 4.0 if sag else 3.0, sag=sag)


SCENES = ("cantilever", "bowline", "overhand", "figure-eight", "clove-hitch", "capstan", "sheet-bend")
WHOLE = [_whole(model, scene) for model in ("rod", "fem") for scene in SCENES]
"""Of the slow suite: the scenes as they are."""
