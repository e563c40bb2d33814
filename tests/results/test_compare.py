"""Runs side by side, on tables of known shape."""

from pathlib import Path

import numpy as np
import pytest
from stored_runs import S, pulled, stored

from knotfem.errors import InputError
from knotfem.results.compare import Comparison, compare
from knotfem.results.data import open_run
from knotfem.results.force import force_curve, onset_of_locking
from knotfem.results.run import Run
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table, write_table
from knotfem.scene import load_scene

TWICE = 'steps=[{kind="pull",%s},{kind="hold",duration="1 s"},{kind="pull",name="on",%s}]'
PULL = 'displacement="%g mm",speed="4 mm/s",ends.rod.start={motion="driven",direction=[0,0,1]}'


def cells(found: Comparison) -> dict[str, list]:
    return {figure.name: list(figure.cells) for figure in found.figures}


def test_differences_are_relative_to_the_first_run(tmp_path):
    runs = pulled(tmp_path / "solid"), pulled(tmp_path / "light", 1.1, to=50.0, model="rod")
    found = cells(compare(*runs))
    assert found["model"] == ["fem", "rod"]
    assert found["wall"] == [3.0, 3.0]
    assert (found["compared from"][0], found["compared to"][0]) == (0.0, 50.0)
    assert found["force there"] == pytest.approx([26.0, 28.6])
    for name in ("force there, difference", "force curve, L2 difference", "force curve before locking, L2 difference"):
        assert found[name][0] is None
        assert found[name][1] == pytest.approx(0.1, rel=2e-3)


def test_profiles_are_those_of_the_last_displacement_that_both_have(tmp_path):
    runs = pulled(tmp_path / "solid"), pulled(tmp_path / "light", 1.1, to=50.0, model="rod")
    found = compare(*runs)
    assert found.state is not None
    assert found.state.displacements == [48.0, 48.0]
    assert found.state.over_force
    first, second = (profile["rod"]["tension"] for profile in found.state.profiles)
    assert first == pytest.approx(1.0 - 0.8 * S)
    assert second == pytest.approx(1.0 - 0.78 * S, rel=2e-3)
    expected = np.linalg.norm(0.02 * S) / np.linalg.norm(1.0 - 0.8 * S)
    assert cells(found)["tension T/F, L2 difference"][1] == pytest.approx(expected, rel=1e-2)
    assert cells(compare(*runs, at=30.5))["tension profile at"] == [30.0, 30.0]


def test_force_is_compared_at_common_displacements_only(tmp_path):
    runs = pulled(tmp_path / "a"), pulled(tmp_path / "b", to=90.0, start=40.0)
    found = cells(compare(*runs))
    assert (found["compared from"][1], found["compared to"][1]) == (40.0, 60.0)
    assert found["force curve, L2 difference"][1] == pytest.approx(0.0, abs=1e-3)


def test_locking_parts_the_curve_where_it_is_put(tmp_path):
    first, second = pulled(tmp_path / "a"), pulled(tmp_path / "b")
    assert second.path is not None
    table = read_table(second.path / "force.csv")
    late = table["displacement_mm"] > 40.0
    write_table(second.path / "force.csv", {**table, "force_N": np.where(late, 2.0, 1.0) * table["force_N"]})
    found = cells(compare(first, second, locking=39.0))
    assert found["force curve before locking, L2 difference"][1] == pytest.approx(0.0, abs=1e-12)
    assert found["force curve after locking, L2 difference"][1] == pytest.approx(1.0, rel=0.03)
    for outside in (-3.0, 300.0):
        with pytest.raises(InputError, match=f"--locking: .*found {outside:g} mm"):
            compare(first, second, locking=outside)


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
    curve = force_curve(open_run(run.path), "run")
    assert curve.displacement.tolist() == [15.0, 30.0, 36.0, 42.0]
    assert curve.force.tolist() == [1.0, 2.0, 3.0, 4.0]
    assert curve.spans == {"pull": (0.0, 7.5, 0.0), "on": (8.5, 11.5, 30.0)}
    assert list(curve.steps) == ["pull", "hold", "on"]


def test_runs_that_cannot_be_compared_are_refused(tmp_path):
    first = pulled(tmp_path / "a")
    with pytest.raises(InputError, match="no displacement in common; found a 0 to 60 mm; b 70 to 90 mm"):
        compare(first, pulled(tmp_path / "b", start=70.0, to=90.0))
    with pytest.raises(InputError, match="nothing to compare"):
        compare(first)
    with pytest.raises(InputError, match=r"the same run twice; found .*a; expected each once"):
        compare(first, tmp_path / "b" / ".." / "a")
    with pytest.raises(InputError, match="no loading step is stored"):
        compare(first, RunDirectory.create(first.scene, tmp_path / "c").path)
    with pytest.raises(InputError, match="no such run"):
        compare(first, tmp_path / "none")
    with pytest.raises(InputError, match="no tension is stored near"):
        compare(first, pulled(tmp_path / "d", to=50.0), at=58.0)


LOADED = (
    'steps=[{kind="pull",name="draw",%s},{kind="load",name="load",duration="2 s",'
    'ends.rod.start={motion="loaded",force="2 N",direction=[0,0,1]}},'
    '{kind="release",name="let-go",duration="5 s"},{kind="hold",name="other",duration="5 s"}]' % (PULL % 12.0)
)


