"""The file summary.json of a run."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from knotfem.energy.balance import StepFigures
from knotfem.energy.energies import Energies
from knotfem.models.base import Model
from knotfem.run.events import TimeStepDone
from knotfem.run.knot_words import Knots, for_summary
from knotfem.run.memory_use import peak_memory_mb
from knotfem.solver.system import System
from knotfem.solver.term import Role

SOLVER_PARTS = {"analysis": "factorisation", "factorisation": "factorisation", "solve": "solve"}
"""Parts of the solver by what they count as; the others (pattern, constraints) are assembly."""


class Summary:
    """Gathers the figures of a run over all its sessions.

    Args:
        model: of the scene.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self._diameter = model.diameter
        self._since: tuple[float, float] | None = None
        self._seen_clock: dict[str, tuple[float, float]] = {}
        self._seen_counts = (0, 0)
        self._system: System | None = None
        self.figures: dict[str, Any] = {
            "phases": {},
            "effects": {},
            "solver_cpu_s": {},
            "other_cpu_s": 0.0,
            "costs": {part: _nothing() for part in ("assembly", "contact", "factorisation", "solve", "output")},
            "absent_effects": dict(model.absent),
            "curves": {rod: size.figures for rod, size in model.curves.items()},
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
            "max_rate_force_over_force": 0.0,
            "events": 0,
            "settling": {step.name: step.way for step in model.scene.tying_steps},
            "knot_before": None,
            "knot_after": None,
            "remarks": [],
            "validity": {},
            "verdict": None,
            "verdict_evidence": None,
            "failure_mode": None,
            "holding": None,
            "final_force_N": 0.0,
            "linear_solver": "",
        }

    def begin(self) -> None:
        """Time counts from now."""
        self._since = time.perf_counter(), time.process_time()

    def add_time(self, phase: str) -> None:
        """Add what a phase took since the last call; nothing before `begin`."""
        now, since = (time.perf_counter(), time.process_time()), self._since
        if since is not None:
            _add(self.figures["phases"].setdefault(phase, _nothing()), now[0] - since[0], now[1] - since[1])
            self._since = now

    @contextmanager
    def output(self) -> Iterator[None]:
        """What happens inside counts as output."""
        wall, cpu = time.perf_counter(), time.process_time()
        try:
            yield
        finally:
            _add(self.figures["costs"]["output"], time.perf_counter() - wall, time.process_time() - cpu)

    def stretch(self, stretches: list[np.ndarray]) -> None:
        """Stretch of the mapping at its increments."""
        self.figures["max_stretch_deviation"] = max(float(np.abs(s - 1.0).max()) for s in stretches)

    def output_figures(self, figures: StepFigures) -> None:
        """Outputs of a loading step are due."""
        f = self.figures
        f["max_imbalance_N"] = max(f["max_imbalance_N"], figures.imbalance)
        f["max_drag_force_N"] = max(f["max_drag_force_N"], figures.drag_force)
        if figures.force != 0.0:
            part = figures.imbalance / abs(figures.force)
            f["max_imbalance_over_force"] = max(f["max_imbalance_over_force"], part)
            carried = figures.dynamic_residual / abs(figures.force)
            f["max_rate_force_over_force"] = max(f["max_rate_force_over_force"], carried)

    def count(self, event: TimeStepDone) -> None:
        """A step was accepted."""
        f, figures = self.figures, event.figures
        f["steps"] += 1
        f["newton_iterations"] += event.accepted.solution.iterations
        f["cutbacks"] += event.accepted.rejected
        f["max_penetration_over_d"] = max(f["max_penetration_over_d"], figures.penetration / self._diameter)
        f["final_force_N"] = figures.force
        f["min_jacobian"] = min(f["min_jacobian"], self.model.smallest_j())

    def add_system(self, system: System | None) -> None:
        """Add what the parts of a solve took since the last call."""
        if system is None:
            return
        if system is not self._system:
            self._system, self._seen_clock, self._seen_counts = system, {}, (0, 0)
        terms = {term.name: term for term in system.terms}
        for name, cpu in system.clock.cpu.items():
            before = self._seen_clock.get(name, (0.0, 0.0))
            now = (system.clock.wall[name], cpu)
            self._seen_clock[name] = now
            wall_s, cpu_s = now[0] - before[0], now[1] - before[1]
            if name in terms:
                self.figures["effects"].setdefault(name, {"cpu_s": 0.0, "share": 0.0})["cpu_s"] += cpu_s
                touching = terms[name].role in (Role.CONTACT, Role.FRICTION)
                part = "contact" if touching else "assembly"
            else:
                parts = self.figures["solver_cpu_s"]
                parts[name] = parts.get(name, 0.0) + cpu_s
                part = SOLVER_PARTS.get(name, "assembly")
            _add(self.figures["costs"][part], wall_s, cpu_s)
        self.figures["analyses"] += system.analyses - self._seen_counts[0]
        self.figures["factorisations"] += system.factorisations - self._seen_counts[1]
        self._seen_counts = (system.analyses, system.factorisations)

    def knots(self, before: Knots | None, after: Knots) -> None:
        """Knots before the first and after the last step."""
        for key, value in (("knot_before", before), ("knot_after", after)):
            self.figures[key] = for_summary(value)
            self.figures[f"{key}_details"] = value

    def finished(self, energies: Energies) -> dict[str, Any]:
        """All figures."""
        f = self.figures
        total = sum(entry["cpu_s"] for entry in f["phases"].values())
        for entry in f["effects"].values():
            entry["share"] = entry["cpu_s"] / total if total > 0.0 else 0.0
        known = sum(entry["cpu_s"] for entry in f["effects"].values()) + sum(f["solver_cpu_s"].values())
        f["other_cpu_s"] = total - known - f["costs"]["output"]["cpu_s"]
        self._note_memory()
        f["energies_Nmm"] = _named(energies)
        return f

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


def _size(model: Model) -> dict[str, Any]:
    return {"dofs": model.dofs, "hexes": model.hexes, "segments": model.segments, "slices": model.slices}


def _nothing() -> dict[str, float]:
    return {"wall_s": 0.0, "cpu_s": 0.0}


def _add(entry: dict[str, float], wall: float, cpu: float) -> None:
    entry["wall_s"] += wall
    entry["cpu_s"] += cpu


def _named(e: Energies) -> dict[str, Any]:
    """Energies as the file names them."""
    return {
        "work": e.work,
        "friction": e.friction,
        "drag": e.taken.get("drag", 0.0),
        "numerical": e.algorithmic,
        "elastic": e.elastic,
        "contact": e.contact,
        "gravity": e.fields.get("gravity", 0.0),
        "kinetic": e.kinetic,
        "stored_at_start": e.initial,
        "turnover": e.throughput,
        "missing": e.error,
        "taken_by": e.taken,
        "stored_by": e.fields,
    }
