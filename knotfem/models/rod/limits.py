"""Limits of the rod model: rigid sections, slender bends, segments short enough (docs/rod-model.md, "Limits")."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from knotfem.geometry.measures import curvature, turning_angles
from knotfem.models.limits import Reach
from knotfem.scene.model import Scene

SQUASHED = 0.1
"""Depth, in diameters, to which a contact would squash sections of the rod's material after Hertz. At 0.04 (bowline
pulled by 33 radii) and 0.05 (Zeppelin bend) forces differ from those of hexahedra by 5 to 8 %."""
CURVATURE = 1.0
"""Product of curvature and diameter. Outer fibres are stretched by half of it, where the material is linear no longer;
up to 0.87 (Carrick bend) the model was held against hexahedra."""
TURN = 0.4
"""Angle by which a rod turns from segment to segment [rad]. With 0.37 (segments of one radius) the force of the bowline
at 33 radii errs by 5 %, with 0.49 by 12 %."""


def reaches(scene: Scene, lines: Sequence[np.ndarray], penetration: float) -> list[Reach]:
    """Measures of a state of discrete rods.

    Args:
        scene: of the rods.
        lines: vertices of each rod [mm], shape [n, 3] each.
        penetration: deepest [mm].
    """
    deep = penetration / scene.diameter
    squashed = deep * scene.contact.line_stiffness_over_hertz ** (2.0 / 3.0)
    bent = max(float(curvature(x).max()) * rod.diameter for x, rod in zip(lines, scene.rods, strict=True))
    turn, length = max(_sharpest(x, rod.diameter) for x, rod in zip(lines, scene.rods, strict=True))
    return [
        Reach(
            "squashed_over_d", squashed, SQUASHED,
            f"contacts, {deep:.2g} d deep, would squash real sections by {squashed:.2g} d (limit {SQUASHED:g} d)",
        ),
        Reach(
            "curvature_times_d", bent, CURVATURE,
            f"curvature times diameter is {bent:.2f} (limit {CURVATURE:g})",
        ),
        Reach(
            "turn_per_segment", turn, TURN,
            f"segments of {length:.2g} d turn by {turn:.2f} rad each (limit {TURN:g} rad); take shorter ones",
        ),
    ]  # fmt: skip


def _sharpest(x: np.ndarray, diameter: float) -> tuple[float, float]:
    """Largest angle between two segments [rad], and the mean length of the two over the diameter."""
    turns = turning_angles(x)
    i = int(np.argmax(turns))
    return float(turns[i]), float(np.linalg.norm(np.diff(x[i : i + 3], axis=0), axis=1).mean()) / diameter
