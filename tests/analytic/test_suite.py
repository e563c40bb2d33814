"""Every case of `knotfem verify`."""

import pytest

from knotfem.verify.suite import closed_forms
from knotfem.verify.verdict import Case, judge


def parameters() -> list:
    return [pytest.param(case, id=case.name, marks=[pytest.mark.slow] if case.slow else []) for case in closed_forms()]


@pytest.mark.parametrize("case", parameters())
def test_closed_form(case: Case) -> None:
    verdict = judge(case)
    for quantity in verdict.quantities:
        expected, found, deviation = quantity.shown
        print(f"\n{case.name}, {quantity.name}: expected {expected}, found {found}, {deviation}", end="")
    assert verdict.passed, [(q.name, q.condition, q.shown) for q in verdict.quantities if not q.passed] or verdict.error
