"""The file summary.json of a run."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from knotfem.energy.account import Balance
from knotfem.models.base import Simulation
from knotfem.run.directory import RunDirectory
from knotfem.run.machine import peak_memory_mb
from knotfem.scene.model import Scene
from knotfem.solver.stepping.integrator import Accepted
from knotfem.solver.system import System
from knotfem.sparse import linear

CONTACT = ("contact", "friction", "cylinder", "cylinder friction")
"""Effects whose time counts as contact; that of all others is assembly."""
SOLVER_PARTS = {"analysis": "factorisation", "factorisation": "factorisation", "solve": "solve"}
"""Parts of the solver by what they count as; the others (pattern, constraints) are assembly."""


class Summary:
    """Gathers the figures of a run over all its sessions."""

    def __init__(self, run: RunDirectory, model: Simulation) -> None:
        self.run, self.model = run, model
        self._diameter = model.diameter
        self._phase, self._since = "", (0.0, 0.0)
        self._seen_clock: dict[str, tuple[float, float]] = {}
        self._seen_counts = (0, 0)
        self.figures: dict[str, Any] = {
            "phases": {},
            "effects": {},
            "solver_cpu_s": {},
            "other_cpu_s": 0.0,
            "costs": {part: _nothing() for part in ("assembly", "contact", "factorisation", "solve", "output")},
            "absent_effects": dict(model.absent),
            **_size(model),
            "steps": 0,
            "newton_iterations": 0,
            "cutbacks": 0,
            "analyses": 0,
            "factorisations": 0,
            "peak_memory_mb": 0.0,
            "max_stretch_deviation": 0.0,
            "max_penetration_over_d": 0.0,
            "min_jacobian": 1.0,
            "max_imbalance_N": 0.0,
            "max_imbalance_over_force": 0.0,
            "max_drag_force_N": 0.0,
            "knot_before": None,
            "knot_after": None,
            "final_force_N": 0.0,
            "linear_solver": "",
        }

    def choose_solver(self, scene: Scene) -> str:
        """Name of the linear solver that "auto" stands for here, recorded."""
        name = scene.solver.linear
        self.figures["linear_solver"] = linear.available()[0] if name == "auto" else name
        return self.figures["linear_solver"]

    def begin_phase(self, name: str) -> None:
        """A phase, or a session's part of it, begins."""
        self._phase, self._since = name, (time.perf_counter(), time.process_time())
        self._seen_clock, self._seen_counts = {}, (0, 0)

    def book(self, system: System | None = None) -> None:
        """Book what the phase took since it began or was booked last.

        Args:
            system: the one at work, if any.
        """
        if not self._phase:
            return
        now, (wall, cpu) = (time.perf_counter(), time.process_time()), self._since
        _add(self.figures["phases"].setdefault(self._phase, _nothing()), now[0] - wall, now[1] - cpu)
        self._since = now
        if system is not None:
            self._book_system(system)

    @contextmanager
    def output(self) -> Iterator[None]:
        """Books what happens inside as output."""
        wall, cpu = time.perf_counter(), time.process_time()
        try:
            yield
        finally:
            _add(self.figures["costs"]["output"], time.perf_counter() - wall, time.process_time() - cpu)

    def stretch(self, stretches: list[np.ndarray]) -> None:
        """Stretch of the mapping at its increments."""
        self.figures["max_stretch_deviation"] = max(float(np.abs(s - 1.0).max()) for s in stretches)

    def balance(self, balance: Balance) -> None:
        """Outputs of a loading step are due."""
        f = self.figures
        f["max_imbalance_N"] = max(f["max_imbalance_N"], balance.imbalance)
        f["max_drag_force_N"] = max(f["max_drag_force_N"], balance.drag_force)
        if balance.force != 0.0:
            share = balance.imbalance / abs(balance.force)
            f["max_imbalance_over_force"] = max(f["max_imbalance_over_force"], share)

    def count(self, accepted: Accepted, balance: Balance) -> None:
        """A step was accepted."""
        f = self.figures
        f["steps"] += 1
        f["newton_iterations"] += accepted.took.count
        f["cutbacks"] += accepted.failed
        f["max_penetration_over_d"] = max(f["max_penetration_over_d"], balance.penetration / self._diameter)
        f["final_force_N"] = balance.force
        f["min_jacobian"] = min([f["min_jacobian"], *(bulk.smallest_j for bulk in self.model.named("elasticity"))])

    def _book_system(self, system: System) -> None:
        names = {effect.name for effect in system.effects}
        for name, cpu in system.clock.cpu.items():
            before = self._seen_clock.get(name, (0.0, 0.0))
            now = (system.clock.wall[name], cpu)
            self._seen_clock[name] = now
            wall_s, cpu_s = now[0] - before[0], now[1] - before[1]
            if name in names:
                self.figures["effects"].setdefault(name, {"cpu_s": 0.0, "share": 0.0})["cpu_s"] += cpu_s
                part = "contact" if name in CONTACT else "assembly"
            else:
                parts = self.figures["solver_cpu_s"]
                parts[name] = parts.get(name, 0.0) + cpu_s
                part = SOLVER_PARTS.get(name, "assembly")
            _add(self.figures["costs"][part], wall_s, cpu_s)
        self.figures["analyses"] += system.analyses - self._seen_counts[0]
        self.figures["factorisations"] += system.factorisations - self._seen_counts[1]
        self._seen_counts = (system.analyses, system.factorisations)

    def knots(self, before: dict[str, Any] | None, after: dict[str, Any]) -> None:
        """Knots before the first and after the last step."""
        one = len(after) == 1
        for key, value in (("knot_before", before), ("knot_after", after)):
            self.figures[key] = next(iter(value.values()))["name"] if one and value else value
            self.figures[f"{key}_details"] = value

    def finish(self, energies: dict[str, float]) -> None:
        """Write the file."""
        self.book()
        f = self.figures
        total = sum(entry["cpu_s"] for entry in f["phases"].values())
        for entry in f["effects"].values():
            entry["share"] = entry["cpu_s"] / total if total > 0.0 else 0.0
        booked = sum(entry["cpu_s"] for entry in f["effects"].values()) + sum(f["solver_cpu_s"].values())
        f["other_cpu_s"] = total - booked - f["costs"]["output"]["cpu_s"]
        self._note_memory()
        f["energies_Nmm"] = energies
        self.run.write_summary(f)

    def state(self) -> dict[str, Any]:
        """For a checkpoint."""
        self._note_memory()
        return {"figures": json.dumps(self.figures)}

    def _note_memory(self) -> None:
        self.figures["peak_memory_mb"] = max(self.figures["peak_memory_mb"], peak_memory_mb())

    def restore(self, state: dict[str, Any]) -> None:
        """From a checkpoint; what this session's model says of itself stays."""
        own = {key: self.figures[key] for key in ("absent_effects", *_size(self.model))}
        self.figures = {**json.loads(state["figures"]), **own}


def _size(model: Simulation) -> dict[str, int]:
    return {"dofs": model.dofs, "hexes": model.hexes, "segments": model.segments}


def _nothing() -> dict[str, float]:
    return {"wall_s": 0.0, "cpu_s": 0.0}


def _add(entry: dict[str, float], wall: float, cpu: float) -> None:
    entry["wall_s"] += wall
    entry["cpu_s"] += cpu
