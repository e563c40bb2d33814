"""Normal contact of discrete rods."""

import numpy as np
import pytest
from derivatives import rotation
from reduced import RADIUS, YOUNGS, Rods, begun, contact, crossing, line, peg, spec

from knotfem.contact.curve_pairs import hertz_line_stiffness

SHIFTS = [(a, b) for a in (0.0, 0.2, 0.375, 0.6) for b in (0.0, 0.2, 0.375)]


def force_on(model, rod):
    f = np.zeros_like(model.x)
    model.contact.assemble(model.x, f, None)
    return -f[model.layout.of(rod), :3].sum(axis=0)


@pytest.mark.parametrize(("approach", "tolerance"), [(0.05, 0.05), (0.10, 0.05)])
def test_crossed_strands_meet_by_hertz(approach, tolerance):
    exact = 4.0 / 3.0 * YOUNGS / 1.5 * np.sqrt(RADIUS) * (approach * RADIUS) ** 1.5
    forces = [force_on(crossing(approach * RADIUS, shift=s), 1)[2] for s in SHIFTS]
    np.testing.assert_allclose(forces, exact, rtol=tolerance)
    assert np.ptp(forces) / exact < 0.04


def test_force_follows_the_line_stiffness_along_a_line_contact():
    s = line(20, 40.0)
    on_top = s + np.array([0.0, 0.0, 2 * RADIUS - 0.3])
    model = begun(Rods([spec(s), spec(on_top)], contact()))
    assert force_on(model, 1)[2] == pytest.approx(0.3 * hertz_line_stiffness(YOUNGS, 0.5) * 40.0, rel=0.02)
    c = model.contacts()
    assert c.normal_force.sum() == pytest.approx(force_on(model, 1)[2], rel=1e-9)
    np.testing.assert_allclose(c.gap, -0.3, atol=1e-9)
    np.testing.assert_allclose(c.arclength, c.other_arclength, atol=1e-9)


def test_forces_turn_with_the_rods():
    Q = rotation()
    a, b = crossing(0.3, angle=1.1, shift=(0.3, 0.1)), crossing(0.3, angle=1.1, shift=(0.3, 0.1), turn=Q)
    np.testing.assert_allclose(force_on(b, 1), Q @ force_on(a, 1), atol=1e-12)


def test_mirrored_rods_feel_mirrored_forces():
    a, b = crossing(0.3, angle=1.1, shift=(0.3, 0.1)), crossing(0.3, angle=-1.1, shift=(0.3, 0.1))
    np.testing.assert_allclose(force_on(b, 1), force_on(a, 1) * [1.0, -1.0, 1.0], atol=1e-12)


def test_no_ripple_as_a_strand_passes_over_nodes():
    forces = [force_on(crossing(0.3, shift=(a, 0.0)), 1)[2] for a in np.linspace(0.0, 2.0, 21)]
    assert np.ptp(forces) / np.mean(forces) < 0.015


@pytest.mark.parametrize("angle", [0.3, 1.0, np.pi / 2])
def test_both_passes_carry_half_where_neither_strand_bends(angle):
    np.testing.assert_allclose(crossing(0.3, angle=angle).contact.pairs.weight, 0.5)


def test_a_strand_round_another_carries_the_contact():
    """In a capstan of rod on rod every point of the wrap is closest to the core's one section."""
    core = line(20, 40.0, axis=1) - np.array([0.0, 20.0, 0.0])
    phi = np.linspace(-1.5, 1.5, 21)
    R = 2 * RADIUS - 0.2
    corner = R / np.cos(0.075)
    wrap = corner * np.stack([np.sin(phi), 0.01 * phi, np.cos(phi)], axis=1)
    model = begun(Rods([spec(core), spec(wrap)], contact()))
    c = model.contacts()
    force = [c.normal_force[c.rod == rod].sum() for rod in (0, 1)]
    assert force[0] < 0.05 * force[1]
    assert force[1] == pytest.approx(0.2 * hertz_line_stiffness(YOUNGS, 0.5) * 3.0 * R, rel=0.05)


