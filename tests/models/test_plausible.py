"""Values that nothing has are refused with the reason, unusual ones are told, and shipped scenes have none."""

import pytest

from knotfem import shipped
from knotfem.errors import InputError
from knotfem.models.build import build_model
from knotfem.models.plausible import largest_tolerance, unusual
from knotfem.scene import load_scene

LEAST = ("model=rod", "rods.0.mesh.element_length=6 mm")


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("rods.0.material.youngs_modulus=1e30 MPa", "diamond 1e6 MPa"),
        ("rods.0.material.youngs_modulus=1.425 mPa", 'did you mean "1.425 MPa"'),
        ("rods.0.material.youngs_modulus=1e-30 MPa", "soft gels"),
        ("rods.0.core.youngs_modulus=75.5 mPa", 'did you mean "75.5 MPa"'),
        ("rods.0.material.density=1160 tonne/mm^3", "water has 1e-9"),
        ("contact.friction=50", "no surfaces rub like this; found 50; expected at most 10"),
        ("obstacles.0.friction=11.0", "no surfaces rub"),
        ("drag.rate=1e300 1/s", "stand still"),
        ("steps.1.speed=1e9 mm/s", "1 km/s"),
        ("gravity.acceleration=1e12 mm/s^2", "the Earth"),
        ("solver.threads=100000", "less than or equal to 1024"),
        ("rods.0.smoothing.iterations=1000000000", "less than or equal to 100000"),
        ("solver.force_tolerance=1e9 N", "as large as the force of a knot; found 1e+09 N; expected at most 0.01 N"),
    ],
)
def test_impossible_values_are_refused_with_the_reason(override: str, said: str) -> None:
    with pytest.raises(InputError) as refused:
        load_scene("bowline", [override])
    assert said in str(refused.value)
    assert refused.value.key == override.partition("=")[0]


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("rods.0.material.youngs_modulus=100 Pa; solver.force_tolerance=1e-8 N", "0.0001 MPa is unusual"),
        ("rods.0.core.youngs_modulus=5e6 MPa", "diamond"),
        ("rods.0.material.density=1 kg/m^3", "1e-12 tonne/mm^3 is unusual"),
        ("rods.0.mesh.element_length=12 mm", "longer than the rod is thick"),
        ("contact.friction=3", "a coefficient of 3 is unusual"),
        ("obstacles.0.friction=4.0", "a coefficient of 4"),
        ("gravity.acceleration=1000 m/s^2", "ten times that of the Earth"),
        ("steps.1.displacement=700 mm", "more than the length of a rod"),
        ("solver.force_tolerance=5e-4 N", "the force of a loose knot is not known to 1%; at most 0.0003 N"),
        ("solver.threads=1024", "more than the"),
    ],
)
def test_unusual_values_are_told(override: str, said: str) -> None:
    told = unusual(load_scene("bowline", override.split("; ")))
    assert len(told) == 1
    assert told[0].startswith(override.partition("=")[0] + ": ")
    assert said in told[0]


def test_an_impact_and_a_load_that_tears_are_told() -> None:
    fast = load_scene("bowline", ["steps.1.rate=real", "steps.1.speed=2 m/s", "drag.rate=1e4 1/s"])
    told = " ".join(unusual(fast))
    assert "this is an impact, not a pull" in told
    assert "drag.rate" in told
    heavy = 'steps=[{kind="load",duration="1 s",ends={rod={end={motion="loaded",force="5000 N",direction=[1,0,0]}}}}]'
    assert "stretched far beyond" in " ".join(unusual(load_scene("cantilever", [heavy])))


def test_a_pull_that_pushes_is_told() -> None:
    usual = load_scene("overhand", LEAST)
    assert not any("pushes" in warning for warning in build_model(usual).warnings)
    pushing = load_scene("overhand", [*LEAST, "steps.1.ends.rod.start.direction=[-1,0,0]"])
    (told,) = (warning for warning in build_model(pushing).warnings if "pushes" in warning)
    assert told.startswith("steps.1.ends.rod.start: 177 degrees from the direction in which the rod ends")


@pytest.mark.parametrize("name", [name for name in shipped.scene_names() if not name.startswith("hard/")])
def test_shipped_scenes_are_usual(name: str) -> None:
    assert unusual(load_scene(name)) == []


def test_the_usual_tolerance_promises_the_force() -> None:
    scene = load_scene("bowline")
    assert scene.solver.force_tolerance < largest_tolerance(scene)
