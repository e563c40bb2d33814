"""Fields at the nodes: what a projection must keep."""

import numpy as np
import pytest
from specimens import make_rod

from knotfem.models.solid.projection import Projection
from knotfem.models.solid.stress import stress_state
from knotfem.scene.elements import ORDERS


def at_points(rod, function) -> np.ndarray:
    """A field at the integration points, shape [slices, quads, points, components]."""
    form, places = rod.bulk.formulation, rod.mesh.nodes[rod.mesh.layers]
    return function(np.einsum("ga,sqai->sqgi", form.shapes, places))


@pytest.mark.parametrize("element", list(ORDERS))
@pytest.mark.parametrize("section", [4, 12, 5])
def test_constants_and_fields_across_the_section_are_met(element, section):
    if section == 5 and element != "hex27":
        section = 20
    rod = make_rod(8.0, 4, section=section, element=element)
    projection = Projection(rod.mesh, rod.bulk.formulation)
    found = projection.nodal(at_points(rod, lambda X: np.stack([0 * X[..., 0] + 2.0, X[..., 0], X[..., 1]], axis=-1)))
    np.testing.assert_allclose(found[:, 0], 2.0, atol=1e-12)
    np.testing.assert_allclose(found[:, 1:], rod.mesh.nodes[:, :2], atol=1e-11)
    if element != "hex8-reduced":
        found = projection.nodal(at_points(rod, lambda X: X[..., 2:]))
        np.testing.assert_allclose(found[:, 0], rod.mesh.nodes[:, 2], atol=1e-10)


@pytest.mark.parametrize("element", list(ORDERS))
def test_the_integral_of_a_field_is_kept(element):
    rod = make_rod(8.0, 4, element=element)
    values = np.random.default_rng(0).standard_normal(
        (*rod.mesh.layers.shape[:2], rod.bulk.formulation.shapes.shape[0], 3)
    )
    found = Projection(rod.mesh, rod.bulk.formulation).nodal(values)
    expected = np.einsum("sqgc,qg->c", values, rod.bulk.formulation.weights)
    mass = rod.mass / rod.density
    np.testing.assert_allclose(mass @ found, expected, atol=1e-10)


@pytest.mark.parametrize("element", list(ORDERS))
def test_stress_and_strain_of_a_homogeneous_state(element):
    rod = make_rod(8.0, 4, element=element, poisson=0.49)
    F = np.eye(3) + 0.1 * np.random.default_rng(2).standard_normal((3, 3))
    x = rod.mesh.nodes @ F.T
    for _ in range(8):
        rod.bulk.assemble(x, np.zeros_like(x), None)
        rod.bulk.increment(np.zeros_like(x))
        rod.bulk.advance(1.0)
    state = stress_state(x, rod.bulk)
    stress, strain = state.nodal(Projection(rod.mesh, rod.bulk.formulation))
    cauchy = state.cauchy[0, 0]
    expected = [cauchy[0, 0], cauchy[1, 1], cauchy[2, 2], cauchy[0, 1], cauchy[1, 2], cauchy[0, 2]]
    np.testing.assert_allclose(stress, np.tile(expected, (len(x), 1)), atol=1e-9)
    np.testing.assert_allclose(strain, 0.5 * np.log(np.linalg.eigvalsh(F.T @ F)[-1]), atol=1e-10)


def test_bending_stress_reaches_the_surface():
    """A stress that grows linearly from the axis is largest at the boundary nodes; means of cells fall short of it."""
    rod = make_rod(16.0, 8, element="hex8", section=44)
    values = at_points(rod, lambda X: X[..., :1])
    found = Projection(rod.mesh, rod.bulk.formulation).nodal(values)[:, 0]
    radius = np.abs(rod.points[:, 0]).max()
    assert found.max() == pytest.approx(radius, rel=1e-9)
    assert values.mean(axis=2).max() < 0.95 * radius
