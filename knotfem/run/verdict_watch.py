"""Watches over a run until it is decided whether the knot holds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from knotfem.energy.balance import StepFigures
from knotfem.models.base import SIDES, Model
from knotfem.models.conditions import friction_factor
from knotfem.run.jumps import furthest
from knotfem.run.knot_words import Knots
from knotfem.run.monitor import KnotMonitor
from knotfem.run.verdict_evidence import FROM_ONSET, FROM_STEP, Progression, label_of, unit_evidence
from knotfem.scene.steps import Driven, Pull, Step
from knotfem.stability import ties
from knotfem.stability.drawn_in import DrawnIn
from knotfem.stability.ends import Place, deciding_steps, free_ends, loaded_ends
from knotfem.stability.holding import Holding, LoadingStep, slip_of
from knotfem.stability.slip import SlipMeter, UnitSlip
from knotfem.stability.unit import Line
from knotfem.stability.verdict import RATE_OVER_DIAMETER, Signs, Verdict, in_words, verdict_of

ONSET_OVER_DIAMETER = 0.5
"""Which strands slip first is read off once one of them has slipped by so much."""
NEAR_OVER_DIAMETER = 3.0
"""A strand can pass over an end only from nearer than this; knots are named then."""
NAMED_OVER_DIAMETER = 0.5
"""Rods near an end move by so much between two namings of their knots."""
FAR_OVER_DIAMETER = 5.0
"""Rods move by at most so much without being named."""


class VerdictWatch:
    """Gathers what tells whether a knot holds.

    Args:
        model: of the scene.
        monitor: its knots, and how their ends are continued.
        knots: that the steps set out from.

    Attributes:
        lost: what has come undone, in words; "" while the knot is what it was.
        holding: what it has borne in the last step that pulls or loads it while ends are free; None before one.
        slipped: whether a free end has been drawn in as far as the present step allows.
    """

    def __init__(self, model: Model, monitor: KnotMonitor, knots: Knots) -> None:
        self.model, self.knots, self.lost = model, knots, ""
        self.holding: Holding | None = None
        self.slipped = False
        self._monitor = monitor
        scene, fixed = model.scene, list(zip(monitor.ends, monitor.outward, strict=True))
        self._reader = ties.TieReader([rod.name for rod in model.rods], fixed, scene.obstacles)
        self._arclengths = [
            target.slices.fractions * rod.length for rod, target in zip(model.rods, model.targets, strict=True)
        ]
        deciding = deciding_steps(scene.steps)[0]
        self._loaded, self._free = loaded_ends(deciding), free_ends(deciding)
        self._places = [*self._loaded, *self._free]
        self._meter = SlipMeter(len(model.rods), model.diameter)
        self._drawn = DrawnIn(len(model.rods), model.diameter)
        self._before: list[ties.RodTies] = []
        self._named: np.ndarray | None = None
        self._touched, self._marked_under_load = False, False
        self._onset: UnitSlip | None = None
        self._onset_at: dict[str, Any] = {}
        self._lost_at: dict[str, Any] = {}
        self._first: Progression | None = None
        self._step: Progression | None = None

    def begin(self, step: Step, x: np.ndarray, time: float) -> None:
        """A step of the scene begins.

        Args:
            step: of the scene.
            x: unknowns, shape [nodes, width].
            time: [s].
        """
        lines = self._lines(x)
        ends = {label_of(place): self._end(x, place) for place in self._places}
        through, drawn_in, deciding = self._meter.through.copy(), self._drawn.lengths.copy(), bool(free_ends(step))
        self._step = Progression(step.name, time, ends, through, drawn_in, deciding)
        if deciding and isinstance(step, LoadingStep):
            self.holding = Holding(slip_of(step, self.model.diameter))
        if loaded_ends(step) and self._first is None:
            self._first = self._step
            self._before, self._named = self._reader.read(self.model.centrelines(x)), x
            self._follow(lines)
        self._meter.begin_step(lines)
        self.slipped = False
        self._onset, self._onset_at = None, {}

    @property
    def drawn_in(self) -> float:
        """Length of the free end that has been drawn in furthest since the scene's step began [mm]."""
        if self._step is None or not self._free:
            return 0.0
        since = self._drawn.lengths - self._step.drawn_in
        return max(float(since[self._at(place)]) for place in self._free)

    def update(
        self,
        step: Step,
        x: np.ndarray,
        figures: StepFigures,
        time: float,
        *,
        settled: bool,
        at_rest: bool,
        output: bool,
    ) -> str:
        """Take an accepted state, the terms being assembled in it.

        Args:
            step: of the scene.
            x: unknowns, shape [nodes, width].
            figures: of the time step.
            time: [s].
            settled: whether it is one of equilibrium.
            at_rest: whether it ends the step in equilibrium.
            output: whether outputs are due.

        Returns:
            What has come undone with this state, in words; "" for nothing.
        """
        if self._first is None or self._step is None:
            return ""
        lines = self._lines(x)
        self._follow(lines)
        now = self._step
        if self.holding is not None and now.deciding and isinstance(step, LoadingStep):
            self.holding.update(figures.displacement, figures.force, self.drawn_in, settled=settled)
            self.slipped = self.holding.slipped and step.slip is not None
        now.at_rest = at_rest and bool(loaded_ends(step)) and not isinstance(step, Pull)
        if isinstance(step, Pull):
            self._follow_pull(now, step, x)
        found = "" if self.lost else self._undone(x, output)
        if found:
            self.lost = found
            self._lost_at = self._when(step, time)
        self._see_onset(step, time)
        if settled and not self.lost:
            self._meter.mark(lines)
            self._onset, self._onset_at, self._marked_under_load = None, {}, bool(loaded_ends(step))
        self._touched |= bool(self._meter.crossings)
        return found

    def note_lost(self, message: str, step: Step, time: float) -> None:
        """The run ends because a knot that must hold has come undone."""
        if not self.lost:
            self.lost, self._lost_at = message, self._when(step, time)

    def figures(self, x: np.ndarray) -> dict[str, Any]:
        """For the summary."""
        signs = self._signs()
        decided = self.lost or (self._step is not None and self._step.deciding)
        verdict: Verdict = verdict_of(signs) if decided else "undecided"
        slip = self._onset or self._meter.since_step.unit_slip
        mode = slip.mode if verdict in ("slips", "unravels") and slip is not None else "none"
        evidence = {
            "in_words": in_words(verdict, signs, mode),
            "at_rest": signs.at_rest,
            "lost": {"what": self.lost, **self._lost_at} if self.lost else None,
            "travel_in_last_step": self._travel(self._step, x),
            "travel_since_loaded": self._travel(self._first, x),
            "fraction_of_last_displacement": None if math.isnan(signs.rate) else signs.rate,
            "rod_diameter_mm": self.model.diameter,
            "locking_unit": None if slip is None else unit_evidence(slip, self.model.rods),
            "slips_measured": None if slip is None else FROM_ONSET if self._onset else FROM_STEP,
            "onset": self._onset_at or None,
        }
        borne = None if self.holding is None else self.holding.figures()
        return {"verdict": verdict, "verdict_evidence": evidence, "failure_mode": mode, "holding": borne}

    def _travel(self, since: Progression | None, x: np.ndarray) -> dict[str, Any] | None:
        if since is None:
            return None
        moved = {
            place: float(np.linalg.norm(self._end(x, place) - since.ends[label_of(place)])) for place in self._places
        }
        through, drawn_in = self._meter.through - since.through, self._drawn.lengths - since.drawn_in
        return {
            "since_start_of": since.name,
            "loaded_ends_mm": {label_of(place): moved[place] for place in self._loaded},
            "free_ends_mm": {label_of(place): moved[place] for place in self._free},
            "through_knot_mm": {rod.name: float(ran) for rod, ran in zip(self.model.rods, through, strict=True)},
            "drawn_in_mm": {label_of(place): float(drawn_in[self._at(place)]) for place in self._free},
        }

    def _signs(self) -> Signs:
        step = self._step
        if step is None:
            return Signs(self.lost, False, 0.0, math.nan, self.model.diameter)
        through = float(np.abs(self._meter.through - step.through).max())
        rate = step.rate(RATE_OVER_DIAMETER * self.model.diameter)
        drawn_in = self.drawn_in if self.slipped else math.nan
        return Signs(self.lost, step.at_rest, through, rate, self.model.diameter, drawn_in)

    def _follow_pull(self, now: Progression, step: Pull, x: np.ndarray) -> None:
        place = step.having(Driven)[0]
        if (start := now.ends.get(label_of(place))) is not None:
            ran = float(self._meter.through[self._rod(place)])
            now.pull(float(np.linalg.norm(self._end(x, place) - start)), ran, RATE_OVER_DIAMETER * self.model.diameter)

    def _when(self, step: Step, time: float) -> dict[str, Any]:
        """The step, the time [s] and the coefficient of friction between rods then."""
        scene, began = self.model.scene, 0.0 if self._step is None else self._step.began
        factor = friction_factor(scene, step, began)
        return {
            "step": step.name,
            "time_s": time,
            "friction": scene.contact.friction * (factor(time) if factor else 1.0),
        }

    def _see_onset(self, step: Step, time: float) -> None:
        if self._onset is None and self._marked_under_load:
            slip = self._meter.since_mark.unit_slip
            if slip is not None and slip.largest >= ONSET_OVER_DIAMETER * self.model.diameter:
                self._onset, self._onset_at = slip, self._when(step, time)

    def _follow(self, lines: list[Line]) -> None:
        self._meter.update(self.model.contacts())
        self._drawn.update(self._meter.crossings, lines)

    def _lines(self, x: np.ndarray) -> list[Line]:
        return [Line(points, s) for points, s in zip(self.model.centrelines(x), self._arclengths, strict=True)]

    def _undone(self, x: np.ndarray, output: bool) -> str:
        if self._came_off():
            return "the rods have come off all that they touched"
        d = self.model.diameter
        moved = math.inf if self._named is None else furthest(self.model, self._named, x)[2]
        due = moved > FAR_OVER_DIAMETER * d or (moved > NAMED_OVER_DIAMETER * d and self._near_an_end(x))
        if not (due or output):
            return ""
        self._named = x
        found = self._reader.undone(self._before, self.model.centrelines(x))
        if not found and len(self.model.rods) > 1:
            found = self._monitor.lost(self.knots, x)
        return found

    def _came_off(self) -> bool:
        """Whether rods that topology does not hold have lost all contact."""
        if not self._touched or self._meter.crossings or len(self.model.rods) > 1:
            return False
        return all(rod.trivial for rod in self._before)

    def _near_an_end(self, x: np.ndarray) -> bool:
        near, lines = NEAR_OVER_DIAMETER * self.model.diameter, self.model.centrelines(x)
        for name, side in self._free:
            own, end = self._rod((name, side)), self._end(x, (name, side))
            for rod, (line, s) in enumerate(zip(lines, self._arclengths, strict=True)):
                from_end = s if side == "start" else s[-1] - s
                others = line if rod != own else line[from_end > 1.5 * near]
                if others.size and KDTree(others).query(end)[0] < near:
                    return True
        return False

    def _rod(self, place: Place) -> int:
        return [rod.name for rod in self.model.rods].index(place[0])

    def _at(self, place: Place) -> tuple[int, int]:
        """Of an end in arrays of shape [rods, 2]."""
        return self._rod(place), SIDES.index(place[1])

    def _end(self, x: np.ndarray, place: Place) -> np.ndarray:
        return x[self.model.end_nodes(self._rod(place), place[1]).outer, :3].copy()

    def state(self) -> dict[str, Any]:
        """For a checkpoint."""
        onset = self._onset
        return {
            "lost": self.lost,
            "lost_at": self._lost_at,
            "meter": self._meter.state(),
            "drawn": self._drawn.state(),
            "before": ties.stored(self._before),
            "named": self._named,
            "touched": self._touched,
            "marked_under_load": self._marked_under_load,
            "onset": None if onset is None else onset.state(),
            "onset_at": self._onset_at,
            "first": None if self._first is None else dict(vars(self._first)),
            "step": None if self._step is None else dict(vars(self._step)),
            "holding": None if self.holding is None else dict(vars(self.holding)),
            "slipped": self.slipped,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """From a checkpoint."""
        self.lost, self._lost_at = state["lost"], state["lost_at"]
        self._meter.restore(state["meter"])
        self._drawn.restore(state["drawn"])
        self._before, self._named = ties.restored(state["before"]), state["named"]
        self._touched, self._marked_under_load = state["touched"], state["marked_under_load"]
        self._onset = state["onset"] and UnitSlip.restored(state["onset"])
        self._onset_at = state["onset_at"]
        self._first = state["first"] and Progression(**state["first"])
        self._step = state["step"] and Progression(**state["step"])
        self.holding = state["holding"] and Holding(**state["holding"])
        self.slipped = state["slipped"]
