import numba
import numpy as np
import pytest
from derivatives import (
    assert_symmetric_storage,
    directional_error,
    gradient_error,
    moments,
    residual,
    rotation,
    tangent,
)
from numba.core import config
from specimens import make_rod, moduli

from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.stress import stress_state
from knotfem.verify.benchmarks.solids import CORNERS, bricks

ELEMENTS = ["hex8", "hex8-reduced", "hex8-incompatible", "hex27"]


def settle(bulk: Elasticity, x: np.ndarray) -> None:
    """Give pressures and modes the values that belong to x."""
    for _ in range(8 if bulk.modes.size else 1):
        bulk.assemble(x, np.zeros_like(x), None)
        bulk.increment(np.zeros_like(x))
        bulk.advance(1.0)


def strained(element: str, poisson: float = 0.4999, amplitude: float = 0.08) -> tuple[Elasticity, np.ndarray]:
    rod = make_rod(6.0, 4, element=element, poisson=poisson)
    if element == "hex8-incompatible":
        poisson, amplitude = min(poisson, 0.495), 0.4 * amplitude
    F = np.eye(3) + 0.1 * np.random.default_rng(0).standard_normal((3, 3))
    x = rod.mesh.nodes @ F / np.cbrt(np.linalg.det(F))
    x = x + amplitude * np.random.default_rng(1).standard_normal(x.shape)
    settle(rod.bulk, x)
    return rod.bulk, x


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("poisson", [0.3, 0.4999])
def test_tangent_is_the_derivative_of_the_residual(element, poisson):
    bulk, x = strained(element, poisson)
    assert directional_error([bulk], x) < 1e-7


@pytest.mark.parametrize("element", ["hex8", "hex8-reduced"])
def test_pressure_enters_the_tangent_by_its_own_geometric_stiffness(element):
    bulk, x = strained(element)
    extra = np.random.default_rng(3).standard_normal(bulk.pressure.shape)
    before = tangent([bulk], x)
    bulk.pressure += extra
    change = tangent([bulk], x) - before

    def pressure_forces(y: np.ndarray) -> np.ndarray:
        F = bulk.deformation(y)
        cofactor = np.linalg.det(F)[..., None, None] * np.linalg.inv(F).swapaxes(-1, -2)
        w = bulk.formulation.weights
        nodal = np.einsum(
            "sqm,qgm,sqgik,qgak,qg->sqai", extra, bulk.formulation.psi, cofactor, bulk.formulation.grads, w
        )
        force = np.zeros_like(y)
        np.add.at(force, bulk.elements, nodal)
        return force

    d = np.random.default_rng(4).standard_normal(x.shape)
    expected = (pressure_forces(x + 1e-6 * d) - pressure_forces(x - 1e-6 * d)) / 2e-6
    found = (change @ d.ravel()).reshape(-1, 3)
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("element", ELEMENTS)
def test_residual_does_not_depend_on_the_pressure_carried_along(element):
    bulk, x = strained(element)
    before = residual([bulk], x)
    bulk.pressure += 1.0
    np.testing.assert_allclose(residual([bulk], x), before, atol=1e-13 * np.abs(before).max())


@pytest.mark.parametrize("element", ELEMENTS)
def test_pressure_increment_solves_the_linearised_constraint(element):
    bulk, x = strained(element)
    if not bulk.modes.size:
        bulk.pressure += 0.3
    bulk.assemble(x, np.zeros_like(x), None)
    d = 1e-6 * np.random.default_rng(8).standard_normal(x.shape)
    bulk.increment(d)
    bulk.advance(1.0)
    found = bulk.pressure.copy()
    settle(bulk, x + d)
    np.testing.assert_allclose(found, bulk.pressure, atol=1e-6 * np.abs(bulk.pressure).max())


@pytest.mark.parametrize("element", ELEMENTS)
def test_upper_storage_equals_the_whole(element):
    bulk, x = strained(element)
    assert_symmetric_storage([bulk], x, tolerance=1e-12)


