"""Which values of a run colour its pictures, and which state is drawn."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from coarse import KNOT

import knotfem as kf
from knotfem.errors import InputError
from knotfem.models.build import build_model
from knotfem.models.series import Fields
from knotfem.results import pictures
from knotfem.results.data import open_run
from knotfem.results.view import knot_points
from knotfem.run.directory import RunDirectory
from knotfem.run.disk import DiskStore
from knotfem.scene import load_scene

COARSE = ("model=rod", "rods.0.mesh.element_length=8 mm")


def drawn(monkeypatch: pytest.MonkeyPatch, folder: Path, colour: str, low: float, high: float) -> dict[str, Any]:
    """How a run is drawn, and shown in a window, whose field of this colour goes from low to high."""
    scene = load_scene("cantilever", COARSE)
    run, model = RunDirectory.create(scene, folder / "run"), build_model(scene)
    fields = model.fields(model.straight().x)
    name = pictures.COLOURS[colour][0]
    values = {name: np.linspace(low, high, len(fields.points))}
    series = DiskStore(run).series(model.series_mesh, None)
    series.append(0.0, 0.0, replace(fields, point_data={**fields.point_data, **values}))
    series.close()
    asked: dict[str, Any] = {}
    shown: dict[str, Any] = {}
    monkeypatch.setattr(pictures, "render_mesh", lambda points, cells, out, look, camera: asked.update(vars(look)))
    monkeypatch.setattr(pictures, "show_mesh", lambda points, cells, look: shown.update(vars(look)))
    state = open_run(run.path).state()
    state.render(folder / "a.png", colour)
    state.show(colour)
    assert {key: np.asarray(shown.get(key)).tolist() for key in asked} == {
        key: np.asarray(value).tolist() for key, value in asked.items()
    }
    return asked


@pytest.mark.parametrize(("low", "high"), [(-0.01, 0.03), (0.0, 0.03), (-0.03, -0.02)])
def test_no_twist_has_the_colour_in_the_middle(monkeypatch, tmp_path, low, high):
    assert drawn(monkeypatch, tmp_path, "twist", low, high)["limits"] == pytest.approx((-0.03, 0.03))


def test_other_colours_and_no_twist_at_all_take_the_limits_of_what_is_drawn(monkeypatch, tmp_path):
    assert drawn(monkeypatch, tmp_path, "curvature", 0.0, 0.03)["limits"] is None
    assert drawn(monkeypatch, tmp_path / "on", "twist", 0.0, 0.0)["limits"] is None


def test_no_contact_is_light_and_neutral():
    name, label, colours = pictures.COLOURS["contact-pressure"]
    red, green, blue = (int(colours[0][i : i + 2], 16) for i in (1, 3, 5))
    assert (name, label) == ("contact_pressure", "contact pressure [MPa]")
    assert min(red, green, blue) > 200
    assert max(red, green, blue) - min(red, green, blue) < 20
    assert pictures.COLOURS["strain"][1] == "largest principal logarithmic strain"


def test_the_knot_is_where_strands_are_close(tmp_path):
    run = pulled_knot()
    state = run.states[-1]
    look = pictures._look(state.fields, run.scene, "none")
    line = state.points
    knot = knot_points(run.scene, [line[rings].mean(axis=1) for rings in look.rings])
    assert np.ptp(knot, axis=0).max() < 0.5 * np.ptp(line, axis=0).max()
    with pytest.raises(InputError, match=r"zoom: no such zoom; found 0; expected 0\.1 to 100"):
        state.render(tmp_path / "a.png", zoom=0.0)
    with pytest.raises(InputError, match="focus: no knot to focus on; expected strands that come closer"):
        drawn_state(tmp_path / "straight").render(tmp_path / "a.png", "none", focus="knot")
    assert not list(tmp_path.glob("*.png"))


def test_what_cannot_be_drawn_is_refused(tmp_path):
    with pytest.raises(InputError, match="this field is not stored; found contact-pressure"):
        drawn_state(tmp_path).render(tmp_path / "a.png", "pressure")
    with pytest.raises(InputError, match="no such colour; found red; expected strain"):
        drawn_state(tmp_path / "on").render(tmp_path / "a.png", "red")
    bare = RunDirectory.create(load_scene("cantilever", COARSE), tmp_path / "bare")
    with pytest.raises(InputError, match="no state was stored before the run ended"):
        open_run(bare.path).state()
    off = RunDirectory.create(load_scene("cantilever", [*COARSE, "output.fields=false"]), tmp_path / "off")
    with pytest.raises(InputError, match=r"no state is stored; expected a run with output\.fields = true"):
        open_run(off.path).state()


@cache
def pulled_knot() -> kf.Run:
    return kf.pull("overhand", KNOT, progress=False)


def drawn_state(folder: Path):
    """A state of hexahedra without any field."""
    run = RunDirectory.create(load_scene("cantilever", ["rods.0.mesh.element_length=8 mm"]), folder / "run")
    model = build_model(run.scene)
    mesh = model.series_mesh()
    series = DiskStore(run).series(lambda: mesh, None)
    series.append(0.0, 0.0, Fields(mesh.reference, {}, {}))
    series.close()
    return open_run(run.path).state()
