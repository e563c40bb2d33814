import numpy as np
import pytest

from knotfem.effects.inertia import Drag, Inertia
from knotfem.errors import InputError
from knotfem.solver.effect import Motion, StepStart
from knotfem.solver.linear import make_solver
from knotfem.solver.newton import NewtonSettings, solve
from knotfem.solver.schemes import BackwardEuler, GeneralisedAlpha, Scheme, generalised_alpha, hht
from knotfem.solver.system import System

OMEGA = 2.0 * np.pi


def swing(scheme: Scheme, spring, steps: int, dt: float, damping: float = 0.0) -> np.ndarray:
    """Positions of an oscillator of one period a second, released from 1 at rest."""
    mass = np.ones(1)
    effects = [spring(OMEGA**2), Inertia(mass, scheme)]
    if damping > 0.0:
        effects.append(Drag(mass, damping, scheme))
    system = System(effects, 1, make_solver("superlu"), scheme)
    x = np.array([[1.0, 0.0, 0.0]])
    motion = Motion(x, np.zeros((1, 3)), -(OMEGA**2) * x)
    settings = NewtonSettings(force_tolerance=1e-10, resultant_tolerance=1e-10, largest_move=10.0)
    path = [1.0]
    for _ in range(steps):
        start = StepStart(motion, dt)
        system.begin(start)
        x, _ = solve(system, motion.x, start, settings, np.zeros(1, dtype=int))
        motion = system.accept(x, start)
        path.append(float(x[0, 0]))
    return np.array(path)


def amplitude_kept(path: np.ndarray, roots: int) -> float:
    """In one period of the numerical motion, whose recurrence has so many roots."""
    rows = np.stack([path[i : len(path) - roots + i] for i in range(roots)], axis=1)
    recurrence = np.linalg.lstsq(rows, path[roots:], rcond=None)[0]
    values = np.roots([1.0, *(-recurrence[::-1])])
    z = values[np.argmax(np.abs(values) * (np.abs(values.imag) > 1e-9))]
    return float(np.abs(z) ** (2.0 * np.pi / abs(np.angle(z))))


def amplification(scheme: GeneralisedAlpha, dt: float) -> float:
    """Amplitude kept in one period of the numerical motion, from the eigenvalues of the step's own matrix."""
    beta, gamma, am, af = scheme.beta, scheme.gamma, scheme.alpha_m, scheme.alpha_f
    after = np.array([[1, 0, -beta * dt**2], [0, 1, -gamma * dt], [(1 - af) * OMEGA**2, 0, 1 - am]])
    before = np.array([[1, dt, (0.5 - beta) * dt**2], [0, 1, (1 - gamma) * dt], [-af * OMEGA**2, 0, -am]])
    values = np.linalg.eigvals(np.linalg.solve(after, before))
    z = values[np.argmax(np.abs(values) * (np.abs(values.imag) > 1e-9))]
    return float(np.abs(z) ** (2.0 * np.pi / abs(np.angle(z))))


@pytest.mark.parametrize(
    ("scheme", "roots", "kept"),
    [
        (BackwardEuler(), 2, {20: 0.379, 100: 0.821}),
        (hht(-0.05), 3, {20: 0.9989, 100: 1.0000}),
        (hht(-0.41421), 3, {10: 0.9774, 50: 0.9998}),
    ],
    ids=["backward-euler", "hht", "hht-dissipative"],
)
def test_amplitude_kept_in_one_period(spring, scheme, roots, kept):
    for steps, expected in kept.items():
        found = amplitude_kept(swing(scheme, spring, 2 * steps, 1.0 / steps), roots)
        print(f"amplitude kept, {steps} steps a period: expected {expected}, found {found:.4f}")
        assert found == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("scheme", [hht(-0.05), hht(-0.41421), generalised_alpha(0.6)])
@pytest.mark.parametrize("steps", [20, 100])
def test_amplitude_follows_the_amplification_matrix(spring, scheme, steps):
    found = amplitude_kept(swing(scheme, spring, 40, 1.0 / steps), 3)
    assert found == pytest.approx(amplification(scheme, 1.0 / steps), abs=1e-7)


@pytest.mark.parametrize(
    ("scheme", "order"),
    [(BackwardEuler(), 1), (hht(0.0), 2), (hht(-0.3), 2), (generalised_alpha(0.5), 2)],
    ids=["backward-euler", "trapezoidal", "hht", "generalised-alpha"],
)
@pytest.mark.parametrize("damping", [0.0, 1.5])
def test_order_of_accuracy(spring, scheme, order, damping):
    end, root = 0.6, np.sqrt(OMEGA**2 - 0.25 * damping**2)
    exact = np.exp(-0.5 * damping * end) * (np.cos(root * end) + 0.5 * damping / root * np.sin(root * end))
    errors = [abs(swing(scheme, spring, n, end / n, damping)[-1] - exact) for n in (50, 100)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize("radius", [0.0, 0.5, 1.0])
def test_generalised_alpha_has_the_spectral_radius_asked_for(radius):
    scheme = generalised_alpha(radius)
    stiff = 1e12
    after = np.array(
        [[1, 0, -scheme.beta], [0, 1, -scheme.gamma], [(1 - scheme.alpha_f) * stiff, 0, 1 - scheme.alpha_m]]
    )
    before = np.array(
        [[1, 1, 0.5 - scheme.beta], [0, 1, 1 - scheme.gamma], [-scheme.alpha_f * stiff, 0, -scheme.alpha_m]]
    )
    values = np.linalg.eigvals(np.linalg.solve(after, before))
    assert np.abs(values).max() == pytest.approx(radius, abs=2e-3)


def test_trapezoidal_rule_keeps_the_amplitude(spring):
    path = swing(hht(0.0), spring, 150, 0.05)
    assert np.abs(path[-40:]).max() == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("scheme", [BackwardEuler(), hht(-0.1), generalised_alpha(0.3), Scheme()])
def test_rates_are_the_derivatives(scheme):
    rng = np.random.default_rng(0)
    motion = Motion(*(rng.standard_normal((4, 3)) for _ in range(3)))
    start = StepStart(motion, 0.2)
    x, d = rng.standard_normal((4, 3)), rng.standard_normal((4, 3))
    for value, rate in ((scheme.velocity, scheme.velocity_rate), (scheme.acceleration, scheme.acceleration_rate)):
        np.testing.assert_allclose(value(x + d, start) - value(x, start), rate(0.2) * d, rtol=1e-9, atol=1e-12)
    end = scheme.finish(x, start)
    assert end.time == pytest.approx(motion.time + 0.2)
    np.testing.assert_array_equal(end.x, x)


def test_wrong_parameters_are_refused():
    with pytest.raises(InputError, match="hht_alpha"):
        hht(0.1)
    with pytest.raises(InputError, match="spectral_radius"):
        generalised_alpha(1.5)
