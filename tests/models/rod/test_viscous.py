"""Drag of a fluid on discrete rods."""

import numpy as np
from reduced import RADIUS, begin, residual, tangent_error

import knotfem as kf
from knotfem.mesh.rod_layout import make_layout
from knotfem.terms.viscous import ViscousDrag

NORMAL, TANGENTIAL = 2e-6, 1e-6


def test_force_on_a_straight_rod_is_length_times_coefficient_times_velocity():
    layout = make_layout([10, 4], [2.0, 3.0], [RADIUS, RADIUS])
    x = np.zeros((layout.nodes, 4))
    x[:11, 0], x[11:, 0], x[11:, 1] = 2.0 * np.arange(11), 3.0 * np.arange(5), 9.0
    edges = np.stack([layout.edges, layout.edges + 1], axis=1)
    drag = ViscousDrag(edges, layout.spacing[layout.edges], NORMAL, TANGENTIAL)
    begin([drag], x)
    moved = x + np.array([0.3, -0.4, 0.0, 1.0])
    force = residual([drag], moved).sum(axis=0)
    np.testing.assert_allclose(force, 32.0 * np.array([0.3 * TANGENTIAL, -0.4 * NORMAL, 0.0, 0.0]), atol=1e-18)
    bent = moved + np.random.default_rng(3).normal(size=x.shape)
    assert tangent_error([drag], bent) < 1e-6


def test_both_models_sag_alike():
    found = {}
    for model in ("fem", "rod"):
        run = kf.pull(
            "cantilever",
            [
                f"model={model}", "rods.0.length=80 mm", "rods.0.mesh.section_elements=4", "solver.threads=1",
                "rods.0.mesh.element_length=4 mm", "rods.0.core=none", "steps.0.rate=real",
                "inertia.scheme=backward-euler",
                "tie.increments=1", "output.fields=false", "steps.0.duration=0.2 s",
                "effects.viscous_drag={normal='600 Pa s', tangential='300 Pa s'}",
            ],
            progress=False,
        )  # fmt: skip
        table = run.table("force")
        assert abs(table["missing_Nmm"][-1]) < 0.05 * table["viscous_drag_Nmm"][-1]
        assert abs(table["drag_Nmm"][-1]) < 1e-12
        found[model] = table["viscous_drag_Nmm"][-1], table["elastic_Nmm"][-1]
    np.testing.assert_allclose(found["rod"], found["fem"], rtol=0.05)
