"""A stability diagram: verdicts, the boundary between them, and the theory of the bowline beside it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.errors import InputError
from knotfem.files import write_json
from knotfem.results.base import frame_of
from knotfem.run.tables import read_table, write_table
from knotfem.study.column_meanings import TABLES
from knotfem.study.stability.boundary import Bracket, bracket_of
from knotfem.study.stability.grid import KEPT, KEYS, LOWERED
from knotfem.study.sweep.table import CSV, StudyTable
from knotfem.theory import crossing, fit_boundary
from knotfem.types import Arrays

BOUNDARY, FIT, PICTURE = "boundary.csv", "fit.json", "stability.png"
COLUMNS = tuple(TABLES["boundary"])
HOLDS, FAILS = ("holds",), ("unravels", "slips")
"""Verdicts that decide; any other leaves a point out of the boundary."""


@dataclass(frozen=True, eq=False)
class StabilityDiagram:
    """Results of `kf.stability`.

    Attributes:
        table: a row for each point: model, protocol, friction, x, tension_N, verdict, failure_mode and more.
        boundary: columns by name, a row for each model, protocol and x: the friction from which on the knot holds, and
            the bracket in which it lies.
        bowline: whether the theory of the paper is about this knot.
    """

    table: StudyTable
    boundary: Arrays
    bowline: bool

    @property
    def path(self) -> Path:
        """Folder of the study."""
        return self.table.path

    def fits(self) -> dict[str, Any]:
        """Alpha and beta of the law for stiff rods (Eq. 3b of the paper), by model and protocol, from the boundary.

        Only loads at which that law governs count, x above its crossing with the law for flexible rods.
        """
        found: dict[str, Any] = {}
        for label, (friction, half, x) in self._boundaries().items():
            stiff = x > crossing()
            width = 2.0 * half[stiff]
            try:
                fit = fit_boundary(x[stiff], friction[stiff], width if (width > 0.0).all() else None)
            except InputError as error:
                found[label] = {"refused": str(error)}
                continue
            found[label] = {
                "alpha": fit.alpha,
                "alpha_error": fit.alpha_error,
                "beta": fit.beta,
                "beta_error": fit.beta_error,
                "correlation": fit.correlation,
                "spread": fit.spread,
                "x": x[stiff].tolist(),
            }
        return found

    def write(self) -> None:
        """Write boundary.csv, for a bowline fit.json, and stability.png into the folder.

        Raises:
            InputError: the disk is full or the folder cannot be written.
        """
        write_table(self.path / BOUNDARY, self.boundary)
        if self.bowline:
            write_json(self.path / FIT, self.fits())
        self.plot(self.path / PICTURE)

    def text(self) -> str:
        """Verdicts, the boundary and the fit in words."""
        verdicts = self.table["verdict"].tolist()
        counted = ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in dict.fromkeys(verdicts) if verdict)
        lines = [f"{len(self.table)} points: {counted}"]
        for values in zip(*self.boundary.values(), strict=True):
            model, protocol, x, tension, _, low, high, monotone = values
            lines.append(
                f"{model}, friction {protocol}, x = {x:g} (T0 = {tension:.4g} N): holds from between {low:.4g} and "
                f"{high:.4g} on" + ("" if monotone else "; it also holds at some smaller friction")
            )
        for label, fit in self.fits().items() if self.bowline else ():
            if "alpha" in fit:
                lines.append(
                    f"{label}: alpha = {fit['alpha']:.3f} +- {fit['alpha_error']:.3f}, "
                    f"beta = {fit['beta']:.2f} +- {fit['beta_error']:.2f} (paper: 1.69 +- 0.04, 10.6 +- 1.0)"
                )
        return "\n".join(lines)

    def plot(self, out: str | Path, others: Mapping[str, StabilityDiagram] | None = None) -> None:
        """Draw the diagram like Fig. 4b of the paper.

        Args:
            out: file to write (.png, .pdf, .svg).
            others: further diagrams whose boundaries are drawn too, by label.

        Raises:
            InputError: the format is unknown or the file cannot be written.
        """
        from knotfem.plot.stability import plot_stability

        boundaries = {_spoken(label): boundary for label, boundary in self._boundaries().items()}
        for name, other in (others or {}).items():
            found = other._boundaries()
            boundaries |= {f"{_spoken(label)} of {name}": boundary for label, boundary in found.items()}
        points = {name: self.table[name] for name in ("model", "friction", "x", "verdict", "failure_mode")}
        kept = self.table["protocol"] == KEPT
        force = float((self.table["x"] * self.table["tension_N"])[0])
        plot_stability({k: v[kept] for k, v in points.items()}, boundaries, out, force=force, theory=self.bowline)

    def boundary_of(self, model: str, protocol: str = KEPT) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Friction, half the bracket, and x of a boundary, each of shape [loads]."""
        b = self.boundary
        of = (b["model"] == model) & (b["protocol"] == protocol)
        return b["friction"][of], 0.5 * (b["high"] - b["low"])[of], b["x"][of]

    def to_pandas(self) -> Any:
        """The table of points as a pandas DataFrame.

        Raises:
            MissingDependency: pandas is not installed.
        """
        return frame_of(self.table.columns)

    def _boundaries(self) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """All of them, by model and protocol; see `boundary_of`."""
        kinds = zip(self.boundary["model"].tolist(), self.boundary["protocol"].tolist(), strict=True)
        return {", ".join(kind): self.boundary_of(*kind) for kind in dict.fromkeys(kinds)}


