import math

import numpy as np
import pytest

from knotfem.errors import InputError, Interrupted, KnotfemError, NotConverged, Stopped
from knotfem.verify.case import Case, Quantity, Result, check, select, table
from knotfem.verify.suite import closed_forms


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
        (Quantity("", 1e-9, 0.0, kind="above"), True),
        (Quantity("", 0.0, 0.0, kind="above"), False),
        (Quantity("", "3_1", "3_1", kind="equal"), True),
        (Quantity("", "4_1", "3_1", kind="equal"), False),
        (Quantity("", math.nan, 1.0, 0.01), False),
        (Quantity("", math.nan, 1.0, kind="at most"), False),
        (Quantity("", -math.inf, 1.0, kind="at most"), False),
    ],
)
def test_check_of_a_figure(quantity: Quantity, passed: bool) -> None:
    assert quantity.passed is passed


def test_a_case_without_figures_has_failed() -> None:
    assert not check(Case("a", lambda: [], "", "")).passed


def fails() -> list[Quantity]:
    raise NotConverged("gave up")


def test_errors_a_user_can_meet_are_results() -> None:
    result = check(Case("a", fails, "", ""))
    assert not result.passed
    assert result.error == "NotConverged: gave up"
    assert [row["verdict"] for row in result.rows()] == ["FAIL"]


def test_any_other_error_is_a_result_too() -> None:
    result = check(Case("a", lambda: [Quantity("", 1 / 0, 1.0)], "", ""))
    assert not result.passed
    assert result.error == "ZeroDivisionError: division by zero"


@pytest.mark.parametrize("kind", [Stopped, Interrupted])
def test_a_request_to_stop_is_no_result(kind: type[KnotfemError]) -> None:
    def stops() -> list[Quantity]:
        raise kind("a checkpoint is written")

    with pytest.raises(kind, match="a:x was stopped before its end"):
        check(Case("a", stops, "", "", variant="x"))


def test_selection_keeps_the_order_of_the_suite() -> None:
    cases = [Case("a", fails, "", "", variant=v) for v in ("x", "y")] + [Case("b", fails, "", "")]
    assert [case.name for case in select(cases, ["b", "a:y"])] == ["a:y", "b"]
    assert select(cases, []) == cases
    with pytest.raises(InputError, match="no such case; found c; expected a, b"):
        select(cases, ["c"])


def test_table_without_rows_has_its_columns() -> None:
    columns = table([])
    assert list(columns)[:3] == ["case", "title", "quantity"]
    assert {len(column) for column in columns.values()} == {0}


def test_table_has_a_row_for_each_figure() -> None:
    case = Case("a", fails, "title", "source", "mesh")
    result = Result(case, (Quantity("force", 1.0, 1.0, 0.01, condition="tight"), Quantity("gap", 2.0, 1.0)), 0.5)
    columns = table([result, Result(case, error="gave up")])
    assert columns["quantity"].tolist() == ["force, tight", "gap", "gave up"]
    assert columns["verdict"].tolist() == ["pass", "FAIL", "FAIL"]
    assert set(map(len, columns.values())) == {3}
    assert isinstance(columns["found"], np.ndarray)


def test_names_in_the_suite_are_unique_and_told_where_from() -> None:
    cases = closed_forms()
    assert len({case.name for case in cases}) == len(cases)
    assert all(case.title and case.source for case in cases)
