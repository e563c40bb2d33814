"""A run in memory: the store of a recorder."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from knotfem.models.series import Fields, SeriesMesh
from knotfem.run.columns import TEXT_COLUMNS, Value


class MemoryTable:
    """Rows with the columns of a table.

    Args:
        columns: names, units included.
    """

    def __init__(self, columns: Sequence[str]) -> None:
        self.columns = tuple(columns)
        self._rows: list[tuple[Value, ...]] = []

    @property
    def rows(self) -> int:
        """How many there are."""
        return len(self._rows)

    def append(self, row: Mapping[str, Value]) -> None:
        """Append one row."""
        self._rows.append(tuple(row[column] for column in self.columns))

    def extend(self, rows: Iterable[Mapping[str, Value]]) -> None:
        """Append rows."""
        for row in rows:
            self.append(row)

    def keep(self, rows: int) -> None:
        """Drop all rows past the first `rows`."""
        del self._rows[rows:]

    def arrays(self) -> dict[str, np.ndarray]:
        """Columns by name, each of shape [rows]."""
        values = list(zip(*self._rows, strict=True)) or [()] * len(self.columns)
        return {
            name: np.array(column, dtype=str if name in TEXT_COLUMNS else float)
            for name, column in zip(self.columns, values, strict=True)
        }


@dataclass(frozen=True, eq=False)
class StoredState:
    """A state whose fields are kept.

    Attributes:
        time: [s].
        displacement: of the reported end over all steps after tying [mm].
        fields: of the state.
    """

    time: float
    displacement: float
    fields: Fields


class MemorySeries:
    """States in memory.

    Args:
        mesh: of them.
        states: so far.
    """

    def __init__(self, mesh: SeriesMesh, states: Sequence[StoredState] = ()) -> None:
        self.mesh = mesh
        self.states = list(states)

    def append(self, time: float, displacement: float, fields: Fields) -> None:
        """Append a state."""
        self.states.append(StoredState(time, displacement, fields))

    @property
    def count(self) -> int:
        """States so far."""
        return len(self.states)

    def close(self) -> None:
        """Nothing is left to do."""


class MemoryStore:
    """Tables, series and log in memory.

    Args:
        earlier: columns of the tables of a run that this one goes on from, by the table's name.
        earlier_states: its stored states.

    Attributes:
        tables: by name.
        states: the series, or None.
        records: of all steps.
    """

    def __init__(
        self, earlier: Mapping[str, Mapping[str, np.ndarray]] | None = None, earlier_states: Sequence[StoredState] = ()
    ) -> None:
        self.tables: dict[str, MemoryTable] = {}
        self.states: MemorySeries | None = None
        self.records: list[dict[str, Any]] = []
        self._earlier, self._earlier_states = dict(earlier or {}), earlier_states

    def table(self, name: str, columns: tuple[str, ...]) -> MemoryTable:
        """A table, with the rows that an earlier run has left."""
        table = self.tables[name] = MemoryTable(columns)
        earlier = self._earlier.pop(name, {})
        table.extend(dict(zip(earlier, row, strict=True)) for row in zip(*earlier.values(), strict=True))
        return table

    def series(self, mesh: Callable[[], SeriesMesh], kept: int | None) -> MemorySeries:
        """The series, with the first `kept` states of an earlier run."""
        self.states = MemorySeries(mesh(), self._earlier_states[: kept or 0])
        return self.states

    def log(self, record: Mapping[str, Any]) -> None:
        """Keep a record."""
        self.records.append(dict(record))

    @property
    def logged(self) -> int:
        """Records so far."""
        return len(self.records)

    def keep_log(self, records: int) -> None:
        """Drop all past the first."""
        del self.records[records:]