def known_verdicts(table: StudyTable) -> dict[tuple[str, float], dict[float, bool]]:
    """Whether the knot holds, by friction, for each model and x; points without such a verdict are left out."""
    found: dict[tuple[str, float], dict[float, bool]] = {}
    for model, protocol, x, friction, verdict in _rows(table):
        if protocol == KEPT:
            of = found.setdefault((model, x), {})
            if verdict in (*HOLDS, *FAILS):
                of[friction] = verdict in HOLDS
    return found


def boundary_of(table: StudyTable) -> Arrays:
    """The boundary that a table of points gives; see `StabilityDiagram`."""
    tension = dict(zip(table["x"].tolist(), table["tension_N"].tolist(), strict=True))
    rows: list[tuple[str, str, float, Bracket]] = []
    for (model, x), known in known_verdicts(table).items():
        bracket = bracket_of(known)
        if bracket is not None:
            rows.append((model, KEPT, x, bracket))
    onset, lost = (_numbers(table[name]) for name in ("onset_friction", "lost_friction"))
    for number, (model, protocol, x, _, verdict) in enumerate(_rows(table)):
        if protocol == LOWERED and verdict == "unravels":
            low, high = float(lost[number]), float(onset[number])
            high = low if np.isnan(high) else high
            rows.append((model, LOWERED, x, Bracket(low, high, True)))
    rows.sort(key=lambda row: row[:3])
    values = [
        (model, protocol, x, tension[x], bracket.middle, bracket.low, bracket.high, float(bracket.monotone))
        for model, protocol, x, bracket in rows
    ]
    columns = list(zip(*values, strict=True)) or [()] * len(COLUMNS)
    return {
        name: np.array(column, dtype=str if name in ("model", "protocol") else float)
        for name, column in zip(COLUMNS, columns, strict=True)
    }


def _numbers(values: np.ndarray) -> np.ndarray:
    """A column of numbers, NaN where no point has one."""
    return values if values.dtype.kind == "f" else np.full(values.shape, np.nan)


def _spoken(label: str) -> str:
    """The boundary of a model and protocol, for the picture's legend."""
    from knotfem.plot.stability import MODEL_WORDS

    model, protocol = label.split(", ")
    return f"boundary, {MODEL_WORDS[model]}" + (", friction lowered" if protocol == LOWERED else "")


def _rows(table: StudyTable) -> Iterator[tuple[str, str, float, float, str]]:
    names = ("model", "protocol", "x", "friction", "verdict")
    yield from zip(*(table[name].tolist() for name in names), strict=True)


def open_stability(folder: str | Path) -> StabilityDiagram:
    """The diagram of a folder that `kf.stability` has written.

    Raises:
        InputError: the folder holds none.
    """
    path = Path(folder)
    if not (path / CSV).exists() or not (path / BOUNDARY).exists():
        raise InputError("no stability diagram", file=path, expected="a folder that knotfem stability wrote")
    table, boundary = read_table(path / CSV, KEYS), read_table(path / BOUNDARY, COLUMNS)
    return StabilityDiagram(StudyTable(path, table), boundary, (path / FIT).exists())
