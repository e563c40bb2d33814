from knotfem.run.inspect import check
from knotfem.scene import load_scene


def test_expected_minutes_of_the_reduced_bowline_are_right_within_a_factor_of_two() -> None:
    """Measured on one idle core: 6 to 9 s of the run itself."""
    assert 3.0 < 60.0 * check(load_scene("bowline", ["model=rod"]))["expected_minutes"] < 18.0
