"""What became of a run of a study, and what its folder already says of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from knotfem.errors import InputError, KnotfemError, KnotLost, NotConverged
from knotfem.results.data import open_run
from knotfem.run.directory import RunDirectory
from knotfem.scene.model import Scene

State = Literal["done", "failed", "stopped", "left out"]
FAILURES = {kind.exit_code: kind for kind in (InputError, NotConverged, KnotLost)}
"""Failures that are results, by exit code; any other end is a crash, and the run is tried again."""
CRASHED = 1
"""Exit code of a run that ended with an error of the program, or whose workers died."""


@dataclass(frozen=True)
class Outcome:
    """What became of a run.

    Attributes:
        state: "done"; "failed", which is a result; "stopped" with a checkpoint; "left out" of the study.
        reason: why it is not done.
        exit_code: of a failed one.
    """

    state: State
    reason: str = ""
    exit_code: int = 0

    @property
    def final(self) -> bool:
        """Whether it stays as it is when the study goes on: done, or failed otherwise than by a crash."""
        return self.state == "done" or (self.state == "failed" and self.exit_code in FAILURES)


def known_outcome(run: RunDirectory, scene: Scene) -> Outcome | None:
    """Final outcome that a run directory holds, or None where the run is still to be brought to its end.

    Args:
        run: there or not.
        scene: that the run must be of.

    Raises:
        InputError: it is a run of another scene.
    """
    if not RunDirectory.is_run(run.path):
        return None
    if physics(run.scene) != physics(scene):
        raise InputError("the folder holds a run of another scene", file=run.path, expected="another folder (-o)")
    status = run.status
    state = status.get("state")
    if state not in ("done", "failed"):
        return None
    code = int(status.get("exit_code", NotConverged.exit_code)) if state == "failed" else 0
    outcome = Outcome(state, str(status.get("reason", "")), code)
    return outcome if outcome.final else None


def physics(scene: Scene) -> Scene:
    """A scene without what leaves its results as they are."""
    solver = scene.solver.model_copy(update={"threads": 0, "time_limit": None})
    output = scene.output.model_copy(update={"checkpoint_every": 60.0})
    return scene.model_copy(update={"solver": solver, "output": output})


def spent(run: RunDirectory) -> float:
    """Wall seconds that a run took so far."""
    try:
        return open_run(run.path).cost.wall_s
    except KnotfemError:
        return 0.0
