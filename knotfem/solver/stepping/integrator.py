"""Marching in time: prediction, step control, undoing of failed steps.

The march knows nothing of files or progress: it yields accepted steps, and whoever iterates it saves and draws.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from knotfem.errors import KnotfemError, NotConverged
from knotfem.solver.nonlinear import newton
from knotfem.solver.nonlinear.newton import Iterations, NewtonSettings, StepFailed
from knotfem.solver.system import System
from knotfem.solver.term import Motion, StepStart, longest_move

MOST_MOVE = 1.5
"""A step that moves a node further than this many times what is aimed at is taken again, shorter: the work of forces on
so long a path is all but unknown, and a strand whipped across a thin one would come out on its far side."""


@dataclass(frozen=True)
class StepControl:
    """Limits of the time step; lengths in mm, times in s.

    Attributes:
        first: first time step.
        smallest: a step that fails below it ends the march.
        largest: longest time step.
        move: largest move of a node in a step that is aimed at.
        few: up to so many iterations the step grows by `grow`.
        many: from so many on it shrinks by `shrink`.
        cut: factor after a failure.
    """

    first: float
    smallest: float
    largest: float
    move: float
    few: int = 5
    many: int = 10
    grow: float = 1.4
    shrink: float = 0.7
    cut: float = 0.4


@dataclass
class Progress:
    """All that the march needs to go on, besides what the effects remember.

    Attributes:
        motion: accepted state.
        increment: last accepted move [mm], shape [nodes, 3].
        increment_dt: time step of that move, 0 where there is none.
        dt: next time step.
        shift: Levenberg-Marquardt shift to begin with.
        steps, cutbacks, iterations: counts so far.
    """

    motion: Motion
    increment: np.ndarray
    increment_dt: float = 0.0
    dt: float = 0.0
    shift: float = 0.0
    steps: int = 0
    cutbacks: int = 0
    iterations: int = 0

    @classmethod
    def at(cls, motion: Motion) -> Progress:
        return cls(motion, np.zeros_like(motion.x))


@dataclass(frozen=True)
class Accepted:
    """An accepted step.

    Attributes:
        start: the state it set out from, and its length.
        motion: the state it ended at.
        took: what the Newton solve took.
        failed: attempts that failed before.
        wall: seconds, failures included.
        arrived: whether it ended exactly at one of the stops.
    """

    start: StepStart
    motion: Motion
    took: Iterations
    failed: int
    wall: float
    arrived: bool


@dataclass
class March:
    """Steps of one phase.

    Args:
        system: effects and constraints of the phase.
        progress: where to set out; updated in place with each accepted step.
        control: step limits.
        settings: of Newton's method.
        sections: cross-section of each node, see `newton.out_of_balance`.
        stops: times [s], ascending, that are met exactly; the last ends the march.
        interrupt: called before each Newton iteration; what it raises ends the march as if the step had not begun.
    """

    system: System
    progress: Progress
    control: StepControl
    settings: NewtonSettings
    sections: np.ndarray
    stops: np.ndarray
    interrupt: Callable[[], None] | None = None
    last_failure: str = field(default="", init=False)

    def __iter__(self) -> Iterator[Accepted]:
        p = self.progress
        if p.dt <= 0.0:
            p.dt = self.control.first
        end = float(self.stops[-1])
        while p.motion.time < end - 1e-12 * max(1.0, abs(end)):
            yield self.step()

    def step(self) -> Accepted:
        """Take one step, shorter and shorter until it succeeds."""
        p, c = self.progress, self.control
        began = time.perf_counter()
        history, before = self.system.history(), replace(p)
        failed = 0
        while True:
            dt, arrived = self._length(p.dt)
            start = StepStart(p.motion, dt)
            try:
                x, took = self._attempt(start)
                motion = self.system.commit(x, start)
                break
            except (StepFailed, ZeroDivisionError) as failure:
                degenerate = isinstance(failure, ZeroDivisionError)
                self.last_failure = "strands or nodes lie on each other" if degenerate else str(failure)
                self.system.load(history)
                failed += 1
                p.cutbacks += 1
                p.shift = max(p.shift, self.settings.shift_start)
                p.increment_dt = 0.0 if failed > 2 else p.increment_dt
                if dt <= c.smallest:
                    raise NotConverged(
                        f"no balance at time {p.motion.time:.6g} s with the smallest step {dt:.3g} s: "
                        f"{self.last_failure}"
                    ) from failure
                p.dt = c.cut * dt
            except KnotfemError:
                self.system.restore(history)
                vars(p).update(vars(before))
                raise
        p.increment, p.increment_dt = x - p.motion.x, dt
        p.motion, p.shift = motion, took.shift
        p.steps += 1
        p.iterations += took.count
        p.dt = self._next(dt, took.count, longest_move(p.increment), failed)
        return Accepted(start, motion, took, failed, time.perf_counter() - began, arrived)

    def _attempt(self, start: StepStart) -> tuple[np.ndarray, Iterations]:
        p = self.progress
        self.system.update(p.motion.x)
        self.system.begin(start)
        x = p.motion.x
        if p.increment_dt > 0.0:
            move = p.increment * (start.dt / p.increment_dt)
            x = x + self.system.allowed_fraction(x, move) * move
        x, took = newton.solve(self.system, x, start, self.settings, self.sections, p.shift, self.interrupt)
        moved = longest_move(x - p.motion.x)
        if moved > MOST_MOVE * self.control.move and start.dt > self.control.smallest:
            raise StepFailed(f"a node moved by {moved:.3g} mm in one step")
        return x, took

    def _length(self, dt: float) -> tuple[float, bool]:
        now = self.progress.motion.time
        ahead = self.stops[self.stops > now + 1e-12 * max(1.0, abs(now))]
        left = float(ahead[0]) - now
        if dt >= left * (1.0 - 1e-9):
            return left, True
        return (0.5 * left, False) if dt > 0.6 * left else (dt, False)

    def _next(self, dt: float, iterations: int, moved: float, failed: int) -> float:
        c, wanted = self.control, self.progress.dt
        if failed:
            factor = 1.0
        elif iterations <= c.few:
            factor = c.grow
        elif iterations >= c.many:
            factor = c.shrink
        else:
            factor = 1.0
        base = dt if failed or dt > 0.5 * wanted else wanted
        if moved > 0.0:
            factor = min(factor, c.move / moved * dt / base)
        return min(max(factor * base, c.smallest), c.largest)