def test_samples_have_no_weight_where_another_strand_begins_to_bend_round_them():
    """Its curvature jumps where pieces of the curve join; beyond the join there is no closest point that stays."""
    directions = np.array([*np.zeros(9), *0.4 * np.arange(1, 6)])
    steps = 2.0 * np.stack([np.cos(directions), 0.0 * directions, np.sin(directions)], axis=1)
    hook = np.cumsum([[-17.0, 0.0, 0.1 - 2 * RADIUS], *steps], axis=0)
    core = line(20, 40.0)[:, [1, 0, 2]] - [0.1, 20.0, 0.0]
    model = begun(Rods([spec(core), spec(hook)], contact()))
    pairs, samples = model.contact.pairs, model.contact.samples
    of_core = samples.rod[pairs.sample] == 0
    touching = of_core & (np.abs(pairs.gap + 0.1) < 0.05)
    assert touching.any()
    assert pairs.weight[touching].max() < 0.01
    opposite = ~of_core & (np.abs(samples.view.at[pairs.sample, 0] - 8.5) < 0.2)
    assert opposite.any()
    assert pairs.weight[opposite].min() > 0.99


def test_neighbours_along_a_strand_do_not_touch():
    phi = np.linspace(0.0, 3.0, 31)
    hairpin = RADIUS * 1.05 * np.stack([np.sin(phi), np.cos(phi), 0 * phi], axis=1)
    model = begun(Rods([spec(hairpin)], contact()))
    assert model.contacts().rod.size == 0


def test_a_rod_finds_all_strands_that_it_touches():
    """A rod lying between two others has two contacts a sample."""
    middle = line(10, 20.0)
    gap = np.array([0.0, 2 * RADIUS - 0.1, 0.0])
    model = begun(Rods([spec(middle), spec(middle + gap), spec(middle - gap)], contact()))
    c = model.contacts()
    own = c.rod == 0
    assert set(c.other[own]) == {1, 2}
    np.testing.assert_allclose(force_on(model, 0), 0.0, atol=1e-12)


def test_rod_on_a_cylinder():
    s = line(20, 40.0)
    model = begun(Rods([spec(s)], contact(), [peg([20.0, 0.0, -RADIUS - 9.8], [2.0, 0.0, 0.0], 10.0, 0.0)]))
    c = model.contacts()
    assert set(c.other) == {-1}
    assert model.penetration == pytest.approx(0.2)
    assert c.normal_force.sum() == pytest.approx(0.2 * 2.0 * hertz_line_stiffness(YOUNGS, 0.5) * 40.0, rel=0.02)
    assert np.all(np.isnan(c.other_arclength))


def test_penetration_is_not_that_of_a_curve_thought_on_beyond_an_end():
    """A strand across another's end, half a segment beyond it, where contact fades."""
    model = crossing(0.5, shift=(21.0, 0.0))
    gap, u = model.contact.pairs.gap, model.contact.pairs.at[:, 0]
    assert gap.min() < -0.4
    beyond = (u < 0.0) | (u > 20.0)
    assert np.all(gap[~beyond] > -0.4)
    assert model.contact.penetration == pytest.approx(max(0.0, -gap[~beyond].min()))
    assert crossing(0.5).penetration == pytest.approx(0.5, rel=0.03)


def test_neighbours_are_sought_anew_by_the_length_of_a_move_whichever_way_it_points():
    for way in ([1.0, 0.0, 0.0], [1.0, 1.0, 1.0]):
        model = crossing(0.5)
        contact, x = model.contact, model.x.copy()
        before = contact.generation
        x[:, :3] += 0.16 * RADIUS * np.array(way) / np.linalg.norm(way)
        contact.update(x)
        assert contact.generation == before + 1
        x[:, 3] += RADIUS
        contact.update(x)
        assert contact.generation == before + 1


def test_a_bundle_may_have_more_neighbours_than_there_is_room_for_at_first():
    """Nineteen parallel strands; inner ones have six neighbours each."""
    h = 2.0 * RADIUS
    places = [(i + 0.5 * j, np.sqrt(0.75) * j) for i in range(-2, 3) for j in range(-2, 3) if abs(i + j) <= 2]
    rods = [spec(line(5, 20.0) + h * np.array([0.0, a, b])) for a, b in places]
    model = begun(Rods(rods, contact()))
    assert len(rods) == 19
    assert model.contact.pairs.sample.size > 4 * model.contact.samples.count
