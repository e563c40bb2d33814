"""Hard cases: runs of the scenes in configs/hard, what came of each, and what it must be.

Each case has a small version, a coarse mesh under a shorter pull, for the tests.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.errors import KnotLost, NotConverged
from knotfem.run import driver
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.scene import Scene, load_scene
from knotfem.verify.stress.figures import Figures, mesh_of
from knotfem.verify.verdict import Case, Quantity

SMALL = (
    "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=5 mm", "contact.sample_spacing_over_diameter=0.25",
    "tie.increments=2",
)  # fmt: skip
SLIGHT = ("steps.1.displacement=2 mm", "output.every_displacement=1 mm")
"""A pull for small versions."""
QUIET = ("output.fields=false", "output.checkpoint_every=1 h")


@dataclass(frozen=True)
class Outcome(Figures):
    """What came of a run, and what it left in its directory.

    Attributes:
        scene: what was run.
        iterations: of Newton's method.
        force: columns of force.csv.
        tension: columns of tension.csv.
        log: lines of log.jsonl.
    """

    scene: Scene
    iterations: int
    force: dict[str, np.ndarray]
    tension: dict[str, np.ndarray]
    log: list[dict[str, Any]]


@contextmanager
def folder() -> Iterator[Path]:
    """A folder that is gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="knotfem-hard-") as path:
        yield Path(path)


def hard_scene(name: str, overrides: Sequence[str] = (), *, small: bool = False) -> Scene:
    """A shipped hard scene.

    Args:
        name: in configs/hard.
        overrides: see `load_scene`.
        small: on the coarse mesh.
    """
    return load_scene(f"hard/{name}", [*QUIET, *(SMALL if small else ()), *overrides])


def run(scene: Scene, path: Path | None = None) -> Outcome:
    """Run a scene to its end, or until it gives up or its knot is lost.

    Args:
        scene: what to run.
        path: of the run directory; None for one that is gone afterwards.

    Raises:
        KnotfemError: what else would end a run.
    """
    if path is None:
        with folder() as temporary:
            return run(scene, temporary / "run")
    directory = RunDirectory.create(scene, path)
    ended = "yes"
    try:
        driver.pull(scene, directory)
    except (NotConverged, KnotLost) as error:
        ended = f"{type(error).__name__}: {error}"
    return outcome(directory, ended)


def outcome(directory: RunDirectory, ended: str) -> Outcome:
    """What the files of a run say."""
    summary = directory.read_summary()
    force, tension = (_table(directory.path / name) for name in ("force.csv", "tension.csv"))
    return Outcome(
        ended,
        int(summary["steps"]),
        int(summary["cutbacks"]),
        float(summary["min_jacobian"]),
        float(summary["max_penetration_over_d"]),
        _knots(summary.get("knot_before_details")),
        _knots(summary.get("knot_after_details")),
        _energy_error(force),
        directory.scene,
        int(summary["newton_iterations"]),
        force,
        tension,
        [json.loads(line) for line in (directory.path / "log.jsonl").read_text().splitlines()],
    )


def _table(path: Path) -> dict[str, np.ndarray]:
    return read_table(path) if path.exists() else {}


def _knots(rods: dict[str, dict[str, Any]] | None) -> str:
    """Names of the rods' knots; "" before they are tied."""
    return ", ".join(knot["name"] for knot in (rods or {}).values())


def _energy_error(force: dict[str, np.ndarray]) -> float | None:
    """Largest missing energy over the largest of work, stored energy and what was taken; None without a row."""
    if not force or not force["missing_Nmm"].size:
        return None
    scale = max(float(np.abs(force[name]).max()) for name in ("work_Nmm", "elastic_Nmm", "friction_Nmm", "drag_Nmm"))
    return float(np.abs(force["missing_Nmm"]).max()) / scale if scale > 0.0 else None


def at(force: dict[str, np.ndarray], displacement: float) -> float:
    """Force [N] at a displacement [mm] of the last step, from the rows of force.csv."""
    rows = force["step"] == force["step"][-1]
    return float(np.interp(displacement, force["displacement_mm"][rows], force["force_N"][rows]))


def hard_case(
    group: str, variant: str, title: str, measure: Callable[[], Sequence[Quantity]], scene: Scene, *, small: bool
) -> Case:  # fmt: skip
    """A case that runs a scene.

    Args:
        group: see `Case`.
        variant: see `Case`.
        title: see `Case`.
        measure: see `Case`.
        scene: whose mesh is told.
        small: whether it is a small version.
    """
    return Case(group, measure, title, "hard cases", mesh_of(scene), variant, slow=not small)


def hard_cases(*, small: bool = False) -> list[Case]:
    """All hard cases.

    Args:
        small: their small versions.
    """
    from knotfem.verify.stress import cycles, input, invariance, knots, pressure, steps, twist

    modules = (knots, pressure, input, twist, cycles, invariance, steps)
    return [case for module in modules for case in module.cases(small=small)]
