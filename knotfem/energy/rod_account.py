"""The account of reduced rods: their own ledger in the run's terms."""

from __future__ import annotations

import numpy as np

from knotfem.energy.account import Account
from knotfem.models.base import Simulation
from knotfem.models.rod.model import RodModel
from knotfem.models.solid.assembly import StepSystem
from knotfem.solver.term import StepStart
from knotfem.terms.registry import INTERNAL_DAMPING


class RodAccount(Account):
    """Takes works and energies from the rods' ledger, which knows what clamps do by turning and what springs keep."""

    def __init__(self, model: Simulation, rod: RodModel) -> None:
        super().__init__(model)
        self._rod = rod

    def open(self, x: np.ndarray, v: np.ndarray, *, anew: bool) -> None:
        if anew:
            sums = self._rod.ledger.energies
            sums.work = sums.friction = sums.drag = sums.damping = sums.numerical = 0.0
        stored = self.energies.stored
        super().open(x, v, anew=anew)
        if not anew:
            self._store(x, v)
            self.energies.numerical += stored - self.energies.stored

    def _book(self, step: StepSystem, start: StepStart, x: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        ledger, e = self._rod.ledger, self.energies
        before = ledger.forces
        ledger.book(step.system, self._rod.frames, start, x, v)
        forces, sums = ledger.forces, ledger.energies
        before = {**forces, **before}
        e.turnover += abs(sums.work - e.work)
        e.work, e.friction, e.drag = sums.work, sums.friction, sums.drag
        if step.system.effect(INTERNAL_DAMPING):
            e.taken_by[INTERNAL_DAMPING] = sums.damping
        kinetic = e.kinetic
        self._store(x, v)
        dx = x - start.motion.x
        for effect in self.registered:
            e.taken_by[effect.name] = e.taken_by.get(effect.name, 0.0) + ledger.drag_by[effect.name]
            e.drag -= e.taken_by[effect.name]
        e.numerical += self._inertial_work(step.system, before, forces, dx) - (e.kinetic - kinetic)
        return forces

    def _static_forces(self, x: np.ndarray) -> dict[str, np.ndarray]:
        return {}

    def _store(self, x: np.ndarray, v: np.ndarray) -> None:
        e, stored = self.energies, self._rod.ledger.energies
        e.elastic, e.gravity, e.kinetic = stored.elastic, stored.gravity, stored.kinetic
        e.contact = stored.contact + stored.springs

    def state(self) -> dict:
        return {**super().state(), "ledger": self._rod.ledger.state()}

    def restore(self, state: dict) -> None:
        super().restore(state)
        self._rod.ledger.restore(state["ledger"])
