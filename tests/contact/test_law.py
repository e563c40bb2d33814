import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem.contact.law import Penalty, penalty
from knotfem.contact.mobilisation import mobilisation, mobilisation_energy

EPS, RAMP = 11.4, 0.2
LAW = Penalty(EPS, RAMP)


@settings(deadline=None)
@given(st.floats(-1.0, 1.0))
def test_pressure_and_slope_are_derivatives_of_the_energy(gap):
    step = 1e-6
    energies = [penalty(gap + s * step, LAW)[0] for s in (1, -1)]
    pressures = [penalty(gap + s * step, LAW)[1] for s in (1, -1)]
    _, pressure, slope = penalty(gap, LAW)
    assert -(energies[0] - energies[1]) / (2 * step) == pytest.approx(pressure, abs=1e-7)
    assert -(pressures[0] - pressures[1]) / (2 * step) == pytest.approx(slope, abs=1e-4)


@settings(deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_closer_never_presses_less(gap, further):
    assert penalty(gap, LAW)[1] >= penalty(gap + further, LAW)[1] >= 0.0


def test_stated_law():
    assert penalty(0.11, LAW) == (0.0, 0.0, 0.0)
    assert penalty(0.0, LAW)[1] == pytest.approx(EPS * 0.1**2 / 0.4)
    assert penalty(-0.3, LAW)[1] == pytest.approx(EPS * 0.3)
    early = Penalty(EPS, RAMP, 0.25)
    assert early.onset == pytest.approx(0.05)
    assert penalty(0.051, early) == (0.0, 0.0, 0.0)
    assert penalty(-0.35, early) == pytest.approx(penalty(-0.3, LAW))


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
