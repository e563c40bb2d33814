"""Time integration: how much of its amplitude an oscillator keeps in one period of the numerical motion."""

from __future__ import annotations

from functools import partial

import numpy as np

from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance, Sections
from knotfem.solver.schemes import BackwardEuler, GeneralisedAlpha, Scheme, generalised_alpha, hht
from knotfem.solver.state import Motion, State
from knotfem.solver.system import System
from knotfem.solver.term import Role, Term
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.sparse.pattern import Matrix
from knotfem.terms.inertia import Drag, Inertia
from knotfem.verify.case import Case, Quantity

OMEGA = 2.0 * np.pi


class Spring(Term):
    """Ties every node to the origin.

    Args:
        stiffness: [N/mm].
    """

    name, role = "spring", Role.ELASTIC

    def __init__(self, stiffness: float) -> None:
        self.stiffness = stiffness

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual += self.stiffness * x
        if matrix is not None:
            matrix.add_diagonal(np.full(x.size, self.stiffness))
        return True

    def merit(self, x: np.ndarray) -> float:
        return 0.5 * self.stiffness * float(np.sum(x * x))


def swing(scheme: Scheme, steps: int, dt: float, damping: float = 0.0) -> np.ndarray:
    """Positions of an oscillator of one period a second, released from 1 at rest, shape [steps + 1]."""
    mass = np.ones(1)
    terms: list[Term] = [Spring(OMEGA**2), Inertia(mass)]
    if damping > 0.0:
        terms.append(Drag(mass, damping))
    system = System(terms, Unknowns(1), make_solver("superlu"), scheme)
    x = np.array([[1.0, 0.0, 0.0]])
    state = State.of(Motion(x, np.zeros((1, 3)), -(OMEGA**2) * x), {})
    newton = Newton(ForceTolerance(1e-10, 1e-10), largest_move=10.0)
    path = [1.0]
    for _ in range(steps):
        step = system.begin(state, dt)
        solution = newton.solve(system, state.x, step, Sections.single(np.zeros(1, dtype=int)))
        state = system.commit(solution.x, step)
        path.append(float(state.x[0, 0]))
    return np.array(path)


def amplitude_kept(path: np.ndarray, roots: int) -> float:
    """In one period of the numerical motion, whose recurrence has so many roots."""
    rows = np.stack([path[i : len(path) - roots + i] for i in range(roots)], axis=1)
    recurrence = np.linalg.lstsq(rows, path[roots:], rcond=None)[0]
    return _kept(np.roots([1.0, *(-recurrence[::-1])]))


def amplification(scheme: GeneralisedAlpha, dt: float) -> float:
    """Amplitude kept in one period of the numerical motion."""
    return _kept(_multipliers(scheme, dt))


def _multipliers(scheme: GeneralisedAlpha, dt: float) -> np.ndarray:
    """Eigenvalues of the scheme's own matrix of one step."""
    beta, gamma, am, af = scheme.beta, scheme.gamma, scheme.alpha_m, scheme.alpha_f
    after = np.array([[1, 0, -beta * dt**2], [0, 1, -gamma * dt], [(1 - af) * OMEGA**2, 0, 1 - am]])
    before = np.array([[1, dt, (0.5 - beta) * dt**2], [0, 1, (1 - gamma) * dt], [-af * OMEGA**2, 0, -am]])
    return np.linalg.eigvals(np.linalg.solve(after, before))


def _kept(values: np.ndarray) -> float:
    z = values[np.argmax(np.abs(values) * (np.abs(np.imag(values)) > 1e-9))]
    return float(np.abs(z) ** (2.0 * np.pi / abs(np.angle(z))))


def kept(scheme: Scheme, roots: int, amplitudes: dict[int, float]) -> list[Quantity]:
    """Amplitude kept for each number of steps per period."""
    return [
        Quantity(
            "amplitude kept",
            amplitude_kept(swing(scheme, 2 * max(steps, 20), 1.0 / steps), roots),
            expected,
            0.01,
            "absolute",
            f"{steps} steps per period",
        )
        for steps, expected in amplitudes.items()
    ]


def spectral(radius: float) -> list[Quantity]:
    """Generalised alpha by its radius: what it keeps of a resolved motion and of one that no step resolves."""
    scheme = generalised_alpha(radius)
    resolved = kept(scheme, 3, {steps: amplification(scheme, 1.0 / steps) for steps in (20, 100)})
    found = float(np.abs(_multipliers(scheme, 1e4)).max())
    return [*resolved, Quantity("kept in a step of 1e4 periods", found, radius, 1e-3, "absolute")]


_ALPHA = {-0.05: {20: 0.9989, 100: 1.0000}, -0.41421: {10: 0.9774, 20: 0.9967, 50: 0.9998, 100: 1.0000}}
_CLOSED_FORM = "eigenvalues of the amplification matrix"

CASES = [
    Case(
        "time-integration",
        partial(kept, BackwardEuler(), 2, {20: 0.379, 100: 0.821}),
        "backward Euler, an oscillator of one period a second",
        _CLOSED_FORM,
        variant="backward-euler",
    ),
    *(
        Case(
            "time-integration",
            partial(kept, hht(alpha), 3, amplitudes),
            f"HHT, alpha = {alpha:g}",
            _CLOSED_FORM,
            variant=f"hht{alpha:g}",
        )
        for alpha, amplitudes in _ALPHA.items()
    ),
    Case(
        "time-integration",
        partial(spectral, 0.8),
        "generalised alpha, spectral radius 0.8",
        _CLOSED_FORM,
        variant="generalised-alpha",
    ),
]
