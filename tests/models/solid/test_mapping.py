"""The mapping of straight rods into the knot."""

import pytest

from knotfem.models.solid import mapping
from knotfem.models.solid.model import SolidModel
from knotfem.scene import load_scene
from knotfem.solver.nonlinear.newton import Newton

THIN = (
    "rods.1.diameter=3 mm", "rods.0.mesh.section_elements=4", "rods.1.mesh.section_elements=4", "tie.increments=2",
    "solver.threads=1",
)  # fmt: skip


def test_newton_goes_by_the_thinnest_rod_and_by_the_tolerances_of_a_step(monkeypatch):
    used = []

    solve = Newton.solve

    def noted(self, *arguments):
        used.append(self)
        return solve(self, *arguments)

    monkeypatch.setattr(Newton, "solve", noted)
    model = SolidModel(load_scene("crossed-rods", THIN))
    assert [increment.mapping_time for increment in model.mapping(model.paths(), "auto")] == [0.5, 1.0]
    tolerance = model.scene.solver.force_tolerance
    assert [newton.tolerance.node for newton in used] == pytest.approx([mapping.LOOSE, tolerance])
    assert [newton.tolerance.resultant for newton in used] == pytest.approx([10.0 * mapping.LOOSE, 10.0 * tolerance])
    assert {newton.largest_move for newton in used} == {0.75}
    assert {newton.max_iterations for newton in used} == {mapping.PATIENCE * model.scene.solver.max_iterations}
