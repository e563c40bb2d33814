"""Directors of the edges, and the vertices between edges at which a rod bends and twists.

The director of an edge is that of the last accepted state, carried by the smallest rotation from the edge's old
direction to its new one, and turned by the rotation of the edge about itself. All this is a function of the unknowns
alone for the length of a step, so that the energies have gradients and symmetric second derivatives in plain
coordinates.

A clamp is an edge of given direction beyond the end, with a vertex of half a cell between: the rod then turns by
kappa h/2 from its end to the middle of its first edge. (Holding the first edge instead would shorten the rod by h/2.)
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import NamedTuple, Self

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.material_frames import FrameView
from knotfem.geometry.frames import material_frames
from knotfem.geometry.rotation import angle_about, nearest_turn, transport, unit
from knotfem.geometry.vectors import unit_vectors
from knotfem.mesh.rod_layout import RodLayout
from knotfem.solver.constraints import Clamp
from knotfem.solver.term import Role, Term, TimeStep
from knotfem.types import Arrays


class VertexView(NamedTuple):
    """Vertices at which rods bend and twist, and the frames of their edges in the accepted state.

    Attributes:
        edges: left and right edge of each vertex, first at the inner nodes, then the clamps', shape [vertices, 2].
        stencil: the two nodes of the left and of the right edge, -1 for a clamp, shape [vertices, 4].
        tangent: direction of each edge and clamp, shape [nodes + clamps, 3].
        director: of each, before its rotation about the edge, shape [nodes + clamps, 3].
        turn: angle from the left edge's director, carried over the vertex, to the right one's [rad], shape [vertices].
        per_radius: 1/radius at each node [1/mm], shape [nodes].
    """

    edges: np.ndarray
    stencil: np.ndarray
    tangent: np.ndarray
    director: np.ndarray
    turn: np.ndarray
    per_radius: np.ndarray


@kernel
def edge(x: np.ndarray, tangent0: np.ndarray, j: int, t: np.ndarray) -> float:
    """Direction of an edge into t; returns its length. Edges beyond the nodes are clamps."""
    if j >= x.shape[0]:
        for i in range(3):
            t[i] = tangent0[j, i]
        return 1.0
    for i in range(3):
        t[i] = x[j + 1, i] - x[j, i]
    return unit(t, t)


@kernel(inline="always")
def rotation_of(x: np.ndarray, per_radius: np.ndarray, j: int) -> float:
    """Rotation of an edge about itself [rad]; none of a clamp."""
    return x[j, 3] * per_radius[j] if j < x.shape[0] else 0.0


@kernel
def directors(
    x: np.ndarray, edges: np.ndarray, tangent0: np.ndarray, director0: np.ndarray, tangent: np.ndarray,
    director: np.ndarray,
) -> None:  # fmt: skip
    """Directions and directors, before their rotation, of edges at x."""
    t, f = np.empty(3), np.empty(3)
    for j in edges:
        edge(x, tangent0, j, t)
        transport(tangent0[j], t, director0[j], f)
        for i in range(3):
            tangent[j, i], director[j, i] = t[i], f[i]


@kernel
def relative_turns(
    edges: np.ndarray, tangent: np.ndarray, director: np.ndarray, turn0: np.ndarray, turn: np.ndarray
) -> None:
    """Angle from the left edge's director, carried over each vertex, to the right one's; the one nearest to turn0."""
    u = np.empty(3)
    for k in range(edges.shape[0]):
        a, b = edges[k]
        transport(tangent[a], tangent[b], director[a], u)
        turn[k] = nearest_turn(angle_about(tangent[b], u, director[b]), turn0[k])


class Frames(Term):
    """What bending, twisting and friction need to know of directions; exerts no force itself.

    Args:
        layout: of the rods.
        x: positions and rotations, shape [nodes, 4].
        director: of each edge, across it, before its rotation, shape [nodes, 3]; rows of last nodes are ignored.

    Raises:
        InputError: a director along its edge.

    Attributes:
        clamped: nodes of the clamped ends, shape [clamps].
        cell: length that each vertex stands for [mm], shape [vertices].
        view: vertices and frames.
    """

    name, role = "frames", Role.KINEMATICS

    def __init__(self, layout: RodLayout, x: np.ndarray, director: np.ndarray) -> None:
        self.layout = layout
        self._per_radius = layout.per_radius
        t = unit_vectors(x[layout.edges + 1, :3] - x[layout.edges, :3])
        tangent0, director0 = np.zeros((layout.nodes, 3)), np.zeros((layout.nodes, 3))
        tangent0[layout.edges] = t
        director0[layout.edges] = material_frames(t, director[layout.edges])[:, 0]
        inner = layout.inner
        self._inner = np.stack([inner - 1, inner], axis=1)
        self._inner_cell = 0.5 * (layout.spacing[inner - 1] + layout.spacing[inner])
        self._set(np.zeros(0, dtype=np.int64), tangent0, director0, np.zeros(inner.size))
        self._set(self.clamped, tangent0, director0, self._turns(tangent0, director0))
        self._initial = self.history()

    def of(self, history: Arrays) -> Self:
        """Frames of the same rods with other history variables; these here stay as they are."""
        other = copy(self)
        other.load(history)
        return other

    def clamped_at(self, clamps: Sequence[Clamp], x: np.ndarray, time: float) -> Arrays:
        """Take other clamps, the rods being at x, shape [nodes, 4]; returns the history variables with them.

        Whole turns are taken such that the clamps twist the rod least.

        Args:
            clamps: from now on.
            x: positions and rotations, shape [nodes, 4].
            time: [s].
        """
        n, v = self.layout.nodes, self.view
        extra = np.zeros((len(clamps), 3))
        nodes = np.array([clamp.node for clamp in clamps], dtype=np.int64)
        turn = np.concatenate([v.turn[: len(self._inner)], np.zeros(len(clamps))])
        self._set(nodes, np.concatenate([v.tangent[:n], extra]), np.concatenate([v.director[:n], extra]), turn)
        edges = self.view.edges[len(self._inner) :]
        angle = np.concatenate([x[:, 3] * self._per_radius, np.zeros(len(clamps))])
        self.view.turn[len(self._inner) :] = angle[edges[:, 0]] - angle[edges[:, 1]]
        self._orient(clamps, time)
        if clamps:
            turns = self._turns(self.view.tangent, self.view.director)
            self.view.turn[len(self._inner) :] = turns[len(self._inner) :]
        return self.history()

    @property
    def material_view(self) -> FrameView:
        """Frames of the segments, for material points."""
        v, ahead = self.view, np.zeros(self.layout.nodes)
        ahead[self._inner[:, 0]] = v.turn[: len(self._inner)]
        return FrameView(v.tangent, v.director, ahead, self._per_radius)

    @property
    def rods(self) -> np.ndarray:
        """Rod of each vertex, shape [vertices]."""
        stencil = self.view.stencil
        return self.layout.rod[np.where(stencil[:, 0] >= 0, stencil[:, 0], stencil[:, 2])]

    def current(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Directions and directors before their rotation of all edges and clamps at x, shape [edges + clamps, 3]."""
        tangent, director = self.view.tangent.copy(), self.view.director.copy()
        directors(x, self.layout.edges, self.view.tangent, self.view.director, tangent, director)
        return tangent, director

    def material(self, x: np.ndarray) -> np.ndarray:
        """Material directors, rotation included, of all edges, shape [nodes, 3]; zero at last nodes."""
        n = self.layout.nodes
        tangent, director = self.current(x)
        tangent, director = tangent[:n], director[:n]
        angle = (x[:, 3] * self._per_radius)[:, None]
        return np.cos(angle) * director + np.sin(angle) * np.cross(tangent, director)

    def twists(self, x: np.ndarray) -> np.ndarray:
        """Twist of each vertex [rad], positive right-handed, shape [vertices]."""
        angle = np.concatenate([x[:, 3] * self._per_radius, np.zeros(self.clamped.size)])
        edges = self.view.edges
        return self._turns(*self.current(x)) + angle[edges[:, 1]] - angle[edges[:, 0]]

    def begin(self, step: TimeStep) -> None:
        self._orient(step.conditions.clamps, step.end)

    def commit(self, x: np.ndarray) -> None:
        tangent, director = self.current(x)
        turn = self._turns(tangent, director)
        self.view = self.view._replace(tangent=tangent, director=director, turn=turn)

    def history(self) -> Arrays:
        v = self.view
        return {
            "clamped": self.clamped.copy(),
            "tangent": v.tangent.copy(),
            "director": v.director.copy(),
            "turn": v.turn.copy(),
        }

    def load(self, history: Arrays) -> None:
        h = history or self._initial
        self._set(h["clamped"].copy(), h["tangent"].copy(), h["director"].copy(), h["turn"].copy())

    def _set(self, clamped: np.ndarray, tangent: np.ndarray, director: np.ndarray, turn: np.ndarray) -> None:
        layout, n = self.layout, self.layout.nodes
        self.clamped = clamped
        beyond = n + np.arange(clamped.size)
        at_start = np.isin(clamped, layout.first[:-1])
        left, right = np.where(at_start, beyond, clamped - 1), np.where(at_start, clamped, beyond)
        edges = np.concatenate([self._inner, np.stack([left, right], axis=1).astype(np.int64)])
        self.cell = np.concatenate([self._inner_cell, 0.5 * layout.spacing[np.where(at_start, clamped, clamped - 1)]])
        a, b = edges.T
        stencil = np.stack([a, a + 1, b, b + 1], axis=1)
        stencil[a >= n, :2] = -1
        stencil[b >= n, 2:] = -1
        self.view = VertexView(edges, stencil, tangent, director, turn, self._per_radius)

    def _orient(self, clamps: Sequence[Clamp], time: float) -> None:
        for c, clamp in enumerate(clamps):
            self.view.tangent[self.layout.nodes + c], self.view.director[self.layout.nodes + c] = clamp.orientation(
                time
            )

    def _turns(self, tangent: np.ndarray, director: np.ndarray) -> np.ndarray:
        turn = np.empty(len(self.view.edges))
        relative_turns(self.view.edges, tangent, director, self.view.turn, turn)
        return turn
