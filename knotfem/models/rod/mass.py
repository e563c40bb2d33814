"""Lumped masses of position and material frame angle.

The fourth unknown is the angle times the radius, so that the mass that belongs to it is m/2 for a segment of mass m (a
full circular section: rho J h = m r^2/2).
"""

from __future__ import annotations

import numpy as np

from knotfem.mesh.rod_layout import RodLayout


def lumped_mass(layout: RodLayout, mass_per_length: np.ndarray) -> np.ndarray:
    """Mass [tonne] that goes with each unknown, shape [nodes, 4].

    Args:
        layout: of the rods.
        mass_per_length: of each rod [tonne/mm], shape [rods].
    """
    segment = np.asarray(mass_per_length, dtype=float)[layout.rod[layout.edges]] * layout.spacing[layout.edges]
    mass = np.zeros((layout.nodes, 4))
    mass[layout.edges, :3] += 0.5 * segment[:, None]
    mass[layout.edges + 1, :3] += 0.5 * segment[:, None]
    mass[layout.edges, 3] = 0.5 * segment
    return mass
