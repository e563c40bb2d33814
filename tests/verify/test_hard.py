"""Small versions of all hard cases, and the measures that their verdicts rest on."""

from __future__ import annotations

import numpy as np
import pytest
from specimens import make_rod

from knotfem import shipped
from knotfem.run.build import build_body
from knotfem.scene import load_scene
from knotfem.verify.hard import Outcome, hard_cases
from knotfem.verify.hard_display import COMMON, runs, show
from knotfem.verify.hard_input import random_curve
from knotfem.verify.hard_invariance import twins
from knotfem.verify.hard_knots import capstan_exponent, roughness
from knotfem.verify.hard_steps import force_error
from knotfem.verify.hard_twist import link_of
from knotfem.verify.verdict import Case, Quantity, Verdict, judge

ROWS = {
    "frictionless", "rough", "bulk", "core", "soft", "stiff", "slip", "end", "overlap", "twist", "hold", "cycles",
    "invariance", "settings", "random",
}  # fmt: skip


@pytest.mark.parametrize("case", hard_cases(small=True), ids=lambda case: case.name)
def test_small_version(case: Case) -> None:
    verdict = judge(case)
    for q in verdict.quantities:
        print(f"\n{case.name}, {q.name} {q.condition}: {q.shown}", end="")
    assert verdict.passed, [(q.name, q.condition, q.shown) for q in verdict.quantities if not q.passed] or verdict.error


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


def test_capstan_with_thickness() -> None:
    assert np.exp(np.pi * capstan_exponent(0.33, 3.0, 10.0)) == pytest.approx(2.187, abs=1e-3)
    assert capstan_exponent(0.33, 1e-4, 10.0) == pytest.approx(0.33, rel=1e-4)


def test_roughness_tells_a_checkerboard_from_a_slope() -> None:
    slope = np.linspace(0.0, 1.0, 41)[:, None, None] * np.ones((1, 4, 1))
    checkerboard = np.where(np.add.outer(np.arange(41), np.arange(4)) % 2, 1.0, -1.0)[:, :, None]
    assert roughness(slope) < 1e-9
    assert roughness(checkerboard) == pytest.approx(2.0, rel=1e-3)
    assert roughness(slope + 0.3 * checkerboard) > 1.0


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
    from knotfem.centerline.frames import rotation_minimising_frame
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


def outcome(displacement: list[float], force: list[float]) -> Outcome:
    columns = {"displacement_mm": np.array(displacement), "force_N": np.array(force)}
    columns["step"] = np.array(["pull"] * len(force))
    scene = load_scene("overhand")
    return Outcome(scene, "yes", 10, 40, 1, 0.9, 0.01, "3_1", "3_1", 0.0, 1.0, columns, {}, [])


def test_error_of_a_force_curve() -> None:
    usual = outcome([1.0, 2.0, 3.0], [1.0, 2.0, 4.0])
    assert force_error(outcome([1.0, 3.0], [1.0, 4.0]), usual) == pytest.approx(0.125)
    assert force_error(usual, usual) == 0.0


def test_outcome_is_judged_by_its_figures(capsys) -> None:
    good = outcome([1.0], [1.0])
    assert all(q.passed for q in good.quantities(before="3_1", after="3_1"))
    lost = good.quantities(after="unknot")
    assert [q.name for q in lost if not q.passed] == ["knot after"]
    assert set(runs(good.quantities())[""]) == set(COMMON)
    case = Case("rough", lambda: [], "title", "hard cases")
    extra = Quantity("force, N", 2.0, 1.0, 0.1)
    show([Verdict(case, (*lost, extra), 1.5), Verdict(case, error="NotConverged: gave up")])
    text = capsys.readouterr().out
    assert "FAIL" in text
    assert "2 cases, 2 failed" in text
    assert "NotConverged" in text
