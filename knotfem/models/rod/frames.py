"""Directors of the edges, and the hinges between edges at which a rod bends and twists.

The director of an edge is that of the last accepted state, carried by the smallest rotation from the edge's old
direction to its new one, and turned by the edge's spin. All this is a function of the unknowns alone for the length of
a step, so that the energies have gradients and symmetric second derivatives in plain coordinates.

A clamp is an edge of given direction beyond the end, with a hinge of half a cell between: the rod then turns by
kappa h/2 from its end to the middle of its first edge. (Holding the first edge instead would shorten the rod by h/2.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from knotfem.compiled import kernel
from knotfem.geometry.rotation import angle_about, nearest_turn, transport, unit
from knotfem.mesh.rod_layout import RodLayout
from knotfem.solver.term import Arrays, StepStart, Term

Orientation = Callable[[float], tuple[np.ndarray, np.ndarray]]
"""Tangent (along the arclength) and director of a clamp as functions of time [s]."""


@kernel
def edge(x, tangent0, j, t):
    """Direction of an edge into t; returns its length. Edges beyond the nodes are clamps."""
    if j >= x.shape[0]:
        for i in range(3):
            t[i] = tangent0[j, i]
        return 1.0
    for i in range(3):
        t[i] = x[j + 1, i] - x[j, i]
    return unit(t, t)


@kernel(inline="always")
def spin(x, per_radius, j):
    """Spin of an edge [rad]."""
    return x[j, 3] * per_radius[j] if j < x.shape[0] else 0.0


@kernel
def directors(x, edges, tangent0, director0, tangent, director):
    """Directions and unspun directors of edges at x."""
    t, f = np.empty(3), np.empty(3)
    for j in edges:
        edge(x, tangent0, j, t)
        transport(tangent0[j], t, director0[j], f)
        for i in range(3):
            tangent[j, i], director[j, i] = t[i], f[i]


@kernel
def relative_turns(hinges, tangent, director, turn0, turn):
    """Angle from the left edge's director, carried over each hinge, to the right one's; the turn nearest to turn0."""
    u = np.empty(3)
    for k in range(hinges.shape[0]):
        a, b = hinges[k]
        transport(tangent[a], tangent[b], director[a], u)
        turn[k] = nearest_turn(angle_about(tangent[b], u, director[b]), turn0[k])


@dataclass(frozen=True)
class Clamp:
    """An end whose orientation is given.

    Args:
        node: first or last node of a rod.
        orientation: tangent and director, see `Orientation`.
    """

    node: int
    orientation: Orientation


@dataclass
class Frames(Term):
    """What bending, twisting and friction need to know of directions; exerts no force itself.

    Args:
        layout: of the rods.
        x: positions and spins, shape [nodes, 4].
        director: of each edge, across it, before its spin, shape [nodes, 3]; rows of last nodes are ignored.

    Attributes:
        hinges: left and right edge, first those at the inner nodes, then the clamps', shape [hinges, 2].
        cell: length that each hinge stands for [mm], shape [hinges].
        tangent0, director0: of the accepted state, edges and clamps, shape [nodes + clamps, 3].
        turn0: relative turn of the accepted state [rad], shape [hinges].
    """

    layout: RodLayout
    x: np.ndarray
    director: np.ndarray
    clamps: list[Clamp] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self.name = "frames"
        layout = self.layout
        self.per_radius = layout.per_radius
        self.tangent0 = np.zeros((layout.nodes, 3))
        step = self.x[layout.edges + 1, :3] - self.x[layout.edges, :3]
        t = step / np.linalg.norm(step, axis=1)[:, None]
        self.tangent0[layout.edges] = t
        d = self.director[layout.edges]
        d = d - np.einsum("ji,ji->j", d, t)[:, None] * t
        self.director0 = np.zeros_like(self.tangent0)
        self.director0[layout.edges] = d / np.linalg.norm(d, axis=1)[:, None]
        inner = layout.inner
        self._inner = np.stack([inner - 1, inner], axis=1)
        self._inner_cell = layout.spacing[layout.rod[inner]]
        self.turn0 = np.zeros(inner.size)
        self.set_clamps([], self.x, 0.0)
        self.turn0 = self._turns(self.tangent0, self.director0)

    def set_clamps(self, clamps: list[Clamp], x: np.ndarray, time: float) -> None:
        """Let other ends be clamped from now on, the rod being at x, shape [nodes, 4].

        Whole turns are taken such that the clamps twist the rod least.
        """
        layout, n = self.layout, self.layout.nodes
        self.clamps = clamps
        extra = np.zeros((len(clamps), 3))
        self.tangent0 = np.concatenate([self.tangent0[:n], extra])
        self.director0 = np.concatenate([self.director0[:n], extra])
        ghosts = np.array(
            [
                (n + c, clamp.node) if clamp.node in layout.first[:-1] else (clamp.node - 1, n + c)
                for c, clamp in enumerate(clamps)
            ],
            dtype=np.int64,
        ).reshape(-1, 2)
        self.hinges = np.concatenate([self._inner, ghosts])
        half = 0.5 * layout.spacing[layout.rod[[clamp.node for clamp in clamps]]] if clamps else np.zeros(0)
        self.cell = np.concatenate([self._inner_cell, half])
        angle = np.concatenate([x[:, 3] * self.per_radius, np.zeros(len(clamps))])
        untwisted = angle[ghosts[:, 0]] - angle[ghosts[:, 1]]
        self.turn0 = np.concatenate([self.turn0[: len(self._inner)], untwisted])
        self._orient(time)
        if clamps:
            self.turn0[-len(clamps) :] = self._turns(self.tangent0, self.director0)[-len(clamps) :]

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """Arguments of compiled loops, in their order."""
        return self.hinges, self.cell, self.tangent0, self.director0, self.turn0, self.per_radius

    @property
    def material_arrays(self) -> tuple[np.ndarray, ...]:
        """tangent0, director0, turn of the hinge ahead of each edge, 1/radius: for material points."""
        ahead = np.zeros(self.layout.nodes)
        ahead[self._inner[:, 0]] = self.turn0[: len(self._inner)]
        return self.tangent0, self.director0, ahead, self.per_radius

    @property
    def stencils(self) -> np.ndarray:
        """The two nodes of the left and the right edge of each hinge, -1 for a clamp, shape [hinges, 4]."""
        a, b = self.hinges.T
        stencil = np.stack([a, a + 1, b, b + 1], axis=1)
        stencil[a >= self.layout.nodes, :2] = -1
        stencil[b >= self.layout.nodes, 2:] = -1
        return stencil

    def current(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Directions and unspun directors of all edges and clamps at x, shape [edges + clamps, 3] each."""
        tangent, director = self.tangent0.copy(), self.director0.copy()
        directors(x, self.layout.edges, self.tangent0, self.director0, tangent, director)
        return tangent, director

    def material(self, x: np.ndarray) -> np.ndarray:
        """Material directors, spin included, of all edges, shape [nodes, 3]; zero at last nodes."""
        n = self.layout.nodes
        tangent, director = self.current(x)
        tangent, director = tangent[:n], director[:n]
        angle = (x[:, 3] * self.per_radius)[:, None]
        return np.cos(angle) * director + np.sin(angle) * np.cross(tangent, director)

    def twists(self, x: np.ndarray) -> np.ndarray:
        """Twist of each hinge [rad], positive right-handed, shape [hinges]."""
        angle = np.concatenate([x[:, 3] * self.per_radius, np.zeros(len(self.clamps))])
        return self._turns(*self.current(x)) + angle[self.hinges[:, 1]] - angle[self.hinges[:, 0]]

    def begin(self, start: StepStart) -> None:
        self._orient(start.end)

    def commit(self, x: np.ndarray) -> None:
        tangent, director = self.current(x)
        self.turn0 = self._turns(tangent, director)
        self.tangent0, self.director0 = tangent, director

    def history(self) -> Arrays:
        return {
            "tangent": self.tangent0.copy(),
            "director": self.director0.copy(),
            "turn": self.turn0.copy(),
        }

    def load(self, history: Arrays) -> None:
        self.tangent0, self.director0 = history["tangent"].copy(), history["director"].copy()
        self.turn0 = history["turn"].copy()

    def _orient(self, time: float) -> None:
        for c, clamp in enumerate(self.clamps):
            tangent, director = clamp.orientation(time)
            self.tangent0[self.layout.nodes + c] = tangent
            self.director0[self.layout.nodes + c] = director

    def _turns(self, tangent: np.ndarray, director: np.ndarray) -> np.ndarray:
        turn = np.empty(len(self.hinges))
        relative_turns(self.hinges, tangent, director, self.turn0, turn)
        return turn
