"""Twisting: energy C/(2 l) m^2 at each vertex, m the angle between the material frames of its edges.

With k as in `knotfem.geometry.rotation`, a and b the directions of the edges and a0, b0 those of the accepted state,

    dm = dtheta_b - dtheta_a + [k(a, b) + k(a0, a)] . da + [k(a, b) - k(b0, b)] . db:

the first bracket's k(a, b) is Bergou et al.'s (2008, Eq. 9), the others come from carrying the directors from the
accepted state in one piece.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.geometry.finite_rotation import half_binormals
from knotfem.geometry.rotation import (
    angle_about,
    half_binormal,
    half_binormal_rate,
    nearest_turn,
    transport,
)
from knotfem.models.rod.frames import VertexView, edge, rotation_of
from knotfem.models.rod.vertices import VertexTerm, listed
from knotfem.sparse.pattern import Matrix, view_of
from knotfem.sparse.scatter import MatrixView, add_blocks


class TwistRoom(NamedTuple):
    """Work space for one vertex: directions a and b of its edges, carried directors f, u and g, shape [3] each."""

    a: np.ndarray
    b: np.ndarray
    f: np.ndarray
    u: np.ndarray
    g: np.ndarray


@kernel
def _twist_room() -> TwistRoom:
    return TwistRoom(np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3))


@kernel
def _twist(x: np.ndarray, vertices: VertexView, k: int, room: TwistRoom) -> tuple[float, float, float]:
    """Twist of a vertex, and the lengths of its edges, whose directions are left in `room`."""
    left, right = vertices.edges[k]
    a, b = room.a, room.b
    la = edge(x, vertices.tangent, left, a)
    lb = edge(x, vertices.tangent, right, b)
    transport(vertices.tangent[left], a, vertices.director[left], room.f)
    transport(a, b, room.f, room.u)
    transport(vertices.tangent[right], b, vertices.director[right], room.g)
    turn = nearest_turn(angle_about(b, room.u, room.g), vertices.turn[k])
    rotation = rotation_of(x, vertices.per_radius, right) - rotation_of(x, vertices.per_radius, left)
    return turn + rotation, la, lb


@kernel
def _energy(x: np.ndarray, vertices: VertexView, rest: np.ndarray, modulus: np.ndarray) -> float:
    room = _twist_room()
    total = 0.0
    for k in range(vertices.edges.shape[0]):
        m = _twist(x, vertices, k, room)[0] - rest[k]
        total += 0.5 * modulus[k] * m * m
    return total


@kernel
def _assemble(
    x: np.ndarray, vertices: VertexView, rest: np.ndarray, modulus: np.ndarray, residual: np.ndarray, matrix: MatrixView
) -> bool:
    room = _twist_room()
    a, b, per_radius, tangent0 = room.a, room.b, vertices.per_radius, vertices.tangent
    kab, kaa, kbb = np.empty(3), np.empty(3), np.empty(3)
    da, db, still = np.empty(3), np.empty(3), np.zeros(3)
    dab, daa, dbb = np.empty(3), np.empty(3), np.empty(3)
    grad = np.empty(16)
    slope = np.empty((2, 3))
    rate = np.empty((2, 3, 2, 3))
    block = np.zeros((16, 16))
    for k in range(vertices.edges.shape[0]):
        ja, jb = vertices.edges[k]
        stencil = vertices.stencil[k]
        m, la, lb = _twist(x, vertices, k, room)
        m -= rest[k]
        half_binormal(a, b, kab)
        half_binormal(tangent0[ja], a, kaa)
        half_binormal(tangent0[jb], b, kbb)
        for i in range(3):
            slope[0, i] = (kab[i] + kaa[i]) / la
            slope[1, i] = (kab[i] - kbb[i]) / lb
        for p in range(4):
            sign = -1.0 if p % 2 == 0 else 1.0
            for i in range(3):
                grad[4 * p + i] = sign * slope[p // 2, i]
            grad[4 * p + 3] = 0.0
        if stencil[0] >= 0:
            grad[3] = -per_radius[stencil[0]]
        if stencil[2] >= 0:
            grad[11] = per_radius[stencil[2]]
        for p in range(4):
            if stencil[p] >= 0:
                for i in range(4):
                    residual[stencil[p], i] += modulus[k] * m * grad[4 * p + i]
        if not matrix.wanted:
            continue
        for side in range(2):
            for i in range(3):
                for j in range(3):
                    same = 1.0 if i == j else 0.0
                    da[j] = (same - a[i] * a[j]) / la if side == 0 else 0.0
                    db[j] = (same - b[i] * b[j]) / lb if side == 1 else 0.0
                half_binormal_rate(a, b, kab, da, db, dab)
                half_binormal_rate(tangent0[ja], a, kaa, still, da, daa)
                half_binormal_rate(tangent0[jb], b, kbb, still, db, dbb)
                for j in range(3):
                    rate[0, j, side, i] = (dab[j] + daa[j]) / la
                    rate[1, j, side, i] = (dab[j] - dbb[j]) / lb
                    if side == 0:
                        rate[0, j, side, i] -= slope[0, j] * a[i] / la
                    else:
                        rate[1, j, side, i] -= slope[1, j] * b[i] / lb
        for p in range(16):
            for q in range(16):
                block[p, q] = modulus[k] * grad[p] * grad[q]
        for p in range(4):
            for q in range(4):
                sign = 1.0 if (p + q) % 2 == 0 else -1.0
                for i in range(3):
                    for j in range(3):
                        block[4 * p + i, 4 * q + j] += sign * modulus[k] * m * rate[p // 2, i, q // 2, j]
        if not add_blocks(matrix, stencil, stencil, block):
            return False
    return True


class Twist(VertexTerm):
    """Twisting stiffness of all vertices.

    Args:
        frames: whose vertices twist.
        stiffness: C of each rod [N mm^2], shape [rods].
    """

    name = "twist"

    def describe(self) -> str:
        return listed(self.stiffness, "C", "N mm^2")

    @property
    def rest(self) -> np.ndarray:
        """Twist of each vertex when free of stress [rad], shape [vertices]."""
        return np.zeros(len(self.frames.view.edges))

    def torque(self, x: np.ndarray) -> np.ndarray:
        """Twisting moment of each vertex [N mm], shape [vertices]."""
        return self.modulus * (self.frames.twists(x) - self.rest)

    def clamp_couples(self, x: np.ndarray) -> np.ndarray:
        a, b, left = self.clamp_directions(x)
        k = half_binormals(a, b)
        torque = self.torque(x)[self.clamped, None]
        return torque * np.where(left, np.cross(a, k) - a, b + np.cross(b, k))

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        return _assemble(x, self.frames.view, self.rest, self.modulus, residual, view_of(matrix, residual.shape[1]))

    def energy(self, x: np.ndarray) -> float:
        return _energy(x, self.frames.view, self.rest, self.modulus)
