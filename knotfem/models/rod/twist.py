"""Twisting: energy C/(2 l) m^2 at each hinge, m the angle between the material frames of its edges.

With k as in `knotfem.geometry.rotation`, a and b the directions of the edges and a0, b0 those of the accepted state,

    dm = dtheta_b - dtheta_a + [k(a, b) + k(a0, a)] . da + [k(a, b) - k(b0, b)] . db:

the first bracket's k(a, b) is Bergou et al.'s (2008, Eq. 9), the others come from carrying the directors from the
accepted state in one piece.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.compiled import kernel
from knotfem.geometry.rotation import (
    angle_about,
    half_binormal,
    half_binormal_rate,
    nearest_turn,
    transport,
)
from knotfem.models.rod.frames import edge, spin
from knotfem.models.rod.hinges import Hinged
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.rod_pattern import add_blocks, matrix_arguments


@kernel
def _twist(x, hinge, tangent0, director0, turn0, per_radius, a, b, f, u, g):
    """Twist of a hinge; fills directions and lengths of its edges."""
    la = edge(x, tangent0, hinge[0], a)
    lb = edge(x, tangent0, hinge[1], b)
    transport(tangent0[hinge[0]], a, director0[hinge[0]], f)
    transport(a, b, f, u)
    transport(tangent0[hinge[1]], b, director0[hinge[1]], g)
    turn = nearest_turn(angle_about(b, u, g), turn0)
    return turn + spin(x, per_radius, hinge[1]) - spin(x, per_radius, hinge[0]), la, lb


@kernel
def _energy(x, hinges, tangent0, director0, turn0, per_radius, rest, modulus):
    a, b, f, u, g = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    total = 0.0
    for k in range(hinges.shape[0]):
        m = _twist(x, hinges[k], tangent0, director0, turn0[k], per_radius, a, b, f, u, g)[0] - rest[k]
        total += 0.5 * modulus[k] * m * m
    return total


@kernel
def _assemble(
    x, hinges, stencils, tangent0, director0, turn0, per_radius, rest, modulus, residual, tangent, node_ptr, node_adj,
    data,
):  # fmt: skip
    a, b, f, u, g = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    kab, kaa, kbb = np.empty(3), np.empty(3), np.empty(3)
    da, db, still = np.empty(3), np.empty(3), np.zeros(3)
    dab, daa, dbb = np.empty(3), np.empty(3), np.empty(3)
    grad = np.empty(16)
    slope = np.empty((2, 3))
    rate = np.empty((2, 3, 2, 3))
    block = np.zeros((16, 16))
    for k in range(hinges.shape[0]):
        ja, jb = hinges[k]
        m, la, lb = _twist(x, hinges[k], tangent0, director0, turn0[k], per_radius, a, b, f, u, g)
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
        if stencils[k, 0] >= 0:
            grad[3] = -per_radius[stencils[k, 0]]
        if stencils[k, 2] >= 0:
            grad[11] = per_radius[stencils[k, 2]]
        for p in range(4):
            if stencils[k, p] >= 0:
                for i in range(4):
                    residual[stencils[k, p], i] += modulus[k] * m * grad[4 * p + i]
        if not tangent:
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
        if not add_blocks(stencils[k], stencils[k], block, node_ptr, node_adj, data):
            return False
    return True


@dataclass
class Twist(Hinged):
    """Twisting stiffness of all hinges.

    Args:
        frames: whose hinges twist.
        stiffness: C of each rod [N mm^2], shape [rods].
    """

    def __post_init__(self) -> None:
        self.name = "twist"

    @property
    def rest(self) -> np.ndarray:
        """Twist of each hinge when free of stress [rad], shape [hinges]."""
        return np.zeros(len(self.frames.hinges))

    def torque(self, x: np.ndarray) -> np.ndarray:
        """Twisting moment of each hinge [N mm], shape [hinges]."""
        return self.modulus * (self.frames.twists(x) - self.rest)

    def clamp_couples(self, x: np.ndarray) -> np.ndarray:
        a, b, left = self._clamps(x)
        k = np.cross(a, b) / (1.0 + np.einsum("ki,ki->k", a, b)[:, None])
        torque = self.torque(x)[self._clamped, None]
        return torque * np.where(left, np.cross(a, k) - a, b + np.cross(b, k))

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        f = self.frames
        return _assemble(
            x, f.hinges, f.stencils, f.tangent0, f.director0, f.turn0, f.per_radius, self.rest, self.modulus,
            residual, *matrix_arguments(matrix),
        )  # fmt: skip

    def energy(self, x: np.ndarray) -> float:
        f = self.frames
        return _energy(x, f.hinges, f.tangent0, f.director0, f.turn0, f.per_radius, self.rest, self.modulus)
