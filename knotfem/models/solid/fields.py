"""Fields of a state of hexahedra for the time series."""

from __future__ import annotations

import numpy as np

from knotfem.models.solid.assembly import Model
from knotfem.models.solid.stress import stress_state

VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def fields(model: Model, x: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Point and cell fields of a state: contact pressure; stress, largest principal strain, pressure, tension."""
    body = model.body
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
    points = {"contact_pressure": contact_pressure(model, x)}
    cells = {
        "stress": np.concatenate(stress),
        "largest_principal_strain": np.concatenate(strain),
        "pressure": np.concatenate(pressure),
        "tension": np.concatenate(tension),
    }
    return points, cells


def contact_pressure(model: Model, x: np.ndarray) -> np.ndarray:
    """Normal contact force of the samples spread on their nodes, over the nodes' share of the surface [MPa]."""
    force, area = np.zeros(model.body.nodes), np.zeros(model.body.nodes)
    contacts = model.named("contact")
    for contact in contacts:
        samples = contact.samples
        weights = np.maximum(samples.weights, 0.0)
        np.add.at(area, samples.nodes, weights * samples.area[:, None])
        touching = contact.pairs[:, 0]
        np.add.at(force, samples.nodes[touching], 2.0 * weights[touching] * contact.force[:, None])
        for cylinder in model.named("cylinder"):
            near = cylinder.touching
            np.add.at(force, samples.nodes[near], weights[near] * cylinder.force[near][:, None])
    return np.divide(force, area, out=np.zeros_like(force), where=area > 0.0)
