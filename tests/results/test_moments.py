"""Stored states of a run with several steps: which are there, which one is asked for, which one is taken."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import knotfem as kf
from knotfem.errors import InputError
from knotfem.results.moment import Moment, choose
from knotfem.run.tables import read_table, write_table
from knotfem_cli.main import knotfem_command

END = 'ends={rod={start={motion="driven",direction=[0,0,1]}}}'
STEPS = (
    f'steps=[{{kind="relax"}},{{kind="pull",displacement="2 mm",{END}}},{{kind="hold",name="wait",duration="1 s"}},'
    f'{{kind="pull",name="on",displacement="3 mm",{END}}}]'
)
QUICK = (
    "model=rod", "rods.0.length=400 mm", "rods.0.mesh.element_length=8 mm", "contact.enabled=false",
    "tie.increments=2", "output.every_displacement=1 mm", STEPS,
)  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> kf.Run:
    return kf.pull("overhand", QUICK, out=tmp_path_factory.mktemp("twice") / "run", progress=False)


def call(*arguments: object) -> Result:
    return CliRunner().invoke(knotfem_command, [str(argument) for argument in arguments])


def test_displacement_runs_on_through_the_steps(run: kf.Run) -> None:
    moments = [(m.step, m.displacement, m.step_displacement) for m in run.stored.moments]
    expected = [
        ("relax", 0, 0),
        ("pull", 1, 1),
        ("pull", 2, 2),
        ("wait", 2, 0),
        ("on", 3, 1),
        ("on", 4, 2),
        ("on", 5, 3),
    ]
    assert [step for step, *_ in moments] == [step for step, *_ in expected]
    assert np.array([row[1:] for row in moments]) == pytest.approx(np.array([row[1:] for row in expected]), abs=1e-9)
    assert np.all(np.diff(run.force.displacement) >= 0.0)
    assert run.force.displacement[-1] == pytest.approx(5.0)
    assert run.force.spans["on"][2] == pytest.approx(2.0)
    for name in ("force", "tension", "twist"):
        table = run.table(name)
        there = table["step"] == "on"
        assert table["displacement_mm"][there] - table["step_displacement_mm"][there] == pytest.approx(2.0)


def test_a_run_in_memory_has_the_same_list(run: kf.Run) -> None:
    memory = kf.pull("overhand", QUICK, progress=False)
    assert memory.stored.moments == run.stored.moments
    assert [state.moment for state in memory.states] == [state.moment for state in run.states] == run.stored.moments


def test_going_on_runs_on(run: kf.Run, tmp_path: Path) -> None:
    knot = kf.tie("overhand", QUICK, out=tmp_path / "knot", progress=False)
    assert kf.pull(knot, progress=False).stored.moments == run.stored.moments


def test_states_are_chosen_by_displacement_and_step(run: kf.Run) -> None:
    assert run.tension(at="4 mm").moment.step == "on"
    assert run.tension(step="pull").displacement == pytest.approx(2.0)
    assert run.tension(at=2.0).moment.step == "pull"
    assert run.state(at=2.0, step="wait").moment.step == "wait"
    with pytest.raises(
        InputError, match='step: no state of this step is stored; found "up"; expected relax, pull, wait'
    ):
        run.tension(step="up")
    with pytest.raises(InputError, match="found 2 mm; expected 3 to 5 mm"):
        run.tension(at=2.0, step="on")


def test_every_verb_says_which_state_it_took(run: kf.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("knotfem.results.pictures.draw", lambda fields, scene, out, colour, **framed: None)
    verbs = (
        ("tension", run.path),
        ("render", run.path, "-o", tmp_path / "a.png"),
        ("export", run.path, "-o", tmp_path / "a.vtu"),
    )
    for verb in verbs:
        assert "state: 4 mm of on (2 mm in this step)" in call(*verb, "--at", "4 mm").stderr
        assert "the nearest stored state: 4 mm of on" in call(*verb, "--at", "4.2 mm").stderr
        assert "state: 2 mm of pull, " in call(*verb, "--step", "pull").stderr
        assert "state: 5 mm of on" in call(*verb).stderr
        for wrong in (("--at", "6 mm"), ("--step", "up"), ("--at", "1 mm", "--step", "on")):
            refused = call(*verb, *wrong)
            assert refused.exit_code == 3
            assert f"{wrong[0]}: no state" in refused.stderr


def test_a_state_without_fields_is_refused(tmp_path: Path) -> None:
    """Of a run whose first part stored none, the state that has fields is not drawn in the place of another."""
    tied = kf.tie("overhand", [*QUICK, "output.fields=false"], out=tmp_path / "run", progress=False)
    assert tied.path is not None
    done = kf.pull(tied.path, {"output.fields": True}, out=tied.path, progress=False)
    assert [state.moment for state in done.states] == done.stored.moments[1:]
    assert done.state(at=1.0).displacement == pytest.approx(1.0)
    with pytest.raises(
        InputError, match=r"its fields are not stored; found 0 mm of relax.*a state of which fields are stored"
    ):
        done.state(at=0.0)


def test_tables_of_older_versions_run_on_too(run: kf.Run, tmp_path: Path) -> None:
    older = kf.pull("overhand", QUICK, out=tmp_path / "older", progress=False)
    assert older.path is not None
    for name in ("force", "tension", "contacts", "twist"):
        table = read_table(older.path / f"{name}.csv")
        table["displacement_mm"] = table.pop("step_displacement_mm")
        if name != "force":
            del table["step"]
        write_table(older.path / f"{name}.csv", table)
    read = kf.open_run(older.path)
    there = [[m.displacement for m in one.stored.moments] for one in (read, run)]
    assert there[0] == pytest.approx(there[1])
    assert [m.step for m in read.stored.moments] == ["", *(m.step for m in run.stored.moments[1:])]
    assert read.force.displacement == pytest.approx(run.force.displacement)


def test_what_a_step_goes_back_is_not_taken_off() -> None:
    back = [Moment("pull", 3.0, 3.0, 1.0), Moment("back", 2.5, -0.5, 2.0), Moment("on", 3.5, 0.5, 3.0)]
    assert choose(back, 2.5, None, None).step == "back"
    assert str(back[1]) == "2.5 mm of back (-0.5 mm in this step), 2 s"
