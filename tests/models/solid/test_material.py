"""Laws of the user's own: Yeoh's and Gent's, against closed forms and central differences."""

import numpy as np
import pytest
from derivatives import directional_error, gradient_error, residual, tangent
from specimens import beam_clamp, make_rod, static

from knotfem.errors import InputError
from knotfem.models.material import Material, NeoHooke, check_material
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.resultants import resultants
from knotfem.models.solid.stress import stress_state
from knotfem.scene.elements import ORDERS
from knotfem.solver.constraints import Prescribed
from knotfem.solver.nonlinear.tolerance import Sections


class Yeoh(Material):
    def __init__(self, c1: float = 0.2, c2: float = -0.01, c3: float = 0.002) -> None:
        self.c1, self.c2, self.c3 = c1, c2, c3

    def energy(self, invariant):
        e = invariant - 3.0
        return self.c1 * e + self.c2 * e**2 + self.c3 * e**3

    def first(self, invariant):
        e = invariant - 3.0
        return self.c1 + 2.0 * self.c2 * e + 3.0 * self.c3 * e**2

    def second(self, invariant):
        return 2.0 * self.c2 + 6.0 * self.c3 * (invariant - 3.0)


class Gent(Material):
    def __init__(self, mu: float = 0.4, limit: float = 4.0) -> None:
        self.mu, self.limit = mu, limit

    def energy(self, invariant):
        return -0.5 * self.mu * self.limit * np.log(1.0 - (invariant - 3.0) / self.limit)

    def first(self, invariant):
        return 0.5 * self.mu * self.limit / (self.limit - invariant + 3.0)

    def second(self, invariant):
        return 0.5 * self.mu * self.limit / (self.limit - invariant + 3.0) ** 2


class Curved(NeoHooke):
    """Neo-Hooke's law through the path of any law."""

    linear = False


LAWS = [Yeoh(), Gent(limit=9.0)]


def bulk_of(material: Material, element: str, *, poisson: float = 0.4999) -> tuple[Elasticity, np.ndarray]:
    rod = make_rod(6.0, 4, element=element)
    kappa = material.shear_modulus * 2.0 * (1.0 + poisson) / (3.0 * (1.0 - 2.0 * poisson))
    return Elasticity(rod.bulk.elements, rod.bulk.formulation, material, kappa), rod.mesh.nodes


def settle(bulk: Elasticity, x: np.ndarray) -> None:
    for _ in range(8 if bulk.modes.size else 1):
        bulk.assemble(x, np.zeros_like(x), None)
        bulk.increment(np.zeros_like(x))
        bulk.advance(1.0)


def strained(material: Material, element: str) -> tuple[Elasticity, np.ndarray]:
    incompatible = element == "hex8-incompatible"
    bulk, X = bulk_of(material, element, poisson=0.49 if incompatible else 0.4999)
    F = np.diag([0.75, 0.8, 1.0 / 0.6]) + 0.1 * np.random.default_rng(0).standard_normal((3, 3))
    x = X @ F / np.cbrt(np.linalg.det(F))
    x = x + (0.02 if incompatible else 0.06) * np.random.default_rng(1).standard_normal(x.shape)
    settle(bulk, x)
    return bulk, x


@pytest.mark.parametrize("element", list(ORDERS))
@pytest.mark.parametrize("law", LAWS, ids=["Yeoh", "Gent"])
def test_tangent_is_the_derivative_of_the_residual(law, element):
    bulk, x = strained(law, element)
    assert np.abs(law.second(np.array([3.5]))).max() > 0.0
    assert directional_error([bulk], x) < 1e-7
    whole = tangent([bulk], x)
    np.testing.assert_allclose(whole, whole.T, atol=1e-12 * np.abs(whole).max())


@pytest.mark.parametrize("element", list(ORDERS))
@pytest.mark.parametrize("law", LAWS, ids=["Yeoh", "Gent"])
def test_energy_gradient_is_the_residual_and_stresses_make_it(law, element):
    bulk, x = strained(law, element)
    f = residual([bulk], x)
    state = stress_state(x, bulk)
    force = np.zeros_like(x)
    np.add.at(force, bulk.elements, bulk.nodal_forces(x, state.first_piola * state.weights[..., None, None]))
    np.testing.assert_allclose(force, f, atol=1e-11 * np.abs(f).max())

    def energy(y: np.ndarray) -> float:
        settle(bulk, y)
        return bulk.energy(y)

    assert gradient_error(energy, f, x) < 1e-7


