"""The contact map: which strands press on each other, where on either, how hard, and whether they slide."""

from __future__ import annotations

from collections.abc import Iterator

from knotfem.contact.report import ContactReport
from knotfem.models.base import Model, Row

CONTACT_COLUMNS = (
    "displacement_mm", "time_s", "rod", "arclength_mm", "other", "other_arclength_mm", "gap_mm", "normal_force_N",
    "friction_force_N", "state",
)  # fmt: skip


def contact_rows(model: Model, found: ContactReport, time: float, displacement: float) -> Iterator[Row]:
    """Rows of contacts.csv for one state: a row for each sample that presses on another strand or on an obstacle.

    Every strand's samples press on the other's surface, so that a crossing shows twice, each time with its part of
    the force. A contact slips where nothing holds it: at the limit of friction, or without friction.

    Args:
        model: for the names of rods and obstacles.
        found: samples in contact.
        time: [s].
        displacement: of the reported end [mm].
    """
    rods, obstacles = [rod.name for rod in model.rods], model.obstacle_names
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
