"""Curves that are made as long as a rod without being scaled: their ends go on straight, or are cut."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.curve import NaturalSpline, interpolate
from knotfem.geometry.measures import arclength
from knotfem.geometry.resample import chords
from knotfem.geometry.slices import Slices
from knotfem.geometry.vectors import unit
from knotfem.types import Array

MOST_CUT = 0.25
"""Fraction of a curve that may be cut off: more would hardly leave the knot that was drawn."""
TOLERANCE = 1e-9
"""Of the length."""


def fitted(points: Array, slices: Slices, *, file: str | Path | None = None) -> tuple[NaturalSpline, float]:
    """A curve through points whose chords add up to the length of a rod, both its ends having been changed alike.

    Args:
        points: of the curve [mm], shape (n, 3).
        slices: of the rod.
        file: named in messages.

    Returns:
        The curve, and by how much both of its ends together became longer [mm]; negative where they were cut.

    Raises:
        InputError: more than a quarter of the curve would have to be cut off.
    """
    length, drawn = float(slices.lengths.sum()), _sum_of_chords(interpolate(points), slices, file)
    if length < (1.0 - MOST_CUT) * drawn:
        problem = "the curve is longer than its rod"
        expected = f"a length of the rod of {drawn:.6g} mm, or another scale"
        raise InputError(problem, file=file, found=f"{drawn:.6g} mm for a rod of {length:.6g} mm", expected=expected)
    added = 0.0
    curve = interpolate(points)
    for _ in range(20):
        missing = length - _sum_of_chords(curve, slices, file)
        if abs(missing) < TOLERANCE * length:
            break
        added += missing
        curve = interpolate(_extended(points, 0.5 * added))
    return curve, added


def _sum_of_chords(curve: NaturalSpline, slices: Slices, file: str | Path | None) -> float:
    x = chords(curve, slices, file=file).points
    return float(np.linalg.norm(np.diff(x, axis=0), axis=1).sum())


def _extended(points: Array, at_each_end: float) -> Array:
    """Points with straight ends so much longer [mm], or so much shorter along the polyline."""
    spacing = arclength(points)[-1] / (len(points) - 1)
    if at_each_end > 0.0:
        steps = np.linspace(0.0, at_each_end, 1 + max(1, round(at_each_end / spacing)))[1:, None]
        first, last = unit(points[0] - points[1]), unit(points[-1] - points[-2])
        return np.concatenate([(points[0] + steps * first)[::-1], points, points[-1] + steps * last])
    curve = interpolate(points)
    start, stop = curve.domain
    inner = curve.spans[
        (curve.spans > start - at_each_end + 0.01 * spacing) & (curve.spans < stop + at_each_end - 0.01 * spacing)
    ]
    return curve(np.concatenate([[start - at_each_end], inner, [stop + at_each_end]]))
