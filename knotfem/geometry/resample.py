"""Points on a smooth curve at equal arclengths, with equal chords, or with chords of given lengths."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_banded

from knotfem.errors import InputError
from knotfem.geometry.curve import Curve
from knotfem.geometry.measures import turning_angles
from knotfem.geometry.slices import Slices
from knotfem.types import Array

TOLERANCE = 1e-9
"""Largest relative difference of the chords."""

MOST_ITERATIONS = 60
"""Of Newton's method."""


class Chords(NamedTuple):
    """Vertices on a scaled curve.

    Attributes:
        points: shape (edges + 1, 3), in the units of the length that was asked for.
        scale: factor by which the curve was scaled about the origin.
        parameters: of the vertices on the curve, shape (edges + 1,).
    """

    points: Array
    scale: float
    parameters: Array


def arc_parameters(curve: Curve, count: int, fractions: Array | None = None) -> Array:
    """Parameters of points at equal arclengths along a curve, or at others.

    The arclength is integrated by eight-point Gauss quadrature over at least eight pieces per point, and inverted by
    linear interpolation.

    Args:
        curve: any smooth curve.
        count: number of points, the two ends included.
        fractions: arclengths of the points over the length of the curve, shape (count,); None for equal ones.

    Returns:
        Shape (count,).
    """
    knots = curve.spans
    gauss, weights = np.polynomial.legendre.leggauss(8)
    pieces = max(2, -(-8 * count // (len(knots) - 1)))
    fine = np.concatenate([np.linspace(a, b, pieces, endpoint=False) for a, b in pairwise(knots)])
    fine = np.append(fine, knots[-1])
    middle, half = 0.5 * (fine[1:] + fine[:-1]), 0.5 * np.diff(fine)
    speed = np.linalg.norm(curve.derivative(middle[:, None] + half[:, None] * gauss), axis=-1)
    arc = np.concatenate([[0.0], np.cumsum((speed * weights).sum(axis=1) * half)])
    wanted = np.linspace(0.0, arc[-1], count) if fractions is None else fractions * arc[-1]
    parameters = np.interp(wanted, arc, fine)
    parameters[[0, -1]] = curve.domain
    return parameters


def equal_chords(curve: Curve, edges: int, length: float | None = None, *, file: str | Path | None = None) -> Chords:
    """Put edges + 1 vertices on the curve, first and last on its ends, all chords equal to a relative 1e-9.

    Points at equal arclengths have shorter chords where the curve is bent, which would strain a core of truss elements.

    Args:
        curve: any smooth curve.
        edges: number of chords, at least 1.
        length: sum of the chords, mm, to which the curve is scaled about the origin; None leaves it as it is.
        file: named in the message of an error.

    Raises:
        InputError: edges or length out of range, or a curve that turns so sharply within one chord that the iteration
            finds no equal chords.
    """
    if edges < 1:
        raise InputError("too few edges", found=edges, expected="at least 1")
    if length is not None and not (np.isfinite(length) and length > 0.0):
        raise InputError("length is not positive", found=length, expected="above 0 mm")
    t, x, mean = _solve(curve, arc_parameters(curve, edges + 1), np.ones(edges), file)
    scale = 1.0 if length is None else length / (edges * mean)
    return Chords(scale * x, scale, t)


def chords(curve: Curve, slices: Slices, length: float | None = None, *, file: str | Path | None = None) -> Chords:
    """Put vertices on the curve, first and last on its ends, with chords as long as the slices of a rod.

    Args:
        curve: any smooth curve.
        slices: of the rod.
        length: of the rod, mm, to which the curve is scaled about the origin; None leaves it as it is.
        file: named in the message of an error.

    Raises:
        InputError: see `equal_chords`.
    """
    if slices.equal:
        return equal_chords(curve, slices.count, length, file=file)
    start = arc_parameters(curve, slices.count + 1, slices.fractions)
    t, x, mean = _solve(curve, start, slices.lengths / slices.lengths.mean(), file)
    scale = 1.0 if length is None else length / (slices.count * mean)
    return Chords(scale * x, scale, t)


def _solve(curve: Curve, t: Array, ratio: Array, file: str | Path | None) -> tuple[Array, Array, float]:
    """Parameters and points of chords in given ratios, and their mean.

    The equations |x(t_(i+1)) - x(t_i)| = r_i c are solved for the parameters t_1 .. t_(edges-1) and the mean chord c by
    Newton's method. A step is shortened where it would reverse the order of two points.

    Args:
        curve: any smooth curve.
        t: parameters to begin with, shape (edges + 1,).
        ratio: r, of mean 1, shape (edges,).
        file: named in the message of an error.
    """
    edges = ratio.size
    smallest = TOLERANCE * float(np.ptp(curve(curve.spans), axis=0).max())
    x = curve(t)
    for _ in range(MOST_ITERATIONS):
        chord = np.diff(x, axis=0)
        size = np.linalg.norm(chord, axis=1)
        mean = float(size.mean())
        if not size.min() > smallest:
            break
        if np.abs(size / mean - ratio).max() < 1e-3 * TOLERANCE:
            break
        step = _newton_step(chord / size[:, None], size - ratio * mean, curve.derivative(t), ratio)
        shift = np.diff(step)
        with np.errstate(divide="ignore", invalid="ignore"):
            room = np.where(shift < 0.0, -np.diff(t) / shift, np.inf).min()
        t = t + min(1.0, 0.5 * room) * step
        x = curve(t)
    size = np.linalg.norm(np.diff(x, axis=0), axis=1)
    mean = float(size.mean())
    if not (size.min() > smallest and np.abs(size - ratio * mean).max() < TOLERANCE * mean):
        kind = "equal chords" if (ratio == 1.0).all() else "chords as long as the slices"
        arc = np.concatenate([[0.0], np.cumsum(size)])
        worst = int(np.argmax(turning_angles(x))) + 1 if size.min() > smallest else int(np.argmin(size))
        place = arc[worst] / arc[-1]
        problem = f"the curve has no {edges} {kind}: it turns too sharply near s/L = {place:.3f}"
        expected = "shorter elements (mesh.element_length), or a smoother curve (smoothing.iterations)"
        raise InputError(problem, file=file, expected=expected)
    return t, x, mean


def _newton_step(direction: Array, residual: Array, slope: Array, ratio: Array) -> Array:
    """Newton step dt of the parameters, zero at both ends, shape (edges + 1,).

    With u_i the direction of chord i and x' the derivative of the curve, it solves

        u_i . x'(t_(i+1)) dt_(i+1) - u_i . x'(t_i) dt_i - r_i dc = -residual_i

    by forward substitution, once for the residual and once for a unit change of the mean chord; the change dc then
    follows from dt = 0 at the last point.

    Args:
        direction: u, shape (edges, 3).
        residual: chord minus what it is to be, shape (edges,).
        slope: x' at the points, shape (edges + 1, 3).
        ratio: r, shape (edges,).
    """
    ahead = np.einsum("ij,ij->i", direction, slope[1:])
    behind = -np.einsum("ij,ij->i", direction, slope[:-1])
    bands = np.vstack([ahead, np.append(behind[1:], 0.0)])
    with_residual, with_chord = solve_banded((1, 0), bands, np.column_stack([-residual, ratio])).T
    dc = -with_residual[-1] / with_chord[-1]
    step = np.concatenate([[0.0], with_residual + dc * with_chord])
    step[-1] = 0.0
    return step
