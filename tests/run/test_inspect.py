import pytest

from knotfem.run.check import check, seconds_an_iteration
from knotfem.scene import load_scene


def test_expected_minutes_of_the_reduced_bowline_are_right_within_a_factor_of_two() -> None:
    """Measured on one idle core: 6 to 9 s of the run itself."""
    assert 3.0 < 60.0 * check(load_scene("bowline", ["model=rod"]))["expected_minutes"] < 18.0


def test_expected_minutes_of_the_bowline_are_right_within_a_factor_of_two() -> None:
    """Measured on two idle cores: 88 s of pulling in 1,069 iterations."""
    assert 44.0 < 60.0 * check(load_scene("bowline"))["expected_minutes"] < 176.0


@pytest.mark.parametrize(("unknowns", "measured"), [(15_351, 0.085), (95_559, 1.3)])
def test_an_iteration_takes_what_was_measured_on_either_mesh(unknowns: int, measured: float) -> None:
    assert seconds_an_iteration("fem", unknowns) == pytest.approx(measured, rel=0.05)
