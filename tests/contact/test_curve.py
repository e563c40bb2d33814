"""The smooth centreline of a discrete rod, and samples on it."""

import numpy as np
import pytest
from reduced import line

from knotfem.contact.basis import axial_basis
from knotfem.contact.curve import CurveView, between_middles, curve_point, curve_room, make_samples, project
from knotfem.mesh.rod_layout import make_layout

LONE = CurveView(np.array([0, 9]), np.array([1.0]))
"""A rod of nine nodes."""


def at(x, u):
    w, C = np.empty((3, 3)), np.empty((3, 3))
    first = axial_basis(u, len(x), w)
    curve_point(x, first, w, C)
    return C


@pytest.fixture
def zigzag():
    return line(8, 16.0) + np.random.default_rng(2).normal(scale=0.4, size=(9, 3))


def test_passes_through_the_middles_of_edges_along_them(zigzag):
    for j in range(8):
        C = at(zigzag, j + 0.5)
        np.testing.assert_allclose(C[0], 0.5 * (zigzag[j] + zigzag[j + 1]), atol=1e-12)
        np.testing.assert_allclose(C[1], zigzag[j + 1] - zigzag[j], atol=1e-12)


def test_runs_a_constant_distance_inside_an_arc():
    h, R = 2.0, 6.0
    corner = h / (2 * np.sin(h / R / 2))
    phi = np.arange(12) * h / R
    x = corner * np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=1)
    radii = [np.linalg.norm(at(x, u)[0]) for u in np.linspace(1.0, 10.0, 91)]
    assert R - np.mean(radii) == pytest.approx(h * h / (12 * R), rel=0.02)
    assert np.ptp(radii) < 2e-4 * R


@pytest.mark.parametrize("u", [0.3, 2.0, 4.71, 7.9])
def test_projection_finds_the_point_below(zigzag, u):
    C = at(zigzag, u)
    across = np.cross(C[1], [0.3, 0.2, 1.0])
    p = C[0] + 0.2 * across / np.linalg.norm(across)
    room = curve_room()
    v, _, inside = project(zigzag, LONE, 0, p, u + 0.3, room)
    assert inside
    assert v == pytest.approx(u, abs=1e-9)
    assert np.linalg.norm(room.q) == pytest.approx(0.2, rel=1e-9)


def test_projection_refuses_points_far_beyond_the_ends(zigzag):
    assert not project(zigzag, LONE, 0, np.array([25.0, 0.0, 0.0]), 7.0, curve_room())[2]


def test_projection_refuses_the_far_side_of_a_bend():
    phi = np.arange(9) * 0.3
    x = np.stack([5 * np.cos(phi), 5 * np.sin(phi), 0 * phi], axis=1)
    room = curve_room()
    beyond = -3.0 * np.array([np.cos(1.2), np.sin(1.2), 0.0])
    _, _, inside = project(x, LONE, 0, beyond, 4.0, room)
    assert not inside or np.dot(room.q, room.C[2]) < np.dot(room.C[1], room.C[1])


def test_samples_cover_the_rods_evenly():
    layout = make_layout([5, 7], [2.0, 1.5], [3.0, 2.0])
    s = make_samples(layout, 0.75)
    for rod, length in ((0, 10.0), (1, 10.5)):
        assert s.view.measure[s.rod == rod].sum() == pytest.approx(length)
        steps = np.diff(s.u[s.rod == rod]) * layout.spacing[layout.first[rod]]
        assert steps.max() <= 0.75 + 1e-12
    x = np.concatenate([line(5, 10.0), line(7, 10.5)])
    np.testing.assert_allclose(s.places(x)[:, 0], s.u * layout.spacing[layout.first[s.rod]], atol=1e-12)


def test_interpolation_goes_from_one_edge_midpoint_to_the_next():
    assert [between_middles(u, 3) for u in (3.0, 3.5, 4.0, 4.5, 5.0)] == [0.0, 0.0, 0.5, 1.0, 1.0]
