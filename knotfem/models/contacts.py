"""The contact map: which strands press on each other, where on either, how hard, and whether they slide."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from knotfem.contact.report import ContactMap, joined
from knotfem.scene.model import Scene

if TYPE_CHECKING:
    from knotfem.models.solid.assembly import Model

CONTACT_COLUMNS = (
    "displacement_mm", "time_s", "rod", "arclength_mm", "other", "other_arclength_mm", "gap_mm", "normal_force_N",
    "friction_force_N", "state",
)  # fmt: skip
MOBILISED = 0.999
"""A sample slips where its friction force is at least this share of what its normal force allows."""


def contact_rows(scene: Scene, found: ContactMap, time: float, displacement: float) -> Iterator[dict[str, float | str]]:
    """Rows of contacts.csv for one state: a row a sample that presses on another strand or on an obstacle.

    Every strand's samples press on the other's surface, so that a crossing shows twice, each time with its share of
    the force. A contact slips where nothing holds it: at the limit of friction, or without friction.

    Args:
        scene: for the names of rods and obstacles.
        found: samples in contact.
        time: [s].
        displacement: of the reported end [mm].
    """
    rods, obstacles = [rod.name for rod in scene.rods], [obstacle.name for obstacle in scene.obstacles]
    columns = (
        found.rod, found.arclength, found.other, found.other_arclength, found.gap, found.normal_force,
        found.friction_force, found.slides,
    )  # fmt: skip
    for rod, s, other, other_s, gap, normal, friction, slides in zip(*columns, strict=True):
        yield {
            "displacement_mm": displacement,
            "time_s": time,
            "rod": rods[rod],
            "arclength_mm": float(s),
            "other": rods[other] if other >= 0 else obstacles[-1 - other],
            "other_arclength_mm": float(other_s),
            "gap_mm": float(gap),
            "normal_force_N": float(normal),
            "friction_force_N": float(friction),
            "state": "slips" if slides else "sticks",
        }


def solid_contacts(model: Model) -> ContactMap:
    """The samples of the hexahedra's surfaces that carry force in the last accepted state."""
    parts: list[tuple[np.ndarray, ...]] = []
    for contact in model.named("contact"):
        on = contact.force > 0.0
        sample, other = contact.pairs[on].T
        rod, arclength, spacing = *_where(contact.samples, sample, contact.tubes.spacing), contact.tubes.spacing
        rubbing = _rubbing(model.named("friction"), np.flatnonzero(on), contact.force[on])
        other_arclength = contact.uv[on, 0] * spacing[other]
        parts.append((rod, arclength, other, other_arclength, contact.gap[on], contact.force[on], *rubbing))
        for number, cylinder in enumerate(model.named("cylinder")):
            on = cylinder.force[cylinder.touching] > 0.0
            sample = cylinder.touching[on]
            force = cylinder.force[sample]
            friction = [f for f in model.named("cylinder friction") if f.cylinder is cylinder]
            rod, arclength = _where(cylinder.samples, sample, spacing)
            other, nowhere = np.full(sample.size, -1 - number), np.full(sample.size, np.nan)
            parts.append((rod, arclength, other, nowhere, cylinder.gap[on], force, *_rubbing(friction, sample, force)))
    return joined(parts)


def _where(samples: Any, sample: np.ndarray, spacing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return samples.rod[sample], samples.u[sample] * spacing[samples.rod[sample]]


def _rubbing(friction: list, on: np.ndarray, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if not friction:
        return np.zeros(on.size), np.ones(on.size, dtype=bool)
    size = np.linalg.norm(friction[0].traction[on], axis=1)
    return size, size >= MOBILISED * friction[0].mu[on] * force
