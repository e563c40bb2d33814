import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from knotfem.errors import InputError
from knotfem.geometry import rotation as kernels
from knotfem.geometry.finite_rotation import (
    half_binormals,
    parallel_transport,
    rotate,
    rotation_vector,
    smallest_rotation,
)

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)
seeds = st.integers(0, 10_000)
angles = st.floats(-20.0, 20.0)


def units(seed: int, count: int) -> Array:
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def smooth_tangents(seed: int, count: int = 60) -> Array:
    """Unit tangents that turn by a few degrees from each to the next."""
    rng, s = np.random.default_rng(seed), np.linspace(0.0, 4.0, count)[:, None]
    t = 3.0 * X + sum(np.sin(s + rng.uniform(0.0, 6.0, 3)) * rng.normal(size=3) for _ in range(3))
    return t / np.linalg.norm(t, axis=1)[:, None]


def across(t: Array, seed: int = 0) -> Array:
    """A random unit vector perpendicular to t."""
    v = np.cross(t, np.random.default_rng([seed, 1]).normal(size=3))
    return v / np.linalg.norm(v)


def test_quarter_turn_is_right_handed() -> None:
    assert rotate(X, Z, 0.5 * np.pi) == pytest.approx(Y)
    assert rotate([X, Y, Z], [0.0, 0.0, 7.0], 0.5 * np.pi) == pytest.approx(np.array([Y, -X, Z]))


@settings(deadline=None)
@given(seeds, angles)
def test_rotate_is_rodrigues_formula(seed: int, angle: float) -> None:
    axis, v = units(seed, 2)
    v = 3.0 * v
    expected = np.cos(angle) * v + np.sin(angle) * np.cross(axis, v) + (1.0 - np.cos(angle)) * (axis @ v) * axis
    np.testing.assert_allclose(rotate(v, 5.0 * axis, angle), expected, atol=1e-14)


@settings(deadline=None)
@given(seeds, angles, angles)
def test_rotations_about_one_axis_add_up(seed: int, first: float, second: float) -> None:
    axis, v = units(seed, 2)
    np.testing.assert_allclose(
        rotate(rotate(v, axis, first), axis, second), rotate(v, axis, first + second), atol=1e-13
    )


@settings(deadline=None)
@given(seeds, angles)
def test_rotate_keeps_lengths_angles_and_handedness(seed: int, angle: float) -> None:
    axis, *rest = units(seed, 4)
    v = np.array(rest)
    w = rotate(v, axis, angle)
    np.testing.assert_allclose(w @ w.T, v @ v.T, atol=1e-14)
    assert np.linalg.det(w) == pytest.approx(np.linalg.det(v), abs=1e-14)
    np.testing.assert_allclose(w @ axis, v @ axis, atol=1e-14)


def test_rotate_broadcasts() -> None:
    v, axes, turns = units(1, 5), units(2, 5), np.linspace(-3.0, 3.0, 5)
    single = np.array([rotate(a, b, c) for a, b, c in zip(v, axes, turns, strict=True)])
    np.testing.assert_allclose(rotate(v, axes, turns), single, atol=1e-14)
    np.testing.assert_allclose(rotate(v[0], axes[0], turns), [rotate(v[0], axes[0], c) for c in turns], atol=1e-14)
    np.testing.assert_allclose(
        rotate(v, axes, 0.3), [rotate(a, b, 0.3) for a, b in zip(v, axes, strict=True)], atol=1e-14
    )
    around = rotate(v[:, None], axes[:, None], turns)
    assert around.shape == (5, 5, 3)
    np.testing.assert_allclose(around[2], rotate(v[2], axes[2], turns), atol=1e-14)


@pytest.mark.parametrize("axis", [[0.0, 0.0, 0.0], [np.nan, 0.0, 1.0]])
def test_rotate_refuses_an_axis_without_direction(axis: list[float]) -> None:
    with pytest.raises(InputError, match="not an axis of rotation"):
        rotate(X, axis, 1.0)


@settings(deadline=None)
@given(seeds)
def test_smallest_rotation_takes_start_to_end_about_their_normal(seed: int) -> None:
    a, b = units(seed, 2)
    rotation, rounding = smallest_rotation(a, b), 1e-14 / float(np.linalg.norm(a + b))
    np.testing.assert_allclose(rotation.apply(a), b, atol=rounding)
    normal = np.cross(a, b)
    np.testing.assert_allclose(rotation.apply(normal), normal, atol=rounding)
    assert rotation.magnitude() == pytest.approx(np.arctan2(np.linalg.norm(normal), a @ b), abs=rounding)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-5, 1.0, 3.0, np.pi - 1e-4])
