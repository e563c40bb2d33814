"""Every case of `knotfem verify`."""

import pytest

from knotfem.verify.case import Case, check
from knotfem.verify.suite import closed_forms


def parameters() -> list:
    return [pytest.param(case, id=case.name, marks=[pytest.mark.slow] if case.slow else []) for case in closed_forms()]


@pytest.mark.parametrize("case", parameters())
def test_closed_form(case: Case) -> None:
    result = check(case)
    for quantity in result.quantities:
        expected, found, deviation = quantity.shown
        print(f"\n{case.name}, {quantity.name}: expected {expected}, found {found}, {deviation}", end="")
    assert result.passed, [(q.name, q.condition, q.shown) for q in result.quantities if not q.passed] or result.error
