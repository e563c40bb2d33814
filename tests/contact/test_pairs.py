"""One term of normal contact for both kinds of surface: tubes of hexahedral rods and centrelines of discrete ones."""

from dataclasses import dataclass

import numpy as np
import pytest
from derivatives import assert_energy_gradient, assert_symmetric_storage, directional_error, moments, residual, rotation

from knotfem.contact.collect import contact_report
from knotfem.contact.curve import make_samples
from knotfem.contact.curve_pairs import CurveSurface
from knotfem.contact.law import Penalty
from knotfem.contact.pairs import PairContact
from knotfem.contact.surface import room_of
from knotfem.mesh.rod_layout import make_layout
from knotfem.solver.state import Motion
from knotfem.solver.term import Role, TimeStep


@dataclass(eq=False)
class Touching:
    """Two rods that cross with a small overlap.

    Attributes:
        contact: of both.
        x: positions.
        first: nodes of the first rod.
        parameters: of a point of the surface.
    """

    contact: PairContact
    x: np.ndarray
    first: int
    parameters: int

    def apart(self, by: float) -> np.ndarray:
        """Positions with the second rod moved away along x."""
        x = self.x.copy()
        x[self.first :, 0] += by
        return x


def curves() -> Touching:
    """Discrete rods of different segments and radii, the second bent a little round the first."""
    layout = make_layout([12, 16], [2.5, 1.7], [3.0, 2.5])
    x = np.zeros((layout.nodes, 4))
    first, second = layout.of(0), layout.of(1)
    x[first, 2] = 2.5 * (np.arange(13) - 6.0)
    s = 1.7 * (np.arange(17) - 8.0)
    x[second, 0], x[second, 1], x[second, 2] = 5.3 - 0.01 * s**2, np.cos(1.2) * s, np.sin(1.2) * s
    rng = np.random.default_rng(1)
    x[:, :3] += 0.02 * rng.standard_normal((layout.nodes, 3))
    x[:, 3] = rng.standard_normal(layout.nodes)
    contact = PairContact(CurveSurface(layout), make_samples(layout, 0.75), Penalty(0.5, 0.2))
    return Touching(contact, x, 13, 1)


@pytest.fixture(params=["tubes", "curves"])
def touching(request, make_crossing) -> Touching:
    if request.param == "curves":
        return curves()
    crossing = make_crossing()
    return Touching(crossing.contact, crossing.x, len(crossing.rods[0].mesh.nodes), 2)


