import numpy as np
import pytest
from derivatives import tangent
from specimens import make_rod

from knotfem.errors import InputError
from knotfem.mesh.make_section import section_of
from knotfem.models.solid.formulation import brick_formulation, make_formulation
from knotfem.scene.elements import ORDERS

GAUSS = 1.0 / np.sqrt(3.0)
CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def by_hand(quads: np.ndarray, height: float, axial: tuple[float, ...]) -> tuple[np.ndarray, ...]:
    """Tables of extruded trilinear hexahedra, the section's plane and the axis apart."""
    points = 4 * len(axial)
    grads, weights, shapes = np.empty((len(quads), points, 8, 3)), np.empty((len(quads), points)), np.empty((points, 8))
    for point, (zeta, (xi, eta)) in enumerate((z, corner) for z in axial for corner in CORNERS * GAUSS):
        line = np.array([(1 - zeta) / 2, (1 + zeta) / 2])
        x, y = CORNERS.T
        flat = (1 + x * xi) * (1 + y * eta) / 4
        rates = np.stack([x * (1 + y * eta), y * (1 + x * xi)], axis=1) / 4
        jacobian = np.einsum("qai,ak->qik", quads, rates)
        in_plane = np.einsum("ak,qki->qai", rates, np.linalg.inv(jacobian))
        for level, sign in enumerate((-1.0, 1.0)):
            nodes = slice(4 * level, 4 * level + 4)
            grads[:, point, nodes, :2] = in_plane * line[level]
            grads[:, point, nodes, 2] = flat * sign / height
            shapes[point, nodes] = flat * line[level]
        weights[:, point] = np.linalg.det(jacobian) * height / len(axial)
    return grads, weights, shapes


@pytest.mark.parametrize(
    ("element", "axial"),
    [("hex8", (-GAUSS, GAUSS)), ("hex8-reduced", (0.0,)), ("hex8-incompatible", (-GAUSS, GAUSS))],
)
def test_tables_are_those_worked_out_by_hand(element, axial):
    section = section_of(44)
    quads = 3.0 * section.points[section.quads]
    form = make_formulation(element, quads, 0.7)
    grads, weights, shapes = by_hand(quads, 0.7, axial)
    np.testing.assert_allclose(form.grads, grads, atol=1e-14 * np.abs(grads).max())
    np.testing.assert_allclose(form.weights, weights, rtol=1e-14)
    np.testing.assert_allclose(form.shapes, shapes, atol=1e-14)
    if element == "hex8-incompatible":
        rates = np.array([[*corner, level] for level in (-1.0, 1.0) for corner in CORNERS]) / 8.0
        np.testing.assert_allclose(form.centre, rates, atol=1e-15)


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


@pytest.mark.parametrize("element", ["hex8", "hex8-reduced", "hex8-incompatible"])
def test_bricks_of_any_shape(element):
    rng = np.random.default_rng(2)
    cube = np.array([[*corner, level] for level in (-1.0, 1.0) for corner in CORNERS])
    nodes = cube + rng.uniform(-0.2, 0.2, (5, 8, 3))
    form = brick_formulation(element, nodes)
    F = np.eye(3) + rng.uniform(-0.3, 0.3, (3, 3))
    gradient = np.einsum("eai,egak->egik", nodes @ F.T, form.grads)
    np.testing.assert_allclose(gradient, np.broadcast_to(F, gradient.shape), atol=1e-12)
    np.testing.assert_allclose(
        brick_formulation(element, nodes @ F.T).weights, np.linalg.det(F) * form.weights, rtol=1e-12
    )
    if element == "hex8-incompatible":
        np.testing.assert_allclose(np.einsum("eg,egm->em", form.weights, form.modes), 0.0, atol=1e-12)


@pytest.mark.parametrize("element", list(ORDERS))
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
    with pytest.raises(InputError, match="hex20"):
        make_formulation("hex20", np.zeros((1, 4, 2)), 1.0)