def loaded(path: Path, part: float, *, drawn: bool = True, force: float = 2.0, last: str = "let-go") -> Run:
    """A run drawn by 12 mm, loaded and let go; in the end its tension falls linearly from 2 N to a part of it."""
    run = RunDirectory.create(load_scene("overhand", [LOADED]), path)
    rows = [(1.0, 4.0, 0.5, "draw"), (3.0, 12.0, 1.0, "draw")] * drawn
    rows += [(4.0, 0.0, 1.5, "load"), (5.0, 0.0, 2.0, "load"), (8.0, 0.1, force, last), (10.0, 0.2, force, last)]
    names = ("time_s", "displacement_mm", "force_N", "step")
    columns = {name: np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}
    write_table(run.path / "force.csv", columns)
    states = ((0.0, 0.5, 0.9), (12.0, 3.0, 0.8), (0.0, 5.0, 0.7), (0.2, 10.0, part))
    tables = [stored(d, t, 2.0 * (1.0 - (1.0 - level) * S)) for d, t, level in states]
    write_table(run.path / "tension.csv", {name: np.concatenate([t[name] for t in tables]) for name in tables[0]})
    return open_run(path)


def test_loaded_runs_are_compared_at_the_end_of_their_last_step_in_common(tmp_path):
    runs = loaded(tmp_path / "a", 0.4), loaded(tmp_path / "b", 0.5)
    found = cells(compare(*runs))
    assert found["tension profile at the end of"] == ["let-go", "let-go"]
    assert found["force F there"] == [2.0, 2.0]
    expected = np.linalg.norm(0.1 * S) / np.linalg.norm(1.0 - 0.6 * S)
    assert found["tension T/F, L2 difference"][1] == pytest.approx(expected)
    other = [runs[0], loaded(tmp_path / "c", 0.5, last="other")]
    assert cells(compare(*other))["tension profile at the end of"] == ["load", "load"]


def test_step_at_whose_end_runs_are_compared_may_be_named(tmp_path):
    runs = loaded(tmp_path / "a", 0.4), loaded(tmp_path / "b", 0.5)
    assert cells(compare(*runs, step="load"))["tension T/F, L2 difference"][1] == pytest.approx(0.0)
    assert cells(compare(*runs, step="draw"))["tension profile at"] == [12.0, 12.0]


def test_runs_that_nothing_pulls_are_compared_by_tension_alone(tmp_path):
    runs = [loaded(tmp_path / name, part, drawn=False, force=0.0) for name, part in (("a", 0.4), ("b", 0.5))]
    found = compare(*runs)
    assert "compared to" not in cells(found)
    assert cells(found)["pulled to"] == [None, None]
    expected = np.linalg.norm(0.1 * S) / np.linalg.norm(1.0 - 0.6 * S)
    assert cells(found)["tension T, L2 difference"][1] == pytest.approx(expected)
    found.write(tmp_path / "both.svg")
    svg = (tmp_path / "both.svg").read_text()
    assert all(text in svg for text in ("end of let-go", ">a<", ">b<", "(N)"))


def test_steps_that_runs_do_not_share_are_refused(tmp_path):
    a, b = loaded(tmp_path / "a", 0.4), pulled(tmp_path / "b")
    with pytest.raises(InputError, match='b: --step: no such step is stored; found "load"; expected pull'):
        compare(a, b, step="load")
    with pytest.raises(InputError, match="two states are asked for"):
        compare(a, b, step="load", at=3.0)
    bare = loaded(tmp_path / "c", 0.4, drawn=False)
    with pytest.raises(InputError, match="no stored step in common; found b pull; c load, let-go"):
        compare(b, bare)


def test_picture_and_table_are_written(tmp_path):
    found = compare(pulled(tmp_path / "solid"), pulled(tmp_path / "light", 1.1, model="rod"))
    table = found.write(tmp_path / "both.svg")
    assert table == tmp_path / "both.csv"
    columns = read_table(table)
    assert list(columns) == ["figure", "unit", "solid", "light"]
    where = columns["figure"].tolist().index("force there, difference")
    assert float(columns["light"][where]) == pytest.approx(0.1, rel=2e-3)
    svg = (tmp_path / "both.svg").read_text()
    assert all(text in svg for text in ("solid", "light", "tension", "force"))


def test_rods_of_different_radii_are_drawn_in_mm(tmp_path, monkeypatch):
    from knotfem.plot import plots

    panels = []

    def keep(axes, curves, radii, *, axis):
        panels.append((axis, radii))

    monkeypatch.setattr(plots, "draw_force", keep)
    thin, thick = pulled(tmp_path / "thin"), pulled(tmp_path / "thick")
    compare(thin, thick).write(tmp_path / "same.svg")
    vars(thick)["_directory"].scene = load_scene(thick.scene, {"rods.rod.diameter": "12 mm"})
    compare(thin, thick).write(tmp_path / "other.svg")
    assert panels == [("both", {"thin": 3.0, "thick": 3.0}), ("mm", {"thin": 3.0, "thick": 6.0})]
