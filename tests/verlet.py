"""Explicit time integration: the reference that the implicit steps are checked against.

Velocity Verlet on the same forces, drag by its mean velocity. Its time step is bounded by the stiffest part, the axial
stiffness: h sqrt(m/EA), less than a microsecond for a rod with a wire core, which is why it is not how rods are run.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from knotfem.errors import InputError, NotConverged
from knotfem.models.rod.system import RodSystem
from knotfem.solver.term import Motion, StepStart, Term
from knotfem.sparse.pattern import Matrix, merge_keys
from knotfem.sparse.rod_pattern import RodPattern
from knotfem.terms.inertia import Drag
from knotfem.terms.registry import INTERNAL_DAMPING

SAFETY = 0.5
"""Share of the largest stable time step that is taken."""


def stable_step(system: RodSystem, motion: Motion, mass: np.ndarray) -> float:
    """Half the largest stable time step [s], by Gershgorin's bound on the frequencies.

    Args:
        system: see `verlet`.
        motion: where to set out.
        mass: of each unknown [tonne], shape [nodes, 4].
    """
    x = motion.x
    begin(system, StepStart(motion, 0.0))
    system.update(x)
    diagonal = np.arange(system.nodes, dtype=np.int64) * (system.nodes + 1)
    keys = [keys for effect in system.effects if (keys := effect.couplings(system.nodes)) is not None]
    matrix = Matrix(RodPattern.from_keys(merge_keys(diagonal, *keys), system.nodes, False))
    for effect in _static_effects(system):
        effect.assemble(x, np.zeros_like(x), matrix)
    indptr = matrix.pattern.csr[0]
    rows = np.add.reduceat(np.abs(matrix.data), indptr[:-1])
    free = ~system.fixed.ravel()
    return float(SAFETY * 2.0 / np.sqrt((rows[free] / mass.ravel()[free]).max()))


def begin(system: RodSystem, start: StepStart) -> None:
    """Let loads, clamps and contact know of a step."""
    for effect in _static_effects(system):
        effect.begin(start)


def _static_effects(system: RodSystem) -> list[Term]:
    return [effect for effect in system.effects if effect.name not in ("inertia", "drag")]


def verlet(system: RodSystem, motion: Motion, mass: np.ndarray, dt: float, steps: int) -> Iterator[Motion]:
    """Yield the motion after each explicit step.

    Args:
        system: made with the quasi-static scheme, so that its residual is the static one; its `Drag`, if any, is
            taken at the mean velocity of the step.
        motion: where to set out.
        mass: of each unknown [tonne], shape [nodes, 4].
        dt: time step [s].
        steps: how many.

    Raises:
        InputError: there is internal damping.
        NotConverged: the motion blew up.
    """
    if system.effect(INTERNAL_DAMPING):
        raise InputError("explicit steps have no internal damping", key="rod model", expected="no relaxation time")
    drag = sum(effect.rate for effect in system.effects if isinstance(effect, Drag))
    free = ~system.fixed
    inverse = np.where(free, 1.0 / np.where(mass > 0.0, mass, np.inf), 0.0)
    x, v = motion.x.copy(), motion.v.copy()
    begin(system, StepStart(motion, 0.0))
    a = -inverse * _force(system, x)
    for step in range(1, steps + 1):
        time = motion.time + step * dt
        half = np.where(free, v + 0.5 * dt * a - 0.5 * dt * drag * v, v)
        begin(system, StepStart(Motion(x, v, a, time - dt), dt))
        after = np.where(free, x + dt * half, system.targets(time))
        try:
            a = -inverse * _force(system, after)
        except ZeroDivisionError:
            a = np.full_like(x, np.nan)
        for effect in system.effects:
            effect.commit(after)
        v = np.where(free, (half + 0.5 * dt * a) / (1.0 + 0.5 * dt * drag), (after - x) / dt)
        x = after
        if not np.all(np.isfinite(a)):
            raise NotConverged(f"the explicit motion blew up at {time:.6g} s; take a shorter step than {dt:.3g} s")
        yield Motion(x.copy(), v.copy(), a.copy(), time)


def _force(system: RodSystem, x: np.ndarray) -> np.ndarray:
    system.update(x)
    residual = np.zeros_like(x)
    for effect in _static_effects(system):
        effect.assemble(x, residual, None)
    return residual
