"""What a case of a suite measures, and the result of the check."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from knotfem.errors import InputError, Interrupted, Stopped

Kind = Literal["relative", "absolute", "at most", "at least", "above", "equal"]
LIMITS: dict[Kind, str] = {"at most": "<= ", "at least": ">= ", "above": "> "}
"""Kinds whose expected value is a limit, and how it is shown."""
COLUMNS = (
    "case", "title", "quantity", "expected", "found", "deviation", "tolerance", "kind", "verdict", "source", "mesh",
    "seconds",
)  # fmt: skip
"""Of the table of results."""


@dataclass(frozen=True)
class Quantity:
    """A measured figure and what it must be.

    Attributes:
        name: what it is, with its unit.
        found: measured.
        expected: value or, for the kinds of `LIMITS`, limit.
        tolerance: largest deviation; unused for limits and "equal".
        kind: "relative" deviates by found / expected - 1, "absolute" by found - expected.
        condition: under which it was measured, such as a load or a mesh.
    """

    name: str
    found: float | str | bool
    expected: float | str | bool
    tolerance: float = 0.0
    kind: Kind = "relative"
    condition: str = ""

    @property
    def deviation(self) -> float:
        """Relative or absolute deviation; NaN where there is none."""
        if isinstance(self.found, str) or isinstance(self.expected, str) or self.kind == "equal":
            return float("nan")
        if self.kind == "relative":
            return self.found / self.expected - 1.0
        return float(self.found - self.expected)

    @property
    def passed(self) -> bool:
        """Whether it is what it must be; a figure that is not finite never is."""
        if self.kind == "equal":
            return self.found == self.expected
        if not np.isfinite(self.deviation):
            return False
        if self.kind == "at most":
            return self.deviation <= 0.0
        if self.kind == "at least":
            return self.deviation >= 0.0
        if self.kind == "above":
            return self.deviation > 0.0
        return abs(self.deviation) <= self.tolerance

    @property
    def shown(self) -> tuple[str, str, str]:
        """Expected, found and deviation as text."""
        limit = LIMITS.get(self.kind, "")
        deviation = ""
        if self.kind == "relative":
            deviation = f"{100.0 * self.deviation:+.2f} % of {100.0 * self.tolerance:g} %"
        elif self.kind == "absolute":
            deviation = f"{self.deviation:+.1e} of {self.tolerance:g}"
        return limit + _figure(self.expected), _figure(self.found), deviation


@dataclass(frozen=True)
class Case:
    """A case of the suite.

    Attributes:
        group: name on the command line.
        measure: runs the case.
        title: in words.
        source: of the expected values.
        mesh: model, mesh and settings.
        variant: distinguishes cases of a group, such as the element.
        slow: whether it takes longer than a quick test may.
    """

    group: str
    measure: Callable[[], Sequence[Quantity]]
    title: str
    source: str
    mesh: str = ""
    variant: str = ""
    slow: bool = False

    @property
    def name(self) -> str:
        """Group and variant."""
        return f"{self.group}:{self.variant}" if self.variant else self.group


@dataclass(frozen=True)
class Result:
    """The result of checking a case.

    Attributes:
        case: which one.
        quantities: measured; empty where an error ended the case.
        seconds: wall time.
        error: what ended the case, or "".
    """

    case: Case
    quantities: tuple[Quantity, ...] = field(default=())
    seconds: float = 0.0
    error: str = ""

    @property
    def passed(self) -> bool:
        """Whether every figure is what it must be."""
        return not self.error and bool(self.quantities) and all(q.passed for q in self.quantities)

    def rows(self) -> list[dict[str, Any]]:
        """One record for each quantity, or one for a case that an error ended."""
        common = {"case": self.case.name, "title": self.case.title}
        tail = {"source": self.case.source, "mesh": self.case.mesh, "seconds": round(self.seconds, 3)}
        rows = [
            {
                **common,
                "quantity": f"{q.name}, {q.condition}" if q.condition else q.name,
                "expected": q.expected,
                "found": q.found,
                "deviation": q.deviation if np.isfinite(q.deviation) else "",
                "tolerance": q.tolerance,
                "kind": q.kind,
                "verdict": "pass" if q.passed else "FAIL",
                **tail,
            }
            for q in self.quantities
        ]
        if self.error:
            nothing = {"expected": "", "found": "", "deviation": "", "tolerance": 0.0, "kind": ""}
            rows.append({**common, "quantity": self.error, **nothing, "verdict": "FAIL", **tail})
        return rows


def check(case: Case) -> Result:
    """Run a case; an error is a result too.

    Raises:
        Stopped, Interrupted: the case was asked to stop, so that it has no result.
    """
    began = time.perf_counter()
    try:
        quantities = tuple(case.measure())
    except (Stopped, Interrupted) as error:
        raise type(error)(f"{case.name} was stopped before its end") from error
    except Exception as error:
        return Result(case, seconds=time.perf_counter() - began, error=f"{type(error).__name__}: {error}")
    return Result(case, quantities, time.perf_counter() - began)


def select(cases: Sequence[Case], names: Iterable[str]) -> list[Case]:
    """Cases by group or full name, in the order of the suite; all of them when no name is given.

    Raises:
        InputError: no case has such a name.
    """
    wanted = list(names)
    known = dict.fromkeys(name for case in cases for name in (case.group, case.name))
    for name in wanted:
        if name not in known:
            groups = ", ".join(dict.fromkeys(case.group for case in cases))
            raise InputError("no such case", key="--only", found=name, expected=groups)
    return [case for case in cases if not wanted or case.group in wanted or case.name in wanted]


def table(results: Iterable[Result]) -> Mapping[str, np.ndarray]:
    """The `COLUMNS` of all records, each of shape [rows], for `run.tables.write_table`."""
    rows = [row for result in results for row in result.rows()]
    return {name: np.array([row[name] for row in rows], dtype=object) for name in COLUMNS}


def _figure(value: float | str | bool) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)
