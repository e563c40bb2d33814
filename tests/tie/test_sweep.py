import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.tie import frame_curvature, make_path, swept_state

GAUSS = np.array([-1.0, 1.0]) / np.sqrt(3.0)
CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


def minimising_frames(points: np.ndarray) -> np.ndarray:
    """Rows d1, d2, t: vertex tangents halve the angle between edges, d1 carried on by double reflection."""
    edges = np.diff(points, axis=0)
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    tangents = np.zeros_like(points)
    tangents[1:-1] = edges[1:] + edges[:-1]
    tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-300)
    tangents[0] = 2.0 * (edges[0] @ tangents[1]) * edges[0] - tangents[1]
    tangents[-1] = 2.0 * (edges[-1] @ tangents[-2]) * edges[-1] - tangents[-2]
    frames = np.empty((len(points), 3, 3))
    across = np.linalg.svd(tangents[:1])[2][1]
    for i, tangent in enumerate(tangents):
        if i:
            step = points[i] - points[i - 1]
            across = across - 2.0 * (step @ across) / (step @ step) * step
            before = tangents[i - 1] - 2.0 * (step @ tangents[i - 1]) / (step @ step) * step
            turn = tangent - before
            if turn @ turn > 1e-28:
                across = across - 2.0 * (turn @ across) / (turn @ turn) * turn
        across = across - (across @ tangent) * tangent
        across /= np.linalg.norm(across)
        frames[i] = across, np.cross(tangent, across), tangent
    return frames


def turned(frames: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.einsum("ab,ibc->iac", np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]), frames)


def arc(kappa: float, edges: int, chord: float = 1.0) -> np.ndarray:
    angle = 2.0 * np.arcsin(0.5 * chord * kappa) * np.arange(edges + 1)
    return np.stack([(np.cos(angle) - 1.0) / kappa, 0.0 * angle, np.sin(angle) / kappa], axis=1)


