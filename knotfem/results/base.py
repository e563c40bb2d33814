"""What the results of a run are taken from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

from knotfem.scene.model import Scene
from knotfem.types import Arrays


class RunData(ABC):
    """What is kept of a run, in memory or on disk.

    Attributes:
        name: for legends.
        path: the run directory, or None in memory.
    """

    name: str
    path: Path | None

    @property
    @abstractmethod
    def scene(self) -> Scene:
        """The resolved scene."""

    @abstractmethod
    def table(self, name: str) -> Arrays:
        """Columns as they were when first asked for, by name with units, each of shape [rows]; empty without a table.

        Args:
            name: "force", "tension", "contacts", "twist", "events" or "tie".
        """

    @property
    @abstractmethod
    def summary(self) -> dict[str, Any]:
        """Figures of the whole run, as in summary.json."""
