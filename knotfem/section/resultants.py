"""Forces and moments carried across the cross-sections of a rod.

Two independent ways: nodal forces that the elements on either side of a section exert on its nodes, summed (the
paper's Section 5.1), and stresses integrated over the planes of integration points next to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from knotfem.effects.elasticity import Elasticity
from knotfem.effects.stress import stress_state

if TYPE_CHECKING:
    from knotfem.effects.core import Core


@dataclass(frozen=True, eq=False)
class Resultants:
    """What the part of the rod behind each section exerts on it; forces in N, moments in N mm.

    Attributes:
        force: from nodal forces, shape [sections, 3].
        moment: about the axis node, from nodal forces, shape [sections, 3].
        tangent: unit tangent of the centreline, shape [sections, 3].
        core: axial force of the core along the tangent, shape [sections].
        bulk: integral of the bulk's stress along the tangent, shape [sections].
    """

    force: np.ndarray
    moment: np.ndarray
    tangent: np.ndarray
    core: np.ndarray
    bulk: np.ndarray

    @property
    def tension(self) -> np.ndarray:
        """Nodal forces along the tangent, shape [sections]."""
        return np.einsum("ni,ni->n", self.force, self.tangent)

    @property
    def shear(self) -> np.ndarray:
        """Size of the force across the tangent, shape [sections]."""
        return np.linalg.norm(self.force - self.tension[:, None] * self.tangent, axis=1)

    @property
    def torque(self) -> np.ndarray:
        """Moment about the tangent, shape [sections]."""
        return np.einsum("ni,ni->n", self.moment, self.tangent)

    @property
    def bending_moment(self) -> np.ndarray:
        """Size of the moment across the tangent, shape [sections]."""
        return np.linalg.norm(self.moment - self.torque[:, None] * self.tangent, axis=1)


def resultants(x: np.ndarray, section_nodes: np.ndarray, axis: int, bulk: Elasticity, core: Core | None) -> Resultants:
    """Forces and moments of one rod.

    Args:
        x: positions [mm], shape [nodes, 3].
        section_nodes: shape [sections, nodes a section].
        axis: which node of a section lies on the centreline.
        bulk: the rod's hexahedra.
        core: its truss, or None.
    """
    centre = x[section_nodes[:, axis]]
    tangent = _tangents(centre)
    state = stress_state(x, bulk)
    weighted = state.first_piola * state.weights[None, :, :, None, None]
    nodal = bulk.nodal_forces(x, weighted)
    across = _across_sections(nodal, bulk.elements, section_nodes)
    axial = np.zeros(section_nodes.shape[0])
    if core is not None:
        edge = np.diff(centre, axis=0)
        edge /= np.linalg.norm(edge, axis=1)[:, None]
        pull = _to_sections(core.force[:, None] * edge)
        across[:, axis] += pull
        axial = np.einsum("ni,ni->n", pull, tangent)
    arm = x[section_nodes] - centre[:, None]
    planes = _plane_forces(weighted, bulk)
    return Resultants(
        across.sum(axis=1),
        np.cross(arm, across).sum(axis=1),
        tangent,
        axial,
        np.einsum("ni,ni->n", planes, tangent),
    )


def _across_sections(nodal: np.ndarray, elements: np.ndarray, section_nodes: np.ndarray) -> np.ndarray:
    """Force carried to the nodes of each section from behind, shape [sections, nodes a section, 3].

    The mean of what the slice behind exerts and of what the slice before must be given; at the ends there is one.
    """
    slices, half = elements.shape[0], elements.shape[2] // 2
    behind = np.zeros((slices, section_nodes.shape[1], 3))
    before = np.zeros_like(behind)
    for layer in range(slices):
        np.add.at(behind[layer], elements[layer, :, :half] - section_nodes[layer, 0], -nodal[layer, :, :half])
        np.add.at(before[layer], elements[layer, :, half:] - section_nodes[layer + 1, 0], nodal[layer, :, half:])
    return np.concatenate([behind[:1], 0.5 * (behind[1:] + before[:-1]), before[-1:]])


def _plane_forces(weighted: np.ndarray, bulk: Elasticity) -> np.ndarray:
    """Integral of P e_z over planes of integration points, taken to the sections, shape [sections, 3]."""
    points = weighted.shape[2]
    planes = max(1, points // 4)
    per_plane = weighted[..., 2].reshape(*weighted.shape[:2], planes, points // planes, 3).sum(axis=(1, 3))
    height = _height(bulk)
    force = per_plane * planes / height
    if planes == 1:
        return _to_sections(force[:, 0])
    between = 0.5 * (force[1:, 0] + force[:-1, -1])
    return np.concatenate([force[:1, 0], between, force[-1:, -1]])


def _height(bulk: Elasticity) -> float:
    """Slice length: one over the axial gradient of the sum of the far nodes' shape functions."""
    half = bulk.elements.shape[2] // 2
    return float(1.0 / bulk.formulation.grads[0, 0, half:, 2].sum())


def _to_sections(per_slice: np.ndarray) -> np.ndarray:
    return np.concatenate([per_slice[:1], 0.5 * (per_slice[1:] + per_slice[:-1]), per_slice[-1:]])


def _tangents(centre: np.ndarray) -> np.ndarray:
    edge = np.diff(centre, axis=0)
    edge /= np.linalg.norm(edge, axis=1)[:, None]
    t = _to_sections(edge)
    return t / np.linalg.norm(t, axis=1)[:, None]
