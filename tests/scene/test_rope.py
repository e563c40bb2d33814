"""A scene for another rope: everything in proportion, said and recorded."""

import numpy as np
import pytest
from click.testing import CliRunner, Result
from coarse import KNOT

import knotfem as kf
from knotfem import shipped
from knotfem.models.plausible import unusual
from knotfem.scene import load_scene, scene_to_toml
from knotfem.scene.steps import Pull
from knotfem_cli.main import knotfem_command

MINE = {"diameter": "10 mm", "youngs_modulus": "5 MPa", "friction": 0.25}
COARSE = {**KNOT, "steps.pull.displacement": "9 mm"}
"""Of the scene "overhand", without gravity."""


def call(*arguments: str) -> Result:
    return CliRunner().invoke(knotfem_command, list(arguments))


def test_lengths_stresses_and_forces_are_in_proportion():
    before, now = load_scene("bowline"), load_scene("bowline", rope=MINE)
    (rod,), (old,) = now.rods, before.rods
    assert (rod.diameter, rod.length, now.obstacles[0].diameter) == pytest.approx((10.0, 1000.0, 20.0 / 0.6))
    assert rod.material.youngs_modulus == 5.0
    assert rod.core is not None
    assert old.core is not None
    assert rod.core.youngs_modulus == old.core.youngs_modulus
    assert rod.core.axial_stiffness / rod.bulk_axial_stiffness == pytest.approx(
        old.core.axial_stiffness / old.bulk_axial_stiffness
    )
    assert rod.slices == old.slices
    pull, earlier = (scene.steps[-1] for scene in (now, before))
    assert isinstance(pull, Pull)
    assert isinstance(earlier, Pull)
    assert (pull.displacement, pull.nominal_speed) == pytest.approx((165.0, 4.0 / 0.6))
    assert pull.duration == pytest.approx(earlier.duration)
    assert now.solver.force_tolerance / now.force_scale == pytest.approx(
        before.solver.force_tolerance / before.force_scale
    )
    assert now.output.every_displacement == pytest.approx(5.0)
    assert (now.contact.friction, now.obstacles[0].friction) == (0.25, 0.39)
    assert now.gravity == before.gravity
    assert load_scene("bowline", rope={"obstacle_friction": 0.2}).obstacles[0].friction == 0.2


@pytest.mark.parametrize("name", [name for name in shipped.scene_names() if "random" not in name])
def test_every_shipped_scene_can_be_scaled_and_back(name):
    scene = load_scene(name)
    there = scene.with_rope(diameter="13 mm", youngs_modulus="200 MPa")
    back = there.with_rope(diameter=f"{scene.diameter!r} mm", youngs_modulus=f"{scene.youngs_modulus!r} MPa")
    assert back.rope is not None
    assert (back.rope.lengths, back.rope.stresses, back.rope.forces) == pytest.approx((1.0, 1.0, 1.0))
    first, second = (numbers(s.model_dump(exclude={"rope"})) for s in (scene, back))
    np.testing.assert_allclose(second, first, rtol=1e-10)
    changed = numbers(there.model_dump(exclude={"rope"}))
    assert sum(a != b for a, b in zip(first, changed, strict=True)) >= 4


def numbers(value: object) -> list[float]:
    if isinstance(value, dict):
        return [number for entry in value.values() for number in numbers(entry)]
    if isinstance(value, list | tuple):
        return [number for entry in value for number in numbers(entry)]
    return [value] if isinstance(value, float) else []


def test_friction_of_pairs_and_schedules_follows():
    pairs = {"contact.pairs": [{"between": ["hitch", "bight"], "friction": 0.66}], "contact.friction": 0.33}
    scene = load_scene("sheet-bend", pairs).with_rope(friction=0.11)
    assert scene.contact.pairs[0].friction == pytest.approx(0.22)
    before, now = load_scene("bowline-lowered"), load_scene("bowline-lowered", rope={"friction": 0.7})
    points = [[point.friction for step in one.steps for point in step.friction_schedule] for one in (before, now)]
    assert points[1] == pytest.approx([0.7 / before.contact.friction * mu for mu in points[0]])


def test_it_is_recorded_and_said(tmp_path):
    scene = load_scene("bowline", {"gravity": None}, rope=MINE)
    file = tmp_path / "mine.toml"
    file.write_text(scene_to_toml(scene))
    assert load_scene(file) == scene
    assert "lengths and speeds x 1.667, stresses x 3.509, forces x 9.747" in str(scene.rope)
    assert not [said for said in unusual(scene) if "weight" in said]
    (said,) = (said for said in unusual(load_scene("bowline", rope=MINE)) if "weight" in said)
    assert "0.475 times" in said
    similar = said.partition('"')[2].partition('"')[0]
    assert similar == "20.65 m/s^2"
    real = load_scene("bowline", {"steps.pull.rate": "real"}, rope=MINE)
    assert any("inertia over stiffness, rho v^2 / E, is 0.792 times" in said for said in unusual(real))
    assert not any("similar" in said for said in unusual(load_scene("bowline", rope={"friction": 0.2})))


