"""Small versions of all hard cases, and the measures on which their results rest."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from specimens import make_rod

import knotfem as kf
from knotfem import shipped
from knotfem.errors import Interrupted, KnotfemError, MissingDependency, NotConverged, Stopped
from knotfem.models.solid.body import build_body
from knotfem.models.solid.model import SolidModel
from knotfem.run.directory import RunDirectory
from knotfem.run.events import PhaseDone, TimeStepDone
from knotfem.run.simulation import Simulation
from knotfem.scene import Scene, load_scene
from knotfem.scene.steps import Relax
from knotfem.solver.state import Motion, State
from knotfem.verify.case import Case, Quantity, Result, check, select
from knotfem.verify.stress import input as hard_input
from knotfem.verify.stress import steps as hard_steps
from knotfem.verify.stress.display import COMMON, runs, show
from knotfem.verify.stress.input import random_curve, tie_random
from knotfem.verify.stress.invariance import twins
from knotfem.verify.stress.knots import contacts
from knotfem.verify.stress.outcome import Outcome
from knotfem.verify.stress.pressure import roughness, roughness_across
from knotfem.verify.stress.runs import Recording, hard_scene, run
from knotfem.verify.stress.steps import force_error
from knotfem.verify.stress.suite import hard_cases
from knotfem.verify.stress.twist import link_of

ROWS = {
    "frictionless", "rough", "bulk", "core", "soft", "stiff", "slip", "end", "overlap", "twist", "hold", "cycles",
    "invariance", "settings", "random",
}  # fmt: skip


LONG = {"stiff", "core"}
"""Small versions that still take more than 20 s."""


def small_cases() -> list:
    marks = {name: [pytest.mark.slow] for name in LONG}
    return [pytest.param(case, id=case.name, marks=marks.get(case.name, [])) for case in hard_cases(small=True)]


@pytest.mark.parametrize("case", small_cases())
def test_small_version(case: Case) -> None:
    result = check(case)
    for q in result.quantities:
        print(f"\n{case.name}, {q.name} {q.condition}: {q.shown}", end="")
    assert result.passed, [(q.name, q.condition, q.shown) for q in result.quantities if not q.passed] or result.error


def test_every_row_has_a_case_and_every_case_a_full_version() -> None:
    small, full = hard_cases(small=True), hard_cases()
    assert {case.group for case in full} == ROWS
    assert [case.name for case in full] == [case.name for case in small]
    assert all(case.slow for case in full)
    assert not any(case.slow for case in small)


def test_every_hard_scene_is_right_and_named() -> None:
    names = [name for name in shipped.scene_names() if name.startswith("hard/")]
    assert len(names) >= 25
    assert all(load_scene(name).description for name in names)


def test_roughness_tells_a_checkerboard_from_a_slope() -> None:
    slope = np.linspace(0.0, 1.0, 41)[:, None, None] * np.ones((1, 4, 1))
    checkerboard = np.where(np.add.outer(np.arange(41), np.arange(4)) % 2, 1.0, -1.0)[:, :, None]
    assert roughness(slope) < 1e-9
    assert roughness(checkerboard) == pytest.approx(2.0, rel=1e-3)
    assert roughness(slope + 0.3 * checkerboard) > 1.0


@pytest.mark.parametrize("elements", [4, 12])
def test_roughness_tells_a_checkerboard_across_the_section_from_a_slope(elements: int) -> None:
    section = make_rod(12.0, 2, section=elements).mesh.section
    x, y = section.points[section.quads[:, :4]].mean(axis=1).T
    slope, checkerboard = (np.tile(p, (41, 1))[:, :, None] for p in (1.0 + 2.0 * x - y, np.sign(x * y)))
    assert roughness(checkerboard) < 1e-9
    assert roughness_across(slope, section) < 1e-9
    assert roughness_across(checkerboard, section) > 0.5
    assert roughness_across(slope + 0.5 * checkerboard, section) > 0.1


def test_roughness_across_of_alternating_quads() -> None:
    section = make_rod(12.0, 2, section=4).mesh.section
    x, y = section.points[section.quads[:, :4]].mean(axis=1).T
    assert roughness_across(np.tile(np.sign(x * y), (5, 1))[:, :, None], section) == pytest.approx(2.0)


@pytest.mark.parametrize("turns", [0.7, -2.25])
def test_link_of_a_twisted_straight_rod_is_its_twist(turns: float) -> None:
    rod = build_body(load_scene("cantilever")).rods[0]
    x = rod.mesh.nodes.copy()
    angle = 2.0 * np.pi * turns * x[:, 2] / rod.mesh.length
    c, s = np.cos(angle), np.sin(angle)
    x[:, 0], x[:, 1] = c * x[:, 0] - s * x[:, 1], s * x[:, 0] + c * x[:, 1]
    twist, writhe = link_of(rod, x)
    assert twist == pytest.approx(turns, abs=1e-9)
    assert writhe == pytest.approx(0.0, abs=1e-9)


def test_link_is_kept_where_twist_becomes_writhe() -> None:
    """A rod along a helix between straight ends, its sections carried without twist: all of the link is writhe."""
    body = build_body(load_scene("overhand", ["rods.0.mesh.section_elements=4"]))
    rod = body.rods[0]
    from knotfem.geometry.frames import rotation_minimising_frame
    from knotfem.tie import swept_state

    links = []
    for turns in (0.0, 0.25):
        frames = rotation_minimising_frame(rod.target.points)
        x = swept_state(rod.target.points, frames, rod.section_points).reshape(-1, 3)
        nodes = rod.section_nodes
        angle = 2.0 * np.pi * turns * np.linspace(0.0, 1.0, len(nodes))[:, None]
        a = np.einsum("ijk,ik->ij", x[nodes] - x[rod.axis_nodes][:, None], frames[:, 0])
        b = np.einsum("ijk,ik->ij", x[nodes] - x[rod.axis_nodes][:, None], frames[:, 1])
        c, s = np.cos(angle), np.sin(angle)
        y = x.copy()
        y[nodes] = x[rod.axis_nodes][:, None] + (c * a - s * b)[..., None] * frames[:, None, 0]
        y[nodes] += (s * a + c * b)[..., None] * frames[:, None, 1]
        links.append(link_of(rod, y))
    assert links[0][0] == pytest.approx(0.0, abs=1e-3)
    assert abs(links[0][1]) > 2.0
    assert links[1][0] - links[0][0] == pytest.approx(0.25, abs=1e-6)
    assert links[1][1] == pytest.approx(links[0][1], abs=1e-9)


def test_sections_are_their_own_mirror_images() -> None:
    for elements in (4, 12):
        section = make_rod(12.0, 2, section=elements).mesh.section
        twin = twins(section.points, section.points * [1.0, -1.0])
        assert sorted(twin) == list(range(len(section.points)))
        assert (twin[twin] == np.arange(len(twin))).all()
    with pytest.raises(AssertionError):
        twins(np.array([[0.0, 0.0], [1.0, 0.5]]), np.array([[0.0, 0.0], [1.0, -0.5]]))


def test_random_curves_repeat_and_some_are_closed() -> None:
    first, closed = random_curve(4)
    again, _ = random_curve(4)
    assert closed
    np.testing.assert_array_equal(first, again)
    np.testing.assert_allclose(first[0], first[-1], atol=1e-9)
    assert sum(random_curve(seed)[1] for seed in range(20)) == 5


def outcome(displacement: list[float], force: list[float], ended: str = "yes") -> Outcome:
    columns = {"step_displacement_mm": np.array(displacement), "force_N": np.array(force)}
    columns["step"] = np.array(["pull"] * len(force))
    scene = load_scene("overhand")
    return Outcome(ended, 10, 1, 0.9, 0.01, "3_1", "3_1", 0.0, scene, 40, columns, {}, [])


def test_error_of_a_force_curve() -> None:
    usual = outcome([1.0, 2.0, 3.0], [1.0, 2.0, 4.0])
    assert force_error(outcome([1.0, 3.0], [1.0, 4.0]), usual) == pytest.approx(0.125)
    assert force_error(usual, usual) == 0.0


def test_outcome_is_checked_by_its_figures(capsys) -> None:
    good = outcome([1.0], [1.0])
    assert all(q.passed for q in good.quantities(before="3_1", after="3_1"))
    lost = good.quantities(before="3_1", after="unknot")
    assert [q.name for q in lost if not q.passed] == ["knot after"]
    assert set(runs(lost)[""]) == set(COMMON)
    case = Case("rough", lambda: [], "title", "hard cases")
    extra = Quantity("force, N", 2.0, 1.0, 0.1)
    show([Result(case, (*lost, extra), 1.5), Result(case, error="NotConverged: gave up")])
    text = capsys.readouterr().out
    assert "FAIL" in text
    assert "2 cases, 2 failed" in text
    assert "NotConverged" in text


def test_what_was_not_measured_and_what_may_deviate_is_shown(capsys) -> None:
    at_rest = replace(outcome([1.0], [1.0]), energy_error=None)
    show(
        [
            Result(
                Case("overlap", lambda: [], "", ""),
                (*at_rest.quantities(before="3_1", after="3_1"), Quantity("gap", 0.5, 0.6, 0.25)),
            )
        ]
    )
    row = next(line for line in capsys.readouterr().out.splitlines() if "3_1" in line)
    assert [cell.strip() for cell in row.split("│")][6:9] == ["3_1", "3_1", "-"]
    show([Result(Case("overlap", lambda: [], "", ""), (Quantity("gap", 0.5, 0.6, 0.25),))])
    assert "-16.67 % of 25 %" in capsys.readouterr().out


def test_mesh_is_that_of_the_scene() -> None:
    meshes = {case.name: case.mesh for case in hard_cases()}
    assert meshes["hold"] == "4 hexahedra per section, h = 5 mm"
    assert meshes["overlap:smoothed"] == meshes["frictionless:overhand"] == "12 hexahedra per section, h = 2.5 mm"


def fails_at_once(scene: Scene, *, out: Path, progress: bool) -> None:
    """A run that gives up before it has a row of force."""
    directory = RunDirectory.create(scene, out)
    directory.write_summary(
        {"steps": 0, "newton_iterations": 0, "cutbacks": 9, "min_jacobian": 1.0, "max_penetration_over_d": 0.0}
    )  # fmt: skip
    (directory.path / "log.jsonl").touch()
    raise NotConverged("gave up")


@pytest.mark.parametrize("name", ["frictionless:overhand", "rough:capstan", "slip", "hold", "cycles"])
def test_a_run_that_fails_at_once_is_shown_to_have_failed(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kf, "pull", fails_at_once)
    (case,) = select(hard_cases(small=True), [name])
    result = check(case)
    assert not result.error
    assert [q.found for q in result.quantities if q.name == "finished"] == ["NotConverged: gave up"]
    assert not result.passed


@pytest.mark.parametrize("kind", [Interrupted, Stopped, MissingDependency])
def test_only_a_run_that_gave_up_or_lost_its_knot_says_so(
    kind: type[KnotfemError], monkeypatch: pytest.MonkeyPatch
) -> None:
    def ends(scene: Scene, *, out: Path, progress: bool) -> None:
        raise kind("ended")

    monkeypatch.setattr(kf, "pull", ends)
    with pytest.raises(kind):
        run(load_scene("overhand"))


@pytest.mark.parametrize("kind", [Interrupted, Stopped])
def test_random_curves_heed_a_request_to_stop(
    kind: type[KnotfemError], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def ends(scene: Scene, *, out: Path, progress: bool) -> None:
        raise kind("asked to stop")

    monkeypatch.setattr(kf, "tie", ends)
    with pytest.raises(kind):
        tie_random(1, tmp_path)
    if kind is Stopped:
        monkeypatch.setattr(hard_input, "LONGEST", 1e-9)
        assert tie_random(2, tmp_path) == "hung"


def test_settings_may_fail_if_they_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    usual, failed = outcome([1.0], [1.0]), outcome([], [], ended="NotConverged: gave up")
    monkeypatch.setattr(hard_steps, "_usual", lambda small: usual)
    monkeypatch.setattr(hard_steps, "run", lambda scene: failed)
    (case,) = select(hard_cases(small=True), ["settings:loose-tolerance"])
    assert check(case).passed
    monkeypatch.setattr(hard_steps, "_usual", lambda small: failed)
    assert not check(case).passed


def test_contact_at_points_is_contact() -> None:
    found = replace(outcome([1.0], [1.0]), force={"contacts": np.array([0.0])})
    assert [q.passed for q in contacts(found)] == [False, True]
    found = replace(found, force={"contacts": np.array([84.0])})
    assert [q.passed for q in contacts(found)] == [True, True]


def test_recording_keeps_the_worst_and_names_the_knot() -> None:
    recording = Recording(Simulation(hard_scene("overhand-core-6e4", ("steps.1.displacement=0.2 mm",), small=True)))
    seen = [step.energies for step in recording if not isinstance(step.step, Relax)]
    found = recording.outcome()
    assert (found.before, found.after) == ("3_1", "3_1")
    scale = max(max(abs(e.work), e.elastic, e.friction, e.taken.get("drag", 0.0)) for e in seen)
    assert scale > 0.0
    assert found.energy_error == pytest.approx(max(abs(e.error) for e in seen) / scale)


def tied_overhand() -> tuple[Scene, np.ndarray]:
    scene = hard_scene("overhand-core-6e4", small=True)
    simulation = Simulation(scene, "tie")
    next(event for event in simulation.run() if isinstance(event, PhaseDone))
    return scene, simulation.state.x


def test_knot_before_and_knot_after_are_those_of_two_states() -> None:
    scene, x = tied_overhand()
    model = SolidModel(scene)
    recording = Recording(Simulation(scene, model=model))
    recording.simulation.start_at(State.of(Motion.at_rest(x), {}))
    recording.simulation.state = State.of(Motion.at_rest(model.body.rods[0].mesh.nodes), {})
    found = recording.outcome()
    assert (found.before, found.after) == ("3_1", "unknot")
    wrong = [q.name for q in found.quantities(before="3_1", after="3_1") if not q.passed]
    assert wrong == ["knot after"]
    assert [q.name for q in found.quantities(before="unknot", after="unknot") if not q.passed] == ["knot before"]


@pytest.mark.parametrize("turn", [np.eye(3), np.array([[0.36, 0.48, -0.80], [-0.80, 0.60, 0.0], [0.48, 0.64, 0.60]])])
def test_a_simulation_starts_at_a_given_state_without_history(turn: np.ndarray) -> None:
    scene, x = tied_overhand()
    simulation = Simulation(scene, "tie")
    start = State.of(Motion.at_rest(x @ turn.T + [5.0, -3.0, 8.0]), {})
    simulation.start_at(start)
    assert simulation.knots_before is not None
    assert simulation.knots_before["rod"]["name"] == "3_1"
    first = next(simulation.run())
    assert isinstance(first, TimeStepDone)
    assert first.accepted.start.x == pytest.approx(start.x)
    again = Simulation(scene, "tie")
    again.restore(simulation.checkpoint())
    np.testing.assert_allclose(again.monitor.ends, simulation.monitor.ends)
    np.testing.assert_array_equal(again.state.x, first.state.x)
