"""Forces and moments carried across the cross-sections of a rod.

Two ways: nodal forces that the elements on either side of a section exert on its nodes, summed (the paper's Section
5.1), and stresses integrated across the slices next to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from knotfem.geometry.slices import Slices
from knotfem.geometry.vectors import along_and_across, unit_edges
from knotfem.models.profile import section_tangents
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.stress import StressState, layer_forces, middle_forces, stress_state

if TYPE_CHECKING:
    from knotfem.terms.axial import AxialStiffness


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
        return along_and_across(self.force, self.tangent)[0]

    @property
    def shear(self) -> np.ndarray:
        """Size of the force across the tangent, shape [sections]."""
        return along_and_across(self.force, self.tangent)[1]

    @property
    def torque(self) -> np.ndarray:
        """Moment about the tangent, shape [sections]."""
        return along_and_across(self.moment, self.tangent)[0]

    @property
    def bending_moment(self) -> np.ndarray:
        """Size of the moment across the tangent, shape [sections]."""
        return along_and_across(self.moment, self.tangent)[1]


def resultants(
    x: np.ndarray, section_nodes: np.ndarray, axis: int, bulk: Elasticity, core: AxialStiffness | None
) -> Resultants:
    """Forces and moments of one rod.

    Args:
        x: positions [mm], shape [nodes, 3].
        section_nodes: shape [sections, nodes a section].
        axis: which node of a section lies on the centreline.
        bulk: the rod's hexahedra.
        core: its truss, or None.
    """
    centre = x[section_nodes[:, axis]]
    tangent = section_tangents(centre)
    state = stress_state(x, bulk)
    weighted = state.first_piola * state.weights[..., None, None]
    nodal = bulk.nodal_forces(x, weighted)
    slices = _slices_of(bulk, len(centre) - 1)
    force, moment = _carried(x, nodal, bulk.elements, centre, slices)
    axial = np.zeros(section_nodes.shape[0])
    if core is not None:
        pull = slices.at_sections(core.force[:, None] * unit_edges(centre))
        force += pull
        axial = np.einsum("ni,ni->n", pull, tangent)
    integral = _stress_integral(state, bulk, slices)
    return Resultants(force, moment, tangent, axial, np.einsum("ni,ni->n", integral, tangent))


def _slices_of(bulk: Elasticity, count: int) -> Slices:
    span = count // len(bulk.elements)
    return Slices(np.repeat(bulk.layer_heights / span, span))


def _carried(
    x: np.ndarray, nodal: np.ndarray, elements: np.ndarray, centre: np.ndarray, slices: Slices
) -> tuple[np.ndarray, np.ndarray]:
    """Force from behind and its moment about the centre of each section, shapes [sections, 3].

    At the border of layers between what the layer behind exerts and what the one before must be given, at the ends one
    of them; half-way through a layer half the difference of what its faces are given.
    """
    layers, _, count = elements.shape
    span = (len(centre) - 1) // layers
    face = count // (span + 1)
    low, high = nodal[:, :, :face].reshape(layers, -1, 3), nodal[:, :, -face:].reshape(layers, -1, 3)
    x_low = x[elements[:, :, :face]].reshape(layers, -1, 3)
    x_high = x[elements[:, :, -face:]].reshape(layers, -1, 3)

    def at(place: np.ndarray, of_low: float, of_high: float) -> np.ndarray:
        force = of_high * high.sum(axis=1) - of_low * low.sum(axis=1)
        moment = of_high * np.cross(x_high - place[:, None], high).sum(axis=1)
        moment -= of_low * np.cross(x_low - place[:, None], low).sum(axis=1)
        return np.concatenate([force, moment], axis=1)

    behind, before = at(centre[:-1:span], 1.0, 0.0), at(centre[span::span], 0.0, 1.0)
    found = np.empty((len(centre), 6))
    share = (slices.lengths[:-1] / (slices.lengths[:-1] + slices.lengths[1:]))[span - 1 :: span, None]
    found[::span] = np.concatenate([behind[:1], share * behind[1:] + (1.0 - share) * before[:-1], before[-1:]])
    if span == 2:
        found[1::2] = at(centre[1::2], 0.5, 0.5)
    return found[:, :3], found[:, 3:]


def _stress_integral(state: StressState, bulk: Elasticity, slices: Slices) -> np.ndarray:
    """Integral of the bulk's stress, taken to the sections, shape [sections, 3].

    Of eight-node hexahedra across the middle of each slice; of quadratic ones the mean over each layer.
    """
    if len(bulk.elements) == slices.count:
        return slices.at_sections(middle_forces(state, bulk))
    layers = layer_forces(state, bulk)
    found = np.empty((slices.count + 1, 3))
    found[::2], found[1::2] = Slices(bulk.layer_heights).at_sections(layers), layers
    return found
