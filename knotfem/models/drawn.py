"""Curves of a scene's rods as they are drawn: read, smoothed, and the factor in which they are taken."""

from __future__ import annotations

from collections.abc import Mapping
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

APART = 2.0
"""Distance between the ends of a closed curve that is cut open, in diameters."""
RADIUS = 0.02
"""Relative difference of the radius in a file from that of the rod."""
SAME_FACTOR = 1e-6
"""Relative difference of a scale from that of the unit in a file."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """The curve of a rod.

    Attributes:
        curve: smoothed; in mm where `factor` is given, else of any size.
        unsmoothed: vertices before smoothing [mm], shape [n, 3]; None without.
        factor: mm per unit of the file, by which the curve keeps its place; None where it is scaled to its length.
        why: what gives the factor of the file.
        read: how the file was scaled before smoothing [mm per unit of the file].
        scatter: of its points across the curve [mm].
        warnings: what deserves one.
    """

    curve: Curve
    unsmoothed: np.ndarray | None
    factor: float | None
    why: str
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
    lengths = 1.0 if scene.rope is None else scene.rope.lengths
    pairs = list(zip(scene.rods, files, strict=True))
    own = {rod.name: _own_factor(rod, file, lengths) for rod, file in pairs}
    drawn = []
    for number, (rod, file) in enumerate(pairs):
        factor, why = _factor(rod, number, file, own, lengths)
        drawn.append(_drawn(rod, file, factor, why, own[rod.name], lengths))
    return drawn


def _read(rod: Rod) -> CurveFile:
    smoothed = rod.smoothing.iterations > 0
    return read_curve(rod.curve_file, Choice(rod.curve, rod.cut_at, APART * rod.diameter / rod.length, smoothed))


def _own_factor(rod: Rod, file: CurveFile, lengths: float) -> float:
    """By which the coordinates of a rod that takes its scale from none are multiplied."""
    if isinstance(rod.scale, float | int):
        return float(rod.scale)
    of_unit = file.millimetres(lengths)
    return _vertices(rod, file, rod.length).scale if of_unit is None else of_unit


def _factor(
    rod: Rod, number: int, file: CurveFile, own: Mapping[str, float], lengths: float
) -> tuple[float | None, str]:
    """By which the coordinates of a rod are multiplied, None for the length of the rod, and what gives it.

    Args:
        rod: in question.
        number: of it in the scene.
        file: of its curve.
        own: factors of all rods by themselves, by their names.
        lengths: by which the scene was scaled for another rope, with it curves that have a unit.

    Raises:
        InputError: the scale contradicts the unit in the file.
    """
    of_unit, header = file.millimetres(lengths), f'the unit in its header ("{file.unit_from}")'
    key = f"rods.{number}.scale"
    if rod.scale is None:
        if of_unit is None:
            return None, f"the length of the rod, {rod.length:g} mm"
        scaled = "" if lengths == 1.0 else f", {lengths:g} times as large for --rope"
        return of_unit, header + scaled
    named = isinstance(rod.scale, str)
    factor = own[rod.scale] if isinstance(rod.scale, str) else float(rod.scale)
    if of_unit is not None and abs(factor / of_unit - 1.0) > SAME_FACTOR:
        found = f'"{rod.scale}", {factor:.6g} mm per unit' if named else f"{factor:.6g}"
        expected = f"{of_unit:g} by {header}, no scale, or a header without a unit"
        raise InputError(f"another unit than in {rod.centerline}", key=key, found=found, expected=expected)
    return factor, f'{key} = "{rod.scale}"' if named else key


def _drawn(rod: Rod, file: CurveFile, factor: float | None, why: str, own: float, lengths: float) -> Drawn:
    read = own if factor is None else factor
    noise = 0.0 if file.points is None else read * scatter(file.points)
    warnings = [*file.warnings, *_radius_warning(rod, file, read, lengths)]
    smoothing = rod.smoothing
    if smoothing.iterations == 0:
        if noise > SCATTERED * rod.diameter:
            cure = "smoothing.iterations = 1000 takes that out"
            warnings.append(f"{rod.centerline}: its points scatter by about {noise:.2g} mm; {cure}")
        curve = file.curve if factor is None else _scaled(file, factor)
        return Drawn(curve, None, factor, why, read, noise, tuple(warnings))
    found = _vertices(rod, file, rod.length if factor is None else None).points
    raw = found if factor is None else factor * found
    keep_size = noise > SCATTERED * rod.diameter if smoothing.keep_size is None else smoothing.keep_size
    smooth = laplacian(raw, smoothing.gamma, smoothing.iterations, keep_size=keep_size)
    if is_curve_file(rod.centerline):
        warnings.append(_moved(rod, raw, smooth, keep_size=keep_size))
    return Drawn(interpolate(smooth), raw, factor, why, read, noise, tuple(warnings))


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


def _radius_warning(rod: Rod, file: CurveFile, factor: float, lengths: float) -> list[str]:
    radius = file.radius_in_mm(factor, lengths)
    if radius is None or abs(radius / rod.radius - 1.0) <= RADIUS:
        return []
    found = f"{2.0 * radius:.4g} mm"
    return [f"{rod.centerline}: its radii make a diameter of {found}; the rod has {rod.diameter:.4g} mm"]
