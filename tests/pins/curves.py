"""Curves of scenes, as the pins compare them: the one place of this folder that touches the program.

Whoever changes how a scene is run adapts these functions and nothing else here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from knotfem.results.profile import tension
from knotfem.run import driver
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.scene import load_scene

Curve = tuple[np.ndarray, np.ndarray]
"""Abscissa and ordinate, each of shape [points]."""


def force_curve(scene: str, overrides: Sequence[str] = ()) -> Curve:
    """Displacement [mm] and force [N] of the driven end at every accepted step of all pulls of a shipped scene.

    Where pulls follow each other, the displacement of the later one goes on from the end of the earlier one.

    Args:
        scene: a shipped name.
        overrides: of keys of the scene, such as "contact.friction=0.3".
    """
    with _ran(scene, overrides) as run:
        return force_of(run)


def sag_curve(scene: str, overrides: Sequence[str] = ()) -> Curve:
    """Arclength [mm] and sag [mm] below the clamped start of a shipped scene's rod at the end; see `force_curve`."""
    with _ran(scene, overrides) as run:
        return sag_of(run)


def force_of(run: RunDirectory) -> Curve:
    """As `force_curve`, of a run that is there."""
    table = read_table(run.path / "force.csv")
    displacement, force, travelled = [], [], 0.0
    for step in run.scene.steps:
        if not step.driven:
            continue
        rows = table["step"] == step.name
        displacement.append(travelled + table["displacement_mm"][rows])
        force.append(table["force_N"][rows])
        travelled = displacement[-1][-1]
    return np.concatenate(displacement), np.concatenate(force)


def sag_of(run: RunDirectory) -> Curve:
    """As `sag_curve`, of a run that is there."""
    profile = tension(run)
    return profile["arclength_mm"], profile["z_mm"][0] - profile["z_mm"]


@contextmanager
def _ran(scene: str, overrides: Sequence[str]) -> Iterator[RunDirectory]:
    """The folder of a whole run, for as long as it is looked at."""
    with TemporaryDirectory() as folder:
        run = RunDirectory.create(load_scene(scene, overrides), Path(folder) / "run")
        driver.pull(run.scene, run)
        yield run
