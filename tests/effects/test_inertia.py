import numpy as np
import pytest
from derivatives import directional_error, residual
from specimens import make_rod

from knotfem.solver.schemes import BackwardEuler, Scheme, generalised_alpha, hht
from knotfem.solver.term import Motion, Moving, StepStart
from knotfem.terms.inertia import Drag, Inertia

SCHEMES = {
    "quasi-static": Scheme(),
    "backward-euler": BackwardEuler(),
    "trapezoidal": hht(0.0),
    "hht": hht(-0.05),
    "hht-dissipative": hht(-0.41421),
    "generalised-alpha": generalised_alpha(0.6),
}


def of(scheme: Scheme, effect: Moving) -> Moving:
    """As a system with this scheme has it."""
    effect.integrate(scheme)
    return effect


def started(scheme) -> tuple[StepStart, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    x = 10.0 * rng.standard_normal((7, 3))
    start = StepStart(Motion(x, rng.standard_normal(x.shape), rng.standard_normal(x.shape), 2.0), 0.3)
    return start, x + 0.1 * rng.standard_normal(x.shape), rng.uniform(0.5, 2.0, 7)


@pytest.mark.parametrize("kind", [Inertia, Drag])
@pytest.mark.parametrize("scheme", [name for name in SCHEMES if name != "quasi-static"])
def test_tangent_is_the_derivative_of_the_residual(kind, scheme):
    start, x, mass = started(SCHEMES[scheme])
    effect = of(SCHEMES[scheme], Inertia(mass) if kind is Inertia else Drag(mass, 20.0))
    effect.begin(start)
    assert directional_error([effect], x) < 1e-8


def test_quasi_static_drag_has_its_tangent_too():
    start, x, mass = started(Scheme())
    drag = of(Scheme(), Drag(mass, 20.0))
    drag.begin(start)
    assert directional_error([drag], x) < 1e-8
    np.testing.assert_allclose(residual([drag], x), 20.0 * mass[:, None] * (x - start.motion.x) / 0.3)


@pytest.mark.parametrize("scheme", list(SCHEMES))
def test_merit_gradient_is_the_residual(scheme):
    start, x, mass = started(SCHEMES[scheme])
    effects = [of(SCHEMES[scheme], Drag(mass, 20.0))]
    if SCHEMES[scheme].inertial:
        effects.append(of(SCHEMES[scheme], Inertia(mass)))
    d = np.random.default_rng(5).standard_normal(x.shape)
    for effect in effects:
        effect.begin(start)
        slope = (effect.merit(x + 1e-5 * d) - effect.merit(x - 1e-5 * d)) / 2e-5
        assert slope == pytest.approx(float(np.sum(residual([effect], x) * d)), rel=1e-7)


@pytest.mark.parametrize("scheme", ["backward-euler", "hht", "generalised-alpha"])
def test_uniform_velocity_needs_no_force_and_drag_takes_its_own(scheme):
    start, x, mass = started(SCHEMES[scheme])
    motion = Motion(start.motion.x, np.full_like(x, 3.0), np.zeros_like(x))
    start = StepStart(motion, 0.3)
    inertia, drag = of(SCHEMES[scheme], Inertia(mass)), of(SCHEMES[scheme], Drag(mass, 20.0))
    inertia.begin(start)
    drag.begin(start)
    x = motion.x + 0.9
    np.testing.assert_allclose(residual([inertia], x), 0.0, atol=1e-11)
    np.testing.assert_allclose(residual([drag], x), 60.0 * np.repeat(mass[:, None], 3, axis=1), rtol=1e-12)


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
