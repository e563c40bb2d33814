"""A scene in memory: its events, and checkpoints from which it goes on to the same bits, also amid a step."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, pairwise
from typing import Any

import numpy as np
import pytest

from knotfem.energy.balance import EnergyBalance
from knotfem.energy.energies import Energies
from knotfem.errors import Stopped
from knotfem.models.base import Increment
from knotfem.run.checkpoint import CheckpointStore
from knotfem.run.events import Event, PhaseDone, TimeStepDone
from knotfem.run.simulation import Simulation
from knotfem.scene import Scene, load_scene
from knotfem.types import Arrays

COARSE = (
    "rods.0.length=400 mm", "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=8 mm",
    "contact.sample_spacing_over_diameter=0.5", "output.fields=false", "tie.path=direct", "solver.threads=1",
    "steps.1.displacement=2 mm", "solver.move_over_diameter=0.02",
)  # fmt: skip
MODELS = ("fem", "rod")
AMID = 4
"""Accepted steps of the pull before the interruption."""

Trace = list[tuple[str, np.ndarray, np.ndarray, dict[str, Arrays], float, float, Energies]]


def scene_of(model: str, *overrides: str) -> Scene:
    return load_scene("overhand", [*COARSE, f"model={model}", *overrides])


def trace(events: Iterator[Event]) -> Trace:
    """All that an accepted step is."""
    return [
        (e.step.name, e.state.x, e.state.v, dict(e.state.history), e.accepted.dt, e.force, e.energies)
        for e in events
        if isinstance(e, TimeStepDone)
    ]


def same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and one.dtype == other.dtype and one.tobytes() == other.tobytes()
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


@pytest.fixture(scope="module", params=MODELS)
def whole(request) -> tuple[Scene, Trace, dict[str, dict[str, Any]]]:
    """A run to its end, with checkpoints on the way, taken while it goes on."""
    scene = scene_of(request.param)
    simulation, kept, seen = Simulation(scene), {}, []

    def events() -> Iterator[Event]:
        pulled = 0
        for event in simulation.run():
            yield event
            if isinstance(event, PhaseDone):
                kept[event.name] = simulation.checkpoint()
            elif isinstance(event, TimeStepDone) and event.step.name == "pull":
                pulled += 1
                if pulled == AMID:
                    kept["amid"] = simulation.checkpoint()

    seen = trace(events())
    assert sum(step[0] == "pull" for step in seen) > AMID + 2
    return scene, seen, kept


def test_events_come_in_order(whole):
    scene, _, _ = whole
    events = list(Simulation(scene, "tie").run())
    done = [event for event in events if isinstance(event, PhaseDone)]
    assert [(event.name, event.tied) for event in done] == [("mapping", False), ("relax", True)]
    assert isinstance(events[0], Increment)
    steps = [event for event in events if isinstance(event, TimeStepDone)]
    assert [event.last for event in steps] == [False] * (len(steps) - 1) + [True]
    assert steps[-1].output
    assert all(before.time <= after.time for before, after in pairwise(steps))
    assert steps[-1].time == 1.0


@pytest.mark.parametrize("place", ["mapping", "relax", "amid"])
@pytest.mark.parametrize("through_file", [False, True])
def test_goes_on_from_a_checkpoint_to_the_same_bits(whole, tmp_path, place: str, through_file: bool):
    """The run that wrote the checkpoint has gone on since: what it holds are values."""
    scene, steps, kept = whole
    state = kept[place]
    if through_file:
        store = CheckpointStore(tmp_path)
        store.save(state, {})
        latest = store.latest()
        assert latest is not None
        state = latest.state
    simulation = Simulation(scene)
    simulation.restore(state)
    rest = trace(simulation.run())
    assert rest
    assert same(rest, steps[-len(rest) :])
    left = {"mapping": len(steps), "relax": sum(step[0] == "pull" for step in steps)}
    assert len(rest) == left.get(place, left["relax"] - AMID)


@pytest.mark.parametrize("model", MODELS)
def test_interrupted_between_iterations_the_step_is_as_if_it_had_not_begun(model: str):
    scene = scene_of(model)
    whole = trace(Simulation(scene).run())
    asked = {"left": 0}

    def interrupt() -> None:
        asked["left"] -= 1
        if asked["left"] == 0:
            raise Stopped("asked to stop")

    simulation = Simulation(scene, interrupt=interrupt)
    events = simulation.run()
    pulled = (e for e in events if isinstance(e, TimeStepDone) and e.step.name == "pull")
    last = list(islice(pulled, AMID))[-1]
    asked["left"] = 2  # after the step, before its successor's first iteration
    with pytest.raises(Stopped):
        next(events)
    assert simulation.state is last.state
    later = Simulation(scene)
    later.restore(simulation.checkpoint())
    rest = trace(later.run())
    assert len(rest) < len(whole)
    assert same(rest, whole[-len(rest) :])


@pytest.mark.parametrize("model", MODELS)
def test_accepted_states_are_not_changed_by_what_follows(model: str):
    steps = [e for e in Simulation(scene_of(model)).run() if isinstance(e, TimeStepDone)]
    copies = [e.state.x.copy() for e in islice(Simulation(scene_of(model)).run(), 1000) if isinstance(e, TimeStepDone)]
    assert all(np.array_equal(event.state.x, x) for event, x in zip(steps, copies, strict=True))
    assert all(np.array_equal(after.accepted.start.x, before.state.x) for before, after in pairwise(steps))


def test_energy_balance_goes_on_from_its_state(whole):
    """Its state is a value; the energies that it had are those that it goes on with."""
    scene, steps, kept = whole
    model = Simulation(scene).model
    balance = EnergyBalance(model)
    balance.restore(kept["amid"]["balance"])
    amid = next(i for i, step in enumerate(steps) if step[0] == "pull") + AMID - 1
    assert balance.energies == steps[amid][-1]
    assert same(balance.state(), kept["amid"]["balance"])


def test_energy_balance_closes(whole):
    _, steps, _ = whole
    energies = steps[-1][-1]
    assert abs(energies.error) < 0.02 * energies.throughput
    assert energies.work == pytest.approx(
        energies.stored - energies.initial + energies.dissipated + energies.error, rel=1e-12
    )
