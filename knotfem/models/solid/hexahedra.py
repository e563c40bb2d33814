"""Compiled kernels of mixed hexahedra: deviator of a law W(I1), element pressure and incompatible modes condensed.

With the energy W(I1) + p (J - 1) - p^2 / (2 kappa), I1 = J^(-2/3) tr b, and the pressure p = sum_q p_q psi_q an unknown
of its own,

    R_q  = int psi_q (J - 1) dV - (G p)_q          G = (1/kappa) int psi psi^T dV
    b_q  = int psi_q J grad(N) dV                  (spatial gradients)
    f    = f_dev + b^T (p + G^-1 R)                K = K_dev + K_geo(p) + b^T G^-1 b
    dp   = G^-1 (R + b . du)                       after the linear solve

which for constant psi is the mean-dilatation element (Simo, Taylor and Pister 1985) with the pressure kept through
the Newton iteration. Tables depend on the section's quadrilateral only: a layer of another length than theirs is the
same seen from a reference that is stretched along the rod, by which F (with its determinant) and volumes change, and
spatial gradients do not.

Incompatible modes (`incompatible`) change the reference gradients to grad N_a + sum_m psi_m c_am beta_m and no more.
With A = K_beta,beta, once the pressure is condensed,

    f   -= K_x,beta A^-1 f_beta      K -= K_x,beta A^-1 K_beta,x
    dbeta = -A^-1 (f_beta + K_beta,x du)

Slices are assembled in two colours, every other one at a time, so that no two threads add to one node and the sums do
not depend on the number of threads.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from knotfem.compiled import kernel
from knotfem.models.solid.incompatible import condense_modes, enhance, point_modes, tangents
from knotfem.models.solid.kinematics import add_product, deformation, deviator, gather, inverse, point_tangent, refer
from knotfem.models.solid.views import (
    CondensedView,
    ElementView,
    LawView,
    ModesView,
    PlacesView,
    UnknownsView,
)
from knotfem.sparse.scatter import block_slot, row_start

BLOCK = 4
"""Slices of one colour that a thread assembles at a time, for which it makes its work space once."""


@kernel
def element_slots(nodes: np.ndarray, node_ptr: np.ndarray, node_adj: np.ndarray, slots: np.ndarray) -> None:
    """Adjacency slots of all node pairs of all elements; `slots` shape [elements, n, n], -1 where not stored."""
    for e in range(nodes.shape[0]):
        for a in range(nodes.shape[1]):
            for b in range(nodes.shape[1]):
                slots[e, a, b] = block_slot(node_ptr, node_adj, nodes[e, a], nodes[e, b])


@kernel(parallel=True, error_model="numpy")
def assemble(
    x: np.ndarray,
    elements: ElementView,
    law: LawView,
    unknowns: UnknownsView,
    condensed: CondensedView,
    residual: np.ndarray,
    matrix: PlacesView,
) -> tuple[float, float]:
    """Residual and, where wanted, the condensed tangent of all elements.

    Args:
        x: positions, shape [nodes, 3].
        elements: tables.
        law: at the integration points.
        unknowns: of the elements.
        condensed: filled.
        residual: added to, shape [nodes, 3].
        matrix: added to.

    Returns:
        Smallest determinant of the deformation gradient, and smallest pivot of the modes (see `condense_modes`).
    """
    slices = elements.nodes.shape[0]
    blocks = (slices + 2 * BLOCK - 1) // (2 * BLOCK)
    determinants = np.full(2 * blocks, np.inf)
    pivots = np.full(2 * blocks, np.inf)
    for colour in range(2):
        for block in prange(blocks):
            first = 2 * BLOCK * block + colour
            smallest = _slices(first, x, elements, law, unknowns, condensed, residual, matrix)
            determinants[2 * block + colour], pivots[2 * block + colour] = smallest
    if slices == 0:
        return np.inf, np.inf
    return determinants.min(), pivots.min()


@kernel(error_model="numpy")
def _slices(
    first: int,
    x: np.ndarray,
    elements: ElementView,
    law: LawView,
    unknowns: UnknownsView,
    condensed: CondensedView,
    residual: np.ndarray,
    matrix: PlacesView,
) -> tuple[float, float]:
    """Every other slice of `assemble`, `BLOCK` of them from `first` on.

    Long on purpose: Numba counts the references of every array and view that is handed to a function, which costs a
    tenth of the time where it happens for each element. So the loops over the work space stand here. And this function
    is called, not inlined: in the body of a parallel loop, Numba drops what is written to an array of a view.
    """
    _, quads, count = elements.nodes.shape
    extra, pressures = unknowns.modes.shape[2], unknowns.pressure.shape[2]
    whole = count + extra
    y, enhanced = np.empty((count, 3)), np.empty((count, 3))
    F, inv, s = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    g, sg, f = np.empty((3, whole)), np.empty((3, whole)), np.empty((3, whole))
    K = np.empty((3, 3, whole, whole))
    b, R = np.empty((pressures, 3, whole)), np.empty(pressures)
    modes = ModesView(np.empty((extra, 3)), np.empty((3, extra)), inv, s, g, sg, f, K)
    A = np.empty((3 * extra, 3 * extra))
    stiff, curved = matrix.wanted or extra > 0, law.first.size > 0
    determinant, pivot = np.inf, np.inf
    for layer in range(first, min(first + 2 * BLOCK, elements.nodes.shape[0]), 2):
        height = elements.heights[layer]
        for e in range(quads):
            nodes = elements.nodes[layer, e]
            gather(x, nodes, y)
            f[:] = 0.0
            b[:] = 0.0
            R[:] = 0.0
            if stiff:
                K[:] = 0.0
            if extra > 0:
                tangents(y, elements.centre, modes.tangents)
            for q in range(elements.weights.shape[1]):
                grad = elements.grads[e, q]
                w = height * elements.weights[e, q]
                if extra > 0:
                    enhance(grad, elements.modes[e, q], elements.centre, unknowns.modes[layer, e], enhanced)
                    grad = enhanced
                J = deformation(y, grad, F)
                inverse(F, J, inv)
                J = refer(F, J, height)
                determinant = min(determinant, J)
                mu = 2.0 * law.first[layer, e, q] if curved else law.mu
                trace = deviator(F, mu * w * abs(J) ** (-2.0 / 3.0), s)
                mu_bar = mu * w * abs(J) ** (-2.0 / 3.0) * trace / 3.0
                pressure = 0.0
                for m in range(pressures):
                    pressure += elements.psi[e, q, m] * unknowns.pressure[layer, e, m]
                    R[m] += elements.psi[e, q, m] * w * (J - 1.0)
                for a in range(count):
                    for i in range(3):
                        g[i, a] = grad[a, 0] * inv[0, i] + grad[a, 1] * inv[1, i] + grad[a, 2] * inv[2, i]
                    for i in range(3):
                        sg[i, a] = s[i, 0] * g[0, a] + s[i, 1] * g[1, a] + s[i, 2] * g[2, a]
                        f[i, a] += sg[i, a]
                        for m in range(pressures):
                            b[m, i, a] += elements.psi[e, q, m] * w * J * g[i, a]
                if stiff:
                    point_tangent(g, sg, count, mu_bar, pressure * w * J, K)
                if extra > 0:
                    point_modes(modes, elements.modes[e, q], elements.centre, mu_bar, pressure * w * J)
                    for m in range(pressures):
                        for k in range(extra):
                            for i in range(3):
                                b[m, i, count + k] += elements.psi[e, q, m] * w * J * modes.along[i, k]
                if stiff and curved and mu != 0.0:
                    add_product(4.0 * law.second[layer, e, q] / (mu * mu * w), sg, K)
            for m in range(pressures):
                total = 0.0
                for k in range(pressures):
                    total += elements.stiffness[e, m, k] / height * R[k]
                condensed.excess[layer, e, m] = total - unknowns.pressure[layer, e, m]
                for i in range(3):
                    for a in range(whole):
                        f[i, a] += total * b[m, i, a]
                        condensed.b[layer, e, m, 3 * a + i] = b[m, i, a]
            if stiff:
                _pressure_tangent(elements.stiffness[e], height, b, g, K)
            if extra > 0:
                pivot = min(pivot, condense_modes(f, K, A, condensed.follow[layer, e]))
            for a in range(count):
                for i in range(3):
                    residual[nodes[a], i] += f[i, a]
            if matrix.wanted:
                _scatter(nodes, matrix.slots[layer * quads + e], K, matrix)
    return determinant, pivot


@kernel(inline="always", error_model="numpy")
def _pressure_tangent(stiffness: np.ndarray, height: float, b: np.ndarray, g: np.ndarray, K: np.ndarray) -> None:
    """K += b^T G^-1 b.

    Args:
        stiffness: G^-1 of the tables, shape [q, q].
        height: of the layer over that of the tables.
        b: shape [q, 3, n + k].
        g: work space, shape [3, n + k].
        K: added to, shape [3, 3, n + k, n + k].
    """
    pressures, whole = b.shape[0], b.shape[2]
    for m in range(pressures):
        g[:] = 0.0
        for k in range(pressures):
            c = stiffness[m, k] / height
            for j in range(3):
                for d in range(whole):
                    g[j, d] += c * b[k, j, d]
        for i in range(3):
            for j in range(3):
                for a in range(whole):
                    cb = b[m, i, a]
                    for d in range(whole):
                        K[i, j, a, d] += cb * g[j, d]


@kernel(inline="always", error_model="numpy")
def _scatter(nodes: np.ndarray, slots: np.ndarray, K: np.ndarray, matrix: PlacesView) -> None:
    """Add an element's stiffness, shape [3, 3, n, n], to the places that `slots`, shape [n, n], name."""
    data, upper = matrix.data, matrix.upper
    for a in range(nodes.size):
        node = nodes[a]
        for i in range(3):
            start = row_start(matrix.node_ptr, 3, upper, node, i)
            for d in range(nodes.size):
                slot = slots[a, d]
                if slot < 0:
                    continue
                place = start + 3 * slot
                if upper and a == d:
                    for j in range(i, 3):
                        data[place + j] += K[i, j, a, d]
                else:
                    data[place] += K[i, 0, a, d]
                    data[place + 1] += K[i, 1, a, d]
                    data[place + 2] += K[i, 2, a, d]


@kernel(parallel=True)
def pressure_increment(
    du: np.ndarray, elements: ElementView, change: np.ndarray, condensed: CondensedView, dp: np.ndarray
) -> None:
    """dp = G^-1 (R + b . du), the modes' increment being `change`, shape [slices, quads, k, 3]."""
    slices, quads, count = elements.nodes.shape
    extra, pressures = change.shape[2], dp.shape[2]
    for layer in prange(slices):
        y = np.empty((count + extra, 3))
        volume = np.empty(pressures)
        for e in range(quads):
            gather(du, elements.nodes[layer, e], y)
            y[count:] = change[layer, e]
            for m in range(pressures):
                value = 0.0
                for a in range(count + extra):
                    for i in range(3):
                        value += condensed.b[layer, e, m, 3 * a + i] * y[a, i]
                volume[m] = value
            for m in range(pressures):
                value = condensed.excess[layer, e, m]
                for k in range(pressures):
                    value += elements.stiffness[e, m, k] / elements.heights[layer] * volume[k]
                dp[layer, e, m] = value
