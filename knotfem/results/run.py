"""A run, in memory or on disk: what it was asked for and what came of it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from knotfem.errors import InputError
from knotfem.results.base import RunData, displacement_of
from knotfem.results.force import ForceCurve, force_curve, tolerance_notes, unrest_notes
from knotfem.results.holding import holding_of
from knotfem.results.moment import reach
from knotfem.results.profile import StoredStates, TensionProfile, stored_states
from knotfem.results.states import RunState
from knotfem.run.checkpoint import RunCheckpoint
from knotfem.run.knot_words import knot_said
from knotfem.stability.holding import Holding
from knotfem.types import Arrays

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Run(RunData):
    """A run and what can be asked of it."""

    @property
    @abstractmethod
    def additions(self) -> Mapping[str, Sequence[str]]:
        """Names of what the user added to the scene as objects, by the argument that they are passed as."""

    @abstractmethod
    def tied(self) -> RunCheckpoint | None:
        """The tied knot, from which other steps can be taken; None where it is not tied.

        Raises:
            InputError: its checkpoint is damaged or of an older version.
        """

    @abstractmethod
    def _read_states(self) -> list[RunState]:
        """See `states`."""

    def __repr__(self) -> str:
        where = "in memory" if self.path is None else str(self.path)
        return f"<knotfem run {self.name!r}, {where}>"

    @cached_property
    def force(self) -> ForceCurve:
        """Force against displacement.

        Raises:
            InputError: no loading step has been taken.
        """
        return force_curve(self)

    @cached_property
    def stored(self) -> StoredStates:
        """States whose tension profiles are stored.

        Raises:
            InputError: there are none.
        """
        return stored_states(self)

    def tension(self, at: float | str | None = None, step: str | None = None) -> TensionProfile:
        """Tension along the centreline in a stored state, which the profile's attribute `moment` tells.

        Args:
            at: displacement over all steps after tying, [mm] or such as "60 mm"; the nearest stored state is taken;
                None for the last.
            step: name of the step that the state is to be of; None for any.

        Raises:
            InputError: nothing is stored near it, or no state of this step.
        """
        return self.stored.profile(displacement_of(at), step)

    def contacts(self, at: float | str | None = None, step: str | None = None) -> Arrays:
        """Samples in contact in a stored state: columns of contacts.csv.

        Args:
            at: see `tension`.
            step: likewise.
        """
        time = self.stored.choose(displacement_of(at), step).time
        table = self.table("contacts")
        rows = table["time_s"] == time if table else np.zeros(0, dtype=bool)
        return {name: values[rows] for name, values in table.items()}

    @cached_property
    def states(self) -> list[RunState]:
        """Stored states, oldest first, as they were when first asked for; their fields are read as they are needed."""
        return self._read_states()

    def state(self, at: float | str | None = None, step: str | None = None) -> RunState:
        """A stored state with its fields; of the last states those are left out that have none.

        Args:
            at: see `tension`.
            step: likewise.

        Raises:
            InputError: no state is stored, none near it or of this step, or its fields are not stored.
        """
        if not self.states:
            if self.scene.output.fields:
                expected = "a run that has stored a state; knotfem resume goes on with this one"
                raise InputError("no state was stored before the run ended", file=self.path, expected=expected)
            raise InputError("no state is stored", file=self.path, expected="a run with output.fields = true")
        if at is None and step is None:
            return self.states[-1]
        moment = self.stored.choose(displacement_of(at), step)
        found = next((state for state in self.states if state.time == moment.time), None)
        if found is None:
            expected = f"a state of which fields are stored: {reach([state.moment for state in self.states])}"
            raise InputError(
                "its fields are not stored", file=self.path, key="at", found=str(moment), expected=expected
            )
        return found

    @property
    def cost(self) -> Cost:
        """What the run took."""
        s = self.summary
        phases = {name: Spent(**spent) for name, spent in s.get("phases", {}).items()}
        effects = {name: entry["cpu_s"] for name, entry in s.get("effects", {}).items()}
        return Cost(phases, effects, s.get("steps", 0), s.get("newton_iterations", 0), s.get("peak_memory_mb", 0.0))

    @property
    def events(self) -> Arrays:
        """Jumps of the rods from one branch of equilibria to another: columns of events.csv, none in real time."""
        return dict(self.table("events"))

    @property
    def notes(self) -> list[str]:
        """What a reader should know, in words: what happened; where forces are not of equilibria, or not known well."""
        happened = [remark["said"] for remark in self.summary.get("remarks", ())]
        return [*happened, *unrest_notes(self), *tolerance_notes(self)]

    @property
    def energy(self) -> EnergyCurve:
        """Energy balance of the loading steps."""
        return EnergyCurve(self.table("force"))

    @property
    def knot(self) -> str | dict[str, str] | None:
        """Name of the knot at the end; of several rods what each is tied into and linked with, by its name."""
        return knot_said(self.summary.get("knot_after"))

    @property
    def verdict(self) -> str | None:
        """Whether the knot "holds", "slips" or "unravels", or "undecided"; None without a loaded and a free end."""
        return self.summary.get("verdict")

    @property
    def verdict_evidence(self) -> dict[str, Any]:
        """What the verdict rests on, as in summary.json; empty without one."""
        return self.summary.get("verdict_evidence") or {}

    def holding(self, slip: float | str | None = None) -> Holding | None:
        """What the knot bore before a free end was drawn in by so much, in the last step that loads it with ends free.

        Args:
            slip: [mm] or such as "3 mm"; None for the step's `slip`, or one diameter of the thinnest rod.

        Returns:
            None where no such step was taken.

        Raises:
            InputError: the run does not tell how far ends were drawn in.
        """
        return holding_of(self, slip)

    @property
    def failure_mode(self) -> str | None:
        """What slips first in a knot that fails, "wrapping" or "central"; "none" where nothing fails or is known."""
        return self.summary.get("failure_mode")


@dataclass(frozen=True)
class Spent:
    """Time that a phase took [s]."""

    wall_s: float
    cpu_s: float


@dataclass(frozen=True)
class Cost:
    """What a run took.

    Attributes:
        phases: by name.
        effects: CPU seconds of each term by name.
        steps: accepted.
        newton_iterations: of all of them.
        peak_memory_mb: of the process.
    """

    phases: dict[str, Spent]
    effects: dict[str, float]
    steps: int
    newton_iterations: int
    peak_memory_mb: float

    @property
    def wall_s(self) -> float:
        """Wall time of all phases [s]."""
        return sum((phase.wall_s for phase in self.phases.values()), 0.0)

    @property
    def cpu_s(self) -> float:
        """CPU seconds of all phases."""
        return sum((phase.cpu_s for phase in self.phases.values()), 0.0)

    def plot(self, axes: Axes | None = None) -> Axes:
        """CPU seconds of the terms, the dearest first."""
        from knotfem.plot.axes import axes_for

        with axes_for(axes) as drawn:
            names = sorted(self.effects, key=lambda name: self.effects[name])
            drawn.barh(names, [self.effects[name] for name in names])
            drawn.set_xlabel("CPU time [s]")
        return drawn


@dataclass(frozen=True, eq=False)
class EnergyCurve:
    """Energy balance [N mm] at each loading step.

    Attributes:
        table: columns of force.csv.
    """

    table: Arrays

    @property
    def names(self) -> list[str]:
        """Names of the parts: work, elastic, friction, ...; missing is the error of the balance."""
        return [name.removesuffix("_Nmm") for name in self.table if name.endswith("_Nmm")]

    def __getitem__(self, name: str) -> np.ndarray:
        """A part [N mm], shape [steps]."""
        try:
            return self.table[f"{name}_Nmm"]
        except KeyError:
            raise InputError("no such energy", found=name, expected=", ".join(self.names)) from None

    def plot(self, axes: Axes | None = None) -> Axes:
        """All parts against time."""
        from knotfem.plot.axes import axes_for

        with axes_for(axes) as drawn:
            for name in self.names:
                if np.abs(self[name]).max(initial=0.0) > 0.0:
                    drawn.plot(self.table["time_s"], self[name], label=name)
            drawn.set_xlabel("time [s]")
            drawn.set_ylabel("energy [N mm]")
            drawn.legend()
        return drawn
