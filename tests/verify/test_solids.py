import numpy as np

from knotfem.models.solid.formulation import make_formulation
from knotfem.verify.benchmarks.rods import make_rod
from knotfem.verify.benchmarks.solids import CORNERS, tables


def test_tables_of_extruded_bricks_are_those_of_hex8():
    rod = make_rod(9.0, 6, section=20, element="hex8")
    first = rod.mesh.nodes[rod.mesh.hexes[: len(rod.mesh.section.quads)]]
    own = tables(first, CORNERS / np.sqrt(3.0))
    known = make_formulation("hex8", rod.points[rod.mesh.section.quads], rod.mesh.element_length)
    order = [int(np.abs(known.shapes - shape).sum(axis=1).argmin()) for shape in own.shapes]
    assert sorted(order) == list(range(8))
    np.testing.assert_allclose(own.shapes, known.shapes[order], atol=1e-14)
    np.testing.assert_allclose(own.grads, known.grads[:, order], atol=1e-12)
    np.testing.assert_allclose(own.weights, known.weights[:, order], rtol=1e-12)


def test_reduced_tables_hold_the_same_volume():
    rod = make_rod(9.0, 6, section=20)
    first = rod.mesh.nodes[rod.mesh.hexes[: len(rod.mesh.section.quads)]]
    own = tables(first, np.array([1.0, 1.0, 0.0]) * CORNERS[:4] / np.sqrt(3.0))
    np.testing.assert_allclose(own.weights, rod.bulk.formulation.weights, rtol=1e-12)
    np.testing.assert_allclose(own.grads, rod.bulk.formulation.grads, atol=1e-12)
