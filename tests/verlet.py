"""Explicit time integration: the reference that the implicit steps are checked against.

Velocity Verlet on the same forces, drag by its mean velocity. Its time step is bounded by the stiffest part, the axial
stiffness: h sqrt(m/EA), less than a microsecond for a rod with a wire core, which is why it is not how rods are run.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from knotfem.errors import InputError, NotConverged
from knotfem.solver.state import Motion, State
from knotfem.solver.system import System
from knotfem.solver.term import Role, Term, TimeStep
from knotfem.sparse.pattern import Matrix, Pattern, merge_keys
from knotfem.terms.inertia import Drag

SAFETY = 0.5
"""Fraction of the largest stable time step that is taken."""


def stable_step(system: System, state: State, mass: np.ndarray) -> float:
    """Half the largest stable time step [s], by Gershgorin's bound on the frequencies.

    Args:
        system: see `verlet`.
        state: where to set out.
        mass: of each unknown [tonne], shape [nodes, 4].
    """
    x = state.x
    system.begin(state, 0.0)
    diagonal = np.arange(system.nodes, dtype=np.int64) * (system.nodes + 1)
    keys = [keys for term in system.terms if (keys := term.couplings(system.nodes)) is not None]
    matrix = Matrix(Pattern.from_keys(merge_keys(diagonal, *keys), system.nodes, False, system.width))
    for term in _static_terms(system):
        term.assemble(x, np.zeros_like(x), matrix)
    indptr = matrix.pattern.csr[0]
    rows = np.add.reduceat(np.abs(matrix.data), indptr[:-1])
    free = ~system.fixed.ravel()
    return float(SAFETY * 2.0 / np.sqrt((rows[free] / mass.ravel()[free]).max()))


def verlet(system: System, state: State, mass: np.ndarray, dt: float, steps: int) -> Iterator[Motion]:
    """Yield the motion after each explicit step.

    Args:
        system: its `Drag`, if any, is taken at the mean velocity of the step.
        state: where to set out.
        mass: of each unknown [tonne], shape [nodes, 4].
        dt: time step [s].
        steps: how many.

    Raises:
        InputError: there is internal damping.
        NotConverged: the motion blew up.
    """
    resistances = system.having(Role.RESISTANCE)
    drag = sum(term.rate for term in resistances if isinstance(term, Drag))
    if any(not isinstance(term, Drag) for term in resistances):
        raise InputError("explicit steps have no internal damping", key="rods", expected="no relaxation time")
    free = ~system.fixed
    inverse = np.where(free, 1.0 / np.where(mass > 0.0, mass, np.inf), 0.0)
    x, v = state.x, state.v
    system.begin(state, 0.0)
    a = -inverse * _force(system, x)
    for step in range(1, steps + 1):
        time = state.time + step * dt
        half = np.where(free, v + 0.5 * dt * a - 0.5 * dt * drag * v, v)
        _begin(system, Motion(x, v, a, time - dt), dt)
        after = np.where(free, x + dt * half, system.targets(time))
        try:
            a = -inverse * _force(system, after)
        except ZeroDivisionError:
            a = np.full_like(x, np.nan)
        for term in system.terms:
            term.commit(after)
        v = np.where(free, (half + 0.5 * dt * a) / (1.0 + 0.5 * dt * drag), (after - x) / dt)
        x = after
        if not np.all(np.isfinite(a)):
            raise NotConverged(f"the explicit motion blew up at {time:.6g} s; take a shorter step than {dt:.3g} s")
        yield Motion(x, v, a, time)


def _static_terms(system: System) -> list[Term]:
    return [term for term in system.terms if term.role not in (Role.INERTIA, Role.RESISTANCE)]


def _begin(system: System, start: Motion, dt: float) -> None:
    """Let loads, clamps and contact know of a step."""
    for term in _static_terms(system):
        term.begin(TimeStep(start, dt, system.scheme, system.conditions))


def _force(system: System, x: np.ndarray) -> np.ndarray:
    system.update(x)
    residual = np.zeros_like(x)
    for term in _static_terms(system):
        term.assemble(x, residual, None)
    return residual
