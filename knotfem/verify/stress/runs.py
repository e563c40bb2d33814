"""How hard cases run the scenes in configs/hard.

Each case has a small version, with a coarse mesh and a shorter pull, for the tests.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

import knotfem as kf
from knotfem.errors import KnotLost, NotConverged
from knotfem.run.events import TimeStepDone
from knotfem.run.memory import MemoryStore
from knotfem.run.recorder import Recorder
from knotfem.run.simulation import Simulation
from knotfem.scene import Scene, load_scene
from knotfem.verify.case import Case, Quantity
from knotfem.verify.stress.outcome import Outcome, Table, make_outcome

SMALL = (
    "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=5 mm", "contact.sample_spacing_over_diameter=0.25",
    "tie.increments=2",
)  # fmt: skip
SLIGHT = ("steps.1.displacement=2 mm", "output.every_displacement=1 mm")
"""A pull for small versions."""
QUIET = ("output.fields=false", "output.checkpoint_every=1 h")
TABLES = ("force", "tension")


@contextmanager
def folder() -> Iterator[Path]:
    """A folder that is deleted afterwards."""
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


def run(scene: Scene) -> Outcome:
    """Pull a scene to its end, or until it fails to converge or its knot is lost, in a run directory.

    Raises:
        KnotfemError: any other error that ends the run.
    """
    with folder() as parent:
        path, ended = parent / "run", "yes"
        try:
            kf.pull(scene, out=path, progress=False)
        except (NotConverged, KnotLost) as error:
            ended = f"{type(error).__name__}: {error}"
        done = kf.open_run(path)
        log = [json.loads(line) for line in (path / "log.jsonl").read_text().splitlines()]
        return make_outcome(ended, done.scene, done.summary, {name: done.table(name) for name in TABLES}, log)


class Recording:
    """The steps of a simulation, recorded in memory: for cases that need each state, a start or a section of their own.

    Args:
        simulation: that has not begun.
    """

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self._store = MemoryStore()
        self._recorder = Recorder(simulation, self._store)
        self._recorder.begin(None)

    def __iter__(self) -> Iterator[TimeStepDone]:
        """Take the steps that are left."""
        for event in self.simulation.run():
            self._recorder.record(event)
            if isinstance(event, TimeStepDone):
                yield event

    def outcome(self) -> Outcome:
        """The outcome of the steps so far."""
        tables = {name: self._store.tables[name].arrays() for name in TABLES}
        return make_outcome("yes", self.simulation.scene, self._recorder.finish(), tables, self._store.records)


def at(force: Table, displacement: float) -> float:
    """Force [N] at a displacement [mm] in the last step, from the table of forces."""
    rows = force["step"] == force["step"][-1]
    return float(np.interp(displacement, force["step_displacement_mm"][rows], force["force_N"][rows]))


def hard_case(
    group: str, variant: str, title: str, measure: Callable[[], Sequence[Quantity]], scene: Scene, *, small: bool
) -> Case:  # fmt: skip
    """A case that runs a scene.

    Args:
        group: see `Case`.
        variant: see `Case`.
        title: see `Case`.
        measure: see `Case`.
        scene: whose mesh the table of results names.
        small: whether it is a small version.
    """
    mesh = scene.rods[0].mesh
    described = f"{mesh.section_elements} hexahedra per section, h = {mesh.element_length:g} mm"
    return Case(group, measure, title, "hard cases", described, variant, slow=not small)
