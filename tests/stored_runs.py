"""Run directories with tables of known shape, which no run has computed."""

from pathlib import Path

import numpy as np

from knotfem.results.data import open_run
from knotfem.results.run import Run
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import write_table
from knotfem.scene import load_scene

S = np.linspace(0.0, 1.0, 51)
SPEED = 4.0


def stored(displacement: float, time: float, tension: np.ndarray) -> dict[str, np.ndarray]:
    bent = 60.0 * np.stack([np.cos(7.0 * S), np.sin(7.0 * S), 1.1 * S], axis=1)
    same = {"displacement_mm": displacement, "time_s": time}
    return {
        **{name: np.full(S.size, value) for name, value in same.items()},
        "rod": np.full(S.size, "rod"),
        "s_over_L": S,
        "arclength_mm": 500.0 * S,
        "tension_N": tension,
        **{f"{axis}_mm": bent[:, i] for i, axis in enumerate("xyz")},
    }


def pulled(path: Path, factor: float = 1.0, *, to: float = 60.0, start: float = 0.0, model: str = "fem") -> Run:
    """A run with F = factor (1 + d^2/100), whose tension falls linearly to 0.2 factor F."""
    scene = load_scene("overhand", [f"model={model}"])
    run = RunDirectory.create(scene, path)
    d = np.linspace(start, to, 61)
    force = factor * (1.0 + d**2 / 100.0)
    steps = np.full(d.size, "pull")
    write_table(path / "force.csv", {"time_s": 2.0 + d / SPEED, "displacement_mm": d, "force_N": force, "step": steps})
    states = [
        stored(at, 2.0 + at / SPEED, factor * (1.0 + at**2 / 100.0) * (1.0 - (1.0 - 0.2 * factor) * S))
        for at in np.arange(3.0, to + 1e-9, 3.0)
        if at > start
    ]
    write_table(path / "tension.csv", {name: np.concatenate([s[name] for s in states]) for name in states[0]})
    run.write_summary(
        {"dofs": 12, "phases": {"relax": {"wall_s": 1.0, "cpu_s": 0.5}, "pull": {"wall_s": 2.0, "cpu_s": 1.0}}}
    )
    return open_run(path)
