import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.mesh.quadratic import five, quadratic
from knotfem.mesh.quality import report
from knotfem.mesh.rod import extrude
from knotfem.mesh.section import Section
from knotfem.mesh.section_file import read_section
from knotfem.mesh.section_properties import area, scale_for_bending, second_moments


@pytest.fixture(params=[4, 5, 12])
def section(request, pytestconfig) -> Section:
    if request.param == 5:
        return five()
    return quadratic(read_section(pytestconfig.rootpath / f"meshes/sections/section_{request.param}.msh"))


def test_boundary_nodes_stand_on_the_circle_at_equal_angles(section):
    angle = 2 * np.pi * np.arange(section.sides) / section.sides
    np.testing.assert_allclose(section.points[section.ring], np.column_stack([np.cos(angle), np.sin(angle)]), atol=1e-9)
    assert section.axis == 0
    assert not section.points[0].any()
    assert len(np.unique(section.quads)) == len(section.points)


def test_area_and_second_moments_are_nearly_the_circles(section):
    assert area(section) == pytest.approx(np.pi, rel=0.02)
    i_xx, i_yy, i_xy = second_moments(section)
    assert i_xx == pytest.approx(i_yy, rel=1e-9)
    assert i_xy == pytest.approx(0.0, abs=1e-9)
    scale = scale_for_bending(section)
    assert scale**4 * i_xx == pytest.approx(np.pi / 4)
    assert 1.0 < scale < 1.02


def test_rod_of_quadratic_hexahedra(section):
    rod = extrude(section, 3.0, 12.0, 6)
    m, q = len(section.points), len(section.quads)
    assert rod.layers.shape == (3, q, 27)
    np.testing.assert_array_equal(rod.layers[1, 0, 9:18], 3 * m + section.quads[0])
    np.testing.assert_array_equal(rod.cells[q, :8], rod.layers[1, 0, [0, 1, 2, 3, 18, 19, 20, 21]])
    assert rod.bricks.shape == (24 * q, 8)
    quality = report(rod)
    assert quality.hexes == 3 * q
    assert quality.min_scaled_jacobian > 0.0
    with pytest.raises(InputError, match="span two slices"):
        extrude(section, 3.0, 12.0, 5)


def test_vtk_finds_the_nodes_of_a_quadratic_hexahedron_where_it_expects_them():
    import pyvista

    rod = extrude(five(), 3.0, 4.0, 2)
    grid = pyvista.UnstructuredGrid(np.column_stack([[27] * 5, rod.cells]).ravel(), np.full(5, 29), rod.nodes)
    cell = grid.GetCell(0)
    reference = np.array([cell.GetParametricCoords()[i] for i in range(81)]).reshape(27, 3)
    X = rod.nodes[rod.cells[0]]
    np.testing.assert_allclose(X[:, 2], 4.0 * reference[:, 2], atol=1e-12)
    corners = X[:4, :2]
    u, v = reference[:, 0], reference[:, 1]
    bilinear = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1) @ corners
    np.testing.assert_allclose(X[:, :2], bilinear, atol=1e-12)
