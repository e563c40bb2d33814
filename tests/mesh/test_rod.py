import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem.errors import InputError
from knotfem.mesh.rod import RodMesh, extrude
from knotfem.mesh.section import Section
from knotfem.mesh.section_file import read_section


@pytest.fixture(scope="module")
def section(pytestconfig) -> Section:
    return read_section(pytestconfig.rootpath / "meshes/sections/section_44.msh")


@pytest.fixture
def rod(section) -> RodMesh:
    return extrude(section, radius=3.0, length=10.0, slices=5)


def test_numbering_is_that_of_the_architecture(rod, section):
    m, q = len(section.points), len(section.quads)
    assert rod.nodes.shape == (6 * m, 3)
    assert rod.hexes.shape == (5 * q, 8)
    assert rod.section_nodes[4, 7] == 4 * m + 7
    np.testing.assert_array_equal(rod.hexes[3 * q + 11, :4], 3 * m + section.quads[11])
    np.testing.assert_array_equal(rod.hexes[3 * q + 11, 4:], 4 * m + section.quads[11])
    np.testing.assert_array_equal(rod.core[2], [2 * m + section.axis, 3 * m + section.axis])
    np.testing.assert_array_equal(rod.axis_nodes, np.arange(6) * m + section.axis)
    np.testing.assert_array_equal(rod.ring_nodes[5], 5 * m + section.ring)


def test_the_rod_stands_along_z_with_its_axis_on_the_line(rod):
    np.testing.assert_array_equal(rod.nodes[rod.axis_nodes, :2], 0.0)
    np.testing.assert_allclose(rod.nodes[rod.axis_nodes, 2], [0, 2, 4, 6, 8, 10])
    assert rod.length == 10.0
    assert rod.element_length == 2.0


def test_ring_starts_at_d1_and_turns_towards_d2(rod):
    ring = rod.nodes[rod.ring_nodes[0]]
    assert ring[0, 1] == 0.0
    assert ring[0, 0] > 0
    np.testing.assert_allclose(np.arctan2(ring[4, 1], ring[4, 0]), np.pi / 2)


def test_boundary_is_moved_out_for_bending_only_when_asked(section):
    radius = [np.hypot(*(m := extrude(section, 3.0, 2.0, 1, match_bending=on)).nodes[m.ring_nodes[0], :2].T)
              for on in (True, False)]  # fmt: skip
    np.testing.assert_allclose(radius[0], 3.0 * (1 / 0.94977) ** 0.25, rtol=1e-6)
    np.testing.assert_allclose(radius[1], 3.0, rtol=1e-14)


@given(radius=st.floats(0.1, 50), length=st.floats(0.5, 1e3), slices=st.integers(1, 9), match=st.booleans())
@settings(max_examples=25, deadline=None)
def test_surface_is_closed_and_encloses_the_hexahedra(section, radius, length, slices, match):
    rod = extrude(section, radius, length, slices, match_bending=match)
    a, b, c, d = (rod.nodes[rod.surface[:, i]] for i in range(4))
    normal = 0.5 * np.cross(c - a, d - b)
    np.testing.assert_allclose(normal.sum(axis=0), 0.0, atol=1e-12 * np.abs(normal).sum())
    enclosed = np.einsum("fi,fi->", normal, (a + b + c + d) / 4) / 3
    h = rod.nodes[rod.hexes]
    prisms = 0.5 * np.cross(h[:, 2] - h[:, 0], h[:, 3] - h[:, 1])[:, 2] * (h[:, 4, 2] - h[:, 0, 2])
    assert prisms.min() > 0
    assert enclosed == pytest.approx(prisms.sum(), rel=1e-11)


@pytest.mark.parametrize("change", [{"radius": 0.0}, {"radius": float("nan")}, {"length": -1.0}, {"slices": 0}])
def test_wrong_dimensions_are_refused_by_name(section, change):
    with pytest.raises(InputError, match=f"^{next(iter(change))}: "):
        extrude(section, **{"radius": 3.0, "length": 10.0, "slices": 5, **change})
