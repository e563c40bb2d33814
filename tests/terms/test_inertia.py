import numpy as np
import pytest
from derivatives import directional_error, residual
from specimens import make_rod

from knotfem.solver.schemes import BackwardEuler, Scheme, generalised_alpha, hht
from knotfem.solver.state import Motion
from knotfem.solver.term import Conditions, TimeStep
from knotfem.terms.inertia import Drag, Inertia

SCHEMES = {
    "quasi-static": Scheme(),
    "backward-euler": BackwardEuler(),
    "trapezoidal": hht(0.0),
    "hht": hht(-0.05),
    "hht-dissipative": hht(-0.41421),
    "generalised-alpha": generalised_alpha(0.6),
}


def started(scheme: Scheme) -> tuple[TimeStep, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    x = 10.0 * rng.standard_normal((7, 3))
    start = Motion(x, rng.standard_normal(x.shape), rng.standard_normal(x.shape), 2.0)
    return TimeStep(start, 0.3, scheme), x + 0.1 * rng.standard_normal(x.shape), rng.uniform(0.5, 2.0, 7)


@pytest.mark.parametrize("kind", [Inertia, Drag])
@pytest.mark.parametrize("scheme", [name for name in SCHEMES if name != "quasi-static"])
def test_tangent_is_the_derivative_of_the_residual(kind, scheme):
    step, x, mass = started(SCHEMES[scheme])
    term = Inertia(mass) if kind is Inertia else Drag(mass, 20.0)
    term.begin(step)
    assert directional_error([term], x) < 1e-8


def test_quasi_static_drag_has_its_tangent_too():
    step, x, mass = started(Scheme())
    drag = Drag(mass, 20.0)
    drag.begin(step)
    assert directional_error([drag], x) < 1e-8
    np.testing.assert_allclose(residual([drag], x), 20.0 * mass[:, None] * (x - step.start.x) / 0.3)


@pytest.mark.parametrize("scheme", list(SCHEMES))
def test_merit_gradient_is_the_residual(scheme):
    step, x, mass = started(SCHEMES[scheme])
    terms = [Drag(mass, 20.0), *([Inertia(mass)] if SCHEMES[scheme].inertial else [])]
    d = np.random.default_rng(5).standard_normal(x.shape)
    for term in terms:
        term.begin(step)
        slope = (term.merit(x + 1e-5 * d) - term.merit(x - 1e-5 * d)) / 2e-5
        assert slope == pytest.approx(float(np.sum(residual([term], x) * d)), rel=1e-7)


@pytest.mark.parametrize("scheme", ["backward-euler", "hht", "generalised-alpha"])
def test_uniform_velocity_needs_no_force_and_drag_takes_its_own(scheme):
    begun, x, mass = started(SCHEMES[scheme])
    step = TimeStep(Motion(begun.start.x, np.full_like(x, 3.0), np.zeros_like(x)), 0.3, SCHEMES[scheme])
    inertia, drag = Inertia(mass), Drag(mass, 20.0)
    inertia.begin(step)
    drag.begin(step)
    x = begun.start.x + 0.9
    np.testing.assert_allclose(residual([inertia], x), 0.0, atol=1e-11)
    np.testing.assert_allclose(residual([drag], x), 60.0 * np.repeat(mass[:, None], 3, axis=1), rtol=1e-12)


def test_conditions_of_a_step_may_give_the_rate_of_the_drag():
    step, x, mass = started(BackwardEuler())
    forces = []
    for conditions in (Conditions(), Conditions(drag=5.0), Conditions(drag=0.0)):
        drag = Drag(mass, 20.0)
        drag.begin(TimeStep(step.start, step.dt, step.scheme, conditions))
        assert conditions.drag == 0.0 or directional_error([drag], x) < 1e-8
        forces.append(residual([drag], x))
    np.testing.assert_allclose(forces[1], 0.25 * forces[0], rtol=1e-14)
    assert not forces[2].any()


@pytest.mark.parametrize("kind", [Inertia, Drag])
def test_every_unknown_may_have_a_mass_of_its_own(kind):
    """As the angles of a discrete rod, which have a moment of inertia."""
    rng = np.random.default_rng(2)
    x, mass = rng.standard_normal((5, 4)), rng.uniform(0.5, 2.0, (5, 4))
    step = TimeStep(Motion(x, rng.standard_normal(x.shape), rng.standard_normal(x.shape)), 0.3, BackwardEuler())
    term = Inertia(mass) if kind is Inertia else Drag(mass, 20.0)
    term.begin(step)
    x = x + 0.1 * rng.standard_normal(x.shape)
    assert directional_error([term], x) < 1e-8
    rate = step.scheme.acceleration(x, step.start, 0.3) if kind is Inertia else 20.0 * step.velocity(x)
    np.testing.assert_allclose(residual([term], x), mass * rate, rtol=1e-12)


def test_kinetic_energy_is_that_of_the_masses():
    rng = np.random.default_rng(2)
    v, mass = rng.standard_normal((5, 3)), rng.uniform(0.5, 2.0, 5)
    assert Inertia(mass).kinetic_energy(v) == pytest.approx(0.5 * float(mass @ (v * v).sum(axis=1)), rel=1e-14)


@pytest.mark.parametrize("element", ["hex8", "hex8-reduced"])
def test_lumped_mass_is_density_times_volume_shared_evenly_along(element):
    rod = make_rod(12.0, 6, element=element, section=44)
    mass = rod.mass
    volume = rod.bulk.formulation.weights.sum() * 6
    assert mass.sum() == pytest.approx(rod.density * volume, rel=1e-12)
    assert (mass > 0.0).all()
    per_section = mass[rod.sections].sum(axis=1) / mass.sum()
    np.testing.assert_allclose(per_section, [1 / 12, *([1 / 6] * 5), 1 / 12], rtol=1e-12)
    np.testing.assert_allclose(mass @ rod.mesh.nodes / mass.sum(), [0.0, 0.0, 6.0], atol=1e-12)
