"""Runs that were never computed: their results follow from the scene by a known error law."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from knotfem.run.columns import FORCE_COLUMNS, FORCE_EXTRA, TENSION_COLUMNS, TENSION_EXTRA
from knotfem.run.directory import RunDirectory, State
from knotfem.run.disk import DiskStore
from knotfem.scene.model import Scene
from knotfem.scene.steps import Pull
from knotfem.study.convergence import make_jobs
from knotfem.study.refinement import base_level, make_series

TRUE_FORCE, TRUE_BENT = 2.0, 60.0
LAW = {"slice": (0.04, 2.0), "section": (0.02, 2.0), "step": (0.006, 1.0), "penalty": (0.003, 1.0)}
"""Relative error of the force at the scene's own size, and its order, by series."""


def error_of(scene: Scene) -> float:
    """Relative error of the force by the law."""
    sizes = {
        "slice": scene.rods[0].mesh.element_length / 2.0,
        "section": math.sqrt(12.0 / scene.rods[0].mesh.section_elements),
        "step": scene.solver.move_over_diameter / 0.5,
        "penalty": 48.0 / scene.contact.stiffness_over_modulus,
    }
    return sum(factor * sizes[name] ** order for name, (factor, order) in LAW.items())


def cpu_of(scene: Scene) -> float:
    """CPU seconds by the law: unknowns times steps."""
    mesh = scene.rods[0].mesh
    return (
        100.0
        * mesh.section_elements
        / 12.0
        * 2.0
        / mesh.element_length
        * (0.5 / scene.solver.move_over_diameter) ** 0.5
    )


def write_run(run: RunDirectory, scene: Scene, *, state: State = "done", reason: str = "") -> None:
    """Write what a run of a scene with one pull would leave."""
    RunDirectory.create(scene, run.path)
    run.write_status(state, reason=reason)
    if state != "done":
        return
    (pull,) = scene.loading_steps
    assert isinstance(pull, Pull)
    steps = round(20 * 0.5 / scene.solver.move_over_diameter)
    displacement = np.linspace(0.1, pull.displacement, steps)
    force = TRUE_FORCE * (1.0 + error_of(scene)) * displacement / pull.displacement
    store = DiskStore(run)
    table = store.table("force", (*FORCE_COLUMNS, *FORCE_EXTRA))
    rows = [dict.fromkeys(table.columns, 0.0) for _ in range(steps)]
    for row, x, f in zip(rows, displacement, force, strict=True):
        row |= {"displacement_mm": x, "step_displacement_mm": x, "force_N": f, "step": pull.name, "time_s": x}
    table.extend(rows)
    profile = store.table("tension", (*TENSION_COLUMNS, *TENSION_EXTRA))
    s = np.linspace(0.0, 1.0, 101)
    places = _arc(s * scene.rods[0].length, TRUE_BENT)
    profile.extend(
        {
            **dict.fromkeys(profile.columns, 0.0),
            "s_over_L": a,
            "tension_N": force[-1] * (1.0 - a),
            "rod": scene.rods[0].name,
            **dict(zip(("x_mm", "y_mm", "z_mm"), place, strict=True)),
        }
        for a, place in zip(s, places, strict=True)
    )
    cpu = cpu_of(scene)
    parts = {"assembly": 0.3, "contact": 0.2, "factorisation": 0.25, "solve": 0.1, "output": 0.05}
    run.write_summary(
        {
            "phases": {
                name: {"wall_s": part * cpu, "cpu_s": part * cpu} for name, part in (("mapping", 0.02), ("pull", 0.98))
            },
            "costs": {name: {"wall_s": part * cpu, "cpu_s": part * cpu} for name, part in parts.items()},
            "effects": {
                "contact": {"cpu_s": 0.15 * cpu, "share": 0.15},
                "elasticity": {"cpu_s": 0.3 * cpu, "share": 0.3},
            },
            "steps": steps,
            "newton_iterations": 4 * steps,
            "cutbacks": 0,
            "dofs": 1000,
            "peak_memory_mb": 400.0,
            "max_penetration_over_d": 0.01 * 48.0 / scene.contact.stiffness_over_modulus,
        }
    )


def write_series(folder: Path, overrides: tuple[str, ...], names: Sequence[str], *, failed: str = "") -> None:
    """Runs of refinement series of the overhand scene; one of them may have failed."""
    jobs = make_jobs("overhand", overrides, folder, budget=None, tell=lambda text: None)
    series = make_series(jobs.scene_of(base_level()), names)
    for level in [base_level(), *(level for levels in series.values() for level in levels)]:
        state, reason = ("failed", "strands passed through each other") if level.name == failed else ("done", "")
        write_run(jobs.run_of(level), jobs.scene_of(level), state=state, reason=reason)


def _arc(s: np.ndarray, length: float) -> np.ndarray:
    """A quarter turn of an arclength between straight ends, shape [n, 3]."""
    radius, before = 2.0 * length / np.pi, 0.5 * (s[-1] - length)
    phi = np.clip(s - before, 0.0, length) / radius
    x = radius * np.sin(phi) + np.minimum(s - before, 0.0)
    y = radius * (1.0 - np.cos(phi)) + np.maximum(s - before - length, 0.0)
    return np.stack([x, y, np.zeros_like(s)], axis=1)
