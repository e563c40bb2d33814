"""Figures of runs, however they ended."""

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from coarse import KNOT
from matplotlib import pyplot
from matplotlib.figure import Figure
from PIL import Image
from stored_runs import pulled

import knotfem as kf
from knotfem.results.profiles import common_state
from knotfem.run.directory import RunDirectory
from knotfem.run.monitor import KnotMonitor
from knotfem.run.stop import StopRequest
from knotfem_cli.main import knotfem_command


def lines(axes) -> list[tuple[np.ndarray, np.ndarray]]:
    """Curves of a panel, without empty ones that stand in the legend only."""
    return [line.get_data() for line in axes.get_lines() if len(line.get_xdata())]


def test_one_run_is_drawn_without_a_legend(tmp_path):
    run = pulled(tmp_path / "a")
    (axes,) = kf.plot(run).figure.axes
    ((x, y),) = lines(axes)
    np.testing.assert_allclose(x, run.force.displacement / 3.0)
    np.testing.assert_array_equal(y, run.force.force)
    assert axes.get_legend() is None
    assert (axes.get_xlim()[0], axes.get_ylim()[0]) == (0.0, 0.0)


@pytest.mark.parametrize(("axis", "over"), [("mm", 1.0), ("radii", 3.0), ("both", 3.0)])
def test_displacement_in_mm_or_radii_and_force_over_stiffness(tmp_path, axis, over):
    run = pulled(tmp_path / "a")
    panel, *_ = kf.plot(run, axis=axis, force_unit="B/r^2", xlim=(None, 9.0), ylim=(0.5, None)).figure.axes
    ((x, y),) = lines(panel)
    np.testing.assert_allclose(x, run.force.displacement / over)
    np.testing.assert_allclose(y, run.force.force / run.scene.force_scale)
    assert (panel.get_xlim()[1], panel.get_ylim()[0]) == (9.0, 0.5)
    assert bool(panel.child_axes) == (axis == "both")


def test_runs_of_different_radii_share_the_axis_in_radii(tmp_path):
    thin = pulled(tmp_path / "a")
    thick = pulled(tmp_path / "b")
    scene = kf.load_scene(thick.scene, {"rods.rod.diameter": "12 mm"})
    vars(thick)["_directory"].scene = scene
    panel, *_ = kf.plot(thin, thick).figure.axes
    (x, _), (other, _) = lines(panel)
    assert x[-1] == pytest.approx(2.0 * other[-1])
    assert not panel.child_axes
    with pytest.raises(kf.InputError, match="axis: rods of different radii"):
        kf.plot(thin, thick, axis="both")


def test_figures_of_one_run_and_of_several_have_the_same_style(tmp_path):
    run = pulled(tmp_path / "a")
    several = kf.plot(run, quantity="both", axis="mm").figure.axes
    figures = run.force.plot(), run.tension().plot()
    for own, other in zip(figures, several, strict=True):
        assert own.get_xlabel() == other.get_xlabel()
        assert (own.lines[0].get_color(), own.lines[0].get_linewidth()) == (other.lines[0].get_color(), 1.4)
        assert own.get_xlim()[0] == 0.0
        assert isinstance(own.figure, Figure)
        assert own.figure.get_size_inches() * 25.4 == pytest.approx([91.44, 71.12])
        assert own.xaxis.label.get_fontsize() == other.xaxis.label.get_fontsize() == 10.0
    assert figures[0].get_ylim()[0] == 0.0
    assert len(run.force.plot(figures[0], color="k").lines) == 2
    pyplot.close("all")


def test_runs_without_data_in_the_plotted_range_are_omitted_from_the_legend(tmp_path):
    short, long = pulled(tmp_path / "short", to=30.0), pulled(tmp_path / "long")
    drawn = kf.plot(short, long, xlim=(15.0, None))
    assert drawn.out_of_view == ["short"]
    legend = drawn.figure.axes[0].get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["long"]
    assert kf.plot(short, long, xlim=(5.0, None)).out_of_view == []
    above = kf.plot(short, pulled(tmp_path / "weak", 0.1), quantity="tension", ylim=(0.1, None))
    assert above.out_of_view == []
    call = ["plot", str(short.path), str(long.path), "--xlim", "15:", "-o", str(tmp_path / "p.svg")]
    assert "short: nothing lies between these limits" in CliRunner().invoke(knotfem_command, call).stderr


def test_tension_is_that_of_the_state_that_is_asked_for(tmp_path):
    runs = pulled(tmp_path / "a"), pulled(tmp_path / "b", 2.0)
    drawn = kf.plot(*runs, quantity="tension", at=31.0, axis="mm", labels=["solid", "light"])
    assert [profile.displacement for profile in drawn.profiles] == [30.0, 30.0]
    first, second = lines(drawn.figure.axes[0])
    assert first[0][-1] == 500.0
    assert (first[1][0], first[1][-1]) == pytest.approx((1.0, 0.2))
    assert second[1][-1] == pytest.approx(0.4)
    legend = drawn.figure.axes[0].get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["solid", "light"]


def test_tension_is_in_newtons_where_the_force_does_not_pull(tmp_path):
    """Over a force that pushes, tension would look like compression."""
    run = pulled(tmp_path / "a", -1.0)
    (axes,) = kf.plot(run, quantity="tension", at=30.0).figure.axes
    assert axes.get_ylabel() == r"tension $T$ (N)"
    np.testing.assert_allclose(lines(axes)[0][1], run.tension(at=30.0).tension)
    state = common_state([run.force], 30.0, None)
    assert state is not None
    assert not state.over_force


