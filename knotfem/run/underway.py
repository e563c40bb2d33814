"""A step of the scene that has begun, and what a checkpoint keeps of states and steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from knotfem.run.jumps import JumpWatch
from knotfem.scene.steps import Step
from knotfem.solver.state import State
from knotfem.solver.stepping.continuation import Continuation
from knotfem.solver.stepping.pace import Pace


@dataclass(frozen=True, eq=False)
class Underway:
    """A step of the scene that has begun.

    Attributes:
        step: of the scene.
        origin: what must be known of the state that it set out from.
        before: force on each loaded end at that time [N], by label, shape [3] each.
        now: how far it has come.
        watch: sees jumps.
        keys: pairs of nodes that its equations couple, as `knotfem.sparse.pattern.stencil_keys` numbers them,
            shape [pairs]; None before the first solve.
    """

    step: Step
    origin: State
    before: dict[str, np.ndarray]
    now: Continuation
    watch: JumpWatch
    keys: np.ndarray | None = None


def stored_step(u: Underway) -> dict[str, Any]:
    """What a checkpoint keeps of a step that has begun, as `knotfem.run.checkpoint.Checkpoint.state` may hold it.

    Its place in the scene and how far it has come are kept elsewhere: `step` by its number, `now` by `stored`.
    """
    return {"origin": stored_state(u.origin), "before": u.before, "watch": u.watch.state(), "keys": u.keys}


def stored_state(state: State) -> dict[str, Any]:
    """Fields of a state by their names, in its units; its history as dictionaries of arrays."""
    history = {label: dict(arrays) for label, arrays in state.history.items()}
    return {"x": state.x, "v": state.v, "a": state.a, "time": state.time, "history": history}


def restored_state(values: dict[str, Any]) -> State:
    """The state of which `stored_state` made these values.

    Raises:
        TypeError: they have other names than the fields of a state.
    """
    return State(**values)


def stored(now: Continuation) -> dict[str, Any]:
    """Fields of a continuation by their names, in its units; its state and its pace as dictionaries."""
    pace = None if now.pace is None else dict(vars(now.pace))
    return {**vars(now), "state": stored_state(now.state), "pace": pace}


def restored(values: dict[str, Any]) -> Continuation:
    """The continuation of which `stored` made these values.

    Raises:
        KeyError: they have no state or no pace.
        TypeError: they have other names than the fields of a continuation, a state or a pace.
    """
    pace = values["pace"]
    state = restored_state(values["state"])
    return Continuation(**{**values, "state": state, "pace": None if pace is None else Pace(**pace)})
