"""Temporary displacements that keep max |lambda - 1| over all edges and mapping times smallest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linprog, minimize

from knotfem.compiled import kernel
from knotfem.tie.extremes import deviation, edges_at, extreme_stretches
from knotfem.tie.path import Array

_TIMES = np.linspace(0.0, 1.0, 18)[1:-1]
_SHARPNESS = (15.0, 60.0, 250.0, 1000.0)


@dataclass(frozen=True)
class Shape:
    """One choice of what the mapping leaves open.

    Attributes:
        direction: unit vector E of the straight rod, shape (3,).
        weights: coefficients of the temporary displacement's edge differences in an orthonormal basis, shape (p, 3).
        deviation: exact max |lambda - 1| over all edges and times.
    """

    direction: Array
    weights: Array
    deviation: float


@kernel
def smoothed_deviation(
    start: Array, end: Array, bump: Array, times: Array, sharpness: float
) -> tuple[float, float, Array, Array]:
    """Log-sum-exp of +-(lambda - 1) over edges and sampled times, with its gradient.

    Args:
        start: shape (3,).
        end: target edges over h, shape (n, 3).
        bump: shape (n, 3).
        times: sampled mapping times, shape (k,).
        sharpness: the larger, the nearer to the maximum.

    Returns:
        The smooth value, the sampled maximum, the derivatives by start (3,) and by bump (n, 3).
    """
    n, k = len(end), len(times)
    stretches = np.empty((n, k))
    largest = 0.0
    for i in range(n):
        for j in range(k):
            t = times[j]
            square = 0.0
            for a in range(3):
                square += ((1.0 - t) * start[a] + t * end[i, a] + t * (1.0 - t) * bump[i, a]) ** 2
            stretches[i, j] = np.sqrt(square)
            largest = max(largest, abs(stretches[i, j] - 1.0))
    by_start = np.zeros(3)
    by_bump = np.zeros((n, 3))
    total = 0.0
    cutoff = 40.0 / sharpness
    for i in range(n):
        for j in range(k):
            excess = stretches[i, j] - 1.0
            if abs(excess) < largest - cutoff:
                continue
            above = np.exp(sharpness * (excess - largest))
            below = np.exp(sharpness * (-excess - largest))
            total += above + below
            t = times[j]
            pull = (above - below) / max(stretches[i, j], 1e-12)
            for a in range(3):
                part = pull * ((1.0 - t) * start[a] + t * end[i, a] + t * (1.0 - t) * bump[i, a])
                by_start[a] += (1.0 - t) * part
                by_bump[i, a] += t * (1.0 - t) * part
    return largest + np.log(total) / sharpness, largest, by_start / total, by_bump / total


@dataclass(frozen=True)
class Minimax:
    """max |lambda - 1| of one target as a function of what the mapping leaves open.

    Attributes:
        end: target edges over h, shape (n, 3).
        basis: orthonormal columns that span the edge differences of the temporary displacement, shape (n, p).
        free_direction: whether the straight rod's direction is open.
        threshold: descent stops as soon as the exact deviation is below.
    """

    end: Array
    basis: Array
    free_direction: bool
    threshold: float

    def bump(self, weights: Array) -> Array:
        """Returns the edge differences of the temporary displacement over h, shape (n, 3)."""
        return np.einsum("ip,pa->ia", self.basis, weights)  # too small for threaded BLAS, which waits on busy machines

    def shape(self, direction: Array, weights: Array) -> Shape:
        """Returns the choice with its exact deviation."""
        return Shape(direction, weights, deviation(direction, self.end, self.bump(weights)))

    def first_guess(self, direction: Array, towards: Array) -> Shape:
        """Returns a choice whose edges, half-way, keep their length and halve the turn from `towards` to the target.

        Args:
            direction: the straight rod's direction, shape (3,).
            towards: unit vector, shape (3,); `direction` itself gives the inextensible tie's half-way shape.
        """
        half = towards + self.end
        half /= np.maximum(np.linalg.norm(half, axis=1, keepdims=True), 0.2)
        return self.shape(direction, self.basis.T @ (4.0 * half - 2.0 * (direction + self.end)))

    def descend(self, guess: Shape) -> Shape:
        """Returns what quasi-Newton descent on smoothed deviations of growing sharpness reaches from the guess."""
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
            value, sampled, by_start, by_bump = smoothed_deviation(
                direction, self.end, self.bump(weights), _TIMES, sharpness
            )
            gradient = scale * np.einsum("ip,ia->pa", self.basis, by_bump).ravel()
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
        """Returns the local minimum of the exact deviation, by a sequence of linear programmes in a trust region."""
        best, radius = guess, 0.05
        for _ in range(steps):
            step = self._linear_step(best, radius)
            if step is None:
                break
            trial, predicted = step
            gain = best.deviation - trial.deviation
            if gain > 0.75 * predicted:
                radius *= 2.0
            elif gain < 0.25 * predicted:
                radius *= 0.3
            if gain > 0.0:
                best = trial
            if radius < 1e-6 or predicted < 1e-5 * best.deviation:
                break
        return best

    def _linear_step(self, guess: Shape, radius: float) -> tuple[Shape, float] | None:
        """Returns the shape after the best step of the linearised problem, and the gain that it promised.

        The constraints are the stationary times of all edges near the maximum; t = 1 is out of reach and bounds the
        deviation from below.
        """
        n, p = self.basis.shape
        bump = self.bump(guess.weights)
        times, stretches = extreme_stretches(guess.direction, self.end, bump)
        edges = edges_at(guess.direction, self.end, bump, times)
        tied = np.abs(stretches - 1.0) > guess.deviation - 6.0 * radius
        tied &= (times > 0.0) & (times < 1.0)
        if not tied.any():
            return None
        floor = float(np.abs(np.linalg.norm(self.end, axis=1) - 1.0).max())
        rows = np.nonzero(tied)[0]
        t, lam = times[tied], stretches[tied]
        unit = edges[tied] / np.maximum(lam, 1e-12)[:, None]
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