@pytest.mark.parametrize("element", list(ORDERS))
def test_both_paths_agree_for_neo_hookes_law(element):
    found = []
    for law in (NeoHooke(0.4), Curved(0.4)):
        bulk, x = strained(law, element)
        found.append((residual([bulk], x), tangent([bulk], x), bulk.energy(x), bulk.merit(x)))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-11, atol=1e-11 * np.abs(one).max())


@pytest.mark.parametrize("stretch", [0.7, 1.4])
@pytest.mark.parametrize("element", ["hex8-reduced", "hex8", "hex27"])
@pytest.mark.parametrize("law", LAWS, ids=["Yeoh", "Gent"])
def test_stretched_bar(law, element, stretch):
    """Incompressible: P = 2 W' (lambda - lambda^-2) A."""
    rod = make_rod(12.0, 4, element=element)
    bulk = Elasticity(rod.bulk.elements, rod.bulk.formulation, law, 1e5 * law.shear_modulus)
    X, far = rod.mesh.nodes, rod.sections[-1]
    top = Prescribed(far, lambda time: X[far] + [0.0, 0.0, 12.0 * (stretch - 1.0)], components=(False, False, True))
    start = X * np.array([stretch**-0.5, stretch**-0.5, stretch])
    x, system, _ = static([bulk], start, [*beam_clamp(rod), top], Sections.single(rod.section_of_node))
    invariant = np.array([stretch**2 + 2.0 / stretch])
    expected = 2.0 * float(law.first(invariant)[0]) * (stretch - stretch**-2) * rod.area
    assert float(system.residual(x)[far, 2].sum()) == pytest.approx(expected, rel=1e-4)
    carried = resultants(x, rod.sections, rod.mesh.section.axis, bulk, None)
    np.testing.assert_allclose(carried.tension, expected, rtol=1e-4)
    np.testing.assert_allclose(carried.bulk, expected, rtol=1e-4)
    volume = bulk.formulation.weights.sum() * len(bulk.elements)
    assert bulk.energy(x) == pytest.approx(float(law.energy(invariant)[0]) * volume, rel=1e-4)


def test_beyond_the_limit_of_a_law_no_state_is_admissible():
    bulk, X = bulk_of(Gent(limit=0.5), "hex8")
    near, beyond = np.array([0.9, 0.9, 0.9**-2]), np.array([0.6, 0.6, 0.6**-2])
    assert np.isfinite(bulk.merit(near * X))
    assert bulk.merit(beyond * X) == np.inf
    bulk.assemble(near * X, np.zeros_like(X), None)
    assert bulk.admissible
    bulk.assemble(beyond * X, np.zeros_like(X), None)
    assert not bulk.admissible


class Wrong(Yeoh):
    """Its derivative was forgotten to be changed with the energy."""

    def energy(self, invariant):
        return 2.0 * super().energy(invariant)


class Bent(Yeoh):
    def second(self, invariant):
        return np.full_like(invariant, self.c1)


class Stored(Yeoh):
    def energy(self, invariant):
        return super().energy(invariant) + 1.0


class Single(Yeoh):
    def energy(self, invariant):
        return super().energy(invariant)[0]


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (Wrong(), r"^Wrong: first\(I1\) is not the derivative of energy\(I1\); found a relative deviation"),
        (Bent(), r"second\(I1\) is not the derivative of first\(I1\)"),
        (Stored(), r"energy is stored without strain; found W\(3\) = 1"),
        (Single(), r"return an array; found shape \(\)"),
        (NeoHooke(-1.0), r"shear modulus of a material is positive; found 2 W'\(3\) = -1"),
        (NeoHooke(float("nan")), "positive"),
    ],
)
def test_laws_that_no_solid_has_are_refused(law, message):
    with pytest.raises(InputError, match=message):
        check_material(law)


def test_moduli_and_descriptions():
    assert Yeoh(0.3).shear_modulus == pytest.approx(0.6)
    assert Gent(0.7).shear_modulus == pytest.approx(0.7)
    assert NeoHooke(0.7).shear_modulus == 0.7
    assert Yeoh(0.3).describe() == "Yeoh, G 0.6 MPa"
    bulk, _ = bulk_of(NeoHooke(0.5), "hex8")
    assert bulk.describe() == "48 hexahedra, G 0.5 MPa"
    assert not NeoHooke(0.5).second(np.array([3.0, 4.0])).any()
