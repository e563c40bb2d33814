"""Tables, series and summary of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from functools import wraps
from typing import Any, Concatenate, ParamSpec

import numpy as np

from knotfem.energy.account import Account, Balance
from knotfem.models.base import Simulation
from knotfem.models.contacts import CONTACT_COLUMNS, contact_rows
from knotfem.models.solid.mapping import Increment
from knotfem.results.profile import EXTRA_COLUMNS, tension
from knotfem.run.directory import RunDirectory
from knotfem.run.series import open_series
from knotfem.run.summary import Summary
from knotfem.run.tables import TWIST_COLUMNS, Table, read_table
from knotfem.scene.steps import Relax, Step
from knotfem.solver.stepping.integrator import Accepted
from knotfem.solver.system import System
from knotfem.solver.term import Motion
from knotfem.terms.registry import BOOKED_BY_NAME

FORCE_EXTRA = (
    "step", "sliding", "imbalance_N", "drag_force_N", "unrest_N", "work_Nmm", "elastic_Nmm", "kinetic_Nmm",
    "contact_Nmm", "gravity_Nmm", "friction_Nmm", "drag_Nmm", "numerical_Nmm", "missing_Nmm", "cutbacks",
)  # fmt: skip

P = ParamSpec("P")


def _timed(write: Callable[Concatenate[Outputs, P], None]) -> Callable[Concatenate[Outputs, P], None]:
    """Books what a method takes as output."""

    @wraps(write)
    def timed(self: Outputs, *args: P.args, **kwargs: P.kwargs) -> None:
        with self.summary.output():
            write(self, *args, **kwargs)

    return timed


class Outputs:
    """All that a run writes besides checkpoints and status."""

    def __init__(self, run: RunDirectory, model: Simulation) -> None:
        self.run, self.model = run, model
        self.summary = Summary(run, model)
        self.mapping_times: list[float] = []
        self._series, self._stored_before = None, 0
        booked = (effect.name for effect in model.effects if effect.name in BOOKED_BY_NAME)
        self._registered_columns = [_column(name) for name in dict.fromkeys(booked)]

    def begin(self, metadata: dict[str, Any] | None) -> None:
        """Start the tables, or cut them back to the rows of a checkpoint."""
        self.tables = {
            "tie": self.run.tie_table,
            "force": self.run.force_table((*FORCE_EXTRA, *self._registered_columns)),
            "tension": self.run.tension_table(EXTRA_COLUMNS),
            "contacts": Table(self.run.path / "contacts.csv", CONTACT_COLUMNS),
        }
        if self.model.segments:
            self.tables["twist"] = Table(self.run.path / "twist.csv", TWIST_COLUMNS)
        rows = metadata["rows"] if metadata else {}
        for name, table in self.tables.items():
            table.keep(int(rows.get(name, 0)))
        self.run.keep_log(int(rows.get("log", 0)))
        self._stored_before = int(rows.get("series", 0))
        if self.model.scene.output.fields:
            path = self.run.path / "results.vtkhdf"
            self._series = open_series(path, self.model.series_mesh, self._stored_before if metadata else None)

    def rows(self) -> dict[str, Any]:
        """For the metadata of a checkpoint."""
        return {
            "rows": {
                **{name: table.rows for name, table in self.tables.items()},
                "log": self.run.log_lines,
                "series": self._stored_before if self._series is None else len(self._series.times),
            }
        }

    @_timed
    def mapping(self, increment: Increment) -> None:
        """An increment of the mapping is solved."""
        self.mapping_times.append(increment.mapping_time)
        self.tables["tie"].append(
            {
                "mapping_time": increment.mapping_time,
                "max_stretch": float(increment.stretch.max()),
                "min_stretch": float(increment.stretch.min()),
                "newton_iterations": increment.iterations,
                "wall_s": increment.wall,
            }
        )

    @_timed
    def plots(self) -> None:
        """Plots of the tables, once the run has reached its goal."""
        from knotfem.plot import plots

        force = self.tables["force"]
        if force.rows:
            curves = {self.run.path.name: read_table(force.path)}
            plots.plot_force(curves, self.run.path / "force.png", radius=0.5 * self.model.diameter)
        if self.tables["tension"].rows:
            profile = tension(self.run)
            rods = {name: profile["rod"] == name for name in np.unique(profile["rod"])}
            curves = {
                ("" if len(rods) == 1 else str(name)): {key: values[rows] for key, values in profile.items()}
                for name, rows in rods.items()
            }
            applied = self.summary.figures["final_force_N"] or float(np.abs(profile["tension_N"]).max())
            plots.plot_tension(curves, self.run.path / "tension.png", applied=applied)

    @_timed
    def stretch_plot(self, stretches: list[np.ndarray]) -> None:
        """Stretch of the centreline against arclength, coloured by mapping time."""
        from knotfem.plot import plots

        first = 0
        for rod in self.model.rods:
            slices = rod.scene.slices
            edges = slice(first, first + slices)
            first += slices
            name = "stretch.png" if len(self.model.rods) == 1 else f"stretch-{rod.scene.name}.png"
            plots.plot_stretch(
                (np.arange(slices) + 0.5) / slices,
                np.array([stretch[edges] for stretch in stretches]),
                np.array(self.mapping_times),
                self.run.path / name,
                threshold=self.model.scene.tie.threshold,
            )

    @_timed
    def step(self, step: Step, accepted: Accepted, balance: Balance, account: Account, system: System) -> None:
        """A step was accepted."""
        e = account.energies
        ratio = e.kinetic / e.elastic if e.elastic > 0.0 else 0.0
        self.summary.count(accepted, balance)
        record = {
            "time_s": accepted.motion.time,
            "displacement_mm": balance.displacement,
            "force_N": balance.force,
            "newton_iterations": accepted.took.count,
            "contacts": balance.contacts,
            "max_penetration_mm": balance.penetration,
            "kinetic_over_internal": ratio,
            "wall_s": accepted.wall,
            "step": step.name,
            "sliding": balance.sliding,
            "imbalance_N": balance.imbalance,
            "drag_force_N": balance.drag_force,
            "unrest_N": balance.unrest,
            "work_Nmm": e.work,
            "elastic_Nmm": e.elastic,
            "kinetic_Nmm": e.kinetic,
            "contact_Nmm": e.contact,
            "gravity_Nmm": e.gravity,
            "friction_Nmm": e.friction,
            "drag_Nmm": e.drag,
            "numerical_Nmm": e.numerical,
            "missing_Nmm": e.missing,
            "cutbacks": accepted.failed,
            **{_column(name): energy for name, energy in e.of_registered.items()},
        }
        if not isinstance(step, Relax):
            self.tables["force"].append(record)
        self.run.log(
            phase=step.name,
            step_s=accepted.start.dt,
            residual_N=accepted.took.residual,
            resultant_N=accepted.took.resultant,
            shift=accepted.took.shift,
            reactions_N=balance.reactions,
            analyses=system.analyses,
            **{key: value for key, value in record.items() if key != "step"},
        )

    @_timed
    def state(self, motion: Motion, balance: Balance, step: Step) -> None:
        """Outputs are due: fields and tension profile."""
        when = motion.time, balance.displacement
        self.tables["tension"].extend(self.model.profile(motion.x, *when))
        self.tables["contacts"].extend(contact_rows(self.model.scene, self.model.contacts(), *when))
        if "twist" in self.tables:
            self.tables["twist"].extend(self.model.twist(motion.x, *when))
        if not isinstance(step, Relax):
            self.summary.balance(balance)
        if self._series is not None:
            found = self.model.fields(motion.x)
            self._series.append(motion.time, found.points, point_data=found.point_data, cell_data=found.cell_data)

    def close(self, account: Account) -> None:
        """The run has reached its goal."""
        self.summary.finish(asdict(account.energies))
        if self._series is not None:
            self._series.close()

    def state_for_checkpoint(self) -> dict[str, Any]:
        return self.summary.state()

    def restore(self, state: dict[str, Any]) -> None:
        self.summary.restore(state)


def _column(name: str) -> str:
    return f"{name.replace(' ', '_')}_Nmm"
