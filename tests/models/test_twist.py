"""The twist of a scene's rods, in both models."""

import numpy as np
import pytest

import knotfem as kf

STRAIGHT = {
    "rods.0.mesh.element_length": "4 mm",
    "rods.0.mesh.section_elements": 4,
    "gravity": None,
    "output.fields": False,
    "steps": [{"kind": "relax"}, {"kind": "hold", "duration": "1 s"}],
}


@pytest.mark.parametrize(("model", "error"), [("rod", 1e-6), ("fem", 2e-3)])
@pytest.mark.parametrize("turns", [0.1, -0.05])
def test_a_twisted_rod_between_clamps_bears_the_torque_of_its_twist(model, error, turns):
    scene = kf.load_scene("cantilever", {**STRAIGHT, "model": model, "rods.0.twist": f"{turns} turns"})
    rod = scene.rods[0]
    assert rod.twist == pytest.approx(2.0 * np.pi * turns)
    torque = kf.pull(scene).table("tension")["torque_Nmm"]
    expected = rod.twisting_stiffness * rod.twist / rod.length
    np.testing.assert_allclose(torque, expected, rtol=error)


def test_a_rod_is_free_of_twist_unless_the_scene_gives_it_some():
    torque = kf.pull("cantilever", {**STRAIGHT, "model": "rod"}).table("tension")["torque_Nmm"]
    np.testing.assert_allclose(torque, 0.0, atol=1e-12)


def test_a_material_angle_in_the_file_of_a_curve_is_said_to_be_unused(tmp_path):
    path = tmp_path / "twisted.csv"
    path.write_text("x,y,z,angle\n" + "".join(f"0,0,{z},{0.1 * z}\n" for z in range(0, 200, 20)))
    said = kf.check("cantilever", {**STRAIGHT, "model": "rod", "rods.0.centerline": str(path)})["warnings"]
    assert any('the column "angle" is not used (the twist of a rod is rods.N.twist)' in line for line in said)
