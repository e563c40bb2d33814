"""Fields of a state of hexahedra for the time series."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from knotfem.models.solid.body import Body
from knotfem.models.solid.stress import stress_state
from knotfem.solver.term import Role, Term

VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def fields(body: Body, terms: Sequence[Term], x: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Point and cell fields of a state: contact pressure; stress, largest principal strain, pressure, tension."""
    stress, strain, pressure, tension = [], [], [], []
    for rod in body.rods:
        state = stress_state(x, rod.bulk)
        cauchy = state.cauchy.reshape(-1, 3, 3)
        stress.append(np.stack([cauchy[:, i, j] for i, j in VOIGT], axis=1))
        strain.append(state.largest_principal_strain.ravel())
        pressure.append(-np.trace(cauchy, axis1=1, axis2=2) / 3.0)
        axial = np.einsum("sqgik,qg->sqik", state.first_piola, state.weights)[..., 2]
        axial /= rod.mesh.span * rod.mesh.element_length
        edge = np.diff(x[rod.axis_nodes[:: rod.mesh.span]], axis=0)
        edge /= np.linalg.norm(edge, axis=1)[:, None]
        force = np.einsum("sqi,si->s", axial, edge) + (
            rod.core.force.reshape(-1, rod.mesh.span).mean(axis=1) if rod.core is not None else 0.0
        )
        tension.append(np.repeat(force, rod.bulk.elements.shape[1]))
    points = {"contact_pressure": _contact_pressure(body, terms)}
    cells = {
        "stress": np.concatenate(stress),
        "largest_principal_strain": np.concatenate(strain),
        "pressure": np.concatenate(pressure),
        "tension": np.concatenate(tension),
    }
    return points, cells


def _contact_pressure(body: Body, terms: Sequence[Term]) -> np.ndarray:
    if not any(term.role is Role.CONTACT for term in terms):
        return np.zeros(body.nodes)
    from knotfem.models.solid.pressure import contact_pressure

    return contact_pressure(body.nodes, terms)
