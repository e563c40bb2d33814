"""Time integration schemes: how velocities and accelerations follow from the positions at the end of a step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.errors import InputError
from knotfem.solver.state import Motion


@dataclass(frozen=True)
class Scheme:
    """Base: quasi-static. Velocity from the backward difference, no inertia.

    Attributes:
        alpha_f: weight of the static residual at the start of the step.
        alpha_m: weight of the acceleration at the start of the step.
        inertial: whether accelerations enter the residual.
    """

    alpha_f: float = 0.0
    alpha_m: float = 0.0
    inertial: bool = False

    def velocity(self, x: np.ndarray, start: Motion, dt: float) -> np.ndarray:
        """Velocity [mm/s] at the end of a step, shape of x; that of the start for a step of no length.

        Args:
            x: positions at the end [mm], shape [nodes, width].
            start: where the step begins.
            dt: its length [s].
        """
        return self._velocity(x, start, dt) if dt > 0.0 else start.v

    def velocity_rate(self, dt: float) -> float:
        """Derivative of the velocity with respect to the position [1/s]."""
        return 1.0 / dt

    def acceleration(self, x: np.ndarray, start: Motion, dt: float) -> np.ndarray:
        """Acceleration [mm/s^2] at the end of a step; see `velocity`."""
        return self._acceleration(x, start, dt) if dt > 0.0 else start.a

    def acceleration_rate(self, dt: float) -> float:
        """Derivative of the acceleration with respect to the position [1/s^2]."""
        return 0.0

    def motion(self, x: np.ndarray, start: Motion, dt: float) -> Motion:
        """The motion at the end of a step that ended at x."""
        return Motion(x.copy(), self.velocity(x, start, dt), self.acceleration(x, start, dt), start.time + dt)

    def _velocity(self, x: np.ndarray, start: Motion, dt: float) -> np.ndarray:
        return (x - start.x) / dt

    def _acceleration(self, x: np.ndarray, start: Motion, dt: float) -> np.ndarray:
        return np.zeros_like(x)


@dataclass(frozen=True)
class BackwardEuler(Scheme):
    """First order, strongly dissipative at high frequency: for quasi-static work with inertia."""

    inertial: bool = True

    def acceleration_rate(self, dt: float) -> float:
        return 1.0 / dt**2

    def _acceleration(self, x: np.ndarray, start: Motion, dt: float) -> np.ndarray:
        return (self._velocity(x, start, dt) - start.v) / dt


@dataclass(frozen=True)
class GeneralisedAlpha(Scheme):
    """Newmark kinematics with weighted residuals (Chung and Hulbert 1993, Eqs. 3 to 6)."""

    inertial: bool = True
    beta: float = 0.25
    gamma: float = 0.5

    def acceleration_rate(self, dt: float) -> float:
        return 1.0 / (self.beta * dt**2)

    def velocity_rate(self, dt: float) -> float:
        return self.gamma / (self.beta * dt)

    def _acceleration(self, x: np.ndarray, start: Motion, dt: float) -> np.ndarray:
        return (x - start.x - dt * start.v - dt**2 * (0.5 - self.beta) * start.a) / (self.beta * dt**2)

    def _velocity(self, x: np.ndarray, start: Motion, dt: float) -> np.ndarray:
        return start.v + dt * ((1.0 - self.gamma) * start.a + self.gamma * self._acceleration(x, start, dt))


def hht(alpha: float) -> GeneralisedAlpha:
    """Hilber, Hughes and Taylor (1977) with -1/2 <= alpha <= 0; alpha = 0 is the trapezoidal rule."""
    if not -0.5 <= alpha <= 0.0:
        raise InputError("out of range", key="inertia.hht_alpha", found=alpha, expected="between -0.5 and 0")
    return GeneralisedAlpha(alpha_f=-alpha, beta=(1.0 - alpha) ** 2 / 4.0, gamma=0.5 - alpha)


def generalised_alpha(spectral_radius: float) -> GeneralisedAlpha:
    """Chung and Hulbert (1993) by the spectral radius at infinite frequency, 0 to 1."""
    if not 0.0 <= spectral_radius <= 1.0:
        raise InputError(
            "out of range", key="inertia.spectral_radius", found=spectral_radius, expected="between 0 and 1"
        )
    alpha_m = (2.0 * spectral_radius - 1.0) / (spectral_radius + 1.0)
    alpha_f = spectral_radius / (spectral_radius + 1.0)
    return GeneralisedAlpha(
        alpha_f=alpha_f,
        alpha_m=alpha_m,
        beta=(1.0 - alpha_m + alpha_f) ** 2 / 4.0,
        gamma=0.5 - alpha_m + alpha_f,
    )
