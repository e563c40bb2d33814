"""Costs count by part, once, also over sessions."""

from types import SimpleNamespace
from typing import Any

import pytest

from knotfem.energy.energies import Energies
from knotfem.run.summary import Summary
from knotfem.solver.clock import Clock
from knotfem.solver.term import Role


class Names:
    """Of a system's terms, with clocks that are set by hand."""

    def __init__(self) -> None:
        roles = {"elasticity": Role.ELASTIC, "contact": Role.CONTACT, "friction": Role.FRICTION}
        self.terms = [SimpleNamespace(name=name, role=role) for name, role in roles.items()]
        self.clock, self.analyses, self.factorisations = Clock(), 0, 0

    def spend(self, seconds: float, *names: str) -> None:
        for name in names:
            self.clock.cpu[name] = self.clock.cpu.get(name, 0.0) + seconds
            self.clock.wall[name] = self.clock.wall.get(name, 0.0) + 2.0 * seconds
        self.factorisations += 1


@pytest.fixture
def summary() -> Summary:
    scene = SimpleNamespace(tying_steps=())
    model: Any = SimpleNamespace(
        scene=scene, diameter=6.0, absent={}, curves={}, dofs=30, hexes=4, segments=0, slices={}
    )
    return Summary(model)


def test_parts(summary):
    system: Any = Names()
    summary.begin()
    system.spend(1.0, "elasticity", "contact", "friction", "pattern", "constrain", "analysis", "factorisation", "solve")
    summary.add_system(system)
    cpu = {name: entry["cpu_s"] for name, entry in summary.figures["costs"].items()}
    assert cpu == {"assembly": 3.0, "contact": 2.0, "factorisation": 2.0, "solve": 1.0, "output": 0.0}
    assert summary.figures["costs"]["contact"]["wall_s"] == 4.0
    assert summary.figures["effects"]["contact"]["cpu_s"] == 1.0
    assert summary.figures["factorisations"] == 1


def test_adding_twice_adds_what_came_in_between(summary):
    system: Any = Names()
    summary.begin()
    for _ in range(3):
        system.spend(1.0, "contact")
        summary.add_system(system)
        summary.add_time("pull")
    assert summary.figures["costs"]["contact"]["cpu_s"] == 3.0
    assert summary.figures["factorisations"] == 3
    other: Any = Names()
    other.spend(1.0, "contact")
    summary.add_system(other)
    summary.add_time("hold")
    assert summary.figures["costs"]["contact"]["cpu_s"] == 4.0
    assert set(summary.figures["phases"]) == {"pull", "hold"}


def test_what_a_checkpoint_knows_is_not_lost(summary):
    system: Any = Names()
    summary.begin()
    system.spend(1.0, "solve")
    summary.add_system(system)
    summary.add_time("pull")
    spent = summary.figures["phases"]["pull"]["wall_s"]
    later = Summary(summary.model)
    later.restore(summary.state())
    later.begin()
    again: Any = Names()
    again.spend(0.5, "solve")
    later.add_system(again)
    later.add_time("pull")
    assert later.figures["costs"]["solve"]["cpu_s"] == 1.5
    assert later.figures["phases"]["pull"]["wall_s"] > spent


def test_memory_of_an_earlier_session_is_remembered(summary, monkeypatch):
    monkeypatch.setattr("knotfem.run.summary.peak_memory_mb", lambda: 2.0)
    state = summary.state()
    monkeypatch.setattr("knotfem.run.summary.peak_memory_mb", lambda: 1.0)
    later = Summary(summary.model)
    later.restore(state)
    assert later.finished(Energies())["peak_memory_mb"] == 2.0


def test_no_time_counts_before_the_beginning(summary):
    summary.add_time("pull")
    summary.add_system(None)
    assert summary.figures["phases"] == {}


def test_output_counts_also_where_it_fails(summary):
    with pytest.raises(OSError, match="full"), summary.output():
        raise OSError("full")
    assert summary.figures["costs"]["output"]["wall_s"] > 0.0
