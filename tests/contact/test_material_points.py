import numpy as np
import pytest
from reduced import rotation

from knotfem.contact import material_points as material
from knotfem.contact.curve import hinge_share
from knotfem.contact.tube import axial_basis
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
    w = np.empty((3, 3))
    first = axial_basis(u, NODES, w)
    share = hinge_share(u, first)
    V, L = material.workspace()
    material.material_frame(x, first, share, frames.material_arrays, angle, V, L)
    S, G = np.empty(3), np.empty((3, 12))
    material.material_point(x, first, w[0], radial, axial, V, S)
    material.material_gradient(first, share, w[0], frames.per_radius, radial, axial, V, L, G)
    return S, G, first, share, V, L


@pytest.mark.parametrize("u", PLACES)
def test_gradient_and_second_derivatives(bent, u):
    frames, x = bent
    tau, args, step = np.array([0.3, -1.1, 0.7]), (u, 0.7, 2.5, 0.6), 1e-6
    _, G, first, share, V, L = point(frames, x, *args)
    H = np.empty((12, 12))
    material.material_curvature(first, share, frames.material_arrays, 2.5, 0.6, V, L, tau, H, np.empty((16, 3)))
    for k in range(12):
        ahead, behind = x.copy(), x.copy()
        ahead[first + k // 4, k % 4] += step
        behind[first + k // 4, k % 4] -= step
        a, b = point(frames, ahead, *args), point(frames, behind, *args)
        np.testing.assert_allclose(G[:, k], (a[0] - b[0]) / (2 * step), atol=1e-8)
        np.testing.assert_allclose(H[:, k], tau @ (a[1] - b[1]) / (2 * step), atol=1e-7)


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
    frames.director0 = frames.director0 @ Q.T
    frames.tangent0 = frames.tangent0 @ Q.T
    np.testing.assert_allclose(point(frames, turned, u, 0.7, 2.5, 0.6)[0], Q @ S + [1.0, 2.0, 3.0], atol=1e-12)


@pytest.mark.parametrize("u", PLACES)
def test_angle_of_a_direction_is_that_of_its_point(bent, u):
    frames, x = bent
    S, _, first, share, V, L = point(frames, x, u, 0.7, 2.5, 0.0)
    axis = point(frames, x, u, 0.7, 0.0, 0.0)[0]
    found = material.material_angle(x, first, share, frames.material_arrays, S - axis, V, L)
    assert found == pytest.approx(0.7, abs=1e-12)


def test_accepting_a_state_moves_nothing(bent):
    frames, x = bent
    before = [point(frames, x, u, 0.7, 2.5, 0.6)[0] for u in PLACES]
    frames.commit(x)
    for u, S in zip(PLACES, before, strict=True):
        np.testing.assert_allclose(point(frames, x, u, 0.7, 2.5, 0.6)[0], S, atol=1e-12)
