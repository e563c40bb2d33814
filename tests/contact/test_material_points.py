"""Material points of discrete rods."""

import numpy as np
import pytest
from derivatives import rotation

from knotfem.contact import material_points as material
from knotfem.contact.arms import arm_curvature, arm_gradient, arm_swing
from knotfem.contact.basis import axial_basis
from knotfem.contact.curve import between_middles
from knotfem.mesh.rod_layout import make_layout
from knotfem.models.rod.frames import Frames

NODES = 6
PLACES = (0.2, 1.3, 2.0, 2.5, 3.1, 4.9, 5.4)


@pytest.fixture
def bent():
    """Frames of a crooked rod, and a state some way off."""
    rng = np.random.default_rng(1)
    layout = make_layout([NODES - 1], [1.0], [3.0])
    x = np.zeros((NODES, 4))
    x[:, 0] = np.arange(NODES)
    x[:, :3] += 0.25 * rng.normal(size=(NODES, 3))
    frames = Frames(layout, x, rng.normal(size=(NODES, 3)))
    y = x + 0.2 * rng.normal(size=x.shape)
    y[:, 3] = rng.normal(size=NODES)
    return frames, y


def point(frames, x, u, angle, radial, axial):
    w, room, view = np.empty((3, 3)), material.material_room(), frames.material_view
    first = axial_basis(u, NODES, w)
    between = between_middles(u, first)
    material.material_frame(x, first, between, view, angle, room)
    S, G, arm = np.empty(3), np.empty((3, 12)), np.empty(3)
    material.material_point(x, first, w[0], radial, axial, room, S)
    material.material_arm(radial, axial, room, arm)
    arm_gradient(first, between, w[0], view, arm, room, G)
    return S, G, first, between, room


def force_on_arm(frames, x, u, arm, force):
    w, room, view, G = np.empty((3, 3)), material.material_room(), frames.material_view, np.empty((3, 12))
    first = axial_basis(u, NODES, w)
    material.material_frame(x, first, between_middles(u, first), view, 0.0, room)
    arm_gradient(first, between_middles(u, first), w[0], view, arm, room, G)
    return force @ G, first, room


@pytest.mark.parametrize("u", PLACES)
def test_gradient_is_the_motion_of_the_point(bent, u):
    frames, x = bent
    args, step = (u, 0.7, 2.5, 0.6), 1e-6
    _, G, first, _, _ = point(frames, x, *args)
    for k in range(12):
        ahead, behind = x.copy(), x.copy()
        ahead[first + k // 4, k % 4] += step
        behind[first + k // 4, k % 4] -= step
        a, b = point(frames, ahead, *args), point(frames, behind, *args)
        np.testing.assert_allclose(G[:, k], (a[0] - b[0]) / (2 * step), atol=1e-8)


@pytest.mark.parametrize("u", PLACES)
def test_derivatives_of_a_force_on_an_arm(bent, u):
    frames, x = bent
    force, arm, step = np.array([0.3, -1.1, 0.7]), np.array([0.4, 2.1, -1.3]), 1e-6
    _, first, room = force_on_arm(frames, x, u, arm, force)
    H, K, between = np.empty((12, 12)), np.empty((12, 3)), between_middles(u, first)
    arm_curvature(first, between, frames.material_view, arm, force, room, H)
    arm_swing(first, between, frames.material_view, force, room, K)
    for k in range(12):
        move = np.zeros_like(x)
        move[first + k // 4, k % 4] = step
        a, b = (force_on_arm(frames, x + sign * move, u, arm, force)[0] for sign in (1, -1))
        np.testing.assert_allclose(H[:, k], (a - b) / (2 * step), atol=1e-7)
    for k in range(3):
        move = step * np.eye(3)[k]
        a, b = (force_on_arm(frames, x, u, arm + sign * move, force)[0] for sign in (1, -1))
        np.testing.assert_allclose(K[:, k], (a - b) / (2 * step), atol=1e-7)


@pytest.mark.parametrize("u", [0.5, 1.5, 2.5, 3.5, 4.5])
def test_no_jump_from_segment_to_segment(bent, u):
    frames, x = bent
    before, after = (point(frames, x, u + side, 0.7, 2.5, 0.0)[0] for side in (-1e-9, 1e-9))
    np.testing.assert_allclose(before, after, atol=1e-7)


@pytest.mark.parametrize("u", PLACES)
def test_a_rigid_motion_carries_the_point(bent, u):
    frames, x = bent
    S = point(frames, x, u, 0.7, 2.5, 0.6)[0]
    Q = rotation()
    turned = x.copy()
    turned[:, :3] = x[:, :3] @ Q.T + [1.0, 2.0, 3.0]
    frames.commit(x)
    view = frames.view
    frames.view = view._replace(tangent=view.tangent @ Q.T, director=view.director @ Q.T)
    np.testing.assert_allclose(point(frames, turned, u, 0.7, 2.5, 0.6)[0], Q @ S + [1.0, 2.0, 3.0], atol=1e-12)


@pytest.mark.parametrize("u", PLACES)
def test_angle_of_a_direction_is_that_of_its_point(bent, u):
    frames, x = bent
    S, _, first, between, room = point(frames, x, u, 0.7, 2.5, 0.0)
    axis, found = point(frames, x, u, 0.7, 0.0, 0.0)[0], np.empty(3)
    material.material_coordinates(x, first, between, frames.material_view, S - axis, room, found)
    assert found == pytest.approx(np.array([0.7, 2.5, 0.0]), abs=1e-12)


def test_accepting_a_state_moves_nothing(bent):
    frames, x = bent
    before = [point(frames, x, u, 0.7, 2.5, 0.6)[0] for u in PLACES]
    frames.commit(x)
    for u, S in zip(PLACES, before, strict=True):
        np.testing.assert_allclose(point(frames, x, u, 0.7, 2.5, 0.6)[0], S, atol=1e-12)