def disc(radius: float, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (m, 2) and quadrilaterals (cells^2, 4) of a square grid bent into a disc; node in the middle at 0."""
    side = np.linspace(-1.0, 1.0, cells + 1)
    u, v = (grid.ravel() for grid in np.meshgrid(side, side, indexing="ij"))
    nodes = radius * np.stack([u * np.sqrt(1.0 - v * v / 2.0), v * np.sqrt(1.0 - u * u / 2.0)], axis=1)
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    return nodes, first[:, None] + np.array([0, cells + 1, cells + 2, 1])


def deformation(swept: np.ndarray, section: np.ndarray, quads: np.ndarray, chord: float):
    """Deformation gradients at the 8 Gauss points of every hexahedron, and their reference weights."""
    axis = chord * np.arange(len(swept))
    straight = np.empty_like(swept)
    straight[:, :, :2] = section
    straight[:, :, 2] = axis[:, None]
    gradients, weights = [], []
    for xi in GAUSS:
        for eta in GAUSS:
            for zeta in GAUSS:
                n = 0.25 * (1.0 + xi * CORNERS[:, 0]) * (1.0 + eta * CORNERS[:, 1])
                dxi = 0.25 * CORNERS[:, 0] * (1.0 + eta * CORNERS[:, 1])
                deta = 0.25 * CORNERS[:, 1] * (1.0 + xi * CORNERS[:, 0])
                low, high = 0.5 * (1.0 - zeta), 0.5 * (1.0 + zeta)
                both = []
                for x in (straight, swept):
                    near, far = x[:-1][:, quads], x[1:][:, quads]
                    middle = low * near + high * far
                    both.append(np.stack([dxi @ middle, deta @ middle, 0.5 * (n @ far - n @ near)], axis=-1))
                gradients.append(both[1] @ np.linalg.inv(both[0]))
                weights.append(np.linalg.det(both[0]))
    return np.array(gradients), np.array(weights)


def volume_ratios(swept: np.ndarray, section: np.ndarray, quads: np.ndarray, chord: float) -> np.ndarray:
    """Mean J of every hexahedron."""
    gradients, weights = deformation(swept, section, quads, chord)
    return (np.linalg.det(gradients) * weights).sum(axis=0) / weights.sum(axis=0)


def arc_volume_error(kappa: float, poisson: float) -> float:
    """Largest |J - 1| of an arc with a section of radius 1, its bending plane askew to the frame."""
    points = arc(kappa, 12, chord=0.2)
    section, quads = disc(1.0, 16)
    swept = swept_state(points, turned(minimising_frames(points), 0.7), section, poisson)
    return np.abs(volume_ratios(swept, section, quads, 0.2) - 1.0).max()


def test_curvature_of_an_arc_is_exact_in_any_frame():
    points = arc(0.2, 20)
    frames = minimising_frames(points)
    for angle in (0.0, 1.1):
        components = frame_curvature(points, turned(frames, angle))
        np.testing.assert_allclose(np.linalg.norm(components, axis=1), 0.2, rtol=1e-12)
    inward = np.einsum("ik,ika->ia", components, turned(frames, 1.1)[:, :2])
    centre = np.array([-5.0, 0.0, 0.0])
    np.testing.assert_allclose(inward, 0.2 * (centre - points) / 5.0, atol=1e-12)


def test_axis_node_lies_exactly_on_the_centreline(bowline):
    section, _ = disc(3.0, 6)
    swept = swept_state(bowline, minimising_frames(bowline), section)
    axis = int(np.linalg.norm(section, axis=1).argmin())
    assert swept.shape == (601, len(section), 3)
    assert np.array_equal(swept[:, axis], bowline)


def test_rigid_carrying_without_poisson_effect(bowline):
    frames = minimising_frames(bowline)
    swept = swept_state(bowline, frames, np.array([[2.0, -1.0]]), poisson=0.0)
    np.testing.assert_allclose(swept[:, 0], bowline + 2.0 * frames[:, 0] - frames[:, 1], atol=1e-12)


def test_correction_leaves_only_second_order_volume_change():
    """To second order J - 1 = -k^2 (x^2 - y^2 / 2) with x in the plane of bending: k^2 r^2 at most."""
    raw = [arc_volume_error(kappa, 0.0) for kappa in (0.1, 0.2)]
    corrected = [arc_volume_error(kappa, 0.5) for kappa in (0.05, 0.1, 0.2)]
    assert raw == pytest.approx([0.1, 0.2], rel=0.05)
    assert corrected == pytest.approx([0.05**2, 0.1**2, 0.2**2], rel=0.1)
    assert corrected[2] / corrected[1] == pytest.approx(4.0, rel=0.1)
    assert corrected[1] / corrected[0] == pytest.approx(4.0, rel=0.1)


def test_bowline_keeps_its_volume(bowline):
    section, quads = disc(3.0, 6)
    frames = minimising_frames(bowline)
    worst = {}
    for poisson in (0.0, 0.5):
        swept = swept_state(bowline, frames, section, poisson)
        worst[poisson] = np.abs(volume_ratios(swept, section, quads, 1.0) - 1.0).max()
    steepest = 3.0 * np.linalg.norm(frame_curvature(bowline, frames), axis=1).max()
    assert worst[0.0] > 0.7 * steepest
    assert worst[0.5] < steepest**2


def test_bending_energy_is_that_of_the_incompressible_rod():
    """Neo-Hookean, mu = 1, with mean dilatation: E I kappa^2 / 2 a length with E = 3 mu; far more with wrong signs."""
    section, quads = disc(1.0, 16)
    kappa, chord, edges = 0.005, 0.2, 10
    points = arc(kappa, edges, chord)
    frames = turned(minimising_frames(points), 0.4)

    def energy(curvature: np.ndarray, poisson: float) -> float:
        swept = swept_state(points, frames, section, poisson, curvature)
        gradients, weights = deformation(swept, section, quads, chord)
        j = np.linalg.det(gradients)
        invariant = np.einsum("...ij,...ij->...", gradients, gradients) * j ** (-2.0 / 3.0)
        theta = volume_ratios(swept, section, quads, chord)
        return float(((0.5 * (invariant - 3.0) + 50.0 * (theta - 1.0) ** 2) * weights).sum())

    corners = section[quads]
    following = np.roll(corners, -1, axis=1)
    cross = corners[..., 0] * following[..., 1] - corners[..., 1] * following[..., 0]
    square = (corners**2 + corners * following + following**2).sum(axis=2)
    second_moment = (cross * square).sum() / 24.0
    expected = 0.5 * 3.0 * second_moment * kappa**2 * chord * edges
    k = frame_curvature(points, frames)
    right = energy(k, 0.5)
    assert right == pytest.approx(expected, rel=0.02)
    assert energy(k, 0.0) > 10.0 * right
    for wrong in (-k, k * [1.0, -1.0], k * [-1.0, 1.0], k[:, ::-1]):
        assert energy(wrong, 0.5) > 2.0 * right


def test_turning_frame_and_section_together_changes_nothing(bowline):
    frames = minimising_frames(bowline)
    section, _ = disc(3.0, 4)
    c, s = np.cos(0.9), np.sin(0.9)
    opposite = section @ np.array([[c, -s], [s, c]])
    np.testing.assert_allclose(
        swept_state(bowline, turned(frames, 0.9), opposite), swept_state(bowline, frames, section), atol=1e-12
    )


def test_rigid_motion_and_mirror_carry_the_sweep_along(bowline, rotation):
    frames = minimising_frames(bowline)
    section, _ = disc(3.0, 4)
    here = swept_state(bowline, frames, section)
    moved = swept_state(bowline @ rotation.T + 9.0, frames @ rotation.T, section)
    np.testing.assert_allclose(moved, here @ rotation.T + 9.0, atol=1e-10)
    mirror = np.diag([1.0, 1.0, -1.0])
    reflected = frames @ mirror
    reflected[:, 1] *= -1.0
    mirrored = swept_state(bowline @ mirror, reflected, section * [1.0, -1.0])
    np.testing.assert_allclose(mirrored, here @ mirror, atol=1e-10)


def test_stretched_rod_thins():
    points = 1.44 * np.arange(6)[:, None] * np.array([0.0, 0.0, 1.0])
    section, quads = disc(2.0, 4)
    swept = swept_state(points, np.tile(np.eye(3), (6, 1, 1)), section, stretch=np.full(5, 1.44))
    np.testing.assert_allclose(swept[:, :, :2], np.broadcast_to(section / 1.2, (6, len(section), 2)), rtol=1e-12)
    gradients, _ = deformation(swept, section, quads, 1.0)
    np.testing.assert_allclose(np.linalg.det(gradients), 1.0, rtol=1e-12)


def test_half_tied_knot_keeps_its_volume_when_told_its_stretch(overhand):
    path = make_path("polynomial", overhand)
    points = path.at(0.5)
    section, quads = disc(0.5, 4)
    frames = minimising_frames(points)
    worst = []
    for stretch in (None, path.stretch(0.5)):
        swept = swept_state(points, frames, section, stretch=stretch)
        worst.append(np.abs(volume_ratios(swept, section, quads, 1.0) - 1.0).max())
    assert worst[1] < 0.25 * worst[0]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"points": np.zeros((4, 2))}, "target centreline"),
        ({"frames": np.zeros((3, 3, 3))}, "wrong shape of frames"),
        ({"frames": np.tile(-np.eye(3), (4, 1, 1))}, "right-handed"),
        ({"frames": np.tile(1.1 * np.eye(3), (4, 1, 1))}, "right-handed"),
        ({"section_points": np.zeros((5, 3))}, "section_points"),
        ({"section_points": [[np.nan, 0.0]]}, "not finite"),
        ({"poisson": 0.6}, "Poisson"),
        ({"curvature": np.zeros((4, 3))}, "curvature"),
        ({"curvature": np.full((4, 2), 1.2)}, "cut each other"),
        ({"stretch": [1.0, 0.0, 1.0]}, "not positive"),
        ({"stretch": np.ones(4)}, "wrong shape of stretch"),
    ],
)
def test_wrong_input_is_refused(arguments, says):
    good = {
        "points": np.arange(4)[:, None] * np.array([0.0, 0.0, 1.0]),
        "frames": np.tile(np.eye(3), (4, 1, 1)),
        "section_points": np.array([[0.0, 0.0], [1.0, 0.0]]),
    }
    with pytest.raises(InputError, match=says):
        swept_state(**(good | arguments))
