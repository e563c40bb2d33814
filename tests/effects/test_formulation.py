import numpy as np
import pytest
from derivatives import tangent
from specimens import make_rod

from knotfem.errors import InputError
from knotfem.mesh.make_section import section_of
from knotfem.models.solid.formulation import make_formulation, names


@pytest.mark.parametrize("element", ["hex8", "hex8-reduced", "hex8-incompatible"])
def test_gradients_reproduce_linear_fields_and_weights_the_volume(element):
    section = section_of(44)
    quads = section.points[section.quads]
    form = make_formulation(element, quads, 0.7)
    corners = np.concatenate([np.concatenate([quads, np.full((44, 4, 1), z)], axis=2) for z in (0.0, 0.7)], axis=1)
    gradient = np.einsum("qai,qgak->qgik", corners, form.grads)
    np.testing.assert_allclose(gradient, np.broadcast_to(np.eye(3), gradient.shape), atol=1e-12)
    sides = section.sides
    assert form.weights.sum() == pytest.approx(0.7 * 0.5 * sides * np.sin(2 * np.pi / sides), rel=1e-12)
    np.testing.assert_allclose(form.shapes.sum(axis=1), 1.0)


@pytest.mark.parametrize("element", ["hex8", "hex8-reduced", "hex8-incompatible", "hex27"])
def test_only_rigid_motions_are_free(element):
    rod = make_rod(4.0, 2, element=element)
    values = np.linalg.eigvalsh(tangent([rod.bulk], rod.mesh.nodes))
    assert values[5] < 1e-9 * values[-1]
    assert values[6] > 1e-6 * values[-1]


@pytest.mark.parametrize("elements", [4, 5, 12])
def test_quadratic_tables_reproduce_quadratic_fields_and_masses_are_positive(elements):
    rod = make_rod(6.0, 4, section=elements, element="hex27")
    form, X = rod.bulk.formulation, rod.mesh.nodes
    H = np.random.default_rng(3).standard_normal((3, 3))
    inner = X[rod.bulk.elements[0]]
    np.testing.assert_allclose(
        np.einsum("qai,qgak->qgik", inner, form.grads), np.broadcast_to(np.eye(3), (elements, 27, 3, 3)), atol=1e-12
    )
    if elements == 5:
        middle = inner[:1]
        place = np.einsum("ga,qai->qgi", form.shapes, middle)
        found = np.einsum("qa,qgak->qgk", np.einsum("qai,ij,qaj->qa", middle, H, middle), form.grads[:1])
        np.testing.assert_allclose(found, place @ (H + H.T), atol=1e-11)
    assert rod.mass.min() > 0.0
    assert rod.mass.sum() == pytest.approx(rod.density * rod.area * 6.0)


def test_unknown_names_are_refused():
    assert names() == ["hex8", "hex8-reduced", "hex8-incompatible", "hex27"]
    with pytest.raises(InputError, match="hex20"):
        make_formulation("hex20", np.zeros((1, 4, 2)), 1.0)
