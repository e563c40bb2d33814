"""Runs side by side, on tables of known shape."""

from pathlib import Path

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.run.compare import Comparison, compare
from knotfem.run.curves import force_curve, onset_of_locking
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table, write_table
from knotfem.scene import load_scene

TWICE = 'steps=[{kind="pull",%s},{kind="hold",duration="1 s"},{kind="pull",name="on",%s}]'
PULL = 'displacement="%g mm",speed="4 mm/s",ends.rod.start={motion="driven",direction=[0,0,1]}'
S = np.linspace(0.0, 1.0, 51)
SPEED = 4.0


def stored(displacement: float, time: float, tension: np.ndarray) -> dict[str, np.ndarray]:
    bent = 60.0 * np.stack([np.cos(7.0 * S), np.sin(7.0 * S), 1.1 * S], axis=1)
    same = {"displacement_mm": displacement, "time_s": time}
    return {
        **{name: np.full(S.size, value) for name, value in same.items()},
        "rod": np.full(S.size, "rod"),
        "s_over_L": S,
        "tension_N": tension,
        **{f"{axis}_mm": bent[:, i] for i, axis in enumerate("xyz")},
    }


def pulled(
    path: Path, factor: float = 1.0, *, to: float = 60.0, start: float = 0.0, model: str = "fem"
) -> RunDirectory:
    """A run with F = factor (1 + d^2/100), whose tension falls linearly to the share 0.2 factor of F."""
    scene = load_scene("overhand", [f"model={model}"])
    run = RunDirectory.create(scene, path)
    d = np.linspace(start, to, 61)
    force = factor * (1.0 + d**2 / 100.0)
    steps = np.full(d.size, "pull")
    write_table(path / "force.csv", {"time_s": 2.0 + d / SPEED, "displacement_mm": d, "force_N": force, "step": steps})
    states = [
        stored(at, 2.0 + at / SPEED, factor * (1.0 + at**2 / 100.0) * (1.0 - (1.0 - 0.2 * factor) * S))
        for at in np.arange(3.0, to + 1e-9, 3.0)
        if at > start
    ]
    write_table(path / "tension.csv", {name: np.concatenate([s[name] for s in states]) for name in states[0]})
    run.write_summary(
        {"dofs": 12, "phases": {"relax": {"wall_s": 1.0, "cpu_s": 0.5}, "pull": {"wall_s": 2.0, "cpu_s": 1.0}}}
    )
    return run


def cells(found: Comparison) -> dict[str, list]:
    return {figure.name: list(figure.cells) for figure in found.figures}


def test_differences_are_relative_to_the_first_run(tmp_path):
    runs = pulled(tmp_path / "solid"), pulled(tmp_path / "light", 1.1, to=50.0, model="rod")
    found = cells(compare(runs))
    assert found["model"] == ["fem", "rod"]
    assert found["wall"] == [3.0, 3.0]
    assert (found["compared from"][0], found["compared to"][0]) == (0.0, 50.0)
    assert found["force there"] == pytest.approx([26.0, 28.6])
    for name in ("force there, difference", "force curve, L2 difference", "force curve before locking, L2 difference"):
        assert found[name][0] is None
        assert found[name][1] == pytest.approx(0.1, rel=2e-3)


def test_profiles_are_those_of_the_last_displacement_that_both_have(tmp_path):
    runs = pulled(tmp_path / "solid"), pulled(tmp_path / "light", 1.1, to=50.0, model="rod")
    found = compare(runs)
    assert found.at == 48.0
    first, second = (profile["rod"]["tension_over_force"] for profile in found.profiles)
    assert first == pytest.approx(1.0 - 0.8 * S)
    assert second == pytest.approx(1.0 - 0.78 * S, rel=2e-3)
    expected = np.linalg.norm(0.02 * S) / np.linalg.norm(1.0 - 0.8 * S)
    assert cells(found)["tension T/F, L2 difference"][1] == pytest.approx(expected, rel=1e-2)
    assert compare(runs, at=30.5).at == 30.0


