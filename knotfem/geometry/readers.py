"""Readers of centrelines: points in tables and files of lines, NURBS curves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.files import read_text
from knotfem.geometry.curve import Curve, interpolate
from knotfem.geometry.length_units import LengthUnit
from knotfem.geometry.line_files import read_obj, read_vect, read_xyz
from knotfem.geometry.nurbs_file import read_nurbs
from knotfem.geometry.points import FEWEST_POINTS, as_points
from knotfem.geometry.polyline import Polyline
from knotfem.geometry.repair import check_gaps, check_order, is_closed, opened, without_twins
from knotfem.geometry.text_table import read_table

NURBS_SUFFIXES = (".json", ".toml")
READERS: dict[str, Callable[[Path, str], list[Polyline]]] = {
    **dict.fromkeys((".csv", ".tsv", ".txt", ".dat"), read_table),
    ".xyz": read_xyz,
    ".obj": read_obj,
    ".vect": read_vect,
}
"""Readers of points, by the suffix in small letters."""


@dataclass(frozen=True)
class Choice:
    """What is taken of a file of points.

    Attributes:
        curve: number of the curve, from 1; None for the only one.
        cut_at: number of the point at which a closed curve is cut open, from 1; None for a curve with two ends.
        apart: distance between the ends of a curve that is cut, over its length.
        smoothed: whether the points will be smoothed: scattered ones then may turn back.
    """

    curve: int | None = None
    cut_at: int | None = None
    apart: float = 0.05
    smoothed: bool = False


@dataclass(frozen=True, eq=False)
class CurveFile:
    """What a file of a centreline holds.

    Attributes:
        curve: in the units of the file.
        points: that it interpolates, shape (n, 3); None for a NURBS curve.
        radius: of the rod, in the unit of the coordinates or in its own; None if the file has none.
        radius_unit: its own.
        unit: of the coordinates; None if the file has none.
        unit_from: what gives it, such as the head of a column.
        warnings: what deserves one; each begins with the file.
    """

    curve: Curve
    points: np.ndarray | None = None
    radius: float | None = None
    radius_unit: LengthUnit | None = None
    unit: LengthUnit | None = None
    unit_from: str = ""
    warnings: tuple[str, ...] = ()

    def millimetres(self, scaled: float) -> float | None:
        """By which coordinates are multiplied to be in mm, as the unit says; None without one.

        Args:
            scaled: by which the scene was scaled for another rope, with it curves that have a unit.
        """
        return None if self.unit is None else scaled * self.unit.millimetres

    def radius_in_mm(self, factor: float, scaled: float) -> float | None:
        """Radius of the rod [mm]; None if the file has none.

        Args:
            factor: by which the coordinates are multiplied.
            scaled: see `millimetres`.
        """
        if self.radius is None:
            return None
        return self.radius * (factor if self.radius_unit is None else scaled * self.radius_unit.millimetres)


def read_centreline(path: str | Path) -> Curve:
    """Read a centreline: a file of points, which are interpolated, or of a NURBS curve; see `read_curve`."""
    return read_curve(path).curve


def read_curve(path: str | Path, choice: Choice | None = None) -> CurveFile:
    """Read a centreline and look for what may be wrong with it.

    Points that stand twice are dropped. Chords much longer than the others, points that turn back, closed curves and
    several curves in one file are refused, or warned of; see `knotfem.geometry.repair`.

    Args:
        path: file of points (.csv, .tsv, .txt, .xyz, .dat, .obj, .vect), which are interpolated, or of a NURBS curve
            (.json, .toml); the first point is the loading end of the rod.
        choice: what is taken of it.

    Raises:
        InputError: another suffix; the file cannot be read or is broken; or the curve cannot be that of a rod.
    """
    path, choice = Path(path), choice or Choice()
    suffix = path.suffix.lower()
    if suffix in NURBS_SUFFIXES:
        for key, given in (("curve", choice.curve), ("cut_at", choice.cut_at)):
            if given is not None:
                raise InputError("only for files of points", file=path, key=key, found=given, expected="none")
        return CurveFile(read_nurbs(path))
    if suffix not in READERS:
        expected = f"{', '.join(READERS)}; {' or '.join(NURBS_SUFFIXES)} for NURBS curves"
        raise InputError("unknown kind of centreline file", file=path, found=suffix or "no suffix", expected=expected)
    found = _chosen(path, READERS[suffix](path, read_text(path, otherwise="latin-1")), choice.curve)
    found, warnings = without_twins(found)
    as_points(found.points, fewest=FEWEST_POINTS, file=path)
    if choice.cut_at is not None:
        found = opened(found, path, choice.cut_at, choice.apart)
    elif is_closed(found):
        gap = float(np.linalg.norm(found.points[-1] - found.points[0]))
        problem = "the curve is closed, a rod has two ends: its last point is one chord from the first, or the same"
        expected = "an open curve; cut_at = 1 in the table of the rod cuts it open at its first point"
        raise InputError(problem, file=path, found=f"{gap:.4g}, chords of {found.median_chord:.4g}", expected=expected)
    warnings += check_order(found, path, smoothed=choice.smoothed)
    warnings += check_gaps(found, path)
    warnings += [f'the column "{name}" is not used (the twist of a rod is rods.N.twist)' for name in found.unused]
    if found.unknown_unit and found.unit is None:
        warnings.append(f'the unit of the column "{found.unknown_unit}" is not known; the file counts as without one')
    points = as_points(found.points, fewest=FEWEST_POINTS, file=path)
    radius = None if found.radii is None else float(np.median(found.radii))
    return CurveFile(
        interpolate(points),
        points,
        radius,
        found.radius_unit,
        found.unit,
        found.unit_from,
        tuple(f"{path}: {warning}" for warning in warnings),
    )


def _chosen(path: Path, curves: list[Polyline], number: int | None) -> Polyline:
    """One of the curves of a file."""
    curves = [curve for curve in curves if len(curve)]
    if not curves:
        raise InputError("too few points", file=path, found=0, expected=f"at least {FEWEST_POINTS}")
    numbers = f"curve = {' or '.join(map(str, range(1, len(curves) + 1)))}"
    if number is None:
        if len(curves) > 1:
            last, first = curves[0].lines[-1], curves[1].lines[0]
            parted = f"blank line {last + 1} ends the first, " if first == last + 2 else ""
            problem = f"{len(curves)} curves in one file; {parted}the second begins in line {first}"
            raise InputError(problem, file=path, expected=f"one of them: {numbers} in the table of the rod")
        return curves[0]
    if number > len(curves):
        raise InputError("no such curve", file=path, found=f"curve = {number}", expected=numbers)
    return curves[number - 1]
