"""Stability diagrams with an engine that computes nothing: a knot holds as a law says."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from stand_in import StandIn

import knotfem as kf
from knotfem.errors import InputError
from knotfem.plot.stability import plot_stability
from knotfem.study.column_meanings import TABLES
from knotfem.study.engine.engine import Job
from knotfem.study.engine.outcomes import Outcome
from knotfem.study.stability.diagram import open_stability
from knotfem.study.sweep import points as module
from knotfem.theory import PAPER, critical_friction
from knotfem_cli.common import numbers
from knotfem_cli.main import knotfem_command

LOADS = (7.4, 9.1, 13.9, 25.0)


def judged(job: Job) -> Outcome:
    """A bowline holds as the theory says; where friction falls, it is lost there and slips a little before."""
    scene = job.run.scene
    name = job.name.split("_")
    threshold = float(critical_friction(float(name[1].removeprefix("x="))))
    knot = "8_20 (by 11 of 12 closures; 6_3 by 1)"
    summary: dict[str, Any] = {"knot_before": knot, "verdict_evidence": {"at_rest": True}}
    if scene.contact.friction < threshold or name[2] == "lowered":
        at = min(scene.contact.friction, threshold)
        evidence = {"at_rest": False, "lost": {"what": "gone", "friction": at}, "onset": {"friction": at + 0.004}}
        summary |= {"verdict": "unravels", "failure_mode": "central", "verdict_evidence": evidence}
    else:
        summary |= {"verdict": "holds", "failure_mode": "none"}
    job.run.write_summary(summary)
    return Outcome("done")


@pytest.fixture
def engines(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[StandIn]:
    used: list[StandIn] = []

    def engine(folder: Path, *arguments: object, **others: object) -> StandIn:
        folder.mkdir(exist_ok=True, parents=True)
        used.append(StandIn(judged))
        return used[-1]

    monkeypatch.setattr(module, "Engine", engine)
    monkeypatch.chdir(tmp_path)
    return used


def diagram(**options: Any) -> kf.StabilityDiagram:
    return kf.stability("bowline", {"model": "rod"}, out="out", progress=False, **options)


def test_the_grid_has_a_row_for_each_point(engines: list[StandIn]) -> None:
    found = diagram(friction=(0.1, 0.3), x=(9.1, 25.0))
    assert found.table["point"].tolist() == [
        "rod_x=9.1_friction=0.3", "rod_x=25_friction=0.3", "rod_x=9.1_friction=0.1", "rod_x=25_friction=0.1",
    ]  # fmt: skip
    np.testing.assert_allclose(found.table["tension_N"][:2], [10.07 / 9.1, 10.07 / 25.0], rtol=1e-3)
    assert found.table["verdict"].tolist() == ["holds", "holds", "unravels", "unravels"]
    assert found.boundary["low"].tolist() == [0.1, 0.1]
    assert found.bowline
    assert tuple(found.table.columns) == tuple(TABLES["study"])
    with (found.path / "boundary.csv").open() as file:
        assert next(csv.reader(file))[:5] == ["model", "protocol", "x", "tension_N", "friction"]


def test_the_boundary_is_found_and_gives_back_the_law(engines: list[StandIn]) -> None:
    found = diagram(grid=False, boundary=0.005, x=LOADS)
    middle, half, x = found.boundary_of("rod")
    assert (np.abs(middle - critical_friction(x)) <= half).all()
    assert (half <= 0.0026).all()
    fit = found.fits()["rod, kept"]
    assert abs(fit["alpha"] - PAPER.alpha) < 3.0 * fit["alpha_error"]
    assert abs(fit["beta"] - PAPER.beta) < 3.0 * fit["beta_error"]
    assert len(engines[0].order) < 4 * 10


def test_the_same_call_runs_nothing_again_and_another_takes_what_is_there(engines: list[StandIn]) -> None:
    first = diagram(grid=False, boundary=0.05, x=(9.1,))
    again = diagram(grid=False, boundary=0.05, x=(9.1,))
    assert engines[1].order == []
    np.testing.assert_array_equal(again.boundary["friction"], first.boundary["friction"])
    diagram(grid=False, boundary=0.01, x=(9.1,))
    assert not set(engines[2].order) & set(engines[0].order)


def test_lowered_friction_gives_the_onset_and_the_loss(engines: list[StandIn]) -> None:
    found = diagram(grid=False, lowered=True, x=(25.0,))
    lost = float(critical_friction(25.0))
    row = {name: values[0] for name, values in found.boundary.items()}
    assert (row["model"], row["protocol"]) == ("rod", "lowered")
    assert (row["low"], row["high"]) == (pytest.approx(lost), pytest.approx(lost + 0.004))


def test_two_models_are_told_apart_and_read_again(engines: list[StandIn], tmp_path: Path) -> None:
    found = diagram(friction=(0.1, 0.3), x=LOADS, models=("rod", "fem"))
    again = open_stability(found.path)
    assert again.boundary["model"].tolist() == ["fem"] * 4 + ["rod"] * 4
    np.testing.assert_allclose(again.boundary["friction"], found.boundary["friction"])
    again.plot(tmp_path / "both.svg", {"same": found})
    drawn = (tmp_path / "both.svg").read_text()
    for text in (
        "holds (hexahedra)", "unravels, central strands slip (discrete rods)", "boundary, discrete rods",
        "boundary, discrete rods of same", "theory, central strands", "T_0",
    ):  # fmt: skip
        assert text in drawn


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"friction": ()}, "friction"),
        ({"x": (0.0,)}, "x"),
        ({"boundary": 0.0}, "boundary"),
        ({"boundary": 0.01, "friction": (0.1,)}, "nothing to bisect"),
        ({"models": ("shell",)}, "no such model"),
        ({"grid": False}, "nothing to run"),
        ({"friction": (0.1, 0.2, 0.1)}, "friction: the same value twice"),
        ({"x": (9.1, 9.1)}, "x: the same value twice"),
        ({"x": (9.1,), "load": ("1 N",)}, "load: one load said in two ways"),
        ({"load": ("0 N",)}, "load: no loads"),
        ({"load": ("2 mm",)}, "load"),
        ({"load": ()}, "load: no loads"),
    ],
)
def test_wrong_arguments_are_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        diagram(**options)


def test_loads_may_be_forces(engines: list[StandIn]) -> None:
    found = diagram(friction=(0.3,), load=("0.5 N", 1.0))
    assert found.table["tension_N"].tolist() == pytest.approx([0.5, 1.0])
    np.testing.assert_allclose(found.table["x"], [10.07 / 0.5, 10.07], rtol=1e-3)


def test_a_cell_without_a_value_is_empty_whatever_other_points_have(engines: list[StandIn]) -> None:
    def cells(x: tuple[float, ...]) -> dict[str, str]:
        diagram(friction=(0.4,), x=x, lowered=len(x) > 1)
        with Path("out/study.csv").open() as file:
            return next(row for row in csv.DictReader(file) if row["point"] == "rod_x=9.1_friction=0.4")

    first = cells((9.1,))
    assert (first["onset_friction"], first["reason"]) == ("", "")
    assert cells((9.1, 7.4)) == first
    assert np.isnan(open_stability("out").table["onset_friction"][0])


def test_a_loss_without_an_onset_is_its_own_bracket(engines: list[StandIn], monkeypatch: pytest.MonkeyPatch) -> None:
    def without_onset(job: Job) -> Outcome:
        outcome = judged(job)
        summary = job.run.read_summary()
        summary["verdict_evidence"]["onset"] = None
        job.run.write_summary(summary)
        return outcome

    monkeypatch.setattr(module, "Engine", lambda *_, **__: StandIn(without_onset))
    Path("out").mkdir()
    found = diagram(grid=False, lowered=True, x=(25.0,))
    assert found.boundary["low"].tolist() == found.boundary["high"].tolist()


def test_one_load_has_one_tick(tmp_path: Path) -> None:
    columns = {"model": ["rod"], "friction": [0.2], "x": [25.0], "verdict": ["holds"], "failure_mode": ["none"]}
    points = {name: np.array(values) for name, values in columns.items()}
    plot_stability(points, {}, tmp_path / "one.svg", force=10.0, theory=False)
    drawn = (tmp_path / "one.svg").read_text()
    assert ">25</text>" in drawn
    assert ">0.4</text>" in drawn
    assert ">24.5</text>" not in drawn


def test_numbers_of_options() -> None:
    assert numbers("0.1, 0.15 0.2", "--x") == (0.1, 0.15, 0.2)
    assert numbers("0:0.4:9", "--x") == pytest.approx([0.05 * i for i in range(9)])
    for text in ("", "a", "0:1", "1:2:x"):
        with pytest.raises(InputError, match="--x"):
            numbers(text, "--x")


def test_the_verb(engines: list[StandIn]) -> None:
    options = {"--model": "rod", "--x": "7.4,9.1,25", "--friction": "0:0.4:3", "--boundary": "0.02"}
    call = ["stability", "bowline", *(word for option in options.items() for word in option)]
    shown = CliRunner().invoke(knotfem_command, [*call, "--direction", "0,0,1", "-o", "out"])
    assert shown.exit_code == 0, shown.output
    assert "rod, friction kept, x = 25 (T0 = 0.4029 N): holds from between 0.2" in shown.output
    assert "alpha = " in shown.output
    assert (Path("out") / "stability.png").stat().st_size > 10_000
    scene = kf.load_scene("out/runs/rod_x=25_friction=0.4/scene.toml")
    assert scene.steps[-1].all_ends()["rod", "end"].direction == (0.0, 0.0, 1.0)  # pyright: ignore[reportAttributeAccessIssue]
    dry = CliRunner().invoke(knotfem_command, [*call, "--dry-run", "-o", "other"])
    assert dry.exit_code == 0
    told = json.loads(CliRunner().invoke(knotfem_command, [*call, "--dry-run", "--log-format", "json"]).stdout)
    assert told["points"] == 9
    assert 2.0 < told["expected_cpu_hours_if_all_unravel"] / told["expected_cpu_hours"] < 3.0
    assert "expected hours if all unravel" in dry.output
    assert not Path("other").exists()
    rope = CliRunner().invoke(knotfem_command, [*call, "--dry-run", "-o", "other", "--rope", "diameter=12 mm"])
    assert "rope: bowline of 6 mm" in rope.stderr
    mine = CliRunner().invoke(knotfem_command, [*call, "-o", "mine", "--rope", "diameter=12 mm"])
    assert mine.exit_code == 0, mine.output
    assert kf.load_scene("mine/runs/rod_x=25_friction=0.4/scene.toml").diameter == 12.0
    assert "rope = " in Path("mine/study.toml").read_text()
    wrong = CliRunner().invoke(knotfem_command, [*call[:4], "--x", "much"])
    assert wrong.exit_code == 3
    assert "--x" in wrong.output
