"""Elements that a scene can ask for, from the scene to the state that is drawn."""

import numpy as np
import pytest

from knotfem import shipped
from knotfem.errors import InputError
from knotfem.models.solid.model import SolidModel
from knotfem.run.frames import read_frame, read_mesh
from knotfem.run.vtkhdf import VtkHdfSeries
from knotfem.scene.load import load_scene

BENT = ("rods.0.length=60 mm", "rods.0.mesh.element_length=6 mm", "tie.path=direct", "solver.threads=1")


def solid(element: str, section: int) -> SolidModel:
    overrides = (*BENT, f"rods.0.mesh.element={element}", f"rods.0.mesh.section_elements={section}")
    return SolidModel(load_scene(shipped.scene_path("cantilever"), overrides))


@pytest.mark.parametrize(("element", "section"), [("hex8-incompatible", 12), ("hex27", 5), ("hex27", 12)])
def test_a_scene_is_tied_and_drawn(element, section, tmp_path):
    model = solid(element, section)
    *_, last = model.mapping(model.paths(), "auto")
    assert last.solved
    assert last.smallest_j > 0.9
    (rod,) = model.body.rods
    assert rod.mesh.slices == (20 if element == "hex27" else 10)
    fields = model.fields(last.state.x)
    mesh = model.series_mesh()
    series = VtkHdfSeries.create(tmp_path / "results.vtkhdf", mesh.reference, mesh.cells)
    series.append(0.0, last.state.x, point_data=fields.point_data, cell_data=fields.cell_data)
    _, cells = read_mesh(tmp_path / "results.vtkhdf")
    np.testing.assert_array_equal(cells, rod.mesh.cells)
    assert len(read_frame(tmp_path / "results.vtkhdf").cell_data["tension"]) == len(rod.mesh.hexes)
    assert model.end_nodes(0, "end").weights.min() > 0.0


def test_five_quadrilaterals_are_for_quadratic_elements_only():
    linear, quadratic = solid("hex8", 5), solid("hex27", 5)
    assert [len(model.body.rods[0].mesh.section.quads) for model in (linear, quadratic)] == [4, 5]
    assert linear.warnings == [
        "rod: mesh.section_elements: asked for 5 quadrilaterals, made 4, the nearest that mesh a disc well"
    ]
    assert not quadratic.warnings


def test_linear_and_quadratic_elements_do_not_go_together():
    scene = load_scene("crossed-rods", ["rods.1.mesh.element=hex27", "rods.1.mesh.section_elements=12"])
    with pytest.raises(InputError, match=r"rods\.1\.mesh\.element: linear and quadratic.*found hex27"):
        SolidModel(scene)
