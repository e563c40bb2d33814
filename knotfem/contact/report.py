"""Where strands press on each other and on cylinders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from knotfem.contact.curve_contact import Contact
    from knotfem.contact.curve_cylinder import Cylinder, CylinderFriction
    from knotfem.contact.curve_friction import Friction


@dataclass(frozen=True, eq=False)
class ContactMap:
    """Where strands press on each other, or on a cylinder; one entry a sample in contact.

    Attributes:
        rod: of the sample, shape [n].
        arclength: of the sample [mm], shape [n].
        other: rod that it touches, or -1 - c for cylinder c, shape [n].
        other_arclength: of the closest point [mm], nan on a cylinder, shape [n].
        gap: [mm], shape [n].
        normal_force: [N], shape [n].
        friction_force: [N], shape [n].
        slides: whether friction holds no longer, as it never does where there is none, shape [n].
    """

    rod: np.ndarray
    arclength: np.ndarray
    other: np.ndarray
    other_arclength: np.ndarray
    gap: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    slides: np.ndarray


def contact_map(
    contact: Contact | None, friction: Friction | None, cylinders: Sequence[tuple[Cylinder, CylinderFriction | None]]
) -> ContactMap:
    """Collect the samples that carry force."""
    parts: list[tuple[np.ndarray, ...]] = []
    if contact is not None:
        on = contact.force > 0.0
        sample, other = contact.pairs[on].T
        rod, arclength = _where(contact, sample)
        other_arclength = contact.u[on] * contact.layout.spacing[other]
        pressing = contact.gap[on], contact.force[on]
        parts.append((rod, arclength, other, other_arclength, *pressing, *_rubbing(friction, on)))
    for number, (cylinder, cylinder_friction) in enumerate(cylinders):
        on = cylinder.force > 0.0
        rod, arclength = _where(cylinder, np.flatnonzero(on))
        other, nowhere = np.full(rod.size, -1 - number), np.full(rod.size, np.nan)
        pressing = cylinder.gap[on], cylinder.force[on]
        parts.append((rod, arclength, other, nowhere, *pressing, *_rubbing(cylinder_friction, on)))
    return joined(parts)


def joined(parts: Sequence[tuple[np.ndarray, ...]]) -> ContactMap:
    """One map of several, each the columns of a `ContactMap` in their order."""
    if not parts:
        nothing, none = np.zeros(0), np.zeros(0, dtype=np.int64)
        return ContactMap(none, nothing, none, nothing, nothing, nothing, nothing, none.astype(bool))
    return ContactMap(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _where(contact: Contact | Cylinder, sample: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rod = contact.samples.rod[sample]
    return rod, contact.samples.u[sample] * contact.layout.spacing[rod]


def _rubbing(friction: Friction | CylinderFriction | None, on: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if friction is None:
        return np.zeros(on.sum()), np.ones(on.sum(), dtype=bool)
    return np.linalg.norm(friction.traction[on], axis=1), friction.slides[on] | (friction.mu[on] == 0.0)
