import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.mesh.quality import report, to_skfem
from knotfem.mesh.rod import RodMesh, extrude
from knotfem.mesh.section_file import read_section
from knotfem.mesh.section_properties import area


@pytest.fixture(scope="module")
def rod(pytestconfig) -> RodMesh:
    return extrude(read_section(pytestconfig.rootpath / "meshes/sections/section_44.msh"), 3.0, 12.0, 12)


def test_the_papers_rod(rod):
    quality = report(rod)
    assert quality.hexes == 12 * 44
    assert quality.min_scaled_jacobian > 0.75
    assert 1.5 < quality.max_aspect_ratio < 2
    assert quality.smallest_edge == pytest.approx(3 * rod.node_scale * 0.19351, rel=1e-4)


def test_aspect_ratio_of_long_slices_is_their_length_over_the_shortest_edge(rod):
    quality = report(rod, rod.nodes * [1, 1, 20])
    assert quality.max_aspect_ratio == pytest.approx(20 / quality.smallest_edge, rel=1e-12)


def test_volume_is_the_polygon_times_the_length(rod):
    quality = report(rod)
    expected = area(rod.section) * (3 * rod.node_scale) ** 2 * 12
    assert quality.volume == pytest.approx(expected, rel=1e-13)
    assert quality.volume_ratio == pytest.approx(1.0, abs=1e-4)


def test_measures_do_not_depend_on_position_and_scale_as_they_must(rod):
    rotation = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    before, after = report(rod), report(rod, 2 * rod.nodes @ rotation.T + 5)
    assert after.min_scaled_jacobian == pytest.approx(before.min_scaled_jacobian, rel=1e-12)
    assert after.max_aspect_ratio == pytest.approx(before.max_aspect_ratio, rel=1e-12)
    assert after.smallest_edge == pytest.approx(2 * before.smallest_edge, rel=1e-12)
    assert after.volume == pytest.approx(8 * before.volume, rel=1e-12)


def test_sheared_brick_corner_has_the_cosine_of_the_shear_angle(rod):
    straight = report(rod).min_scaled_jacobian
    sheared = rod.nodes.copy()
    sheared[:, 0] += sheared[:, 2] * np.tan(np.pi / 3)
    assert report(rod, sheared).min_scaled_jacobian < 0.6 * straight
    assert report(rod, sheared).volume == pytest.approx(report(rod).volume, rel=1e-12)


def test_an_inverted_element_shows(rod):
    bad = rod.nodes.copy()
    bad[rod.hexes[7, 0]] = 2 * bad[rod.hexes[7, 6]] - bad[rod.hexes[7, 0]]
    assert report(rod, bad).min_scaled_jacobian < 0


def test_skfem_sees_the_same_corners(rod):
    mesh = to_skfem(rod)
    assert set(mesh.t[:, 5]) == set(rod.hexes[5])
    assert mesh.mapping().detDF(np.full((3, 1), 0.5)).min() > 0


def test_positions_that_do_not_fit_are_refused(rod):
    with pytest.raises(InputError, match="do not fit"):
        report(rod, rod.nodes[:-1])
    with pytest.raises(InputError, match="not finite"):
        report(rod, np.full_like(rod.nodes, np.nan))
