"""What a verdict rests on: how far steps have come, and the evidence in the words of summary.json."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from knotfem.scene.rods import Rod
from knotfem.stability.ends import Place
from knotfem.stability.slip import UnitSlip

FROM_ONSET = "from the last equilibrium under load to the onset of slip"
FROM_STEP = "since the start of the last step"


@dataclass
class Progression:
    """How far a step of the scene has come.

    Attributes:
        name: of the step.
        began: [s].
        ends: where the loaded and the free ends were at its start [mm], by label, shape [3].
        through: what had run through the crossings of each rod by then [mm], shape [rods].
        drawn_in: by how much each end had been drawn in by then [mm], shape [rods, 2].
        deciding: whether it has a loaded and a free end.
        pulled: displacements of the driven end, of a pull [mm].
        ran: lengths that had run through by then [mm].
        at_rest: whether its last state is at rest under loads that stand still.
    """

    name: str
    began: float
    ends: dict[str, np.ndarray]
    through: np.ndarray
    drawn_in: np.ndarray
    deciding: bool
    pulled: list[float] = field(default_factory=list)
    ran: list[float] = field(default_factory=list)
    at_rest: bool = False

    def pull(self, displacement: float, ran: float, span: float) -> None:
        """A driven end has come so far [mm], and so much has run through; the last `span` of it is kept."""
        self.pulled.append(displacement)
        self.ran.append(ran)
        first = max(0, int(np.searchsorted(self.pulled, displacement - span)) - 1)
        del self.pulled[:first], self.ran[:first]

    def rate(self, span: float) -> float:
        """Fraction of the last `span` of a pull that ran through; nan where the end has not been pulled so far."""
        if not self.pulled or self.pulled[-1] < span:
            return math.nan
        return abs(self.ran[-1] - float(np.interp(self.pulled[-1] - span, self.pulled, self.ran))) / span


def label_of(place: Place) -> str:
    """Name of an end, such as "rod.start"."""
    return f"{place[0]}.{place[1]}"


def unit_evidence(slip: UnitSlip, rods: Sequence[Rod]) -> dict[str, Any]:
    """Strands of the locking unit and how far each has slipped."""
    found = [("wrapping", slip.wrapping), *(("central", central) for central in slip.central)]
    strands = [
        {
            "strand": kind,
            "rod": rods[on.strand.rod].name,
            "from_s_over_L": on.strand.first / rods[on.strand.rod].length,
            "to_s_over_L": on.strand.last / rods[on.strand.rod].length,
            "slip_mm": on.slip,
        }
        for kind, on in found
    ]
    return {"wrapping_angle_rad": slip.angle, "strands": strands}
