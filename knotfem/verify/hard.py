"""Hard cases: runs of the scenes in configs/hard, what came of each, and what it must be.

Each case has a small version, a coarse mesh under a shorter pull, for the tests.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.errors import InputError, KnotfemError
from knotfem.run import driver
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.scene import Scene, load_scene
from knotfem.verify.rehearsal import Passed, Rehearsal
from knotfem.verify.verdict import Case, Kind, Quantity

SMALL = (
    "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=5 mm", "contact.sample_spacing_over_diameter=0.25",
    "tie.increments=2",
)  # fmt: skip
QUIET = ("output.fields=false", "output.checkpoint_every=1 h")

FEW_CUTBACKS, CUTBACKS = 3.0, 0.5
"""So many are always allowed, and this share of the steps."""
SMALLEST_J = 0.05
PENETRATION = 0.10
"""Deepest penetration over the diameter."""
ENERGY = 0.02
"""Largest part of the work that may be missing from the energy account."""


@dataclass(frozen=True)
class Outcome:
    """What came of a run.

    Attributes:
        scene: what was run.
        ended: "yes", or the error that ended it.
        steps: accepted.
        iterations: of Newton's method.
        cutbacks: failed attempts at a step.
        jacobian: smallest determinant of the deformation gradient.
        penetration: deepest, over the diameter.
        before: knot that was tied.
        after: knot at the end.
        energy_error: largest missing energy over the work.
        wall: [s].
        force: columns of force.csv.
        tension: columns of tension.csv.
        log: lines of log.jsonl.
    """

    scene: Scene
    ended: str
    steps: int
    iterations: int
    cutbacks: int
    jacobian: float
    penetration: float
    before: str
    after: str
    energy_error: float
    wall: float
    force: dict[str, np.ndarray]
    tension: dict[str, np.ndarray]
    log: list[dict[str, Any]]

    @property
    def finished(self) -> bool:
        return self.ended == "yes"

    def quantities(
        self, *, before: str = "", after: str = "", condition: str = "", penetration: float = PENETRATION,
        energy: float = ENERGY,
    ) -> list[Quantity]:  # fmt: skip
        """The figures that every case has.

        Args:
            before: knot that must have been tied, or "" for whichever it is.
            after: knot that must be left, likewise.
            condition: tells runs of one case apart.
            penetration: largest share of the diameter.
            energy: largest part of the work that may be missing.
        """
        figures: list[tuple[str, float | str, float | str, Kind]] = [
            ("finished", self.ended, "yes", "equal"),
            ("cutbacks", float(self.cutbacks), max(FEW_CUTBACKS, CUTBACKS * self.steps), "at most"),
            ("smallest J", self.jacobian, SMALLEST_J, "at least"),
            ("penetration / d", self.penetration, penetration, "at most"),
            ("knot before", self.before, before or self.before, "equal"),
            ("knot after", self.after, after or self.after, "equal"),
            ("energy error", self.energy_error, energy, "at most"),
        ]
        return [Quantity(name, found, limit, kind=kind, condition=condition) for name, found, limit, kind in figures]


def quantities_of(rehearsal: Rehearsal, last: Passed) -> list[Quantity]:
    """The same figures of a scene taken in memory, as far as it has them.

    Args:
        rehearsal: at its end.
        last: its last step.
    """
    energies = rehearsal.account.energies
    scale = max(abs(energies.work), energies.stored, energies.friction, 1e-300)
    return [
        Quantity("finished", "yes", "yes", kind="equal"),
        Quantity("cutbacks", float(rehearsal.cutbacks), max(FEW_CUTBACKS, CUTBACKS * rehearsal.steps), kind="at most"),
        Quantity("smallest J", rehearsal.jacobian, SMALLEST_J, kind="at least"),
        Quantity("penetration / d", rehearsal.penetration / rehearsal.model.diameter, PENETRATION, kind="at most"),
        Quantity("energy error", abs(last.missing) / scale, ENERGY, kind="at most"),
    ]


def mesh_of(small: bool) -> str:
    """What the table of verdicts says of the mesh; the rest is in the scenes."""
    return "4 hexes a section, h = 5 mm" if small else "12 hexes a section"


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
    """Run a scene to its end, or to the error that a user would meet.

    Args:
        scene: what to run.
        path: of the run directory; None for one that is gone afterwards.
    """
    if path is None:
        with folder() as temporary:
            return run(scene, temporary / "run")
    directory = RunDirectory.create(scene, path)
    began, ended = time.perf_counter(), "yes"
    try:
        driver.pull(scene, directory)
    except InputError:
        raise
    except KnotfemError as error:
        ended = f"{type(error).__name__}: {error}"
    return outcome(directory, ended, time.perf_counter() - began)


def outcome(directory: RunDirectory, ended: str, wall: float) -> Outcome:
    """What the files of a run say."""
    summary = directory.read_summary()
    force, tension = (_table(directory.path / name) for name in ("force.csv", "tension.csv"))
    return Outcome(
        directory.scene,
        ended,
        int(summary["steps"]),
        int(summary["newton_iterations"]),
        int(summary["cutbacks"]),
        float(summary["min_jacobian"]),
        float(summary["max_penetration_over_d"]),
        str(summary["knot_before"]),
        str(summary["knot_after"]),
        _energy_error(force),
        wall,
        force,
        tension,
        [json.loads(line) for line in (directory.path / "log.jsonl").read_text().splitlines()],
    )


def _table(path: Path) -> dict[str, np.ndarray]:
    return read_table(path) if path.exists() else {}


def _energy_error(force: dict[str, np.ndarray]) -> float:
    """Largest missing energy over the largest of work, stored energy and what was taken."""
    if not force or not force["missing_Nmm"].size:
        return 0.0
    scale = max(float(np.abs(force[name]).max()) for name in ("work_Nmm", "elastic_Nmm", "friction_Nmm", "drag_Nmm"))
    return float(np.abs(force["missing_Nmm"]).max()) / scale if scale > 0.0 else 0.0


def at(force: dict[str, np.ndarray], displacement: float) -> float:
    """Force [N] at a displacement [mm] of the last step, from the rows of force.csv."""
    rows = force["step"] == force["step"][-1]
    return float(np.interp(displacement, force["displacement_mm"][rows], force["force_N"][rows]))


def hard_cases(*, small: bool = False) -> list[Case]:
    """All hard cases.

    Args:
        small: their small versions.
    """
    from knotfem.verify import hard_cycles, hard_input, hard_invariance, hard_knots, hard_steps, hard_twist

    modules = (hard_knots, hard_input, hard_twist, hard_cycles, hard_invariance, hard_steps)
    return [case for module in modules for case in module.cases(small=small)]
