import time
from collections.abc import Callable

import numpy as np
import pytest
from curve_fixtures import arc, helix
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.geometry.frames import (
    material_frames,
    rotate_frames,
    rotation_minimising_frame,
    tangents,
    twist_of,
)

Array = NDArray[np.float64]


def test_tangents_of_a_circle_are_exact() -> None:
    a = np.linspace(0.0, 2.0, 12)
    assert tangents(arc(12, 2.0)) == pytest.approx(np.column_stack([-np.sin(a), np.cos(a), 0 * a]), abs=1e-14)


def test_tangents_refuse_a_fold() -> None:
    with pytest.raises(InputError, match="folds back at point 2"):
        tangents([[0, 0, 0], [1, 0, 0], [0, 0, 0]])


def test_straight_rod_has_the_section_axes() -> None:
    frames = rotation_minimising_frame(np.outer(np.arange(4.0), [0, 0, 1]))
    assert frames == pytest.approx(np.broadcast_to(np.eye(3), (4, 3, 3)))
    assert rotation_minimising_frame([[0, 0, 0], [0, 0, 1]]).shape == (2, 3, 3)


def test_frames_are_right_handed_and_orthonormal(shipped: Callable[[str], Array]) -> None:
    x = shipped("bowline")
    frames = rotation_minimising_frame(x)
    assert frames @ frames.transpose(0, 2, 1) == pytest.approx(np.broadcast_to(np.eye(3), frames.shape), abs=1e-12)
    assert np.linalg.det(frames) == pytest.approx(np.ones(len(x)))
    assert frames[:, 2] == pytest.approx(tangents(x))


def test_plane_curve_keeps_its_normal() -> None:
    frames = rotation_minimising_frame(arc(30, 5.0), start=[0, 0, 1])
    assert frames[:, 0] == pytest.approx(np.broadcast_to([0.0, 0, 1], (30, 3)), abs=1e-13)


def test_helix_frame_turns_back_by_its_torsion() -> None:
    nodes, turns, radius, pitch = 2001, 2.0, 3.0, 5.0
    x = helix(nodes, turns, radius, pitch)
    c = pitch / (2 * np.pi)
    speed = np.hypot(radius, c)
    frames = rotation_minimising_frame(x, start=[-1, 0, 0])
    a = 2 * np.pi * turns
    normal = np.array([-np.cos(a), -np.sin(a), 0.0])
    binormal = np.cross(frames[-1, 2], normal)
    torsion = c / speed**2
    expected = -torsion * speed * a
    angle = np.arctan2(frames[-1, 0] @ binormal, frames[-1, 0] @ normal)
    assert np.exp(1j * angle) == pytest.approx(np.exp(1j * expected), abs=1e-4)


def test_frame_moves_with_the_rod(shipped: Callable[[str], Array], rigid: Callable[[int], tuple[Array, Array]]) -> None:
    x, (rotation, shift) = shipped("surgeon"), rigid(4)
    start = np.array([0.3, 1.0, -0.2])
    frames = rotation_minimising_frame(x, start)
    moved = rotation_minimising_frame(x @ rotation.T + shift, rotation @ start)
    assert moved == pytest.approx(frames @ rotation.T, abs=1e-10)


def test_start_along_the_rod_is_refused() -> None:
    with pytest.raises(InputError, match="lies along the rod"):
        rotation_minimising_frame([[0, 0, 0], [0, 0, 1], [0, 0, 2]], start=[0, 0, 1])


def test_twist_put_in_is_read_back(shipped: Callable[[str], Array]) -> None:
    x = shipped("surgeon")
    frames = rotation_minimising_frame(x)
    angles = np.cumsum(np.random.default_rng(0).normal(scale=0.1, size=len(x)))
    turned = rotate_frames(frames, angles)
    assert twist_of(turned, x) == pytest.approx(np.diff(angles), abs=1e-10)
    assert twist_of(turned) == pytest.approx(np.diff(angles), abs=1e-3)
    assert turned[:, 2] == pytest.approx(frames[:, 2])


def test_quarter_turn_takes_d1_to_d2() -> None:
    frames = rotation_minimising_frame(arc(5, 1.0))
    turned = rotate_frames(frames, 0.5 * np.pi)
    assert turned[:, 0] == pytest.approx(frames[:, 1])
    assert turned[:, 1] == pytest.approx(-frames[:, 0])


def test_material_frames_project_the_directors(shipped: Callable[[str], Array]) -> None:
    x = shipped("surgeon")
    frames = rotation_minimising_frame(x)
    slanted = 3.0 * frames[:, 0] + np.linspace(-5.0, 5.0, len(x))[:, None] * frames[:, 2]
    assert material_frames(frames[:, 2], slanted) == pytest.approx(frames, abs=1e-12)


def test_material_frames_refuse_a_director_along_the_tangent() -> None:
    with pytest.raises(InputError, match="director 2 lies along the tangent"):
        material_frames([[0, 0, 1], [0, 0, 1]], [[1, 0, 0], [0, 0, -2]])


def test_twist_refuses_other_points() -> None:
    with pytest.raises(InputError, match="frames and points differ"):
        twist_of(rotation_minimising_frame(arc(5, 1.0)), arc(6, 1.0))


def test_is_fast(shipped: Callable[[str], Array]) -> None:
    x = shipped("bowline")
    rotation_minimising_frame(x)
    begin = time.perf_counter()
    rotation_minimising_frame(x)
    assert time.perf_counter() - begin < 0.2
