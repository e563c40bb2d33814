import numpy as np
import pytest
from derivatives import directional_error, gradient_error, moments, residual, rotation, tangent

from knotfem.models.solid.core import Core

EA, H = 3826.0, 1.5


def settle(core: Core, x: np.ndarray) -> None:
    core.assemble(x, np.zeros_like(x), None)
    core.increment(np.zeros_like(x))
    core.advance(1.0)


def strained() -> tuple[Core, np.ndarray]:
    count = 8
    core = Core(np.stack([np.arange(count - 1), np.arange(1, count)], axis=1), H, EA)
    x = np.zeros((count, 3))
    x[:, 2] = H * np.arange(count)
    x = x + 0.1 * np.random.default_rng(0).standard_normal(x.shape)
    settle(core, x)
    return core, x


def test_tangent_is_the_derivative_of_the_residual():
    core, x = strained()
    assert directional_error([core], x) < 1e-8


def test_force_carried_along_enters_only_the_geometric_stiffness():
    core, x = strained()
    before, f = tangent([core], x), residual([core], x)
    core.force += 2.0
    change = tangent([core], x) - before
    np.testing.assert_allclose(residual([core], x), f, atol=1e-12)
    edge = x[1] - x[0]
    length = np.linalg.norm(edge)
    across = np.eye(3) - np.outer(edge, edge) / length**2
    np.testing.assert_allclose(change[:3, 3:6], -2.0 / length * across, atol=1e-9)


def test_upper_storage_equals_the_whole():
    core, x = strained()
    whole = tangent([core], x)
    np.testing.assert_allclose(whole, whole.T, atol=1e-12 * EA)
    np.testing.assert_allclose(tangent([core], x, upper=True), whole, atol=1e-12 * EA)


def test_forces_and_moments_balance():
    core, x = strained()
    f = residual([core], x)
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=1e-11)
    np.testing.assert_allclose(moments(x, f), 0.0, atol=1e-10)


def test_frame_indifference():
    core, x = strained()
    Q = rotation()
    f = residual([core], x)
    np.testing.assert_allclose(residual([core], x @ Q.T + 3.0), f @ Q.T, atol=1e-9)


def test_energy_gradient_is_the_residual():
    core, x = strained()
    assert gradient_error(core.energy, residual([core], x), x, step=1e-6) < 1e-8


def test_uniform_stretch_has_the_closed_form():
    core, x = strained()
    x = np.zeros_like(x)
    x[:, 2] = 1.02 * H * np.arange(len(x))
    settle(core, x)
    np.testing.assert_allclose(core.force, 0.02 * EA)
    np.testing.assert_allclose(residual([core], x)[[0, -1], 2], [-0.02 * EA, 0.02 * EA])
    assert core.energy(x) == pytest.approx(0.5 * EA * 0.02**2 * H * (len(x) - 1))


def test_increment_solves_the_linearised_law():
    core, x = strained()
    core.force += 5.0
    core.assemble(x, np.zeros_like(x), None)
    d = 1e-7 * np.random.default_rng(8).standard_normal(x.shape)
    core.increment(d)
    core.advance(1.0)
    np.testing.assert_allclose(core.force, EA * core.strain(x + d), atol=1e-8)


def test_sideways_move_of_a_straight_core_needs_no_force():
    core, x = strained()
    x = np.zeros_like(x)
    x[:, 2] = H * np.arange(len(x))
    settle(core, x)
    core.assemble(x, np.zeros_like(x), None)
    d = np.zeros_like(x)
    d[3, 0] = 0.5
    core.increment(d)
    core.advance(1.0)
    np.testing.assert_allclose(core.force, 0.0, atol=1e-12)


def test_memory_goes_round_to_the_bit():
    core, x = strained()
    history, kept = core.history(), core.force.tobytes()
    settle(core, 1.1 * x)
    assert core.force.tobytes() != kept
    core.load(history)
    assert core.force.tobytes() == kept
