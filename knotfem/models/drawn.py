"""Curves of a scene's rods as they are drawn: read, smoothed, and in which scale they are taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.curve import Curve, NaturalSpline, interpolate
from knotfem.geometry.fit import fitted
from knotfem.geometry.measures import arclength
from knotfem.geometry.nurbs import Nurbs
from knotfem.geometry.readers import Choice, CurveFile, read_curve
from knotfem.geometry.repair import scatter
from knotfem.geometry.resample import Chords, arc_parameters, equal_chords
from knotfem.geometry.slices import Slices
from knotfem.geometry.smoothing import laplacian
from knotfem.geometry.validate import SCATTERED
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod, is_curve_file

UNITS = {1000.0: "metres", 10.0: "centimetres", 25.4: "inches", 304.8: "feet", 1e-3: "micrometres"}
"""What a file is in, by the millimetres of its unit."""
SAME_UNIT = 0.03
"""Relative difference of a factor from that of a unit."""
UNSAID = 0.005
"""Relative change of size that is not worth a word: a spline is longer than the polyline through its points."""
ALIKE = 0.005
"""Relative difference of the factors of two rods that is not."""
ONE_FRAME = "curves drawn in one frame no longer fit"
"""Said of rods whose factors differ by more."""
APART = 2.0
"""Distance between the ends of a closed curve that is cut open, in diameters."""
RADIUS = 0.02
"""Relative difference of the radius in a file from that of the rod."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """The curve of a rod.

    Attributes:
        curve: smoothed; in mm where `factor` is given, else of any size.
        unsmoothed: vertices before smoothing [mm], shape [n, 3]; None without.
        factor: mm per unit of the file, by which the curve keeps its place; None where it is scaled to its length.
        read: how the file was scaled before smoothing [mm per unit of the file].
        scatter: of its points across the curve [mm].
        warnings: what deserves one.
    """

    curve: Curve
    unsmoothed: np.ndarray | None
    factor: float | None
    read: float
    scatter: float
    warnings: tuple[str, ...] = ()

    def along(self, slices: Slices, file: str) -> tuple[Curve, float]:
        """The curve along which a rod of these slices lies, and by how much its ends were made longer for it [mm]."""
        if self.factor is None:
            return self.curve, 0.0
        vertices = self.curve(self.curve.spans) if isinstance(self.curve, NaturalSpline) else self._sampled(slices)
        return fitted(vertices, slices, file=file)

    def _sampled(self, slices: Slices) -> np.ndarray:
        return self.curve(arc_parameters(self.curve, 4 * slices.count + 1))


def drawn_curves(scene: Scene) -> list[Drawn]:
    """The curve of each rod.

    Raises:
        InputError: a file that holds no curve of a rod; see `read_curve`.
    """
    files = [_read(rod) for rod in scene.rods]
    own = {rod.name: _own_factor(rod, file) for rod, file in zip(scene.rods, files, strict=True)}
    return [
        _drawn(rod, file, own[rod.scale] if isinstance(rod.scale, str) else rod.scale, own[rod.name])
        for rod, file in zip(scene.rods, files, strict=True)
    ]


def _read(rod: Rod) -> CurveFile:
    smoothed = rod.smoothing.iterations > 0
    return read_curve(rod.curve_file, Choice(rod.curve, rod.cut_at, APART * rod.diameter / rod.length, smoothed))


def _own_factor(rod: Rod, file: CurveFile) -> float:
    """By which the coordinates of a rod that takes its scale from none are multiplied."""
    if isinstance(rod.scale, float | int):
        return float(rod.scale)
    return _vertices(rod, file, rod.length).scale


def _drawn(rod: Rod, file: CurveFile, factor: float | None, own: float) -> Drawn:
    read = own if factor is None else factor
    noise = 0.0 if file.points is None else read * scatter(file.points)
    warnings = [*file.warnings, *_radius_warning(rod, file, read)]
    smoothing = rod.smoothing
    if smoothing.iterations == 0:
        if noise > SCATTERED * rod.diameter:
            cure = "smoothing.iterations = 1000 takes that out"
            warnings.append(f"{rod.centerline}: its points scatter by about {noise:.2g} mm; {cure}")
        curve = file.curve if factor is None else _scaled(file, factor)
        return Drawn(curve, None, factor, read, noise, tuple(warnings))
    found = _vertices(rod, file, rod.length if factor is None else None).points
    raw = found if factor is None else factor * found
    keep_size = noise > SCATTERED * rod.diameter if smoothing.keep_size is None else smoothing.keep_size
    smooth = laplacian(raw, smoothing.gamma, smoothing.iterations, keep_size=keep_size)
    if is_curve_file(rod.centerline):
        warnings.append(_moved(rod, raw, smooth, keep_size=keep_size))
    return Drawn(interpolate(smooth), raw, factor, read, noise, tuple(warnings))


def _vertices(rod: Rod, file: CurveFile, length: float | None) -> Chords:
    """Vertices on the curve of a file, which smoothing acts on: with equal chords, or at equal arclengths where points
    scatter so much that there are none.

    Raises:
        InputError: no equal chords, and no smoothing.
    """
    try:
        return equal_chords(file.curve, rod.slices, length, file=rod.centerline)
    except InputError:
        if rod.smoothing.iterations == 0:
            raise
    parameters = arc_parameters(file.curve, rod.slices + 1)
    x = file.curve(parameters)
    scale = 1.0 if length is None else length / arclength(x)[-1]
    return Chords(scale * x, scale, parameters)


def _scaled(file: CurveFile, factor: float) -> Curve:
    """The curve of a file, scaled about the origin."""
    if isinstance(file.curve, Nurbs):
        return replace(file.curve, points=factor * file.curve.points)
    return interpolate(factor * file.curve(file.curve.spans))


def _moved(rod: Rod, before: np.ndarray, after: np.ndarray, *, keep_size: bool) -> str:
    moved = np.linalg.norm(after - before, axis=1)
    worst = int(np.argmax(moved))
    said = f"{moved.mean():.3g} mm on average, {moved[worst]:.3g} mm at the most (s/L = {worst / (len(moved) - 1):.3f})"
    kind = "smoothing that keeps the size of loops" if keep_size else "smoothing"
    return f"{rod.centerline}: {kind} moves the curve by {said}"


def _radius_warning(rod: Rod, file: CurveFile, factor: float) -> list[str]:
    if file.radius is None or abs(factor * file.radius / rod.radius - 1.0) <= RADIUS:
        return []
    found = f"{2.0 * factor * file.radius:.4g} mm"
    return [f"{rod.centerline}: its radii make a diameter of {found}; the rod has {rod.diameter:.4g} mm"]


def scaling_warnings(rods: Sequence[Rod], factors: Sequence[float], added: Sequence[float]) -> list[list[str]]:
    """What must be said of the size in which the files of the rods are taken, for each rod.

    Args:
        rods: of the scene.
        factors: mm per unit of the file of each.
        added: by which the ends of each were made longer [mm].
    """
    said: list[list[str]] = [[] for _ in rods]
    for index, (rod, factor, longer) in enumerate(zip(rods, factors, added, strict=True)):
        if not is_curve_file(rod.centerline):
            continue
        if rod.scale is None and abs(factor - 1.0) > UNSAID:
            goal = f"about the origin to the length of the rod, {rod.length:g} mm"
            said[index].append(f"{rod.centerline}: scaled by {factor:.5g}{_unit(factor)} {goal}")
        if abs(longer) > UNSAID * rod.length:
            kind = "made longer" if longer > 0.0 else "cut"
            goal = f"by {0.5 * abs(longer):.4g} mm each to the length of the rod, {rod.length:g} mm"
            said[index].append(f"{rod.centerline}: in the scale of {factor:.5g}, its ends are {kind} {goal}")
        first = next((i for i, other in enumerate(rods) if is_curve_file(other.centerline)), index)
        free = rod.scale is None and rods[first].scale is None
        if free and abs(factor / factors[first] - 1.0) > ALIKE:
            both = f"{rods[first].name} is scaled by {factors[first]:.5g} and {rod.name} by {factor:.5g}"
            cure = f'rods.{index}.scale = "{rods[first].name}" gives both one scale'
            said[index].append(f"{both}, each to its own length: {ONE_FRAME}; {cure}")
    return said


def _unit(factor: float) -> str:
    unit = next((name for size, name in UNITS.items() if abs(factor / size - 1.0) < SAME_UNIT), "")
    return f" (the file seems to be in {unit})" if unit else ""