def test_curves_that_begin_late_are_drawn_from_there(tmp_path):
    late = pulled(tmp_path / "a", start=40.0)
    assert kf.plot(late, axis="mm").figure.axes[0].get_xlim()[0] == 40.0
    assert kf.plot(pulled(tmp_path / "b", start=20.0), axis="mm").figure.axes[0].get_xlim()[0] == 0.0


def test_figures_of_tension_say_which_state_they_show(tmp_path):
    run, other = pulled(tmp_path / "a"), pulled(tmp_path / "b", 2.0)
    heading = kf.plot(run, quantity="tension", at=31.0).figure.axes[0].get_title()
    assert heading.startswith(r"$\delta$ = 30 mm")
    assert run.tension(at=31.0).plot().get_title() == heading
    both = kf.plot(run, other, quantity="both", at=31.0, title="two").figure.axes
    assert (both[0].get_title(), both[1].get_title()) == ("two", heading)
    titled = kf.plot(run, quantity="tension", at=31.0, title="mine").figure.axes[0].get_title()
    assert titled == f"mine\n{heading}"


def test_file_has_the_size_that_is_asked_for(tmp_path):
    run = pulled(tmp_path / "a")
    kf.plot(run, out=tmp_path / "a.svg", width="85 mm", height=60.0, quantity="both", title="two")
    found = re.search(r'width="([\d.]+)pt" height="([\d.]+)pt"', (tmp_path / "a.svg").read_text())
    assert found is not None
    assert [float(size) * 25.4 / 72.0 for size in found.groups()] == pytest.approx([85.0, 60.0], abs=0.01)
    kf.plot(run, out=tmp_path / "a.png", width=85.0)
    assert Image.open(tmp_path / "a.png").size[0] == pytest.approx(85.0 / 25.4 * 300.0, abs=1.0)
    kf.plot(run, out=tmp_path / "a.pdf")
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"labels": ["a", "b"]}, "label: labels do not fit the runs; found 2 for 1 runs"),
        ({"width": "2 m"}, "width: no size of a figure; found 2000 mm"),
        ({"width": float("nan")}, "width: no size of a figure"),
        ({"width": "20 mm"}, "width: no size of a figure; found 20 mm; expected 25.6 to 1000 mm without a height"),
        ({"width": "45 mm", "quantity": "both"}, "width: no size of a figure; found 45 mm; expected 51.3 to 1000 mm"),
        ({"width": "30 mm", "height": "10 mm"}, "height: no size of a figure; found 10 mm; expected 20 to 1000 mm"),
        ({"xlim": (500.0, 600.0)}, "xlim: nothing lies between these limits; found 500:600; expected .* go from "),
        ({"xlim": (None, -1.0)}, "xlim: nothing lies between these limits; found :-1;"),
        ({"ylim": (1e6, None)}, "ylim: nothing lies between these limits; found 1e.06:; expected limits"),
        ({"quantity": "tension", "xlim": (2.0, 3.0)}, "xlim: nothing lies .* the data go from 0 to 1"),
        ({"font": 0.0}, "font: no size of a figure"),
        ({"xlim": (5.0, 1.0)}, "xlim: limits that do not rise; found 5:1"),
        ({"quantity": "both", "ylim": (None, 1.0)}, "xlim, ylim: limits of two panels"),
        ({"quantity": "strain"}, "quantity: unknown choice"),
        ({"out": "a.gif"}, r"no such picture format; found \.gif"),
        ({"quantity": "tension", "at": "90 mm"}, "at: no state is stored near"),
    ],
)
def test_refusals_leave_no_file(tmp_path, monkeypatch, asked, said):
    run = pulled(tmp_path / "a")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(kf.InputError, match=said):
        kf.plot(run, **{"out": "b.svg", **asked})
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def assert_drawn(folder: Path) -> None:
    for name in ("force.png", "tension.png"):
        Image.open(folder / name).verify()
    assert not list(folder.glob(".*.part"))
    run = kf.open_run(folder)
    ((x, _),) = lines(kf.plot(run).figure.axes[0])
    assert 0.0 <= x[-1] < 1.0
    np.testing.assert_allclose(x, run.force.displacement / 3.0)


def under_way(folder: Path) -> bool:
    """Whether a few loading steps have been taken."""
    table = folder / "force.csv"
    return table.exists() and table.read_text().count("\n") > 5


def test_knot_that_is_lost_leaves_its_figures(tmp_path, monkeypatch):
    folder = tmp_path / "run"
    monkeypatch.setattr(KnotMonitor, "lost", lambda *arguments: "come undone" if under_way(folder) else "")
    with pytest.raises(kf.KnotLost, match="come undone"):
        kf.pull("overhand", KNOT, out=folder)
    assert RunDirectory.open(folder).read_status()["exit_code"] == 5
    assert_drawn(folder)


def test_run_that_is_stopped_leaves_its_figures(tmp_path, monkeypatch):
    monkeypatch.setattr(StopRequest, "due", property(lambda request: under_way(tmp_path / "run")))
    with pytest.raises(kf.Stopped):
        kf.pull("overhand", KNOT, out=tmp_path / "run")
    assert_drawn(tmp_path / "run")


def test_figures_that_cannot_be_drawn_do_not_hide_what_ended_the_run(tmp_path, monkeypatch):
    from knotfem.plot import plots

    def broken(*arguments: object, **options: object) -> None:
        raise OSError("no space")

    monkeypatch.setattr(plots, "plot_force", broken)
    monkeypatch.setattr(KnotMonitor, "lost", lambda *arguments: "the knot has come undone")
    with pytest.raises(kf.KnotLost, match="come undone"):
        kf.pull("overhand", KNOT, out=tmp_path / "run")
    assert not (tmp_path / "run" / "force.png").exists()
