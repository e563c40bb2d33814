import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.solver.schemes import BackwardEuler, Scheme, generalised_alpha, hht
from knotfem.solver.state import Motion
from knotfem.verify.benchmarks.oscillator import OMEGA, amplification, amplitude_kept, swing


@pytest.mark.parametrize("scheme", [hht(-0.05), hht(-0.41421), generalised_alpha(0.6)])
@pytest.mark.parametrize("steps", [20, 100])
def test_amplitude_follows_the_amplification_matrix(scheme, steps):
    found = amplitude_kept(swing(scheme, 40, 1.0 / steps), 3)
    assert found == pytest.approx(amplification(scheme, 1.0 / steps), abs=1e-7)


@pytest.mark.parametrize(
    ("scheme", "order"),
    [(BackwardEuler(), 1), (hht(0.0), 2), (hht(-0.3), 2), (generalised_alpha(0.5), 2)],
    ids=["backward-euler", "trapezoidal", "hht", "generalised-alpha"],
)
@pytest.mark.parametrize("damping", [0.0, 1.5])
def test_order_of_accuracy(scheme, order, damping):
    end, root = 0.6, np.sqrt(OMEGA**2 - 0.25 * damping**2)
    exact = np.exp(-0.5 * damping * end) * (np.cos(root * end) + 0.5 * damping / root * np.sin(root * end))
    errors = [abs(swing(scheme, n, end / n, damping)[-1] - exact) for n in (50, 100)]
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


def test_trapezoidal_rule_keeps_the_amplitude():
    path = swing(hht(0.0), 150, 0.05)
    assert np.abs(path[-40:]).max() == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("scheme", [BackwardEuler(), hht(-0.1), generalised_alpha(0.3), Scheme()])
def test_rates_are_the_derivatives(scheme):
    rng = np.random.default_rng(0)
    motion = Motion(*rng.standard_normal((3, 4, 3)))
    x, d = rng.standard_normal((4, 3)), rng.standard_normal((4, 3))
    for value, rate in ((scheme.velocity, scheme.velocity_rate), (scheme.acceleration, scheme.acceleration_rate)):
        np.testing.assert_allclose(
            value(x + d, motion, 0.2) - value(x, motion, 0.2), rate(0.2) * d, rtol=1e-9, atol=1e-12
        )
    end = scheme.motion(x, motion, 0.2)
    assert end.time == pytest.approx(motion.time + 0.2)
    np.testing.assert_array_equal(end.x, x)


def test_wrong_parameters_are_refused():
    with pytest.raises(InputError, match="hht_alpha"):
        hht(0.1)
    with pytest.raises(InputError, match="spectral_radius"):
        generalised_alpha(1.5)


@pytest.mark.parametrize("scheme", [Scheme(), BackwardEuler(), hht(-0.3), generalised_alpha(0.5)])
def test_step_of_no_length_moves_as_its_start(scheme):
    motion = Motion(np.ones((1, 3)), np.full((1, 3), 2.0), np.zeros((1, 3)), 1.0)
    np.testing.assert_array_equal(scheme.velocity(motion.x, motion, 0.0), motion.v)
    np.testing.assert_array_equal(scheme.acceleration(motion.x, motion, 0.0), motion.a)


@pytest.mark.parametrize("scheme", [Scheme(), BackwardEuler(), hht(-0.3), generalised_alpha(0.5)])
def test_motion_at_the_end_is_a_value_of_its_own(scheme):
    rng = np.random.default_rng(3)
    start = Motion(*rng.standard_normal((3, 4, 3)))
    kept = [array.copy() for array in (start.x, start.v, start.a)]
    x = rng.standard_normal((4, 3))
    end = scheme.motion(x, start, 0.2)
    held = end.x.copy()
    x += 1.0
    np.testing.assert_array_equal(end.x, held)
    for array, before in zip((start.x, start.v, start.a), kept, strict=True):
        np.testing.assert_array_equal(array, before)
