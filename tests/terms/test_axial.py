import numpy as np
import pytest
from derivatives import directional_error, gradient_error, moments, residual, rotation, tangent

from knotfem.terms.axial import AxialStiffness

EA, H = 3826.0, 1.5


NODES = 8
WIDTHS = pytest.mark.parametrize("width", [3, 4])
"""Of a solid's core and of a discrete rod's stretch."""


def settle(core: AxialStiffness, x: np.ndarray) -> None:
    core.assemble(x, np.zeros_like(x), None)
    core.increment(np.zeros_like(x))
    core.advance(1.0)


def chain(merit_stiffness: float = 50.0) -> AxialStiffness:
    edges = np.stack([np.arange(NODES - 1), np.arange(1, NODES)], axis=1)
    count = np.ones(len(edges))
    return AxialStiffness("core", edges, H * count, EA * count, merit_stiffness * count)


def straight(width: int, stretch: float = 1.0) -> np.ndarray:
    x = np.zeros((NODES, width))
    x[:, 2] = stretch * H * np.arange(NODES)
    return x


def strained(width: int) -> tuple[AxialStiffness, np.ndarray]:
    core = chain()
    x = straight(width) + 0.1 * np.random.default_rng(0).standard_normal((NODES, width))
    settle(core, x)
    return core, x


def turned(x: np.ndarray, Q: np.ndarray, shift: float) -> np.ndarray:
    y = x.copy()
    y[:, :3] = x[:, :3] @ Q.T + shift
    return y


@WIDTHS
def test_tangent_is_the_derivative_of_the_residual(width):
    core, x = strained(width)
    assert directional_error([core], x) < 1e-8


@WIDTHS
def test_force_carried_along_enters_only_the_geometric_stiffness(width):
    core, x = strained(width)
    before, f = tangent([core], x), residual([core], x)
    core.force[:] += 2.0
    change = tangent([core], x) - before
    np.testing.assert_allclose(residual([core], x), f, atol=1e-12)
    edge = (x[1] - x[0])[:3]
    length = np.linalg.norm(edge)
    across = np.eye(3) - np.outer(edge, edge) / length**2
    np.testing.assert_allclose(change[:3, width : width + 3], -2.0 / length * across, atol=1e-9)


@WIDTHS
def test_upper_storage_equals_the_whole(width):
    core, x = strained(width)
    whole = tangent([core], x)
    np.testing.assert_allclose(whole, whole.T, atol=1e-12 * EA)
    np.testing.assert_allclose(tangent([core], x, upper=True), whole, atol=1e-12 * EA)


@WIDTHS
def test_forces_and_moments_balance(width):
    core, x = strained(width)
    f = residual([core], x)
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=1e-11)
    np.testing.assert_allclose(moments(x[:, :3], f[:, :3]), 0.0, atol=1e-10)


@WIDTHS
def test_frame_indifference(width):
    core, x = strained(width)
    Q = rotation()
    f = residual([core], x)
    np.testing.assert_allclose(residual([core], turned(x, Q, 3.0)), turned(f, Q, 0.0), atol=1e-9)


@WIDTHS
def test_energy_gradient_is_the_residual(width):
    core, x = strained(width)
    assert gradient_error(core.energy, residual([core], x), x, step=1e-6) < 1e-8


@WIDTHS
def test_uniform_stretch_has_the_closed_form(width):
    core, x = chain(), straight(width, 1.02)
    settle(core, x)
    np.testing.assert_allclose(core.force, 0.02 * EA)
    np.testing.assert_allclose(core.tension(x), 0.02 * EA)
    np.testing.assert_allclose(residual([core], x)[[0, -1], 2], [-0.02 * EA, 0.02 * EA])
    assert core.energy(x) == pytest.approx(0.5 * EA * 0.02**2 * H * (len(x) - 1))


@WIDTHS
def test_increment_solves_the_linearised_law(width):
    core, x = strained(width)
    core.force[:] += 5.0
    core.assemble(x, np.zeros_like(x), None)
    d = 1e-7 * np.random.default_rng(8).standard_normal(x.shape)
    core.increment(d)
    core.advance(1.0)
    np.testing.assert_allclose(core.force, EA * core.strain(x + d), atol=1e-8)


@WIDTHS
def test_sideways_move_of_a_straight_core_needs_no_force(width):
    core, x = chain(), straight(width)
    settle(core, x)
    core.assemble(x, np.zeros_like(x), None)
    d = np.zeros_like(x)
    d[3, 0] = 0.5
    core.increment(d)
    core.advance(1.0)
    np.testing.assert_allclose(core.force, 0.0, atol=1e-12)


@WIDTHS
def test_history_goes_round_to_the_bit(width):
    core, x = strained(width)
    history, kept = core.history(), core.force.tobytes()
    settle(core, 1.1 * x)
    assert core.force.tobytes() != kept
    core.load(history)
    assert core.force.tobytes() == kept
    core.load({})
    assert not core.force.any()


@WIDTHS
def test_history_is_a_copy(width):
    core, x = strained(width)
    history = core.history()
    kept = history["force"].copy()
    settle(core, 1.1 * x)
    np.testing.assert_array_equal(history["force"], kept)
    core.load(history)
    core.force[:] += 1.0
    np.testing.assert_array_equal(history["force"], kept)


@WIDTHS
def test_the_angle_of_a_discrete_rod_has_no_part_in_it(width):
    core, x = strained(width)
    before, matrix = residual([core], x), tangent([core], x)
    x[:, 3:] += 1.0
    np.testing.assert_array_equal(residual([core], x), before)
    assert not before[:, 3:].any()
    free = np.arange(x.size) % width >= 3
    assert not matrix[free].any()
    assert not matrix[:, free].any()


@WIDTHS
def test_slope_of_the_merit_is_the_force_that_the_iteration_will_carry(width):
    """The moderate stiffness of the merit comes on top of it."""
    core, x = strained(width)
    f = residual([core], x)
    core.increment(np.zeros_like(x))
    slopes = []
    for stiffness in (0.0, 50.0):
        core.merit_stiffness = np.full(NODES - 1, stiffness)
        d = np.random.default_rng(4).standard_normal(x.shape)
        slopes.append((core.merit(x + 1e-6 * d) - core.merit(x - 1e-6 * d)) / 2e-6)
    strain = 50.0 * core.strain(x)
    first, second = core.view.nodes.T
    opening = np.einsum("ki,ki->k", core.view.direction, d[second, :3] - d[first, :3])
    assert slopes[0] == pytest.approx(float(np.sum(f * d)), rel=1e-6)
    assert slopes[1] - slopes[0] == pytest.approx(float(strain @ opening), rel=1e-6)


def test_merit_stiffness_is_no_more_than_the_true_one():
    np.testing.assert_array_equal(chain(1e9).merit_stiffness, EA)
    np.testing.assert_array_equal(chain(50.0).merit_stiffness, 50.0)


@WIDTHS
def test_a_rest_strain_is_free_of_stress(width):
    core, x = chain(), straight(width, 1.02)
    core.view.rest[:] = 0.02
    settle(core, x)
    np.testing.assert_allclose(core.force, 0.0, atol=1e-10)
    np.testing.assert_allclose(residual([core], x), 0.0, atol=1e-10)
    assert core.energy(x) == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(core.tension(straight(width)), -0.02 * EA)
