import numpy as np
import pytest
from derivatives import rotation
from specimens import Rod, make_rod, static

from knotfem.models.solid.resultants import Resultants, resultants
from knotfem.solver.constraints import Prescribed, held
from knotfem.solver.nonlinear.tolerance import Sections
from knotfem.terms.gravity import Gravity
from knotfem.terms.load import EndForce, FollowingForce

Z = np.array([0.0, 0.0, 1.0])


def carried(rod: Rod, x: np.ndarray) -> Resultants:
    return resultants(x, rod.sections, rod.mesh.section.axis, rod.bulk, rod.core)


def solved(rod: Rod, loads: list, ends: list[Prescribed]) -> np.ndarray:
    return static([*rod.terms, *loads], rod.mesh.nodes, ends, Sections.single(rod.section_of_node))[0]


def clamp(rod: Rod, end: int = 0) -> Prescribed:
    return held(rod.sections[end], rod.mesh.nodes[rod.sections[end]])


@pytest.mark.parametrize("element", ["hex8", "hex8-reduced", "hex8-incompatible", "hex27"])
@pytest.mark.parametrize("core", [0.0, 3826.0])
def test_pulled_rod_carries_the_pull_through_every_section(element, core):
    rod = make_rod(30.0, 20, element=element, core_stiffness=core)
    weights = rod.end_weights * 35.0
    weights[rod.mesh.section.axis] += core
    x = solved(rod, [EndForce(rod.sections[-1], weights / weights.sum(), lambda t: 2.0 * t * Z)], [clamp(rod)])
    found = carried(rod, x)
    np.testing.assert_allclose(found.tension, 2.0, rtol=1e-8)
    inner = slice(6, -6)
    np.testing.assert_allclose((found.core + found.bulk)[inner], 2.0, rtol=1e-3)
    np.testing.assert_allclose(found.shear, 0.0, atol=1e-8)
    np.testing.assert_allclose(found.moment, 0.0, atol=1e-8)
    if core:
        np.testing.assert_allclose(found.core[inner], 2.0 * 3826.0 / (3826.0 + 1.25 * np.pi * 9.0), rtol=1e-3)


def test_hanging_rod_carries_the_weight_below():
    rod = make_rod(60.0, 20)
    g = 9810.0
    x = solved(rod, [Gravity(rod.mass, g * Z)], [clamp(rod)])
    weight = g * rod.mass.sum()
    below = weight * (1.0 - np.arange(21) / 20.0)
    below[[0, -1]] += weight / 40.0 * np.array([-1.0, 1.0])
    np.testing.assert_allclose(carried(rod, x).tension, below, rtol=1e-7)


def test_end_moment_bends_every_section():
    rod = make_rod(60.0, 30)
    moment = 0.3
    couple = FollowingForce(
        rod.sections[-1], -rod.couple_weights(0), int(rod.axis[-2]), int(rod.axis[-1]), lambda t: moment * t
    )
    x = solved(rod, [couple], [clamp(rod)])
    found = carried(rod, x)
    np.testing.assert_allclose(np.abs(found.moment[:, 1]), moment, rtol=0.01)
    np.testing.assert_allclose(found.bending_moment[2:-1], moment, rtol=0.01)
    np.testing.assert_allclose(found.torque, 0.0, atol=1e-6)
    np.testing.assert_allclose(found.force, 0.0, atol=1e-7)


def test_cantilever_carries_shear_and_a_moment_that_falls_to_the_tip():
    rod = make_rod(60.0, 30)
    push = 1e-4
    x = solved(rod, [EndForce(rod.sections[-1], rod.end_weights, lambda t: np.array([push, 0.0, 0.0]))], [clamp(rod)])
    found = carried(rod, x)
    np.testing.assert_allclose(found.force, np.broadcast_to([push, 0.0, 0.0], found.force.shape), atol=1e-10)
    lever = 60.0 - rod.mesh.nodes[rod.axis, 2]
    np.testing.assert_allclose(found.moment[:-1, 1], push * lever[:-1], atol=push * 0.1)
    np.testing.assert_allclose(found.shear, push, rtol=1e-3)


def test_twisted_rod_carries_a_torque():
    rod = make_rod(20.0, 20)
    angle = 0.02
    c, s = np.cos(angle), np.sin(angle)
    far = rod.mesh.nodes[rod.sections[-1]] @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    x = solved(rod, [], [clamp(rod), held(rod.sections[-1], far)])
    found = carried(rod, x)
    G = rod.bulk.shear_modulus
    np.testing.assert_allclose(found.torque, G * np.pi * 3.0**4 / 2.0 * angle / 20.0, rtol=0.01)
    np.testing.assert_allclose(found.bending_moment, 0.0, atol=1e-6)


def test_frame_indifference():
    rod = make_rod(20.0, 10, core_stiffness=100.0)
    x = rod.mesh.nodes + 0.1 * np.random.default_rng(0).standard_normal(rod.mesh.nodes.shape)
    before = carried(rod, x)
    Q = rotation()
    after = carried(rod, x @ Q.T + 7.0)
    for name in ("force", "moment", "tangent"):
        np.testing.assert_allclose(getattr(after, name), getattr(before, name) @ Q.T, atol=1e-9)
    for name in ("tension", "core", "bulk", "shear", "torque", "bending_moment"):
        np.testing.assert_allclose(getattr(after, name), getattr(before, name), atol=1e-9)


def test_another_rod_before_it_changes_nothing():
    first = make_rod(20.0, 10, core_stiffness=100.0)
    second = make_rod(20.0, 10, core_stiffness=100.0, first=len(first.mesh.nodes))
    x = first.mesh.nodes + 0.1 * np.random.default_rng(0).standard_normal(first.mesh.nodes.shape)
    both = np.vstack([np.zeros_like(x), x])
    np.testing.assert_array_equal(carried(second, both).tension, carried(first, x).tension)
