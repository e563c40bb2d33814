"""Which values of a run colour its pictures."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from knotfem.models.base import make_simulation
from knotfem.plot import pictures
from knotfem.run.directory import RunDirectory
from knotfem.run.series import open_series
from knotfem.scene import load_scene

COARSE = ("model=rod", "rods.0.mesh.element_length=8 mm")


def drawn(monkeypatch: pytest.MonkeyPatch, folder: Path, colour: str, low: float, high: float) -> dict[str, Any]:
    """How a run is drawn whose field of this colour goes from low to high."""
    scene = load_scene("cantilever", COARSE)
    run, model = RunDirectory.create(scene, folder / "run"), make_simulation(scene)
    fields = model.fields(model.straight().x)
    name = pictures.COLOURS[colour][0]
    values = {name: np.linspace(low, high, len(fields.points))}
    series = open_series(run.path / "results.vtkhdf", model.series_mesh, None)
    series.append(0.0, fields.points, point_data={**fields.point_data, **values}, cell_data=fields.cell_data)
    series.close()
    asked: dict[str, Any] = {}
    monkeypatch.setattr(pictures, "render_mesh", lambda points, cells, out, **options: asked.update(options))
    pictures.render(run, folder / "a.png", colour)
    return asked


@pytest.mark.parametrize(("low", "high"), [(-0.01, 0.03), (0.0, 0.03), (-0.03, -0.02)])
def test_no_twist_has_the_colour_in_the_middle(monkeypatch, tmp_path, low, high):
    assert drawn(monkeypatch, tmp_path, "twist", low, high)["limits"] == pytest.approx((-0.03, 0.03))


def test_other_colours_and_no_twist_at_all_take_the_limits_of_what_is_drawn(monkeypatch, tmp_path):
    assert drawn(monkeypatch, tmp_path, "curvature", 0.0, 0.03)["limits"] is None
    assert drawn(monkeypatch, tmp_path / "on", "twist", 0.0, 0.0)["limits"] is None
