"""Knot diagrams: projections of polylines onto a plane, with their crossings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from knotfem.compiled import kernel
from knotfem.geometry.points import as_points
from knotfem.geometry.vectors import unit
from knotfem.types import Array

FRONT = (0.0, -1.0, 0.0)
"""Direction from the knot to an observer at -y."""


@dataclass(frozen=True)
class Diagram:
    """A link diagram in planar diagram (PD) code, the notation of the Knot Atlas.

    Attributes:
        crossings: for each crossing, the numbers of its four arcs counter-clockwise, beginning with the incoming arc of
            the under-strand.
        signs: of the crossings: +1 for a right-handed one, -1 for a left-handed one.
        loops: number of components without crossings.
    """

    crossings: tuple[tuple[int, int, int, int], ...]
    signs: tuple[int, ...]
    loops: int = 0

    @property
    def writhe(self) -> int:
        """Sum of the signs of the crossings."""
        return sum(self.signs)

    def __str__(self) -> str:
        """The PD code as `PD[X[1,5,2,4],...]`."""
        return "PD[" + ",".join(f"X[{','.join(map(str, crossing))}]" for crossing in self.crossings) + "]"


@dataclass(frozen=True)
class _Passes:
    """The two passes through each of n crossings, in the order in which the components are traversed.

    Attributes:
        crossing: index of the crossing that is passed, shape (2n,).
        over: whether the pass is the over-strand of its crossing, shape (2n,).
        component: on which the pass lies, shape (2n,).
        signs: of the crossings, shape (n,).
    """

    crossing: NDArray[np.int64]
    over: NDArray[np.bool_]
    component: NDArray[np.int64]
    signs: NDArray[np.int64]


def view_frame(view: ArrayLike) -> Array:
    """Axes of the picture that an observer sees.

    Args:
        view: direction from the knot to the observer, shape (3,), of any length.

    Returns:
        Unit vectors to the right, upwards and towards the observer as rows, shape (3, 3). Upwards is +z as far as
        possible, +y for a view nearly along z.

    Raises:
        InputError: a view of length zero.
    """
    towards = unit(view)
    up = np.array([0.0, 0.0, 1.0]) if abs(towards[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    right = unit(np.cross(up, towards))
    return np.stack([right, np.cross(towards, right), towards])


def _passes(starts: Array, stops: Array, follower: NDArray[np.int64], component: NDArray[np.int64]) -> _Passes:
    """Find all crossings of edges that are given in the axes of the picture.

    Args:
        starts: first points of the edges, in the order of traversal, shape (n, 3).
        stops: their last points, shape (n, 3).
        follower: index of the edge that follows each edge, -1 at an open end, shape (n,).
        component: of each edge, shape (n,).
    """
    capacity = 64
    while True:
        count, edges, places, over, signs = _find_crossings(starts, stops, follower, capacity)
        if count <= capacity:
            break
        capacity = count
    edges, places = edges[:count].ravel(), places[:count].ravel()
    order = np.lexsort((places, edges))
    upper = np.column_stack([over[:count], ~over[:count]]).ravel()
    crossing = np.repeat(np.arange(count), 2)
    return _Passes(crossing[order], upper[order], component[edges[order]], signs[:count])


@kernel
def _find_crossings(
    starts: Array, stops: Array, follower: NDArray[np.int64], capacity: int
) -> tuple[int, NDArray[np.int64], Array, NDArray[np.bool_], NDArray[np.int64]]:
    """Number of crossings and, of as many as the capacity, edges, parameters on them, first edge over, and sign."""
    edges = np.empty((capacity, 2), dtype=np.int64)
    places = np.empty((capacity, 2))
    over = np.empty(capacity, dtype=np.bool_)
    signs = np.empty(capacity, dtype=np.int64)
    count = 0
    for i in range(len(starts)):
        ux, uy = stops[i, 0] - starts[i, 0], stops[i, 1] - starts[i, 1]
        for j in range(i + 1, len(starts)):
            if follower[i] == j or follower[j] == i:
                continue
            vx, vy = stops[j, 0] - starts[j, 0], stops[j, 1] - starts[j, 1]
            wx, wy = starts[j, 0] - starts[i, 0], starts[j, 1] - starts[i, 1]
            determinant = ux * vy - uy * vx
            if determinant == 0.0:
                continue
            s, t = (wx * vy - wy * vx) / determinant, (wx * uy - wy * ux) / determinant
            if s < 0.0 or s >= 1.0 or t < 0.0 or t >= 1.0:
                continue
            if count < capacity:
                height_i = starts[i, 2] + s * (stops[i, 2] - starts[i, 2])
                height_j = starts[j, 2] + t * (stops[j, 2] - starts[j, 2])
                edges[count, 0], edges[count, 1] = i, j
                places[count, 0], places[count, 1] = s, t
                over[count] = height_i > height_j
                signs[count] = 1 if (determinant > 0.0) == over[count] else -1
            count += 1
    return count, edges, places, over, signs


def crossing_signature(points: ArrayLike, view: ArrayLike = FRONT) -> str:
    """Signed Gauss code of an open polyline in a projection, such as `O1- U2- U3+ O2- ...`.

    The passes are listed from the first to the last point: O for over, U for under, the number of the crossing in the
    order of first passes, and its sign. The ends are not continued.

    Args:
        points: shape (n, 3), beginning with the loading end.
        view: direction from the knot to the observer, shape (3,); by default the observer is at -y.

    Returns:
        Empty for a curve that does not cross itself in this projection.

    Raises:
        InputError: points that `as_points` refuses, or a view of length zero.
    """
    x = as_points(points) @ view_frame(view).T
    edges = len(x) - 1
    follower = np.append(np.arange(1, edges), -1)
    passes = _passes(x[:-1].copy(), x[1:].copy(), follower, np.zeros(edges, dtype=np.int64))
    names: dict[int, int] = {}
    code = []
    for crossing, over in zip(passes.crossing.tolist(), passes.over.tolist(), strict=True):
        number = names.setdefault(crossing, len(names) + 1)
        code.append(f"{'O' if over else 'U'}{number}{'+' if passes.signs[crossing] > 0 else '-'}")
    return " ".join(code)


def diagram(polygons: Sequence[ArrayLike], view: ArrayLike = FRONT) -> Diagram:
    """Diagram of a knot or link in a projection.

    Args:
        polygons: closed, each of shape (n, 3), the first point not repeated.
        view: direction from the knot to the observer, shape (3,).

    Raises:
        InputError: points that `as_points` refuses, or a view of length zero.
    """
    frame = view_frame(view)
    closed = [as_points(polygon) @ frame.T for polygon in polygons]
    sizes = [len(polygon) for polygon in closed]
    first = np.concatenate([[0], np.cumsum(sizes)])
    follower = np.arange(1, first[-1] + 1)
    follower[first[1:] - 1] = first[:-1]
    starts = np.concatenate(closed)
    component = np.repeat(np.arange(len(sizes)), sizes)
    passes = _passes(starts, starts[follower], follower, component)
    return _planar_code(passes, len(sizes))


def _planar_code(passes: _Passes, components: int) -> Diagram:
    """Number the arcs from 1 along the components and collect the four arcs of each crossing."""
    corners: list[dict[bool, tuple[int, int]]] = [{} for _ in passes.signs]
    loops = 0
    for number in range(components):
        on = np.flatnonzero(passes.component == number)
        loops += len(on) == 0
        for k, index in enumerate(on):
            leaving = on[(k + 1) % len(on)]
            corners[passes.crossing[index]][bool(passes.over[index])] = (int(index) + 1, int(leaving) + 1)
    code = []
    for corner, sign in zip(corners, passes.signs, strict=True):
        (under_in, under_out), (over_in, over_out) = corner[False], corner[True]
        right, left = (over_out, over_in) if sign > 0 else (over_in, over_out)
        code.append((under_in, right, under_out, left))
    return Diagram(tuple(code), tuple(int(sign) for sign in passes.signs), loops)