def test_changes_of_keys_come_after_the_rope():
    scene = load_scene("bowline", {"steps.pull.displacement": "50 mm", "contact.friction": 0.3}, rope=MINE)
    assert scene.loading_steps[-1].displacement == 50.0  # pyright: ignore[reportAttributeAccessIssue]
    assert scene.contact.friction == 0.3


@pytest.mark.parametrize(
    ("rope", "said"),
    [
        ({"diametre": "10 mm"}, r"^rope: diametre: unknown key.*\"diameter\""),
        ({"diameter": 10.0}, "^rope: diameter: a bare number"),
        ({"diameter": "10 m", "friction": 40.0}, "friction: no surfaces rub like this"),
        ({"youngs_modulus": "5 mPa"}, 'did you mean "5 MPa"'),
    ],
)
def test_impossible_ropes_are_refused(rope, said):
    with pytest.raises(kf.InputError, match=said):
        load_scene("bowline", rope=rope)


def test_option_takes_all_that_follows(tmp_path):
    file = tmp_path / "mine.toml"
    result = call("check", "bowline", "--rope", "diameter=10 mm", "friction=0.25", "--model", "rod", "-o", str(file))
    assert result.exit_code == 0
    bare = call("check", "bowline", "-o", str(file.with_suffix("")))
    assert bare.exit_code == 3
    assert "--output: not the name of a scene's file; found no suffix; expected .toml" in bare.stderr
    assert not file.with_suffix("").exists()
    assert "lengths and speeds x 1.667" in " ".join(result.stdout.split())
    scene = load_scene(file)
    assert (scene.diameter, scene.contact.friction, scene.model) == (10.0, 0.25, "rod")
    for wrong, said in (
        ("diametre=1 mm", "--rope: not a property"),
        ("diameter=10", "--rope: diameter: a bare number"),
    ):
        result = call("check", "bowline", "--rope", wrong)
        assert (result.exit_code, said in result.stderr) == (3, True)


def test_friction_on_obstacles_stays_and_is_said():
    kept = "friction on obstacles as it was (obstacle_friction changes it)"
    scene = load_scene("bowline", rope=MINE)
    assert kept in str(scene.rope)
    assert kept in str(load_scene(scene, rope={"diameter": "12 mm"}).rope)
    assert kept not in str(load_scene(scene, rope={"obstacle_friction": 0.3}).rope)
    assert kept not in str(load_scene("bowline", rope={"diameter": "10 mm"}).rope)
    assert kept not in str(load_scene("overhand", rope=MINE).rope)


def test_rope_of_hold(tmp_path, monkeypatch):
    begun = []
    monkeypatch.setattr("knotfem.api.drive", lambda run, *arguments, **others: begun.append(run.scene))
    options = ("--model", "rod", "--tighten", "5 N", "-o", str(tmp_path / "run"), "--yes")
    result = call("hold", "clove-hitch", *options, "--rope", "diameter=10 mm", "friction=0.25")
    assert "rope: clove-hitch of 6 mm" in result.stderr
    (scene,) = begun
    assert (scene.diameter, scene.contact.friction) == (10.0, 0.25)
    assert scene.steps[-1].slip == 10.0


def test_force_over_stiffness_does_not_depend_on_the_rope():
    scene = load_scene("overhand", COARSE)
    assert scene.gravity is None
    runs = [kf.pull(one) for one in (scene, scene.with_rope(diameter="17 mm", youngs_modulus="230 MPa"))]
    (d, f), (other_d, other_f) = (
        (run.force.displacement / run.scene.diameter, run.force.force / run.scene.force_scale) for run in runs
    )
    assert d[-1] == pytest.approx(other_d[-1], rel=1e-9)
    assert np.interp(d, other_d, other_f) == pytest.approx(f, rel=1e-6)


def test_core_of_a_stiff_rope_has_room_in_it():
    before, now = load_scene("bowline"), load_scene("bowline", rope={"youngs_modulus": "2 GPa"})
    (rod,), (old,) = now.rods, before.rods
    assert rod.core is not None
    assert 2.0 * rod.core.radius < rod.diameter
    assert rod.axial_stiffness / rod.bulk_axial_stiffness == pytest.approx(
        old.axial_stiffness / old.bulk_axial_stiffness
    )
