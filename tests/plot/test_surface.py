import numpy as np
import pytest

from knotfem.mesh.rod import RodMesh, extrude
from knotfem.mesh.section_file import read_section
from knotfem.plot.surface import Surface, boundary, on_nodes, smooth_tube


@pytest.fixture(scope="module")
def rod(pytestconfig) -> RodMesh:
    section = read_section(pytestconfig.rootpath / "meshes/sections/section_12.msh")
    return extrude(section, 3.0, 20.0, 10, match_bending=False)


def flux(surface: Surface) -> tuple[np.ndarray, float]:
    """Sum of area vectors, and enclosed volume by the divergence theorem over triangles."""
    a, b, c, d = (surface.points[surface.faces[:, i]] for i in range(4))
    vectors = 0.5 * (np.cross(b - a, c - a) + np.cross(c - a, d - a))
    volume = sum(np.einsum("fi,fi->", np.cross(p, q), r) for p, q, r in ((a, b, c), (a, c, d))) / 6
    return vectors.sum(axis=0), volume


def test_eight_facets_become_a_round_tube(rod):
    tube = smooth_tube(rod.nodes[rod.ring_nodes])
    side = tube.points[: -2 * 49]
    np.testing.assert_allclose(np.hypot(side[:, 0], side[:, 1]), 3.0, atol=1e-12)
    vectors, volume = flux(tube)
    np.testing.assert_allclose(vectors, 0.0, atol=1e-10)
    assert volume == pytest.approx(np.pi * 9 * 20, rel=5e-3)


def test_the_tube_passes_through_the_nodes(rod):
    bent = rod.nodes.copy()
    bent[:, 0] += 0.02 * bent[:, 2] ** 2
    tube = smooth_tube(bent[rod.ring_nodes])
    distance = np.linalg.norm(tube.points[None] - bent[rod.ring_nodes.ravel()][:, None], axis=-1).min(axis=1)
    np.testing.assert_allclose(distance, 0.0, atol=1e-12)


def test_values_on_the_tube_stay_within_the_given_ones_and_follow_the_height(rod):
    height = rod.nodes[rod.ring_nodes][..., 2]
    tube = smooth_tube(rod.nodes[rod.ring_nodes], height)
    assert tube.values is not None
    np.testing.assert_allclose(tube.values, tube.points[:, 2], atol=1e-12)
    spiky = np.random.default_rng(0).normal(size=height.shape)
    values = smooth_tube(rod.nodes[rod.ring_nodes], spiky).values
    assert values is not None
    assert values.min() == pytest.approx(spiky.min())
    assert values.max() == pytest.approx(spiky.max())


def test_boundary_is_the_outside_alone(rod):
    surface = boundary(rod.nodes, rod.hexes, rod.nodes[:, 2])
    assert len(surface.faces) == len(rod.surface)
    vectors, volume = flux(surface)
    np.testing.assert_allclose(vectors, 0.0, atol=1e-10)
    h = rod.nodes[rod.hexes]
    prisms = 0.5 * np.cross(h[:, 2] - h[:, 0], h[:, 3] - h[:, 1])[:, 2] * (h[:, 4, 2] - h[:, 0, 2])
    assert volume == pytest.approx(prisms.sum(), rel=1e-12)
    np.testing.assert_array_equal(surface.values, surface.points[:, 2])


def test_cell_values_are_averaged_to_nodes(rod):
    q = len(rod.section.quads)
    values = np.repeat(np.arange(10.0), q)
    nodal = on_nodes(rod.hexes, values, len(rod.nodes) + 1)
    np.testing.assert_allclose(nodal[rod.section_nodes[4]], 3.5)
    np.testing.assert_allclose(nodal[rod.section_nodes[0]], 0.0)
    assert nodal[-1] == 0.0