def places(x: np.ndarray, Q: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Positions turned and moved, angles as they are."""
    y = x.copy()
    y[:, :3] = x[:, :3] @ Q.T + shift
    return y


def test_the_term_is_the_same_and_the_surface_says_what_differs(touching):
    contact = touching.contact
    contact.update(touching.x)
    assert type(contact) is PairContact
    assert (contact.name, contact.role, contact.external, contact.symmetric) == ("contact", Role.CONTACT, False, True)
    assert contact.surface.parameters == touching.parameters == contact.pairs.at.shape[1]
    assert contact.surface.width == touching.x.shape[1]
    assert str(contact.samples.count) in contact.describe()
    assert ("MPa/mm" in contact.describe()) == (touching.parameters == 2)
    secondary = contact.samples.rod[contact.pairs.sample]
    assert set(zip(secondary.tolist(), contact.pairs.rod.tolist(), strict=True)) == {(0, 1), (1, 0)}


def test_tangent_is_the_derivative_of_the_residual(touching):
    assert directional_error([touching.contact], touching.x) < 1e-6


def test_upper_storage_equals_the_whole(touching):
    assert_symmetric_storage([touching.contact], touching.x, tolerance=1e-10)


def test_energy_gradient_is_the_residual(touching):
    assert_energy_gradient(touching.contact, touching.x)


def test_merit_elsewhere_is_the_energy_there_and_moves_nothing(touching):
    contact, x = touching.contact, touching.x
    before = residual([contact], x)
    pairs = [array.copy() for array in contact.pairs[:6]]
    there = touching.apart(-0.1)
    merit = contact.merit(there)
    assert merit > contact.energy(x)
    for array, kept in zip(contact.pairs[:6], pairs, strict=True):
        np.testing.assert_array_equal(array, kept)
    np.testing.assert_array_equal(residual([contact], x), before)
    contact.update(there)
    assert merit == pytest.approx(contact.energy(there), rel=1e-10)


def test_action_equals_reaction(touching):
    f = residual([touching.contact], touching.x)
    assert f[: touching.first, 0].sum() > 0.5
    np.testing.assert_allclose(f[:, :3].sum(axis=0), 0.0, atol=1e-12 * np.abs(f).sum())
    np.testing.assert_allclose(moments(touching.x[:, :3], f[:, :3]), 0.0, atol=1e-11 * np.abs(f).sum())
    assert not f[:, 3:].any()


def test_frame_indifference(touching):
    Q = rotation()
    f = residual([touching.contact], touching.x)
    turned = residual([touching.contact], places(touching.x, Q, np.array([5.0, -8.0, 2.0])))
    np.testing.assert_allclose(turned, places(f, Q, np.zeros(3)), atol=1e-10 * np.abs(f).max())


def test_search_finds_the_same_as_following_the_pairs(touching):
    contact = touching.contact
    contact.update(touching.x)
    searches = contact.generation
    moved = touching.x.copy()
    moved[touching.first :, 2] += 0.3
    followed = residual([contact], moved)
    assert contact.generation == searches
    contact.search(moved)
    assert contact.generation == searches + 1
    np.testing.assert_allclose(residual([contact], moved), followed, atol=1e-9)


def test_predictor_may_close_no_pair_by_more_than_it_may(touching):
    contact = touching.contact
    x = touching.apart(0.3)
    contact.update(x)
    move = touching.apart(-2.0) - touching.x
    assert contact.allowed_fraction(x, move) < 0.5
    assert contact.allowed_fraction(x, 0.05 * move) == 1.0
    assert contact.allowed_fraction(x, -move) == 1.0


def test_rods_apart_exert_nothing(touching):
    x = touching.apart(0.9)
    assert np.abs(residual([touching.contact], x)).max() == 0.0
    assert (touching.contact.penetration, touching.contact.touching) == (0.0, 0)
    far = touching.apart(50.0)
    residual([touching.contact], far)
    assert touching.contact.couplings(len(far)) is None
    assert touching.contact.allowed_fraction(far, np.ones_like(far)) == 1.0


def test_history_goes_to_another_term_to_the_bit(touching, request):
    contact, x = touching.contact, touching.x
    before = residual([contact], x)
    history = contact.history()
    kept = {name: value.tobytes() for name, value in history.items()}
    other = request.getfixturevalue("touching_anew")
    other.load(history)
    assert residual([other], x).tobytes() == before.tobytes()
    assert {name: value.tobytes() for name, value in other.history().items()} == kept
    other.search(touching.apart(0.2))
    other.pairs.weight[:] = 0.0
    assert {name: value.tobytes() for name, value in history.items()} == kept


@pytest.fixture
def touching_anew(touching) -> PairContact:
    contact = touching.contact
    return PairContact(contact.surface, contact.samples, contact.law)


def test_weights_follow_the_closest_points_from_step_to_step(touching):
    """A strand may bend round another that it touches already: samples of the other see no closest point then."""
    contact, x = touching.contact, touching.x
    residual([contact], x)
    fresh = contact.pairs.weight.copy()
    contact.pairs.weight[:] = 0.3
    contact.begin(TimeStep(Motion.at_rest(x), 0.1))
    assert (contact.pairs.force > 0.0).any()
    np.testing.assert_allclose(contact.pairs.weight, fresh, atol=1e-12)


def test_known_pairs_keep_their_weights_in_a_search(touching):
    contact, x = touching.contact, touching.x
    contact.update(x)
    known = len(contact.match)
    contact.pairs.weight[:] = 0.3
    contact.search(touching.apart(0.05))
    assert np.count_nonzero(contact.match >= 0) > 0.5 * known
    np.testing.assert_array_equal(contact.pairs.weight[contact.match >= 0], 0.3)


def test_report_says_the_same_of_both(touching):
    contact, x = touching.contact, touching.x
    f = residual([contact], x)
    report = contact_report([contact])
    assert report.rod.size == contact.touching
    on_first = report.rod == 0
    assert (report.other == 1 - report.rod).all()
    assert (report.normal[on_first, 0] < 0.0).all()
    assert (report.normal[~on_first, 0] > 0.0).all()
    push = (report.normal_force[:, None] * report.normal)[on_first].sum(axis=0)
    push -= (report.normal_force[:, None] * report.normal)[~on_first].sum(axis=0)
    np.testing.assert_allclose(push, -f[: touching.first, :3].sum(axis=0), rtol=1e-9)
    assert (report.friction_force == 0.0).all()
    assert report.slides.all()


def test_what_is_no_surface_is_refused():
    with pytest.raises(TypeError, match="no surface: object"):
        room_of(object())
