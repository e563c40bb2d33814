"""Where strands press on each other and on obstacles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class ContactReport:
    """Where strands press on each other, or on an obstacle; one entry for each sample in contact.

    Attributes:
        rod: of the sample, shape [n].
        arclength: of the sample [mm], shape [n].
        other: rod that it touches, or -1 - c for obstacle c, shape [n].
        other_arclength: of the closest point [mm], nan on an obstacle, shape [n].
        gap: [mm], shape [n].
        normal: unit vector from the other surface to the sample, shape [n, 3].
        normal_force: [N], shape [n].
        friction_force: [N], shape [n].
        slides: whether friction holds no longer, as it never does where there is none, shape [n].
    """

    rod: np.ndarray
    arclength: np.ndarray
    other: np.ndarray
    other_arclength: np.ndarray
    gap: np.ndarray
    normal: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    slides: np.ndarray

    @classmethod
    def empty(cls) -> ContactReport:
        """Of a model without contact, or of strands that do not touch."""
        nothing, none = np.zeros(0), np.zeros(0, dtype=np.int64)
        normal = np.zeros((0, 3))
        return cls(none, nothing, none, nothing, nothing, normal, nothing, nothing, none.astype(bool))
