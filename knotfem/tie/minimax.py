"""Temporary displacements that minimise max |lambda - 1| over all edges and mapping times.

The symbols are those of `extremes`: direction E of the straight rod, edges e_1 of the target and differences w of the
temporary displacements, both over h.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linprog, minimize

from knotfem.tie.extremes import deviation, edges_at, extreme_stretches
from knotfem.tie.smooth_maximum import smoothed_deviation
from knotfem.types import Array

_TIMES = np.linspace(0.0, 1.0, 18)[1:-1]
"""Mapping times at which the smooth approximation samples the stretches."""

_SHARPNESS = (15.0, 60.0, 250.0, 1000.0)
"""Sharpness of the smooth approximation in successive minimisations."""


@dataclass(frozen=True)
class Shape:
    """Values of the free parameters of the mapping.

    Attributes:
        direction: unit vector E of the straight rod, shape (3,).
        weights: coefficients of w in an orthonormal basis, shape (p, 3).
        deviation: exact max |lambda - 1| over all edges and times.
    """

    direction: Array
    weights: Array
    deviation: float


@dataclass(frozen=True)
class Minimax:
    """max |lambda - 1| of one target as a function of the free parameters of the mapping.

    Attributes:
        end: e_1, shape (n, 3).
        basis: orthonormal columns that span all possible w, shape (n, p).
        free_direction: whether the direction of the straight rod is a free parameter.
        threshold: the descent stops as soon as the exact deviation is smaller.
    """

    end: Array
    basis: Array
    free_direction: bool
    threshold: float

    def temporary(self, weights: Array) -> Array:
        """Return w, shape (n, 3)."""
        return np.einsum("ip,pa->ia", self.basis, weights)  # too small for BLAS, whose threads wait on a busy machine

    def shape(self, direction: Array, weights: Array) -> Shape:
        """Return the parameters with their exact deviation."""
        return Shape(direction, weights, deviation(direction, self.end, self.temporary(weights)))

    def first_guess(self, direction: Array, towards: Array) -> Shape:
        """Return parameters with which, at t = 1/2, edges are unstretched and halfway between `towards` and the target.

        Args:
            direction: the straight rod's direction, shape (3,).
            towards: unit vector, shape (3,). With `direction` itself, the shape at t = 1/2 is that of the inextensible
                mapping.
        """
        half = towards + self.end
        half /= np.maximum(np.linalg.norm(half, axis=1, keepdims=True), 0.2)
        return self.shape(direction, self.basis.T @ (4.0 * half - 2.0 * (direction + self.end)))

    def descend(self, guess: Shape) -> Shape:
        """Return what BFGS minimisation of smooth approximations of growing sharpness reaches from the guess."""
        best = guess
        for sharpness in _SHARPNESS:
            if best.deviation < self.threshold:
                break
            best = min(best, self._descend_once(best, sharpness), key=lambda shape: shape.deviation)
        return best

    def _descend_once(self, guess: Shape, sharpness: float) -> Shape:
        size = guess.weights.size
        scale = np.sqrt(len(self.end))
        sampled = np.inf

        def unpack(x: Array) -> tuple[Array, Array, float]:
            raw = x[size:] if self.free_direction else guess.direction
            norm = float(np.linalg.norm(raw))
            return raw / norm, scale * x[:size].reshape(-1, 3), norm

        def objective(x: Array) -> tuple[float, Array]:
            nonlocal sampled
            direction, weights, norm = unpack(x)
            value, sampled, by_start, by_temporary = smoothed_deviation(
                direction, self.end, self.temporary(weights), _TIMES, sharpness
            )
            gradient = scale * np.einsum("ip,ia->pa", self.basis, by_temporary).ravel()
            if self.free_direction:
                by_raw = (by_start - (by_start @ direction) * direction) / norm
                gradient = np.concatenate([gradient, by_raw])
            return value, gradient

        def stop_if_reached(x: Array) -> None:
            if sampled < self.threshold and self.shape(*unpack(x)[:2]).deviation < self.threshold:
                raise StopIteration

        x0 = guess.weights.ravel() / scale
        if self.free_direction:
            x0 = np.concatenate([x0, guess.direction])
        options: dict[str, Any] = {"maxiter": 400, "gtol": 1e-4, "xrtol": 1e-7}
        end = minimize(objective, x0, jac=True, method="BFGS", callback=stop_if_reached, options=options)
        return self.shape(*unpack(end.x)[:2])

    def polish(self, guess: Shape, steps: int = 60) -> Shape:
        """Return a local minimum of the exact deviation, found by sequential linear programming in a trust region."""
        best, radius = guess, 0.05
        for _ in range(steps):
            step = self._linear_step(best, radius)
            if step is None:
                break
            trial, predicted = step
            decrease = best.deviation - trial.deviation
            if decrease > 0.75 * predicted:
                radius *= 2.0
            elif decrease < 0.25 * predicted:
                radius *= 0.3
            if decrease > 0.0:
                best = trial
            if radius < 1e-6 or predicted < 1e-5 * best.deviation:
                break
        return best

    def _linear_step(self, guess: Shape, radius: float) -> tuple[Shape, float] | None:
        """Return the parameters after the best step of the linearised problem, and the decrease that it predicts.

        The constraints are the stretches at those stationary times of all edges at which the deviation is near its
        maximum. The stretches at t = 1 are given by the target and bound the deviation from below.
        """
        n, p = self.basis.shape
        temporary = self.temporary(guess.weights)
        times, stretches = extreme_stretches(guess.direction, self.end, temporary)
        edges = edges_at(guess.direction, self.end, temporary, times)
        active = np.abs(stretches - 1.0) > guess.deviation - 6.0 * radius
        active &= (times > 0.0) & (times < 1.0)
        if not active.any():
            return None
        floor = float(np.abs(np.linalg.norm(self.end, axis=1) - 1.0).max())
        rows = np.nonzero(active)[0]
        t, lam = times[active], stretches[active]
        unit = edges[active] / np.maximum(lam, 1e-12)[:, None]
        scale = np.sqrt(n)
        by_weights = scale * (t * (1.0 - t))[:, None, None] * self.basis[rows][:, :, None] * unit[:, None, :]
        jacobian = by_weights.reshape(len(t), 3 * p)
        tangent = np.linalg.svd(guess.direction[None])[2][1:]
        if self.free_direction:
            jacobian = np.hstack([jacobian, (1.0 - t)[:, None] * (unit @ tangent.T)])
        size = jacobian.shape[1]
        ones = np.ones((len(t), 1))
        solution = linprog(
            np.append(np.zeros(size), 1.0),
            A_ub=np.vstack([np.hstack([jacobian, -ones]), np.hstack([-jacobian, -ones])]),
            b_ub=np.concatenate([1.0 - lam, lam - 1.0]),
            bounds=[(-radius, radius)] * size + [(floor, None)],
            method="highs-ds",
        )
        if solution.x is None:
            return None
        step = solution.x
        direction = guess.direction
        if self.free_direction:
            direction = direction + step[3 * p : size] @ tangent
            direction /= np.linalg.norm(direction)
        trial = self.shape(direction, guess.weights + scale * step[: 3 * p].reshape(p, 3))
        return trial, guess.deviation - step[-1]