def test_force_is_compared_at_common_displacements_only(tmp_path):
    runs = pulled(tmp_path / "a"), pulled(tmp_path / "b", to=90.0, start=40.0)
    found = cells(compare(runs))
    assert (found["compared from"][1], found["compared to"][1]) == (40.0, 60.0)
    assert found["force curve, L2 difference"][1] == pytest.approx(0.0, abs=1e-3)


def test_locking_parts_the_curve_where_it_is_put(tmp_path):
    first, second = pulled(tmp_path / "a"), pulled(tmp_path / "b")
    table = read_table(second.path / "force.csv")
    late = table["displacement_mm"] > 40.0
    write_table(second.path / "force.csv", {**table, "force_N": np.where(late, 2.0, 1.0) * table["force_N"]})
    found = cells(compare([first, second], locking=39.0))
    assert found["force curve before locking, L2 difference"][1] == pytest.approx(0.0, abs=1e-12)
    assert found["force curve after locking, L2 difference"][1] == pytest.approx(1.0, rel=0.03)


def test_knot_begins_to_lock_where_its_force_begins_to_soar():
    d = np.linspace(0.0, 100.0, 401)
    assert onset_of_locking(d, 0.01 * d + 0.2 * np.maximum(d - 70.0, 0.0)) == pytest.approx(70.0, abs=4.0)
    assert onset_of_locking(d, 0.01 * d) is None
    assert onset_of_locking(d, 1.0 - 0.01 * d) is None


def test_pulls_follow_each_other(tmp_path):
    scene = load_scene("overhand", [TWICE % (PULL % 30.0, PULL % 12.0)])
    run = RunDirectory.create(scene, tmp_path / "run")
    columns = {
        "time_s": np.array([3.75, 7.5, 8.5, 10.0, 11.5]),
        "displacement_mm": np.array([15.0, 30.0, 0.0, 6.0, 12.0]),
        "force_N": np.array([1.0, 2.0, 2.0, 3.0, 4.0]),
        "step": np.array(["pull", "pull", "hold", "on", "on"]),
    }
    write_table(run.path / "force.csv", columns)
    curve = force_curve(run, "run")
    assert curve.displacement.tolist() == [15.0, 30.0, 36.0, 42.0]
    assert curve.force.tolist() == [1.0, 2.0, 3.0, 4.0]
    assert curve.spans == ((0.0, 7.5, 0.0), (8.5, 11.5, 30.0))


def test_runs_that_cannot_be_compared_are_refused(tmp_path):
    first = pulled(tmp_path / "a")
    with pytest.raises(InputError, match="no displacement in common; found a 0 to 60 mm; b 70 to 90 mm"):
        compare([first, pulled(tmp_path / "b", start=70.0, to=90.0)])
    with pytest.raises(InputError, match="nothing to compare"):
        compare([first])
    with pytest.raises(InputError, match="no pull is stored"):
        compare([first, RunDirectory.create(first.scene, tmp_path / "c")])
    with pytest.raises(InputError, match="no tension is stored near"):
        compare([first, pulled(tmp_path / "d", to=50.0)], at=58.0)


def test_picture_and_table_are_written(tmp_path):
    found = compare([pulled(tmp_path / "solid"), pulled(tmp_path / "light", 1.1, model="rod")])
    table = found.write(tmp_path / "both.svg")
    assert table == tmp_path / "both.csv"
    columns = read_table(table)
    assert list(columns) == ["figure", "unit", "solid", "light"]
    where = columns["figure"].tolist().index("force there, difference")
    assert float(columns["light"][where]) == pytest.approx(0.1, rel=2e-3)
    svg = (tmp_path / "both.svg").read_text()
    assert all(text in svg for text in ("solid", "light", "tension", "force"))
