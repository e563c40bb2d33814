"""Whole runs with quasi-static steps, on discrete rods."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

import knotfem as kf
from knotfem.errors import Stopped
from knotfem.results.run import Run
from knotfem.run.jumps import Jump
from knotfem.run.stop import StopRequest

SNAP = {"model": "rod", "output.fields": False, "steps.pull.displacement": "12 mm"}
"""A figure-eight knot, whose loop turns over on the way."""
PLAIN = {**SNAP, "steps.pull.displacement": "1 mm", "output.every_displacement": "0.5 mm"}


def pulled(**changes) -> Run:
    return kf.pull("figure-eight", {**SNAP, **{key.replace("__", "."): value for key, value in changes.items()}})


@pytest.fixture(scope="module")
def snapped() -> Run:
    return pulled()


def jumps(run: Run) -> Mapping[str, np.ndarray]:
    """Events of the pull."""
    rows = run.events["step"] == "pull"
    return {name: values[rows] for name, values in run.events.items()}


def test_a_jump_is_an_event(snapped):
    """The force falls by a third and more at one displacement."""
    found = jumps(snapped)
    assert len(found["step"]) == 1
    assert found["displacement_mm"][0] == pytest.approx(9.8, abs=0.5)
    assert found["force_after_N"][0] < 0.7 * found["force_before_N"][0]
    assert found["moved_mm"][0] > 20.0
    assert found["rod"][0] == "rod"
    assert 0.0 < found["s_over_L"][0] < 1.0
    assert found["released_Nmm"][0] == pytest.approx(0.062, rel=0.1)


def test_the_energy_released_in_a_jump_is_what_the_rod_loses(snapped):
    table, found = snapped.table("force"), jumps(snapped)
    at = table["displacement_mm"] == found["displacement_mm"][0]
    rows = np.flatnonzero(at)
    lost = table["elastic_Nmm"][rows[0] - 1] - table["elastic_Nmm"][rows[-1]]
    taken = found["released_Nmm"][0] + table["friction_Nmm"][rows[-1]] - table["friction_Nmm"][rows[0] - 1]
    assert lost == pytest.approx(taken, rel=0.15)
    assert np.abs(table["missing_Nmm"]).max() < 2e-3 * table["elastic_Nmm"].max()


def test_a_released_end_dissipates_energy_of_its_own_step():
    """Not that of the relax step before it, which the energy balance of the pull does not hold."""
    changed = {"model": "rod", "output.fields": False, "rods.0.mesh.element_length": "6 mm"}
    run = kf.pull("bowline", {**changed, "steps.pull.displacement": "1 mm"})
    tied, let_go = run.events["released_Nmm"]
    assert tied > 5.0
    assert 0.1 < let_go < 5.0


def test_every_state_of_the_force_curve_is_one_of_equilibrium(snapped):
    """Drag carries less than 0.01 % of the larger force on the ends, or than what the balance tolerates."""
    table = snapped.table("force")
    settled = table["equilibrium"] > 0
    allowed = np.maximum(0.0001 * table["force_N"], 1e-4)
    assert (table["unrest_N"][settled] <= 1.05 * allowed[settled]).all()
    assert (~settled).sum() > 5
    assert snapped.force.displacement.size == settled.sum()
    assert (np.diff(snapped.force.displacement) > 0.0).all()
    assert not snapped.force.unbalanced


def test_nothing_depends_on_speed():
    """The time of tables runs differently, and nothing else."""
    slow, fast = (kf.pull("figure-eight", {**PLAIN, "steps.pull.speed": f"{v} mm/s"}) for v in (1, 16))
    np.testing.assert_allclose(fast.force.force, slow.force.force, rtol=1e-5)
    assert fast.table("force")["time_s"][-1] == pytest.approx(1.0 + (slow.table("force")["time_s"][-1] - 1.0) / 16.0)


def test_nothing_depends_on_density_without_weight():
    light, heavy = (kf.pull("figure-eight", {**PLAIN, "rods.0.material.density": f"{rho} kg/m^3"}) for rho in (10, 1e5))
    places = np.array([0.0, 0.5, 1.0])
    np.testing.assert_allclose(heavy.force.at(places), light.force.at(places), rtol=2e-3)


def test_force_over_modulus_is_constant():
    forces = []
    for modulus in (2.0, 10.0):
        tolerance = f"{1e-5 * modulus / 1.425} N"
        changed = {
            "rods.0.material.youngs_modulus": f"{modulus} MPa",
            "rods.0.core.youngs_modulus": f"{75.5 * modulus / 1.425} GPa",
            "solver.force_tolerance": tolerance,
        }
        run = kf.pull("figure-eight", {**PLAIN, **changed})
        forces.append(run.force.force[-1] / modulus)
    assert forces[1] == pytest.approx(forces[0], rel=5e-3)


def test_a_run_that_is_stopped_again_and_again_goes_on_to_the_bit(tmp_path, monkeypatch, snapped):
    """Amid the jump too, which takes more iterations than lie between two stops."""
    asked = iter(range(10**6))
    monkeypatch.setattr(StopRequest, "due", property(lambda self: next(asked) % 97 == 96))
    stops = 0
    try:
        run = kf.pull("figure-eight", SNAP, out=tmp_path / "run")
    except Stopped:
        run = None
    while run is None:
        stops += 1
        try:
            run = kf.resume(tmp_path / "run")
        except Stopped:
            continue
    assert stops > 3
    for name in ("displacement_mm", "force_N", "elastic_Nmm", "equilibrium"):
        np.testing.assert_array_equal(run.table("force")[name], snapped.table("force")[name])
    for name, values in snapped.events.items():
        np.testing.assert_array_equal(run.events[name], values)


def test_a_step_in_real_time_sets_out_at_rest():
    steps = [{"kind": "relax"}, {"kind": "hold", "duration": "0.01 s", "rate": "real"}]
    scene = kf.load_scene("cantilever", {"model": "rod", "steps": steps, "output.fields": False})
    hold = [event for event in kf.steps(scene) if event.step.kind == "hold"]
    assert not hold[0].accepted.start.v.any()
    assert max(event.energies.kinetic for event in hold) < 1e-6


def test_a_jump_without_an_equilibrium_before_it_tells_the_force_after_it():
    jump = Jump("pull", 1.0, 60.0, 0.0, math.nan, 0.27, "rod", 1.0, 191.0, 17.8, 238)
    assert ", force 0.27 N, " in str(jump)
    assert ", force 0.5 to 0.27 N, " in str(replace(jump, force_before=0.5))


def test_sliding_over_a_cylinder_is_smooth_and_independent_of_the_steps():
    """A rod that may roll: friction with an arm that turns with it made its tail swing to and fro at every step."""
    coarse = {
        "model": "rod",
        "output.fields": False,
        "rods.0.mesh.element_length": "5 mm",
        "contact.sample_spacing_over_diameter": 0.25,
        "steps.pull.displacement": "3 mm",
    }
    long, short = (kf.pull("capstan", {**coarse, "solver.move_over_diameter": move}) for move in (0.5, 0.05))
    for run in (long, short):
        pulled = run.table("force")
        sliding = pulled["force_N"][(pulled["step"] == "pull") & (pulled["step_displacement_mm"] > 1.5)]
        assert np.ptp(sliding) < 0.02 * sliding[-1]
    assert short.force.force[-1] == pytest.approx(long.force.force[-1], rel=2e-3)
