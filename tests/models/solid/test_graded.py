"""Hexahedra of unequal lengths along a rod."""

import numpy as np
import pytest
from derivatives import directional_error, residual
from specimens import make_rod

from knotfem.geometry.slices import Slices
from knotfem.models.solid.projection import Projection
from knotfem.models.solid.resultants import resultants
from knotfem.models.solid.stress import stress_state
from knotfem.terms.axial import AxialStiffness
from knotfem.terms.load import EndForce
from knotfem.verify.benchmarks.bending import loaded

ELEMENTS = ["hex8", "hex8-reduced", "hex8-incompatible", "hex27"]
LENGTHS = np.repeat(1.15 ** np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0]), 2)
LENGTH = float(LENGTHS.sum())


def graded(element: str, poisson: float = 0.49, **more):
    return make_rod(LENGTH, Slices(LENGTHS), element=element, poisson=poisson, **more)


def relaxed(bulk, x) -> None:
    """Give pressures and modes the values that belong to x."""
    for _ in range(8 if bulk.modes.size else 1):
        bulk.assemble(x, np.zeros_like(x), None)
        bulk.increment(np.zeros_like(x))
        bulk.advance(1.0)


@pytest.mark.parametrize("element", ELEMENTS)
def test_mesh_mass_and_volume_are_those_of_the_whole_rod(element):
    rod = graded(element)
    z = rod.mesh.nodes[rod.mesh.axis_nodes, 2]
    np.testing.assert_allclose(z, np.concatenate([[0.0], np.cumsum(LENGTHS)]), atol=1e-12)
    equal = make_rod(LENGTH, 12, element=element)
    assert rod.mesh.length == LENGTH
    assert rod.mass.sum() == pytest.approx(equal.mass.sum(), rel=1e-12)
    assert rod.bulk.weights.sum() == pytest.approx(equal.bulk.weights.sum(), rel=1e-12)
    masses = rod.mass[rod.mesh.section_nodes].sum(axis=1) / rod.mass.sum()
    slices, middles = LENGTHS / LENGTH, 0.5 * (z[1:] + z[:-1])
    assert masses @ z == pytest.approx(slices @ middles, rel=1e-12)
    np.testing.assert_allclose(rod.bulk.layer_heights, LENGTHS[:: rod.mesh.span] * rod.mesh.span)


