import numpy as np
import pytest
from specimens import make_rod, surfaces

from knotfem.contact.tube import project, spline_radius, stencil, surface_point, tube_room


def surface(x, tubes, rod, u, v):
    room = tube_room()
    stencil(tubes.view, rod, u, v, room.nodes, room.W)
    surface_point(x, room.nodes, room.W, room.S)
    return room.S, room.W, room.nodes


@pytest.fixture(params=[12, 20, 44])
def tube(request):
    rod = make_rod(20.0, 10, section=request.param)
    tubes, samples = surfaces([rod], 0.75)
    return rod, tubes, samples


def test_surface_is_the_physical_cylinder(tube):
    rod, tubes, _ = tube
    sides = rod.mesh.section.sides
    ripple = 0.5 * abs(0.75 + 0.25 * np.cos(2 * np.pi / sides) - np.cos(np.pi / sides)) / spline_radius(sides)
    for u in (0.0, 0.3, 1.0, 4.7, 9.6, 10.0):
        for v in np.linspace(0.0, sides, 37):
            point = surface(rod.mesh.nodes, tubes, 0, u, v)[0][0]
            assert point[2] == pytest.approx(2.0 * u, abs=1e-12)
            assert np.hypot(*point[:2]) == pytest.approx(3.0, rel=1.01 * ripple + 1e-12)
    assert ripple < (2e-3 if sides == 8 else 3e-4)


def test_derivatives_of_the_surface(tube):
    rod, tubes, _ = tube
    x = rod.mesh.nodes + 0.2 * np.random.default_rng(0).standard_normal(rod.mesh.nodes.shape)
    step = 1e-5
    for u, v in ((0.2, 1.3), (3.9, 0.1), (9.8, 5.7)):
        S = surface(x, tubes, 0, u, v)[0]
        along = [surface(x, tubes, 0, u + s * step, v)[0] for s in (1, -1)]
        around = [surface(x, tubes, 0, u, v + s * step)[0] for s in (1, -1)]
        for sides, of, to in ((along, 0, 1), (around, 0, 2), (along, 1, 3), (around, 1, 4), (around, 2, 5)):
            np.testing.assert_allclose((sides[0][of] - sides[1][of]) / (2 * step), S[to], atol=1e-8)


def test_surface_is_smooth_across_patches(tube):
    rod, tubes, _ = tube
    x = rod.mesh.nodes + 0.2 * np.random.default_rng(0).standard_normal(rod.mesh.nodes.shape)
    for before, after in (((4.5 - 1e-9, 1.2), (4.5 + 1e-9, 1.2)), ((4.1, 1.5 - 1e-9), (4.1, 1.5 + 1e-9))):
        a, b = surface(x, tubes, 0, *before)[0], surface(x, tubes, 0, *after)[0]
        np.testing.assert_allclose(a[:3], b[:3], atol=1e-7)
    sides = rod.mesh.section.sides
    np.testing.assert_allclose(surface(x, tubes, 0, 3.3, 0.2)[0], surface(x, tubes, 0, 3.3, 0.2 + sides)[0], atol=1e-12)


def test_weights_sum_to_one_so_that_the_surface_follows_rigid_motions(tube):
    _, tubes, _ = tube
    for u, v in ((0.0, 0.0), (0.4, 2.2), (5.5, 3.5), (10.0, 7.9)):
        W = surface(np.zeros((2000, 3)), tubes, 0, u, v)[1]
        np.testing.assert_allclose(W.sum(axis=1), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], atol=1e-13)


def test_closest_point_is_perpendicular(tube):
    rod, tubes, _ = tube
    x = rod.mesh.nodes + 0.05 * np.random.default_rng(0).standard_normal(rod.mesh.nodes.shape)
    room = tube_room()
    for target in ([3.4, 0.5, 7.3], [-1.0, -2.6, 12.1], [0.5, 3.9, 0.4]):
        p = np.array(target)
        guess = np.arctan2(p[1], p[0]) / (2 * np.pi) * rod.mesh.section.sides
        *_, found = project(x, tubes.view, 0, p, p[2] / 2.0, guess, room)
        assert found
        np.testing.assert_allclose(room.q, p - room.S[0], atol=1e-13)
        assert abs(room.q @ room.S[1]) < 1e-10
        assert abs(room.q @ room.S[2]) < 1e-10


def test_no_closest_point_far_beyond_an_end(tube):
    rod, tubes, _ = tube
    *_, found = project(rod.mesh.nodes, tubes.view, 0, np.array([3.2, 0.0, 26.0]), 9.5, 0.0, tube_room())
    assert not found


def test_samples_cover_the_surface_no_further_apart_than_asked(tube):
    rod, _, samples = tube
    points, around = samples.places(rod.mesh.nodes), samples.view.at[:, 1]
    assert samples.view.measure.sum() == pytest.approx(2 * np.pi * 3.0 * 20.0, rel=1e-12)
    np.testing.assert_allclose(points[:, 2], 2.0 * samples.u, atol=1e-12)
    assert 2.0 * np.diff(np.unique(samples.u)).max() <= 0.75 + 1e-9
    assert 2 * np.pi * 3.0 / rod.mesh.section.sides * np.diff(np.unique(around)).max() <= 0.75 + 1e-9
    assert samples.start[0] == 0
    assert samples.start[-1] == samples.count == samples.u.size
    for section in range(11):
        inside = samples.u[samples.start[section] : samples.start[section + 1]]
        assert (np.abs(inside - section) <= 0.5 + 1e-12).all()


def test_a_closest_point_that_is_claimed_is_one(tube):
    """Also on a rod thrown about so that its surface folds, where Newton's method may go round and round."""
    rod, tubes, _ = tube
    rng = np.random.default_rng(3)
    room = tube_room()
    claimed = lost = 0
    for _ in range(40):
        x = rod.mesh.nodes + 0.8 * rng.standard_normal(rod.mesh.nodes.shape)
        for _ in range(40):
            p = np.array([*(4.0 * rng.standard_normal(2)), rng.uniform(2.0, 18.0)])
            u, v, found = project(x, tubes.view, 0, p, p[2] / 2.0, rng.uniform(0.0, 8.0), room)
            lost += not found
            if found:
                S = surface(x, tubes, 0, u, v)[0]
                assert np.abs((p - S[0]) @ S[1:3].T).max() < 1e-6
                claimed += 1
    assert claimed > 800
    assert lost > 0
