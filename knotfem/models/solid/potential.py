"""Compiled potential of mixed hexahedra, and the invariants that laws of the user's own are evaluated at."""

from __future__ import annotations

import numpy as np
from numba import prange

from knotfem.compiled import kernel
from knotfem.models.solid.incompatible import enhance
from knotfem.models.solid.kinematics import deformation, gather, refer
from knotfem.models.solid.views import ElementView, UnknownsView


@kernel(parallel=True, error_model="numpy")
def potential(
    x: np.ndarray, elements: ElementView, unknowns: UnknownsView, mu: float, modulus: float
) -> tuple[float, float]:
    """Sum of W_dev + p (J - 1) + modulus/2 (theta - 1)^2 of a linear law, and the smallest J.

    The augmented Lagrangian of the mixed element with a moderate modulus; modulus = 0 with the converged pressure
    leaves W_dev + p (theta - 1), theta being the mean of J.
    """
    slices, quads, count = elements.nodes.shape
    sums = np.zeros(slices)
    worst = np.full(slices, np.inf)
    for layer in prange(slices):
        F = np.empty((3, 3))
        y = np.empty((count, 3))
        enhanced = np.empty((count, 3))
        value = 0.0
        for e in range(quads):
            gather(x, elements.nodes[layer, e], y)
            volume = 0.0
            dilatation = 0.0
            for q in range(elements.weights.shape[1]):
                w = elements.heights[layer] * elements.weights[e, q]
                grad = elements.grads[e, q]
                if unknowns.modes.shape[2] > 0:
                    enhance(grad, elements.modes[e, q], elements.centre, unknowns.modes[layer, e], enhanced)
                    grad = enhanced
                J = refer(F, deformation(y, grad, F), elements.heights[layer])
                worst[layer] = min(worst[layer], J)
                trace = 0.0
                for i in range(3):
                    for k in range(3):
                        trace += F[i, k] * F[i, k]
                pressure = 0.0
                for m in range(unknowns.pressure.shape[2]):
                    pressure += elements.psi[e, q, m] * unknowns.pressure[layer, e, m]
                value += w * (0.5 * mu * (abs(J) ** (-2.0 / 3.0) * trace - 3.0) + pressure * (J - 1.0))
                volume += w
                dilatation += w * (J - 1.0)
            value += 0.5 * modulus * dilatation * dilatation / volume
        sums[layer] = value
    return sums.sum(), worst.min() if slices > 0 else np.inf


@kernel(parallel=True, error_model="numpy")
def invariants(
    x: np.ndarray, elements: ElementView, modes: np.ndarray, first: np.ndarray, determinant: np.ndarray
) -> None:
    """I1 = |J|^(-2/3) tr C and J at the integration points, both of shape [slices, quads, points].

    Args:
        x: positions, shape [nodes, 3].
        elements: tables.
        modes: incompatible modes, shape [slices, quads, k, 3].
        first: filled.
        determinant: filled.
    """
    slices, quads, count = elements.nodes.shape
    for layer in prange(slices):
        F = np.empty((3, 3))
        y = np.empty((count, 3))
        enhanced = np.empty((count, 3))
        for e in range(quads):
            gather(x, elements.nodes[layer, e], y)
            for q in range(elements.weights.shape[1]):
                grad = elements.grads[e, q]
                if modes.shape[2] > 0:
                    enhance(grad, elements.modes[e, q], elements.centre, modes[layer, e], enhanced)
                    grad = enhanced
                J = refer(F, deformation(y, grad, F), elements.heights[layer])
                trace = 0.0
                for i in range(3):
                    for k in range(3):
                        trace += F[i, k] * F[i, k]
                first[layer, e, q] = abs(J) ** (-2.0 / 3.0) * trace
                determinant[layer, e, q] = J