def test_threads_change_no_bit():
    rod = make_rod(30.0, 41, section=44)
    x = rod.mesh.nodes + 0.05 * np.random.default_rng(1).standard_normal(rod.mesh.nodes.shape)
    results = []
    threads = numba.get_num_threads()
    try:
        for count in (1, vars(config)["NUMBA_NUM_THREADS"]):
            numba.set_num_threads(count)
            results.append([residual([rod.bulk], x) for _ in range(5)])
    finally:
        numba.set_num_threads(threads)
    for other in (*results[0], *results[1]):
        assert other.tobytes() == results[0][0].tobytes()


@pytest.mark.parametrize("element", ELEMENTS)
def test_forces_and_moments_balance(element):
    bulk, x = strained(element)
    f = residual([bulk], x)
    scale = np.abs(f).max()
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=1e-12 * scale)
    np.testing.assert_allclose(moments(x, f), 0.0, atol=1e-11 * scale)


@pytest.mark.parametrize("element", ELEMENTS)
def test_frame_indifference(element):
    bulk, x = strained(element)
    Q = rotation()
    f = residual([bulk], x)
    np.testing.assert_allclose(residual([bulk], x @ Q.T + [30.0, -4.0, 9.0]), f @ Q.T, atol=1e-10 * np.abs(f).max())


@pytest.mark.parametrize("element", ELEMENTS)
def test_rigid_motion_is_free_of_force_and_energy(element):
    rod = make_rod(6.0, 4, element=element)
    bulk, x = rod.bulk, rod.mesh.nodes @ rotation().T + 5.0
    assert np.abs(residual([bulk], x)).max() < 1e-10
    settle(bulk, x)
    assert abs(bulk.energy(x)) < 1e-12


@pytest.mark.parametrize("element", ELEMENTS)
def test_energy_gradient_is_the_residual(element):
    bulk, x = strained(element)

    def energy(y: np.ndarray) -> float:
        settle(bulk, y)
        return bulk.energy(y)

    f = residual([bulk], x)
    assert gradient_error(energy, f, x) < 1e-7


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("poisson", [0.3, 0.4999])
def test_homogeneous_strain_has_the_closed_form_energy_and_stress(element, poisson):
    rod = make_rod(5.0, 4, element=element, poisson=poisson, youngs=1.4)
    bulk = rod.bulk
    G, kappa = moduli(1.4, poisson)
    F = np.eye(3) + 0.15 * np.random.default_rng(2).standard_normal((3, 3))
    x = rod.mesh.nodes @ F.T
    settle(bulk, x)
    J = np.linalg.det(F)
    volume = len(bulk.elements) * bulk.formulation.weights.sum()
    density = 0.5 * G * (J ** (-2 / 3) * np.sum(F * F) - 3.0) + 0.5 * kappa * (J - 1.0) ** 2
    assert bulk.energy(x) == pytest.approx(volume * density, rel=1e-12)
    b = F @ F.T
    cauchy = G * J ** (-5 / 3) * (b - np.trace(b) / 3 * np.eye(3)) + kappa * (J - 1.0) * np.eye(3)
    state = stress_state(x, bulk)
    np.testing.assert_allclose(state.cauchy, np.broadcast_to(cauchy, state.cauchy.shape), rtol=1e-9, atol=1e-9)
    largest = 0.5 * np.log(np.linalg.eigvalsh(F.T @ F)[-1])
    np.testing.assert_allclose(state.largest_principal_strain, largest, rtol=1e-12)
    assert bulk.smallest_j == pytest.approx(J)


@pytest.mark.parametrize("element", ELEMENTS)
def test_stresses_at_the_integration_points_make_the_nodal_forces(element):
    bulk, x = strained(element)
    state = stress_state(x, bulk)
    nodal = bulk.nodal_forces(x, state.first_piola * state.weights[..., None, None])
    force = np.zeros_like(x)
    np.add.at(force, bulk.elements, nodal)
    f = residual([bulk], x)
    np.testing.assert_allclose(force, f, atol=1e-11 * np.abs(f).max())


