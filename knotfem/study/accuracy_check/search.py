"""Refines the choices of a scene until its estimated error is within a target, or the budget ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from knotfem.scene.model import Scene
from knotfem.study.accuracy_check.choices import Sizes, choices_of, finer_size, level_at, setting_of
from knotfem.study.accuracy_check.estimate import Change, estimated_error, to_adopt
from knotfem.study.convergence import require_base
from knotfem.study.extrapolation import rms
from knotfem.study.jobs import Jobs
from knotfem.study.measured import Measured, measure
from knotfem.study.quantities import main_quantity, scale_of
from knotfem.study.refinement import Level, base_level

ROUNDS = 6
"""How often settings are refined at most; each time the size of a choice falls at least to a half."""


@dataclass(frozen=True, eq=False)
class Found:
    """What a search came to.

    Attributes:
        level: run with the settings that were found.
        sizes: of their choices.
        quantity: that runs were compared by.
        scale: of this quantity in that run, which relative errors are multiples of.
        changes: of each choice at these settings.
        ended: why the search ended before the target; "" where the target is reached.
        cpu_s: of all runs that are done.
    """

    level: Level
    sizes: Sizes
    quantity: str
    scale: float
    changes: tuple[Change, ...]
    ended: str
    cpu_s: float

    @property
    def estimate(self) -> float | None:
        """Relative error; None where a choice was not measured."""
        return estimated_error(self.changes)


class Search:
    """Measures the error of settings and refines them.

    A round runs the next finer setting of each choice, one at a time. Where the estimate exceeds the target, the finer
    settings that are expected to bring it within are adopted, and the adopted choices are measured again. The change of
    a choice that was not adopted keeps what was measured before, since errors of separate choices add up to first
    order.

    Args:
        jobs: of the scene.
        target: largest relative error.
        tell: told what was found after each round.
    """

    def __init__(self, jobs: Jobs, target: float, tell: Callable[[str], None]) -> None:
        self.jobs, self.target, self.tell = jobs, target, tell
        self.scene: Scene = jobs.scene_of(base_level())
        self._sizes: dict[str, float] = {}
        self._known: dict[str, Change] = {}
        self._read: dict[str, Measured] = {}

    def run(self) -> Found:
        """Go on until within the target, or until the budget or what can be refined ends.

        Raises:
            KnotfemError: the scene itself did not run to its end, or a stop was asked for.
        """
        self.jobs.run([base_level()])
        require_base(self.jobs)
        for turn in range(ROUNDS):
            self._measure()
            if self._within:
                return self._found("")
            why = self._stuck() or self._adopt(turn + 1)
            if why:
                return self._found(why)
        self._measure()
        return self._found("" if self._within else f"{ROUNDS} rounds of finer settings were not enough")

    @property
    def _changes(self) -> list[Change]:
        return [self._known[name] for name in choices_of(self.scene)]

    @property
    def _base(self) -> Level:
        return level_at(self.scene, self._sizes)

    @property
    def _within(self) -> bool:
        estimate = estimated_error(self._changes)
        return estimate is not None and estimate <= self.target and not any(one.missing for one in self._changes)

    def _measure(self) -> None:
        """Run what is finer than the present settings in each choice that was not measured at them."""
        trials: dict[str, Level] = {}
        for name in choices_of(self.scene):
            before = self._known.get(name)
            if before is not None and not before.missing and not before.expected:
                continue
            size = finer_size(self.scene, name, self._sizes)
            if size is None:
                self._note(name, missing="there is no finer setting")
            else:
                finer = level_at(self.scene, {**self._sizes, name: size})
                trials[name] = replace(finer, setting=f"{name} {setting_of(self.scene, name, size)}")
        self.jobs.run(list(trials.values()))
        for name, level in trials.items():
            outcome = self.jobs.outcomes[level.name]
            if outcome.state == "done":
                self._compare(name, self._results(level))
            else:
                self._note(name, missing=f"{outcome.state}: {outcome.reason}")

    def _note(self, name: str, *, missing: str) -> None:
        """Keep that a choice was not measured at its present setting; what first order expects of it stays."""
        before = self._known.get(name) or self._change(name)
        self._known[name] = replace(before, missing=missing)

    def _compare(self, name: str, finer: Measured) -> None:
        base = self._results(self._base)
        quantity = main_quantity(list(base.quantities))
        value = finer.quantities[quantity]
        cpu = finer.cpu["total"]
        self._known[name] = replace(
            self._change(name),
            change=rms(value - base.quantities[quantity]) / scale_of(quantity, value),
            cpu_s=cpu,
            cost=cpu / base.cpu["total"],
        )

    def _change(self, name: str) -> Change:
        """A choice at its present size, not measured."""
        now, finer = self._sizes.get(name, 1.0), finer_size(self.scene, name, self._sizes)
        after = "none" if finer is None else setting_of(self.scene, name, finer)
        factor = 0.5 if finer is None else finer / now
        return Change(name, setting_of(self.scene, name, now), after, factor)

    def _stuck(self) -> str:
        """Why nothing more can be found out; "" where it can."""
        missing = [f"{one.choice} ({one.missing})" for one in self._changes if one.missing]
        return f"not checked: {'; '.join(missing)}" if missing else ""

    def _adopt(self, turn: int) -> str:
        """Take finer settings; returns why they could not be taken, "" where they are."""
        adopted = to_adopt(self._changes, self.target)
        names = ", ".join(f"{one.choice} {one.after}" for one in adopted)
        self.tell(f"round {turn}: {self._says()}; next with {names}")
        sizes = {**self._sizes, **{one.choice: self._finer(one.choice) for one in adopted}}
        level = level_at(self.scene, sizes)
        self.jobs.run([level])
        outcome = self.jobs.outcomes[level.name]
        if outcome.state != "done":
            return f"the run with {names}: {outcome.state}, {outcome.reason}"
        self._sizes = sizes
        for one in adopted:
            after = self._change(one.choice)
            left = one.factor * one.error
            self._known[one.choice] = replace(after, change=left * (1.0 - after.factor), cost=one.cost, expected=True)
        return ""

    def _finer(self, name: str) -> float:
        size = finer_size(self.scene, name, self._sizes)
        assert size is not None, "what was measured has a finer setting"
        return size

    def _says(self) -> str:
        parts = sorted(self._changes, key=lambda one: one.error, reverse=True)
        return f"error {sum(one.error for one in parts):.2%}, most of it {parts[0].choice} ({parts[0].error:.2%})"

    def _results(self, level: Level) -> Measured:
        if level.name not in self._read:
            self._read[level.name] = measure(self.jobs, level)
        return self._read[level.name]

    def _found(self, ended: str) -> Found:
        base = self._results(self._base)
        quantity = main_quantity(list(base.quantities))
        done = [name for name, outcome in self.jobs.outcomes.items() if outcome.state == "done"]
        return Found(
            self._base,
            dict(self._sizes),
            quantity,
            scale_of(quantity, base.quantities[quantity]),
            tuple(self._changes),
            ended,
            math.fsum(self._read[name].cpu["total"] for name in done),
        )
