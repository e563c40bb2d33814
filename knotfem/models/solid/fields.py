"""Fields of a state of hexahedra for the time series."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from knotfem.geometry.vectors import unit_edges
from knotfem.mesh.rod import RodMesh
from knotfem.models.solid.body import Body
from knotfem.models.solid.stress import layer_forces, stress_state, symmetric
from knotfem.solver.term import Role, Term


def fields(body: Body, terms: Sequence[Term], x: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Point and cell fields of a state.

    Points carry contact pressure, stress, pressure and largest principal strain (projected, see `Projection`), and the
    tension of their section; cells carry the means of stress and pressure over each hexahedron, the largest principal
    strain of its mean, and the tension of its slice.

    Args:
        body: rods.
        terms: of the model.
        x: positions [mm], shape [nodes, 3].
    """
    stress, strain, pressure, tension = [], [], [], []
    nodal_stress, nodal_strain, nodal_tension = [], [], []
    for rod in body.rods:
        state = stress_state(x, rod.bulk)
        cauchy = state.cauchy.reshape(-1, 3, 3)
        stress.append(symmetric(cauchy))
        strain.append(state.largest_principal_strain.ravel())
        pressure.append(-np.trace(cauchy, axis1=1, axis2=2) / 3.0)
        edge = unit_edges(x[rod.axis_nodes[:: rod.mesh.span]])
        force = np.einsum("si,si->s", layer_forces(state, rod.bulk), edge)
        if rod.core is not None:
            force += rod.core.force.reshape(-1, rod.mesh.span).mean(axis=1)
        tension.append(np.repeat(force, rod.bulk.elements.shape[1]))
        at_nodes = state.nodal(rod.projection)
        nodal_stress.append(at_nodes[0])
        nodal_strain.append(at_nodes[1])
        nodal_tension.append(_at_sections(force, rod.mesh))
    points = {
        "contact_pressure": _contact_pressure(body, terms),
        "stress": np.concatenate(nodal_stress),
        "pressure": -np.concatenate(nodal_stress)[:, :3].mean(axis=1),
        "largest_principal_strain": np.concatenate(nodal_strain),
        "tension": np.concatenate(nodal_tension),
    }
    cells = {
        "stress": np.concatenate(stress),
        "largest_principal_strain": np.concatenate(strain),
        "pressure": np.concatenate(pressure),
        "tension": np.concatenate(tension),
    }
    return points, cells


def _at_sections(force: np.ndarray, mesh: RodMesh) -> np.ndarray:
    """Values of slices at the nodes of all sections, between two slices their mean, shape [nodes]."""
    sections = np.interp(np.arange(len(mesh.section_nodes)) / mesh.span, np.arange(len(force)) + 0.5, force)
    nodes = np.empty(len(mesh.nodes))
    nodes[mesh.section_nodes] = sections[:, None]
    return nodes


def _contact_pressure(body: Body, terms: Sequence[Term]) -> np.ndarray:
    if not any(term.role is Role.CONTACT for term in terms):
        return np.zeros(body.nodes)
    from knotfem.models.solid.pressure import contact_pressure

    return contact_pressure(body.nodes, terms)
