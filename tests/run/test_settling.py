"""How the loose knot comes to rest: protocols, and what a scene gives that quasi-static steps do not take up."""

import numpy as np
import pytest

import knotfem as kf
from knotfem.errors import InputError
from knotfem.models.build import build_model
from knotfem.run.events import TimeStepDone
from knotfem.run.simulation import Simulation
from knotfem.scene import load_scene, scene_to_toml

COARSE = (
    "model=rod", "rods.0.length=400 mm", "rods.0.mesh.element_length=6 mm", "contact.sample_spacing_over_diameter=0.25",
    "tie.path=direct", "output.fields=false", "solver.threads=1",
)  # fmt: skip
FREE_TWIST = (*COARSE, "steps.0.protocol=free-twist", "steps.pull.displacement=1 mm")


def test_the_free_twist_protocol_is_three_steps_that_a_written_scene_keeps(tmp_path):
    scene = load_scene("overhand", FREE_TWIST)
    assert [step.name for step in scene.steps] == ["relax", "relax-twist", "relax-again", "pull"]
    assert [step.frozen for step in scene.tying_steps] == [False, True, False]
    path = tmp_path / "overhand.toml"
    path.write_text(scene_to_toml(scene))
    assert load_scene(path) == scene


def test_names_that_a_protocol_needs_are_not_taken():
    with pytest.raises(InputError, match='used twice; found "relax-twist"'):
        load_scene("overhand", [*FREE_TWIST, "steps.1.name=relax-twist"])


@pytest.mark.parametrize("model", ["rod", "fem"])
def test_sections_turn_on_frozen_centrelines_until_they_are_twisted_least(model):
    overrides = [*FREE_TWIST, f"model={model}", "rods.0.mesh.section_elements=4", "steps.1.displacement=0.01 mm"]
    simulation = Simulation(load_scene("overhand", overrides), "tie")
    ends, elastic, frictional = {}, {}, {}
    for event in simulation.run():
        if isinstance(event, TimeStepDone):
            ends[event.step.name] = np.concatenate(simulation.model.centrelines(event.state.x))
            elastic.setdefault(event.step.name, []).append(event.energies.elastic)
            frictional[event.step.name] = "friction" in {term.name for term in event.system.terms}
    np.testing.assert_allclose(ends["relax-twist"], ends["relax"], atol=1e-9)
    assert elastic["relax-twist"][-1] <= elastic["relax"][-1]
    assert frictional == {"relax": True, "relax-twist": False, "relax-again": True}


def test_the_protocol_is_recorded():
    settling = kf.pull("overhand", FREE_TWIST, progress=False).summary["settling"]
    assert settling == {
        "relax": "overdamped, with friction",
        "relax-twist": "sections turn, centrelines frozen, without friction",
        "relax-again": "overdamped, with friction",
    }


def test_smaller_steps_of_settling_are_more():
    few, many = (
        kf.tie("overhand", [*COARSE, f"quasi_static.settling_slip_over_diameter={size}"], progress=False).summary
        for size in (0.5, 0.05)
    )
    assert many["steps"] > 1.5 * few["steps"]


def test_what_acts_in_real_time_only_is_said_to_be_idle():
    given = ["drag.rate=10 1/s", "inertia.scheme=backward-euler", "rods.0.material.relaxation_time=0.1 s"]
    said = "\n".join(build_model(load_scene("overhand", [*COARSE, *given])).warnings)
    for key in ("drag", "inertia", "rods.material.relaxation_time"):
        assert f'{key} changes nothing: it acts in real time only, and no step has rate = "real"' in said
    real = [*given, "steps.1.rate=real"]
    assert not any("changes nothing" in line for line in build_model(load_scene("overhand", [*COARSE, *real])).warnings)


def test_a_pull_in_real_time_says_where_it_was_not_quasi_static():
    fast = ["steps.pull.rate=real", "steps.pull.displacement=3 mm", "steps.pull.speed=100 mm/s", "drag.rate=20 1/s"]
    run = kf.pull("overhand", [*COARSE, *fast], progress=False)
    (note,) = run.notes
    assert note.startswith("pull was not quasi-static: drag and inertia carried more than 0.01% of the force over ")
    assert run.force.unbalanced
    assert kf.pull("overhand", [*COARSE, "steps.pull.displacement=3 mm"], progress=False).notes == []


def test_internal_damping_carries_nothing_in_quasi_static_steps():
    damped = "rods.0.material.relaxation_time=0.1 s"
    shared = [*COARSE, "steps.pull.displacement=2 mm"]
    plain, quasi_static = (kf.pull("overhand", [*shared, *more], progress=False) for more in ((), (damped,)))
    np.testing.assert_array_equal(quasi_static.force.force, plain.force.force)


def test_what_real_steps_take_stays_booked_in_quasi_static_ones_that_follow():
    end = '{rod={start={motion="driven", direction=[0, 0, 1]}}}'
    steps = ", ".join(
        f'{{kind="pull", name="{name}", displacement="{size} mm", speed="50 mm/s", rate="{rate}", ends={end}}}'
        for name, size, rate in (("jerk", 2, "real"), ("on", 1, "quasi-static"))
    )
    overrides = [*COARSE, "rods.0.material.relaxation_time=0.1 s", f'steps=[{{kind="relax"}}, {steps}]']
    run = kf.pull("overhand", overrides, progress=False)
    table = run.table("force")
    jerk, on = (np.flatnonzero(table["step"] == name) for name in ("jerk", "on"))
    assert (np.diff(table["internal_damping_Nmm"][jerk]) > 0.0).all()
    assert (table["internal_damping_Nmm"][on] == table["internal_damping_Nmm"][jerk[-1]]).all()
    assert (np.diff(table["numerical_drag_Nmm"][on]) >= 0.0).all()
    assert table["kinetic_Nmm"][jerk[0]] > 0.0
    assert (table["kinetic_Nmm"][on] == 0.0).all()