@pytest.mark.parametrize("element", ELEMENTS)
def test_homogeneous_deformation_is_met_and_leaves_inner_nodes_without_force(element):
    rod = graded(element)
    F = np.array([[0.95, 0.03, 0.02], [0.0, 0.97, -0.04], [0.01, 0.05, 1.1]])
    x = rod.mesh.nodes @ F.T
    relaxed(rod.bulk, x)
    np.testing.assert_allclose(rod.bulk.deformation(x), np.broadcast_to(F, (*rod.bulk.weights.shape, 3, 3)), atol=1e-12)
    forces = residual([rod.bulk], x)
    inner = np.setdiff1d(np.arange(len(x)), rod.mesh.surface.ravel())
    inner = inner[(rod.mesh.nodes[inner, 2] > 0.0) & (rod.mesh.nodes[inner, 2] < LENGTH)]
    np.testing.assert_allclose(forces[inner], 0.0, atol=1e-10 * np.abs(forces).max())
    state = stress_state(x, rod.bulk)
    np.testing.assert_allclose(state.cauchy, np.broadcast_to(state.cauchy[0, 0], state.cauchy.shape), atol=1e-9)
    nodal, _ = state.nodal(Projection(rod.mesh, rod.bulk.formulation))
    np.testing.assert_allclose(nodal, np.broadcast_to(nodal[0], nodal.shape), atol=1e-8)
    found = resultants(x, rod.mesh.section_nodes, rod.mesh.section.axis, rod.bulk, None)
    np.testing.assert_allclose(found.force, np.broadcast_to(found.force[0], found.force.shape), rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(found.bulk, found.bulk[0], rtol=1e-8)


@pytest.mark.parametrize("element", ELEMENTS)
def test_nodal_forces_of_a_graded_element_are_those_of_a_uniform_mesh(element):
    """Energy and forces of a deformation that only bends within one element are those of an equal rod's element."""
    rod, order = graded(element), 2 if element == "hex27" else 1
    layer = 3
    own = rod.bulk.elements[layer]
    equal = make_rod(float(rod.bulk.layer_heights[layer]) * 2, 2 * order, element=element, poisson=0.49)
    rng = np.random.default_rng(2)
    local = rng.standard_normal((len(np.unique(own)), 3))
    x, y = rod.mesh.nodes.copy(), equal.mesh.nodes.copy()
    moved, alike = np.unique(own), np.unique(equal.bulk.elements[0])
    x[moved] += 0.02 * local
    y[alike] += 0.02 * local
    relaxed(rod.bulk, x)
    relaxed(equal.bulk, y)
    forces = [
        bulk.nodal_forces(place, s.first_piola * s.weights[..., None, None])[which]
        for bulk, place, which, s in (
            (rod.bulk, x, layer, stress_state(x, rod.bulk)),
            (equal.bulk, y, 0, stress_state(y, equal.bulk)),
        )
    ]
    np.testing.assert_allclose(forces[0], forces[1], atol=1e-8 * np.abs(forces[1]).max())


@pytest.mark.parametrize("element", ELEMENTS)
def test_tangent_is_the_derivative_of_the_residual_and_that_the_gradient_of_the_energy(element):
    rod = graded(element)
    x = rod.mesh.nodes + 0.03 * np.random.default_rng(1).standard_normal(rod.mesh.nodes.shape)
    relaxed(rod.bulk, x)
    assert directional_error([rod.bulk], x) < 1e-7
    d, h = np.random.default_rng(4).standard_normal(x.shape), 1e-5
    energies = []
    for sign in (1.0, -1.0):
        relaxed(rod.bulk, x + sign * h * d)
        energies.append(rod.bulk.energy(x + sign * h * d))
    relaxed(rod.bulk, x)
    assert (energies[0] - energies[1]) / (2.0 * h) == pytest.approx(
        float((residual([rod.bulk], x) * d).sum()), rel=1e-5
    )


def sag(slices: int | Slices, element: str) -> float:
    """Sag over length of a cantilever, L/r = 40, under a dead transverse tip load P L^2/EI = 5."""
    rod = make_rod(40.0, slices, radius=1.0, section=12, element=element)
    force = 5.0 * rod.bending / 40.0**2 * np.array([1.0, 0.0, 0.0])
    tip = EndForce(rod.sections[-1], rod.end_weights, lambda t: t * force)
    reaction = EndForce(rod.sections[0], rod.end_weights, lambda t: -t * force)
    return float(loaded(rod, [tip, reaction])[-1, 0] / 40.0)


@pytest.mark.parametrize("element", ["hex8-reduced", "hex27"])
def test_cantilever_of_slices_that_are_short_at_the_clamp_lies_between_coarse_and_fine(element):
    order = 2 if element == "hex27" else 1
    lengths = 1.15 ** np.arange(10)
    graded = Slices(np.repeat(lengths * 40.0 / lengths.sum() / order, order))
    coarse, between, fine = (sag(slices, element) for slices in (10 * order, graded, 60 * order))
    assert abs(between - fine) < 0.7 * abs(coarse - fine)
    assert between == pytest.approx(fine, rel=2e-3)


@pytest.mark.parametrize("element", ["hex8-reduced", "hex27"])
def test_tension_that_grows_along_the_rod_is_met_at_the_sections(element):
    """Slices stretched by c z each carry a force in proportion to z."""
    rod = graded(element)
    x = rod.mesh.nodes.copy()
    x[:, 2] += 0.5e-5 * x[:, 2] ** 2
    relaxed(rod.bulk, x)
    core = AxialStiffness("core", rod.mesh.core, rod.mesh.lengths, np.ones(12), np.ones(12))
    core.force[:] = core.tension(x)
    found = resultants(x, rod.mesh.section_nodes, rod.mesh.section.axis, rod.bulk, core)
    inner, z = slice(rod.mesh.span, -rod.mesh.span, rod.mesh.span), x[rod.mesh.axis_nodes, 2]
    for force in (found.tension, found.bulk, found.core):
        np.testing.assert_allclose(force[inner] / z[inner], force[inner][0] / z[inner][0], rtol=2e-3)
