"""Combinations: errors add up, costs multiply, the cheapest within the target is taken."""

import pytest

from knotfem.study.choose import Option, combine
from knotfem.study.refinement import Level, base_level

BASE = Option(base_level(), 0.02, 1.0)


def option(series: str, error: float, cost: float) -> Option:
    return Option(Level(f"{series}-1", series, "coarse", None, (f"{series}=1",)), error, cost)


STEP, SLICE = option("step", 0.025, 0.6), option("slice", 0.03, 0.4)
SINGLE = {"step": [BASE, STEP], "slice": [BASE, SLICE]}


@pytest.mark.parametrize(("target", "name"), [(0.06, "step-1+slice-1"), (0.05, None), (0.01, None)])
def test_cheapest_within_the_target(target, name):
    found = combine([SINGLE], target)
    assert (found and found.name) == name


def test_cheapest_of_all_families():
    element = option("element", 0.03, 0.1)
    found = combine([SINGLE, {"step": [BASE, STEP], "element": [BASE, element]}], 0.06)
    assert found is not None
    assert found.name == "step-1+element-1"
    assert found.overrides == ("step=1", "element=1")
    assert found.setting == "for 0.06: step coarse, element coarse"
    dear = option("element", 0.03, 0.9)
    found = combine([SINGLE, {"step": [BASE, STEP], "element": [BASE, dear]}], 0.06)
    assert found is not None
    assert found.name == "step-1+slice-1"
