import numpy as np
import pytest

from knotfem.mesh.make_section import section_of
from knotfem.mesh.section import Section
from knotfem.mesh.section_properties import area, scale_for_bending, second_moments


@pytest.mark.parametrize(("count", "factor"), [(4, 0.812), (12, 0.812), (44, 0.950), (48, 0.950), (104, 0.977)])
def test_bending_stiffness_of_the_facetted_disc(count, factor):
    section = section_of(count)
    i_xx, i_yy, i_xy = second_moments(section)
    assert i_xx / (np.pi / 4) == pytest.approx(factor, abs=5e-4)
    assert i_yy == pytest.approx(i_xx, rel=1e-14)
    assert i_xy == pytest.approx(0.0, abs=1e-14)
    assert i_xx * scale_for_bending(section) ** 4 == pytest.approx(np.pi / 4, rel=1e-14)


@pytest.mark.parametrize("count", [12, 44])
def test_moments_agree_with_quadrature_over_the_quadrilaterals(count):
    from skfem import CellBasis, ElementQuad1, MeshQuad

    section = section_of(count)
    basis = CellBasis(MeshQuad(section.points.T.copy(), section.quads.T.copy()), ElementQuad1(), intorder=4)
    x, y = basis.global_coordinates()
    assert area(section) == pytest.approx(basis.dx.sum(), rel=1e-13)
    i_xx, i_yy, i_xy = second_moments(section)
    assert i_xx == pytest.approx((y**2 * basis.dx).sum(), rel=1e-13)
    assert i_yy == pytest.approx((x**2 * basis.dx).sum(), rel=1e-13)
    assert i_xy == pytest.approx((x * y * basis.dx).sum(), abs=1e-13)


def test_moments_of_a_rectangle_shaped_ring():
    points = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 3.0]])
    rectangle = Section(points, np.array([[0, 1, 2, 3]]), 0, np.arange(4))
    assert area(rectangle) == pytest.approx(6.0)
    assert second_moments(rectangle) == pytest.approx((2 * 27 / 3, 3 * 8 / 3, 4 * 9 / 4))


def test_moments_of_a_rectangle_of_one_nine_node_quadrilateral():
    x, y = np.array([0, 2, 2, 0, 1, 2, 1, 0, 1.0]), np.array([0, 0, 3, 3, 0, 1.5, 3, 1.5, 1.5])
    rectangle = Section(np.column_stack([x, y]), np.arange(9)[None], 8, np.arange(8))
    assert area(rectangle) == pytest.approx(6.0, rel=1e-14)
    assert second_moments(rectangle) == pytest.approx((2 * 27 / 3, 3 * 8 / 3, 4 * 9 / 4), rel=1e-14)
