"""What a scene is expected to take."""

import pytest

from knotfem.models.build import build_model
from knotfem.run.check import check
from knotfem.run.expected import COSTS, count_unknowns, expected
from knotfem.scene import load_scene
from knotfem.study.dead_load import dead_load


def test_expected_minutes_of_the_reduced_bowline_are_right_within_a_factor_of_two() -> None:
    """Measured with one thread: 10.4 CPU s."""
    assert 5.0 < 60.0 * check(load_scene("bowline", ["model=rod"]))["expected_minutes"] < 21.0


def test_expected_minutes_of_the_bowline_are_right_within_a_factor_of_two() -> None:
    """Measured with one thread: 253 CPU s in 1,752 iterations."""
    assert 126.0 < 60.0 * check(load_scene("bowline"))["expected_minutes"] < 506.0


@pytest.mark.parametrize(("unravels", "measured"), [(False, 1859.0), (True, 4758.0)])
def test_expected_time_of_a_dead_load_is_that_of_a_knot_that_holds_or_unravels(unravels: bool, measured: float) -> None:
    """Measured: mean iterations of the 34 and 20 points of the bowline's stability diagram."""
    scene = dead_load("bowline", "1.1 N", {"model": "rod"})
    takes = expected(scene)
    seconds = takes.if_it_unravels if unravels else takes.seconds
    iterations = seconds / COSTS["rod"].seconds_per_iteration(takes.unknowns)
    assert iterations == pytest.approx(measured, rel=0.1)
    found = check(scene)
    assert found["expected_minutes_if_it_unravels"] > 2.0 * found["expected_minutes"]
    assert "expected_minutes_if_it_unravels" not in check(load_scene("bowline", ["model=rod"]))


@pytest.mark.parametrize(("unknowns", "measured"), [(15_351, 0.144), (95_559, 1.8)])
def test_an_iteration_takes_what_was_measured_on_either_mesh(unknowns: int, measured: float) -> None:
    assert COSTS["fem"].seconds_per_iteration(unknowns) == pytest.approx(measured, rel=0.05)


@pytest.mark.parametrize("overrides", [["model=rod"], [], ["rods.0.mesh.element=hex27"]])
def test_unknowns_are_counted_without_building_the_model(overrides: list[str]) -> None:
    scene = load_scene("overhand", [*overrides, "rods.0.mesh.element_length=10 mm"])
    assert count_unknowns(scene) == build_model(scene).dofs


def test_a_step_that_pulls_nothing_takes_its_time_too() -> None:
    assert check("cantilever")["expected_minutes"] > 0.0


def test_the_knots_that_are_to_be_tied_are_named() -> None:
    assert check(load_scene("overhand", ["model=rod"]))["knots"] == {"rod": "3_1"}
    assert check(load_scene("clove-hitch", ["model=rod"]))["knots"] == {"rod": "hitch round cylinder (2.5 turns)"}
    assert check(load_scene("sheet-bend", ["model=rod"]))["knots"] == {
        "hitch": "unknot, linked with bight",
        "bight": "unknot, linked with hitch",
    }
