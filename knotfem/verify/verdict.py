"""What a case of the suite measures, and the verdict on it."""

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
"""Of the table of verdicts."""


@dataclass(frozen=True)
class Quantity:
    """A measured figure beside what it must be.

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
        """Whether it is what it must be; a figure that is not finite is not."""
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
        """Expected, found and deviation as a person reads them."""
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
        group: name of the case on the command line.
        measure: runs it.
        title: in words.
        source: of the expected values.
        mesh: model, mesh and settings it is run with.
        variant: tells cases of a group apart, such as the element.
        slow: takes longer than a quick test may.
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
class Verdict:
    """What came of a case.

    Attributes:
        case: which one.
        quantities: measured; empty when it failed.
        seconds: wall time.
        error: why it could not be measured.
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
        """A plain record a quantity, or one for a case that could not be measured."""
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


def judge(case: Case) -> Verdict:
    """Run a case; an error is a verdict too.

    Raises:
        Stopped, Interrupted: a request to stop, which is none.
    """
    began = time.perf_counter()
    try:
        quantities = tuple(case.measure())
    except (Stopped, Interrupted) as error:
        raise type(error)(f"{case.name} was stopped before its end") from error
    except Exception as error:
        return Verdict(case, seconds=time.perf_counter() - began, error=f"{type(error).__name__}: {error}")
    return Verdict(case, quantities, time.perf_counter() - began)


def select(cases: Sequence[Case], names: Iterable[str]) -> list[Case]:
    """Cases by group or full name, in the order of the suite; all of them when no name is given.

    Raises:
        InputError: a name that no case has.
    """
    wanted = list(names)
    known = dict.fromkeys(name for case in cases for name in (case.group, case.name))
    for name in wanted:
        if name not in known:
            groups = ", ".join(dict.fromkeys(case.group for case in cases))
            raise InputError("no such case", key="--only", found=name, expected=groups)
    return [case for case in cases if not wanted or case.group in wanted or case.name in wanted]


def table(verdicts: Iterable[Verdict]) -> Mapping[str, np.ndarray]:
    """The `COLUMNS` of all records, shape [rows], for `run.tables.write_table`."""
    rows = [row for verdict in verdicts for row in verdict.rows()]
    return {name: np.array([row[name] for row in rows], dtype=object) for name in COLUMNS}


def _figure(value: float | str | bool) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)