def test_elements_keep_their_volume_when_nearly_incompressible():
    bulk, x = strained("hex8", poisson=0.49999, amplitude=0.0)
    theta = 1.0 + bulk.pressure[..., 0] / moduli(1.25, 0.49999)[1]
    J = np.linalg.det(bulk.deformation(x))
    mean = np.einsum("sqg,qg->sq", J, bulk.formulation.weights) / bulk.formulation.weights.sum(axis=1)
    np.testing.assert_allclose(theta, mean, rtol=1e-12)


def test_merit_refuses_inverted_elements():
    rod = make_rod(6.0, 4)
    x = rod.mesh.nodes.copy()
    x[:, 2] *= -1.0
    assert rod.bulk.merit(x) == np.inf
    assert np.isfinite(rod.bulk.merit(rod.mesh.nodes))


def test_memory_goes_round_to_the_bit():
    bulk, x = strained("hex8")
    history = bulk.history()
    kept = bulk.pressure.tobytes()
    settle(bulk, 1.01 * x)
    assert bulk.pressure.tobytes() != kept
    bulk.load(history)
    assert bulk.pressure.tobytes() == kept
    bulk.pressure += 1.0
    bulk.load(history)
    assert bulk.pressure.tobytes() == kept


def test_memory_of_modes_goes_round_to_the_bit():
    bulk, x = strained("hex8-incompatible")
    history, kept = bulk.history(), bulk.modes.tobytes()
    settle(bulk, x @ np.diag([1.0, 1.01, 1.02]))
    assert bulk.modes.tobytes() != kept
    bulk.load(history)
    assert bulk.modes.tobytes() == kept
    bulk.load({})
    assert not bulk.modes.any()
    assert not bulk.pressure.any()


@pytest.mark.parametrize("poisson", [0.3, 0.4999])
@pytest.mark.parametrize("proportion", [1.0, 4.0])
def test_incompatible_modes_bend_a_brick_as_a_beam(poisson, proportion):
    X = 0.5 * CORNERS * [1.0, 1.0, proportion]
    x, y, z = X.T
    u = np.stack([0.5 * poisson * (x * x - y * y) + 0.5 * z * z, poisson * x * y, -x * z], axis=1).ravel()
    work = {}
    for incompatible in (False, True):
        bulk = bricks(X, np.arange(8)[None], *moduli(1.25, poisson), incompatible=incompatible)
        work[incompatible] = u @ tangent([bulk], X) @ u / (1.25 * proportion / 12.0)
    assert work[True] == pytest.approx(1.0, abs=1e-9)
    assert work[False] > 1.1


@pytest.mark.parametrize("proportion", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("stretch", [0.3, 0.6, 2.0])
def test_incompatible_modes_add_no_hourglass_in_compression_or_tension(proportion, stretch):
    X = 0.5 * CORNERS * [1.0, 1.0, proportion]
    across = stretch**-0.5
    unstable = []
    for incompatible in (False, True):
        bulk = bricks(X, np.arange(8)[None], *moduli(1.25, 0.4999), incompatible=incompatible)
        bulk.pressure[..., 0] = bulk.shear_modulus * (stretch**2 - across**2) / 3.0
        values = np.linalg.eigvalsh(tangent([bulk], X * [across, across, stretch]))
        unstable.append(np.count_nonzero(values < -1e-9 * values[-1]))
    assert unstable[1] <= unstable[0]


@pytest.mark.parametrize("element", ELEMENTS)
def test_mirror_image_carries_the_mirror_forces(element):
    rod = make_rod(6.0, 4, element=element)
    x = rod.mesh.nodes + 0.02 * np.random.default_rng(9).standard_normal(rod.mesh.nodes.shape)
    points = rod.points * [-1.0, 1.0]
    partner = np.argmin(np.linalg.norm(points[:, None] - rod.points, axis=2), axis=1)
    number = rod.sections[:, partner].ravel()
    flip = np.array([-1.0, 1.0, 1.0])
    settle(rod.bulk, x)
    f = residual([rod.bulk], x)
    y = x[number] * flip
    other = make_rod(6.0, 4, element=element).bulk
    settle(other, y)
    np.testing.assert_allclose(residual([other], y), f[number] * flip, atol=1e-8 * np.abs(f).max())
