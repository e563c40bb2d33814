import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem.contact.law import mobilisation, mobilisation_energy, penalty, sliding_work, spring_energy

EPS, RAMP = 11.4, 0.2


@settings(deadline=None)
@given(st.floats(-1.0, 1.0))
def test_pressure_and_slope_are_derivatives_of_the_energy(gap):
    step = 1e-6
    energies = [penalty(gap + s * step, EPS, RAMP)[0] for s in (1, -1)]
    pressures = [penalty(gap + s * step, EPS, RAMP)[1] for s in (1, -1)]
    _, pressure, slope = penalty(gap, EPS, RAMP)
    assert -(energies[0] - energies[1]) / (2 * step) == pytest.approx(pressure, abs=1e-7)
    assert -(pressures[0] - pressures[1]) / (2 * step) == pytest.approx(slope, abs=1e-4)


@settings(deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_closer_never_presses_less(gap, further):
    assert penalty(gap, EPS, RAMP)[1] >= penalty(gap + further, EPS, RAMP)[1] >= 0.0


def test_stated_law():
    assert penalty(0.11, EPS, RAMP) == (0.0, 0.0, 0.0)
    assert penalty(0.0, EPS, RAMP)[1] == pytest.approx(EPS * 0.1**2 / 0.4)
    assert penalty(-0.3, EPS, RAMP)[1] == pytest.approx(EPS * 0.3)


@settings(deadline=None)
@given(st.floats(0.0, 3.0))
def test_mobilised_share_rises_to_one_and_stays(y):
    psi, over_y, slope = mobilisation(y)
    assert 0.0 <= psi <= 1.0
    assert psi == pytest.approx(over_y * y, abs=1e-12)
    assert slope >= 0.0
    if y >= 1.0:
        assert (psi, slope) == (1.0, 0.0)


@settings(deadline=None)
@given(st.floats(0.01, 3.0))
def test_mobilisation_is_the_derivative_of_its_energy(y):
    step = 1e-6
    slope = (mobilisation_energy(y + step) - mobilisation_energy(y - step)) / (2 * step)
    assert slope == pytest.approx(mobilisation(y)[0], abs=1e-8)
    assert mobilisation_energy(np.float64(0.0)) == 0.0


STIFFNESS, LIMIT = 3.0, 0.6


@settings(deadline=None)
@given(st.floats(1e-3, 1.0))
def test_traction_of_a_spring_is_cut_at_its_limit(slip):
    step = 1e-6
    energies = [spring_energy(slip + s * step, STIFFNESS, LIMIT) for s in (1, -1)]
    assert (energies[0] - energies[1]) / (2 * step) == pytest.approx(min(STIFFNESS * slip, LIMIT), abs=1e-5)
    assert spring_energy(0.0, STIFFNESS, LIMIT) == 0.0


@settings(deadline=None)
@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_sliding_takes_work_and_stores_the_rest(before, cut, further):
    """Energy stored before plus work of the mean traction along the path is energy stored after plus what is lost."""
    after, trial = cut, cut + further
    lost = sliding_work(STIFFNESS, before, after, trial)
    assert lost >= 0.0
    put_in = 0.5 * STIFFNESS * (before + after) * (trial - before)
    stored = 0.5 * STIFFNESS * (after**2 - before**2)
    assert put_in == pytest.approx(stored + lost, abs=1e-12)
