"""What happens to the ends of rods: held or driven places and orientations, dead and following forces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from knotfem.models.rod.frames import Orientation
from knotfem.solver.term import StepStart, Term
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.rod_pattern import add_blocks, stencil_keys

Place = Callable[[float], np.ndarray]
"""Place of an end [mm], shape [3], as a function of time [s]."""
History = Callable[[float], float]
"""A number as a function of time [s]."""


@dataclass(frozen=True)
class EndFrame:
    """Place [mm], tangent (along the arclength) and material director of an end, shape [3] each."""

    place: np.ndarray
    tangent: np.ndarray
    director: np.ndarray


@dataclass(frozen=True)
class End:
    """What happens to one end during a step; nothing of it: the end is free.

    Attributes:
        place: where the end is.
        orientation: how it points.
        force: dead force on it [N], shape [3].
        following: force along the end's own tangent, positive outwards [N].
    """

    place: Place | None = None
    orientation: Orientation | None = None
    force: Place | None = None
    following: History | None = None


def clamped(frame: EndFrame) -> End:
    """Held in place and orientation."""
    return End(lambda time: frame.place, lambda time: (frame.tangent, frame.director))


def pinned(frame: EndFrame) -> End:
    """Held in place, free to turn."""
    return End(lambda time: frame.place)


def driven(frame: EndFrame, direction: np.ndarray, path: History) -> End:
    """Carried without rotation along the unit vector `direction` by path(time) [mm]."""
    return End(lambda time: frame.place + path(time) * direction, lambda time: (frame.tangent, frame.director))


def turned(frame: EndFrame, axis: np.ndarray, angle: History, held: bool = True) -> End:
    """Turned about an axis through the end by angle(time) [rad]; its place is held or left free."""
    axis = axis / np.linalg.norm(axis)

    def turn(v: np.ndarray, a: float) -> np.ndarray:
        along = (v @ axis) * axis
        return along + np.cos(a) * (v - along) + np.sin(a) * np.cross(axis, v)

    def orientation(time: float) -> tuple[np.ndarray, np.ndarray]:
        a = angle(time)
        return turn(frame.tangent, a), turn(frame.director, a)

    return End((lambda time: frame.place) if held else None, orientation)


@dataclass
class FollowingForce(Term):
    """A force [N] on the node `outer` along the edge from `inner` to it."""

    inner: int
    outer: int
    magnitude: History
    _now: float = field(default=0.0, init=False)
    _tangent: np.ndarray = field(default_factory=lambda: np.zeros(3), init=False)

    def __post_init__(self) -> None:
        self.name = "load"
        self.symmetric = False

    def couplings(self, nodes: int) -> np.ndarray:
        return stencil_keys(np.array([[self.inner, self.outer]]), nodes)

    def begin(self, start: StepStart) -> None:
        self._now = self.magnitude(start.end)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        d = x[self.outer, :3] - x[self.inner, :3]
        length = float(np.linalg.norm(d))
        t = self._tangent = d / length
        residual[self.outer, :3] -= self._now * t
        if matrix is None:
            return True
        turn = self._now / length * (np.eye(3) - np.outer(t, t))
        block = np.zeros((4, 8))
        block[:3, :3], block[:3, 4:7] = turn, -turn
        nodes = np.array([self.inner, self.outer])
        return add_blocks(nodes[1:], nodes, block, matrix.pattern.node_ptr, matrix.pattern.node_adj, matrix.data)

    def merit(self, x: np.ndarray) -> float:
        """Of the force as a dead one along the tangent last assembled: a following force has no potential."""
        return -self._now * float(x[self.outer, :3] @ self._tangent)
