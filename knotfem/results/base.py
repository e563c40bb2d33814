"""What the results of a run are taken from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from knotfem.errors import InputError, MissingDependency
from knotfem.scene.model import Scene
from knotfem.types import Arrays


def displacement_of(at: float | str | None, key: str = "at") -> float | None:
    """Displacement, or another length, [mm] given as a number or as a text such as "60 mm"; None for none.

    Args:
        at: the length.
        key: its name for messages.
    """
    if not isinstance(at, str):
        return at
    from knotfem.scene.quantity import LENGTH, parse_quantity

    return parse_quantity(at, LENGTH, key)


def frame_of(columns: Arrays) -> object:
    """Columns as a pandas DataFrame.

    Raises:
        MissingDependency: pandas is not installed.
    """
    try:
        import pandas as pd  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise MissingDependency("pandas is missing; cure: pip install pandas") from None
    return pd.DataFrame(dict(columns))


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


def labels_of(runs: Sequence[RunData]) -> list[str]:
    """Names of runs; where two are the same, their folders, or names with a number.

    Raises:
        InputError: two of them are one and the same run.
    """
    places = [id(run) if run.path is None else run.path.resolve() for run in runs]
    for number, run in enumerate(runs):
        if places[number] in places[:number]:
            raise InputError("the same run twice", found=run.path or run.name, expected="each once")
    names = [run.name for run in runs]
    numbered = [f"{name} ({number})" for number, name in enumerate(names, 1)]
    long = [other if run.path is None else str(run.path) for run, other in zip(runs, numbered, strict=True)]
    return [name if names.count(name) == 1 else other for name, other in zip(names, long, strict=True)]
