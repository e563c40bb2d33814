"""Bending of a naturally straight rod of circular section.

At each hinge between edges of directions a and b the energy is B/(2 l) |kappa b|^2 with the integrated curvature
|kappa b|^2 = 4 (1 - c)/(1 + c), c = a . b (Bergou et al. 2008, Eq. 2), which grows without bound as an edge folds
back. For equal stiffness in all directions no material frame is needed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from knotfem.rod.frames import Frames, edge
from knotfem.rod.rotation import dot
from knotfem.rod.sparsity import add_blocks, matrix_arguments, stencil_keys
from knotfem.solver.effect import Effect
from knotfem.solver.sparsity import Matrix


@njit(cache=True)
def _energy(x, hinges, tangent0, modulus):
    a, b = np.empty(3), np.empty(3)
    total = 0.0
    for k in range(hinges.shape[0]):
        edge(x, tangent0, hinges[k, 0], a)
        edge(x, tangent0, hinges[k, 1], b)
        c = dot(a, b)
        total += 2.0 * modulus[k] * (1.0 - c) / (1.0 + c)
    return total


@njit(cache=True)
def _assemble(x, hinges, stencils, tangent0, modulus, residual, tangent, node_ptr, node_adj, data):
    a, b = np.empty(3), np.empty(3)
    g = np.empty((2, 3))
    H = np.empty((2, 2, 3, 3))
    block = np.zeros((16, 16))
    for k in range(hinges.shape[0]):
        la = edge(x, tangent0, hinges[k, 0], a)
        lb = edge(x, tangent0, hinges[k, 1], b)
        c = dot(a, b)
        first = -4.0 * modulus[k] / (1.0 + c) ** 2
        second = 8.0 * modulus[k] / (1.0 + c) ** 3
        for i in range(3):
            g[0, i] = (b[i] - c * a[i]) / la
            g[1, i] = (a[i] - c * b[i]) / lb
        for p in range(4):
            node = stencils[k, p]
            if node >= 0:
                sign = -1.0 if p % 2 == 0 else 1.0
                for i in range(3):
                    residual[node, i] += sign * first * g[p // 2, i]
        if not tangent:
            continue
        for i in range(3):
            for j in range(3):
                same = 1.0 if i == j else 0.0
                H[0, 0, i, j] = -(a[i] * g[0, j] + g[0, i] * a[j] + c * (same - a[i] * a[j]) / la) / la
                H[1, 1, i, j] = -(b[i] * g[1, j] + g[1, i] * b[j] + c * (same - b[i] * b[j]) / lb) / lb
                H[0, 1, i, j] = (same - b[i] * b[j] - a[i] * a[j] + c * a[i] * b[j]) / (la * lb)
                H[1, 0, j, i] = H[0, 1, i, j]
        for p in range(4):
            for q in range(4):
                sign = 1.0 if (p + q) % 2 == 0 else -1.0
                for i in range(3):
                    for j in range(3):
                        value = second * g[p // 2, i] * g[q // 2, j] + first * H[p // 2, q // 2, i, j]
                        block[4 * p + i, 4 * q + j] = sign * value
        if not add_blocks(stencils[k], stencils[k], block, node_ptr, node_adj, data):
            return False
    return True


@dataclass
class Bend(Effect):
    """Bending stiffness of all hinges.

    Args:
        frames: whose hinges bend.
        stiffness: B of each rod [N mm^2], shape [rods].
    """

    frames: Frames
    stiffness: np.ndarray

    def __post_init__(self) -> None:
        self.name = "bend"

    @property
    def modulus(self) -> np.ndarray:
        """Stiffness over length of each hinge [N mm], shape [hinges]."""
        return np.asarray(self.stiffness, dtype=float)[hinge_rods(self.frames)] / self.frames.cell

    def keys(self, nodes: int) -> np.ndarray:
        return stencil_keys(self.frames.stencils, nodes)

    def curvature(self, x: np.ndarray) -> np.ndarray:
        """Curvature of each hinge [1/mm], shape [hinges]."""
        tangent = self.frames.current(x)[0]
        a, b = tangent[self.frames.hinges[:, 0]], tangent[self.frames.hinges[:, 1]]
        c = np.einsum("ki,ki->k", a, b)
        return 2.0 * np.sqrt(np.maximum(1.0 - c, 0.0) / (1.0 + c)) / self.frames.cell

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        f = self.frames
        return _assemble(x, f.hinges, f.stencils, f.tangent0, self.modulus, residual, *matrix_arguments(matrix))

    def merit(self, x: np.ndarray) -> float:
        return self.energy(x)

    def energy(self, x: np.ndarray) -> float:
        return _energy(x, self.frames.hinges, self.frames.tangent0, self.modulus)


def hinge_rods(frames: Frames) -> np.ndarray:
    """Rod of each hinge, shape [hinges]."""
    stencils = frames.stencils
    return frames.layout.rod[np.where(stencils[:, 0] >= 0, stencils[:, 0], stencils[:, 2])]
