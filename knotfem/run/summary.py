"""The file summary.json of a run."""

from __future__ import annotations

import json
import resource
import time
from typing import Any

import numpy as np

from knotfem.run.account import Balance
from knotfem.run.directory import RunDirectory
from knotfem.run.model import Model
from knotfem.scene.model import Scene
from knotfem.solver import linear
from knotfem.solver.march import Accepted
from knotfem.solver.system import System


class Summary:
    """Gathers the figures of a run over all its sessions."""

    def __init__(self, run: RunDirectory, model: Model) -> None:
        self.run, self.model = run, model
        body = model.body
        diameter = min(rod.scene.diameter for rod in body.rods)
        self._diameter = diameter
        self.figures: dict[str, Any] = {
            "phases": {},
            "effects": {},
            "solver_cpu_s": {},
            "absent_effects": dict(model.absent),
            "dofs": 3 * body.nodes,
            "hexes": body.hexes,
            "steps": 0,
            "newton_iterations": 0,
            "cutbacks": 0,
            "analyses": 0,
            "factorisations": 0,
            "peak_memory_mb": 0.0,
            "max_stretch_deviation": 0.0,
            "max_penetration_over_d": 0.0,
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

    def phase(self, name: str, began_wall: float, began_cpu: float) -> None:
        """A phase, or a session's part of it, has ended."""
        entry = self.figures["phases"].setdefault(name, {"wall_s": 0.0, "cpu_s": 0.0})
        entry["wall_s"] += time.perf_counter() - began_wall
        entry["cpu_s"] += time.process_time() - began_cpu

    def stretch(self, stretches: list[np.ndarray]) -> None:
        """Stretch of the mapping at its increments."""
        self.figures["max_stretch_deviation"] = max(float(np.abs(s - 1.0).max()) for s in stretches)

    def output(self, balance: Balance) -> None:
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

    def system(self, system: System) -> None:
        """A step's system has done its work."""
        names = {effect.name for effect in system.effects}
        for name, seconds in system.clock.cpu.items():
            if name in names:
                entry = self.figures["effects"].setdefault(name, {"cpu_s": 0.0, "share": 0.0})
                entry["cpu_s"] += seconds
            else:
                parts = self.figures["solver_cpu_s"]
                parts[name] = parts.get(name, 0.0) + seconds
        self.figures["analyses"] += system.analyses
        self.figures["factorisations"] += system.factorisations

    def knots(self, before: dict[str, Any] | None, after: dict[str, Any]) -> None:
        """Knots before the first and after the last step."""
        one = len(after) == 1
        for key, value in (("knot_before", before), ("knot_after", after)):
            self.figures[key] = next(iter(value.values()))["name"] if one and value else value
            self.figures[f"{key}_details"] = value

    def finish(self, energies: dict[str, float]) -> None:
        """Write the file."""
        f = self.figures
        total = sum(entry["cpu_s"] for entry in f["phases"].values())
        for entry in f["effects"].values():
            entry["share"] = entry["cpu_s"] / total if total > 0.0 else 0.0
        f["peak_memory_mb"] = max(f["peak_memory_mb"], resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0)
        f["energies_Nmm"] = energies
        self.run.write_summary(f)

    def state(self) -> dict[str, Any]:
        """For a checkpoint."""
        return {"figures": json.dumps(self.figures)}

    def restore(self, state: dict[str, Any]) -> None:
        """From a checkpoint; what this session's model says of itself stays."""
        own = {key: self.figures[key] for key in ("absent_effects", "dofs", "hexes")}
        self.figures = {**json.loads(state["figures"]), **own}
