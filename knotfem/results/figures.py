"""The figures that a run directory draws by itself."""

from __future__ import annotations

import numpy as np

from knotfem.plot import plots
from knotfem.results.data import open_run
from knotfem.results.force import force_at, force_curve
from knotfem.results.moment import moment_heading
from knotfem.results.profile import StoredStates
from knotfem.run.directory import RunDirectory
from knotfem.run.recorder import Recorder


class RunFigures:
    """See `knotfem.run.driver.Figures`."""

    def mapped(self, run: RunDirectory, recorder: Recorder) -> None:
        """stretch.png: stretch of each rod's centreline against arclength, coloured by mapping time."""
        rods, first = run.scene.rods, 0
        for rod, target in zip(rods, recorder.model.targets, strict=True):
            edges = slice(first, first + target.slices.count)
            first += target.slices.count
            plots.plot_stretch(
                target.slices.middles,
                np.array([stretch[edges] for stretch in recorder.stretches]),
                np.array(recorder.mapping_times),
                run.path / ("stretch.png" if len(rods) == 1 else f"stretch-{rod.name}.png"),
                threshold=run.scene.tie.threshold,
            )

    def finished(self, run: RunDirectory, name: str | None = None) -> None:
        """force.png and tension.png: force against displacement, and the last tension profile over its force.

        The force has a band of its error where that was measured. What is not stored is not drawn.

        Args:
            run: its directory.
            name: of the run in legends; that of its folder by default.
        """
        done = open_run(run.path)
        if done.table("force").get("force_N", np.zeros(0)).size:
            curve = force_curve(done, name or run.path.name)
            displacement, force = curve.drawn
            bands = {} if curve.band is None else {curve.label: curve.band}
            if displacement.size > 1:
                plots.plot_force(
                    {curve.label: {"displacement_mm": displacement, "force_N": force}},
                    run.path / "force.png",
                    radius=0.5 * run.scene.diameter,
                    bands=bands,
                    unbalanced=curve.unbalanced,
                )
        stored = StoredStates.of(run.path, done.table("tension"))
        if not stored.moments:
            return
        last = stored.profile()
        curves = {"" if len(last.rods) == 1 else rod: last.of(rod).table for rod in sorted(last.rods)}
        force = force_at(done, last.moment)
        applied = force if force > 0.0 else None
        plots.plot_tension(curves, run.path / "tension.png", applied=applied, title=moment_heading(last.moment))
