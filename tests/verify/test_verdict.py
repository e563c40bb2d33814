import math

import numpy as np
import pytest

from knotfem.errors import InputError, NotConverged
from knotfem.verify.suite import closed_forms
from knotfem.verify.verdict import Case, Quantity, Verdict, judge, select, table


@pytest.mark.parametrize(
    ("quantity", "passed"),
    [
        (Quantity("", 1.0099, 1.0, 0.01), True),
        (Quantity("", 0.9899, 1.0, 0.01), False),
        (Quantity("", -1.0099, -1.0, 0.01), True),
        (Quantity("", 1.0, -1.0, 0.01), False),
        (Quantity("", 0.389, 0.379, 0.0101, "absolute"), True),
        (Quantity("", 0.368, 0.379, 0.01, "absolute"), False),
        (Quantity("", 2.0, 2.0, kind="at most"), True),
        (Quantity("", 2.1, 2.0, kind="at most"), False),
        (Quantity("", 1.9, 2.0, kind="at least"), False),
        (Quantity("", "3_1", "3_1", kind="equal"), True),
        (Quantity("", "4_1", "3_1", kind="equal"), False),
        (Quantity("", math.nan, 1.0, 0.01), False),
        (Quantity("", math.nan, 1.0, kind="at most"), False),
        (Quantity("", -math.inf, 1.0, kind="at most"), False),
    ],
)
def test_verdict_on_a_figure(quantity: Quantity, passed: bool) -> None:
    assert quantity.passed is passed


def test_a_case_without_figures_has_failed() -> None:
    assert not judge(Case("a", lambda: [], "", "")).passed


def fails() -> list[Quantity]:
    raise NotConverged("gave up")


def test_errors_a_user_can_meet_are_verdicts() -> None:
    verdict = judge(Case("a", fails, "", ""))
    assert not verdict.passed
    assert verdict.error == "NotConverged: gave up"
    assert [row["verdict"] for row in verdict.rows()] == ["FAIL"]


def test_other_errors_are_raised() -> None:
    with pytest.raises(ZeroDivisionError):
        judge(Case("a", lambda: [Quantity("", 1 / 0, 1.0)], "", ""))


def test_selection_keeps_the_order_of_the_suite() -> None:
    cases = [Case("a", fails, "", "", variant=v) for v in ("x", "y")] + [Case("b", fails, "", "")]
    assert [case.name for case in select(cases, ["b", "a:y"])] == ["a:y", "b"]
    assert select(cases, []) == cases
    with pytest.raises(InputError, match="no such case; found c; expected a, b"):
        select(cases, ["c"])


def test_table_has_a_row_a_figure() -> None:
    case = Case("a", fails, "title", "source", "mesh")
    verdict = Verdict(case, (Quantity("force", 1.0, 1.0, 0.01, condition="tight"), Quantity("gap", 2.0, 1.0)), 0.5)
    columns = table([verdict, Verdict(case, error="gave up")])
    assert columns["quantity"].tolist() == ["force, tight", "gap", "gave up"]
    assert columns["verdict"].tolist() == ["pass", "FAIL", "FAIL"]
    assert set(map(len, columns.values())) == {3}
    assert isinstance(columns["found"], np.ndarray)


def test_names_in_the_suite_are_unique_and_told_where_from() -> None:
    cases = closed_forms()
    assert len({case.name for case in cases}) == len(cases)
    assert all(case.title and case.source for case in cases)
