"""Draws the figures of a run directory as it goes on."""

from __future__ import annotations

import numpy as np

from knotfem.plot.figures import draw_curves, draw_stretch
from knotfem.run.directory import RunDirectory
from knotfem.run.recorder import Recorder
from knotfem.run.tables import read_table


class RunFigures:
    """See `knotfem.run.driver.Figures`."""

    def mapped(self, run: RunDirectory, recorder: Recorder) -> None:
        """stretch.png."""
        rods = run.scene.rods
        draw_stretch(
            run.path,
            [rod.name for rod in rods],
            [rod.slices for rod in rods],
            recorder.mapping_times,
            recorder.stretches,
            run.scene.tie.threshold,
        )

    def finished(self, run: RunDirectory) -> None:
        """force.png and tension.png."""
        force, tension = (read_table(run.path / f"{name}.csv") for name in ("force", "tension"))
        last = None
        if len(tension["time_s"]):
            rows = tension["time_s"] == np.max(tension["time_s"])
            last = {name: values[rows] for name, values in tension.items()}
        applied = float(force["force_N"][-1]) if len(force["force_N"]) else 0.0
        draw_curves(run.path, force, last, radius=0.5 * run.scene.diameter, applied=applied)
