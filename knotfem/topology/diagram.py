"""Knot diagrams: projections of polylines with their crossings."""

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
"""Direction from the knot to a viewer at -y."""


@dataclass(frozen=True)
class Diagram:
    """A link diagram as a planar diagram (PD) code.

    Attributes:
        crossings: four arcs a crossing, counter-clockwise, beginning with the lower strand's incoming one.
        signs: +1 or -1 a crossing (right-handed is +1).
        loops: components without any crossing.
    """

    crossings: tuple[tuple[int, int, int, int], ...]
    signs: tuple[int, ...]
    loops: int = 0

    @property
    def writhe(self) -> int:
        """Sum of the signs."""
        return sum(self.signs)

    def __str__(self) -> str:
        """The PD code as `PD[X[1,5,2,4],...]`."""
        return "PD[" + ",".join(f"X[{','.join(map(str, crossing))}]" for crossing in self.crossings) + "]"


@dataclass(frozen=True)
class _Passes:
    """Crossings of a projection: two passes each, along all edges of all components.

    Attributes:
        crossing: of the pass, in the order of travel, shape (2 crossings,).
        over: whether it is the upper one.
        component: it lies on.
        signs: of the crossings, shape (crossings,).
    """

    crossing: NDArray[np.int64]
    over: NDArray[np.bool_]
    component: NDArray[np.int64]
    signs: NDArray[np.int64]


def view_frame(view: ArrayLike) -> Array:
    """Rows right, up, towards the viewer, shape (3, 3), for a direction from the knot to the viewer."""
    towards = unit(view)
    up = np.array([0.0, 0.0, 1.0]) if abs(towards[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    right = unit(np.cross(up, towards))
    return np.stack([right, np.cross(towards, right), towards])


def _passes(starts: Array, stops: Array, follower: NDArray[np.int64], component: NDArray[np.int64]) -> _Passes:
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
            turn = ux * vy - uy * vx
            if turn == 0.0:
                continue
            s, t = (wx * vy - wy * vx) / turn, (wx * uy - wy * ux) / turn
            if s < 0.0 or s >= 1.0 or t < 0.0 or t >= 1.0:
                continue
            if count < capacity:
                height_i = starts[i, 2] + s * (stops[i, 2] - starts[i, 2])
                height_j = starts[j, 2] + t * (stops[j, 2] - starts[j, 2])
                edges[count, 0], edges[count, 1] = i, j
                places[count, 0], places[count, 1] = s, t
                over[count] = height_i > height_j
                signs[count] = 1 if (turn > 0.0) == over[count] else -1
            count += 1
    return count, edges, places, over, signs


def crossing_signature(points: ArrayLike, view: ArrayLike = FRONT) -> str:
    """Crossings of an open polyline in the order of travel, such as `O1- U2- U3+ O2- ...`.

    O is over, U under; crossings are numbered by their first pass; the sign is the crossing's handedness. The ends are
    not extended.

    Args:
        points: shape (n, 3), first = loading end.
        view: direction from the knot to the viewer, shape (3,); by default the viewer is at -y.

    Returns:
        Empty for a curve that does not cross itself in this view.
    """
    x = as_points(points) @ view_frame(view).T
    edges = len(x) - 1
    follower = np.append(np.arange(1, edges), -1)
    passes = _passes(x[:-1].copy(), x[1:].copy(), follower, np.zeros(edges, dtype=np.int64))
    names: dict[int, int] = {}
    words = []
    for crossing, over in zip(passes.crossing.tolist(), passes.over.tolist(), strict=True):
        number = names.setdefault(crossing, len(names) + 1)
        words.append(f"{'O' if over else 'U'}{number}{'+' if passes.signs[crossing] > 0 else '-'}")
    return " ".join(words)


def diagram(polygons: Sequence[ArrayLike], view: ArrayLike = FRONT) -> Diagram:
    """Project closed polygons (a knot or a link) to a diagram.

    Args:
        polygons: each shape (n, 3), without repetition of the first point.
        view: direction from the knot to the viewer, shape (3,).
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
    """Number the arcs from 1 along each component and write down the four arcs of every crossing."""
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
