"""Turns the events of a simulation into tables, series and summary, in memory or on disk."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

import numpy as np

from knotfem.errors import InputError
from knotfem.models.base import Increment, Model
from knotfem.models.contacts import CONTACT_COLUMNS, contact_rows
from knotfem.models.series import Fields, SeriesMesh
from knotfem.run.checkpoint import RunCheckpoint
from knotfem.run.columns import (
    DRAWN_IN,
    EVENT_COLUMNS,
    FORCE_COLUMNS,
    FORCE_EXTRA,
    OF_STATE,
    RUNNING,
    TENSION_COLUMNS,
    TENSION_EXTRA,
    TIE_COLUMNS,
    TWIST_COLUMNS,
    Value,
    energy_column,
)
from knotfem.run.events import PhaseDone, TimeStepDone
from knotfem.run.jumps import Jump
from knotfem.run.simulation import Simulation
from knotfem.run.summary import Summary
from knotfem.solver.term import VISCOUS, Role, Term

SHARED = {"gravity": Role.FIELD, "drag": Role.RESISTANCE}
"""Terms whose energies have a column in every run, and what they are; those of their name and role add to it."""


class TableSink(Protocol):
    """A table that rows are appended to."""

    @property
    def rows(self) -> int:
        """How many there are."""
        ...

    def append(self, row: Mapping[str, Value]) -> None:
        """Append one row."""
        ...

    def extend(self, rows: Iterable[Mapping[str, Value]]) -> None:
        """Append rows."""
        ...

    def keep(self, rows: int) -> None:
        """Drop all rows past the first `rows`."""
        ...


class SeriesSink(Protocol):
    """A time series of fields."""

    def append(self, time: float, displacement: float, fields: Fields) -> None:
        """Append a state."""
        ...

    @property
    def count(self) -> int:
        """States so far."""
        ...

    def close(self) -> None:
        """Bring it to an end."""
        ...


class Store(Protocol):
    """Where a run is kept."""

    def table(self, name: str, columns: tuple[str, ...]) -> TableSink:
        """The table of a name."""
        ...

    def series(self, mesh: Callable[[], SeriesMesh], kept: int | None) -> SeriesSink:
        """The time series: a new one, or an existing one cut back to the first `kept` states."""
        ...

    def log(self, record: Mapping[str, Any]) -> None:
        """Keep a record of a step."""
        ...

    @property
    def logged(self) -> int:
        """Records so far."""
        ...

    def keep_log(self, records: int) -> None:
        """Drop all past the first."""
        ...


class Recorder:
    """Records the events of a simulation.

    Args:
        simulation: whose events they are.
        store: where to.

    Attributes:
        summary: figures of the whole run.
        stretches: of the mapping's increments, shape [edges] each.
        mapping_times: of them.
    """

    def __init__(self, simulation: Simulation, store: Store) -> None:
        self.simulation, self.store = simulation, store
        self.model: Model = simulation.model
        self.summary = Summary(self.model)
        self.mapping_times: list[float] = []
        self.stretches: list[np.ndarray] = []
        self._series: SeriesSink | None = None
        self._stored_before = 0
        self._own = own_columns(self.model.terms)

    def begin(self, checkpoint: RunCheckpoint | None = None) -> None:
        """Start tables and summary, or go on from those of a checkpoint.

        Raises:
            InputError: the tables are not those of the model, or cannot be written.
        """
        columns = {
            "tie": TIE_COLUMNS,
            "force": (*FORCE_COLUMNS, *FORCE_EXTRA, *self._own, *([DRAWN_IN] if self.simulation.decides else [])),
            "tension": (*TENSION_COLUMNS, *TENSION_EXTRA),
            "contacts": (*CONTACT_COLUMNS, *OF_STATE),
            **({"twist": TWIST_COLUMNS} if self.model.segments else {}),
            **({} if all(step.real for step in self.model.scene.steps) else {"events": EVENT_COLUMNS}),
        }
        self.tables = {name: self.store.table(name, of_it) for name, of_it in columns.items()}
        rows = checkpoint.rows if checkpoint else {}
        for name, table in self.tables.items():
            table.keep(int(rows.get(name, 0)))
        self.store.keep_log(int(rows.get("log", 0)))
        self._stored_before = int(rows.get("series", 0))
        self.summary.begin()
        if checkpoint:
            self.summary.restore(checkpoint.summary)
        self.summary.figures["linear_solver"] = self.simulation.linear_solver
        if self.model.scene.output.fields:
            self._series = self.store.series(self.model.series_mesh, self._stored_before if checkpoint else None)

    def checkpoint(self) -> RunCheckpoint:
        """All that is needed to go on."""
        self._add_rest()
        return RunCheckpoint(self.simulation.checkpoint(), self.summary.state(), self.rows())

    def rows(self) -> dict[str, int]:
        """Rows so far."""
        series = self._stored_before if self._series is None else self._series.count
        return {**{name: table.rows for name, table in self.tables.items()}, "log": self.store.logged, "series": series}

    def record(self, event: Increment | TimeStepDone | PhaseDone) -> None:
        """Record an event; the time since the last one belongs to its phase."""
        if isinstance(event, TimeStepDone):
            self.summary.add_system(event.system)
            with self.summary.output():
                self._step(event)
            self.summary.add_time(event.step.name)
        elif isinstance(event, Increment):
            self.summary.add_system(event.system)
            with self.summary.output():
                self._increment(event)
            self.summary.add_time("mapping")
        else:
            if event.name == "mapping" and self.stretches:
                self.summary.stretch(self.stretches)
            self.summary.add_time(event.name)

    def finish(self) -> dict[str, Any]:
        """Figures of the run so far."""
        self._add_rest()
        if self.simulation.knots_before is not None:
            self.summary.knots(self.simulation.knots_before, self.simulation.knots())
        self.summary.figures.update(self.simulation.verdict())
        self.summary.figures["remarks"] = self.simulation.remarks.figures()
        self.summary.figures["validity"] = self.simulation.validity.found
        if self._series is not None:
            self._series.close()
        return self.summary.finished(self.simulation.balance.energies)

    def _add_rest(self) -> None:
        """Add what the present phase took since the last event, such as a time step that was not accepted."""
        self.summary.add_system(self.simulation.system)
        self.summary.add_time(self.simulation.phase)

    def _increment(self, increment: Increment) -> None:
        self.mapping_times.append(increment.mapping_time)
        self.stretches.append(increment.stretch)
        self.tables["tie"].append(
            {
                "mapping_time": increment.mapping_time,
                "max_stretch": float(increment.stretch.max()),
                "min_stretch": float(increment.stretch.min()),
                "newton_iterations": increment.iterations,
                "wall_s": increment.wall,
            }
        )
        self.store.log(
            {
                "phase": "mapping",
                "mapping_time": increment.mapping_time,
                "smallest_j": increment.smallest_j,
                "solved": increment.solved,
            }
        )

    def _step(self, event: TimeStepDone) -> None:
        record = {**dict.fromkeys(self._own, 0.0), **force_row(event)}
        if self.simulation.decides:
            record[DRAWN_IN] = event.drawn_in
        self.summary.count(event)
        if event.step.loading:
            self.tables["force"].append(record)
        solution = event.accepted.solution
        self.store.log(
            {
                "phase": event.step.name,
                "step_s": event.accepted.dt,
                "residual_N": solution.imbalance.residual,
                "resultant_N": solution.imbalance.resultant,
                "damping": solution.damping,
                "reactions_N": event.figures.reactions,
                "analyses": event.system.analyses,
                **{key: value for key, value in record.items() if key != "step"},
            }
        )
        if event.jump is not None:
            self.tables["events"].append(event_row(event.jump))
            self.summary.figures["events"] += 1
        if event.output:
            self._output(event)

    def _output(self, event: TimeStepDone) -> None:
        """Fields and profiles of a state."""
        model, x, when = self.model, event.state.x, (event.time, event.displacement)
        of_state = {"step": event.step.name, RUNNING: event.step_displacement}
        rows: dict[str, Iterable[Mapping[str, Value]]] = {
            "tension": model.tension_profile(x, *when),
            "contacts": contact_rows(model, model.contacts(), *when),
            **({"twist": model.twist_profile(x, *when)} if "twist" in self.tables else {}),
        }
        for name, found in rows.items():
            self.tables[name].extend({**row, **of_state} for row in found)
        if event.step.loading:
            self.summary.output_figures(event.figures)
        if self._series is not None:
            self._series.append(*when, model.fields(x))


def own_columns(terms: Iterable[Term]) -> list[str]:
    """Columns of force.csv for the energies of terms that have none in `FORCE_EXTRA`.

    Raises:
        InputError: the energy of a term would stand in the column of another quantity.
    """
    taken: dict[str, tuple[str, Role] | None] = dict.fromkeys(FORCE_EXTRA)
    taken |= {energy_column(name): (name, role) for name, role in SHARED.items()}
    for term in terms:
        if term.role in (*VISCOUS, Role.FIELD):
            kind = term.name, term.role
            if taken.setdefault(energy_column(term.name), kind) != kind:
                problem = "its energy has the column of another"
                raise InputError(problem, key="terms", found=term.name, expected="a name of its own")
    return [column for column in taken if column not in FORCE_EXTRA]


def event_row(jump: Jump) -> dict[str, float | int | str]:
    """Row of events.csv."""
    return {
        "step": jump.step,
        "time_s": jump.time,
        "displacement_mm": jump.displacement,
        RUNNING: jump.step_displacement,
        "force_before_N": jump.force_before,
        "force_after_N": jump.force_after,
        "rod": jump.rod,
        "s_over_L": jump.arclength_fraction,
        "moved_mm": jump.moved,
        "released_Nmm": jump.released,
        "steps": jump.steps,
    }


def force_row(event: TimeStepDone) -> dict[str, float | int | str]:
    """Row of force.csv of an accepted step."""
    e, f, accepted = event.energies, event.figures, event.accepted
    own = {energy_column(name): value for name, value in {**e.taken, **e.fields}.items()}
    return {
        "time_s": event.time,
        "displacement_mm": event.displacement,
        RUNNING: event.step_displacement,
        "force_N": f.force,
        "newton_iterations": accepted.solution.iterations,
        "contacts": f.contacts,
        "max_penetration_mm": f.penetration,
        "kinetic_over_internal": e.kinetic / e.elastic if e.elastic > 0.0 else 0.0,
        "wall_s": accepted.wall,
        "step": event.step.name,
        "sliding": f.sliding,
        "imbalance_N": f.imbalance,
        "drag_force_N": f.drag_force,
        "unrest_N": f.dynamic_residual,
        "work_Nmm": e.work,
        "elastic_Nmm": e.elastic,
        "kinetic_Nmm": e.kinetic,
        "contact_Nmm": e.contact,
        "friction_Nmm": e.friction,
        "numerical_Nmm": e.algorithmic,
        "missing_Nmm": e.error,
        "cutbacks": accepted.rejected,
        "equilibrium": int(event.equilibrium),
        **dict.fromkeys(map(energy_column, SHARED), 0.0),
        **own,
    }