def test_smallest_rotation_is_accurate_for_any_angle(angle: float) -> None:
    b = np.cos(angle) * X + np.sin(angle) * Y
    assert smallest_rotation(X, b).as_rotvec() == pytest.approx(angle * Z, abs=1e-11, rel=1e-11)


def test_smallest_rotations_of_many_pairs() -> None:
    a, b = units(3, 6), units(4, 6)
    np.testing.assert_allclose(smallest_rotation(a, b).apply(a), b, atol=1e-14)


@settings(deadline=None)
@given(seeds)
def test_kernel_of_transport_is_the_smallest_rotation(seed: int) -> None:
    a, b = units(seed, 2)
    out = np.empty(3)
    kernels.transport(a, b, across(a, seed), out)
    np.testing.assert_allclose(out, smallest_rotation(a, b).apply(across(a, seed)), atol=1e-13 / (1.0 + a @ b))


@settings(deadline=None)
@given(seeds)
def test_transport_keeps_length_angle_and_the_normal_plane(seed: int) -> None:
    t = smooth_tangents(seed)
    first = parallel_transport(t, across(t[0], 1))
    second = parallel_transport(t, across(t[0], 2))
    np.testing.assert_allclose(np.linalg.norm(first, axis=1), 1.0, atol=1e-13)
    np.testing.assert_allclose(np.sum(first * t, axis=1), 0.0, atol=1e-13)
    np.testing.assert_allclose(np.sum(first * second, axis=1), first[0] @ second[0], atol=1e-13)


@settings(deadline=None)
@given(seeds)
def test_transport_is_the_product_of_the_smallest_rotations(seed: int) -> None:
    t = smooth_tangents(seed)
    start = across(t[0])
    whole = Rotation.identity()
    for rotation in smallest_rotation(t[:-1], t[1:]):
        whole = rotation * whole
    found = parallel_transport(t, start)
    assert np.array_equal(found[0], start)
    np.testing.assert_allclose(found[-1], whole.apply(start), atol=1e-13)


def test_transport_round_an_octant_turns_by_its_area() -> None:
    found = parallel_transport([X, Y, Z, X], Y)
    assert found == pytest.approx(np.array([Y, -X, -X, Z]))


@settings(deadline=None)
@given(seeds)
def test_half_binormals_are_those_of_the_kernel(seed: int) -> None:
    a, b = units(seed, 5), units(seed + 1, 5)
    k = np.empty((5, 3))
    for i in range(5):
        kernels.half_binormal(a[i], b[i], k[i])
    rounding = 1e-14 * (1.0 + np.abs(k)) / (1.0 + np.sum(a * b, axis=1))[:, None]
    assert (np.abs(half_binormals(a, b) - k) < rounding).all()
    size = np.tan(0.5 * smallest_rotation(a, b).magnitude())
    np.testing.assert_allclose(np.linalg.norm(k, axis=1), size, rtol=1e-9)


def test_opposite_directions_are_refused() -> None:
    nearly = np.array([-1.0, 1e-8, 0.0])
    with pytest.raises(InputError, match="opposite"):
        smallest_rotation(X, -X)
    with pytest.raises(InputError, match="opposite"):
        smallest_rotation([X, Y], [Y, -Y])
    with pytest.raises(InputError, match="opposite"):
        parallel_transport([Z, X, nearly], Y)
    with pytest.raises(InputError, match="opposite"):
        half_binormals([X, X], [Y, nearly])


def test_transport_refuses_a_director_that_is_not_perpendicular() -> None:
    with pytest.raises(InputError, match=r"not perpendicular to the first tangent; found 0\.1"):
        parallel_transport([X, Y], [0.1, 0.0, 1.0])
    with pytest.raises(InputError, match="not perpendicular"):
        parallel_transport([X, Y], [np.nan, 0.0, 1.0])


@settings(deadline=None)
@given(seeds, st.floats(0.0, 3.1))
def test_rotation_vector_is_axis_times_angle(seed: int, angle: float) -> None:
    axis, t = units(seed, 2)
    before = np.stack([across(t), np.cross(t, across(t)), t])
    after = rotate(before, axis, angle)
    np.testing.assert_allclose(rotation_vector(before, after), angle * axis, atol=1e-9)
    both = rotation_vector(np.stack([before, after]), np.stack([after, before]))
    np.testing.assert_allclose(both, [angle * axis, -angle * axis], atol=1e-9)


@settings(deadline=None)
@given(seeds, st.floats(-3.1, 3.1))
def test_kernel_of_the_angle_is_that_of_the_rotation(seed: int, angle: float) -> None:
    t = units(seed, 1)[0]
    u = across(t)
    assert kernels.angle_about(t, u, rotate(u, t, angle)) == pytest.approx(angle, abs=1e-14)
