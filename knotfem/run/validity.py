"""How far a run has come towards the limits within which its model is valid."""

from __future__ import annotations

from typing import Any

import numpy as np

from knotfem.models.base import Model
from knotfem.run.remarks import Remarks
from knotfem.scene.steps import Step


class Validity:
    """Keeps the largest measures of all states that are looked at, and says once where a limit is passed.

    Args:
        model: whose limits they are; see `Model.reaches`.
        remarks: of the run.

    Attributes:
        found: for the summary and checkpoints, by the name of the measure: `largest`, `limit`, `exceeded`.
    """

    def __init__(self, model: Model, remarks: Remarks) -> None:
        self.model, self._remarks = model, remarks
        self.found: dict[str, dict[str, Any]] = {}

    def look(self, step: Step, x: np.ndarray, penetration: float, time: float, displacement: float) -> None:
        """Take an accepted state.

        Args:
            step: of the scene.
            x: unknowns, shape [nodes, width].
            penetration: deepest [mm].
            time: [s].
            displacement: of the reported end [mm].
        """
        for reach in self.model.reaches(x, penetration):
            largest = max(reach.value, self.found.get(reach.name, {}).get("largest", 0.0))
            self.found[reach.name] = {"largest": largest, "limit": reach.limit, "exceeded": largest > reach.limit}
            if reach.exceeded:
                said = f"beyond the limits of the {self.model.scene.model} model from {{when}} on: {reach.meaning}"
                self._remarks.tell(reach.name, said, step, time, displacement)
