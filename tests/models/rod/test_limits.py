"""Limits of the rod model, and what a run says of them."""

from __future__ import annotations

import numpy as np
import pytest

import knotfem as kf
from knotfem.models.build import build_model
from knotfem.models.rod.limits import CURVATURE, SQUASHED, TURN, reaches
from knotfem.run.progress import Silent
from knotfem.scene import load_scene

COARSE = {"model": "rod", "output.fields": False, "rods.0.mesh.element_length": "3 mm"}


def arc(radius: float, segment: float) -> np.ndarray:
    a = np.arange(0.0, 1.5, segment / radius)
    return radius * np.column_stack([np.cos(a), np.sin(a), 0.0 * a])


def measured(line: np.ndarray, penetration: float, **changes: object) -> dict[str, tuple[float, bool]]:
    scene = load_scene("overhand", {**COARSE, **changes})
    return {reach.name: (reach.value, reach.exceeded) for reach in reaches(scene, [line], penetration)}


@pytest.mark.parametrize(("times", "beyond"), [(0.95, False), (1.05, True)])
def test_each_limit_is_met_by_its_own_measure(times: float, beyond: bool) -> None:
    for name, line, penetration, value in (
        ("curvature_times_d", arc(6.0 / (times * CURVATURE), 0.5), 0.0, times * CURVATURE),
        ("turn_per_segment", arc(20.0, 20.0 * times * TURN), 0.0, times * TURN),
        ("squashed_over_d", arc(100.0, 1.0), 6.0 * times * SQUASHED / 100.0 ** (2.0 / 3.0), times * SQUASHED),
    ):
        found = measured(line, penetration)
        assert found[name] == (pytest.approx(value, rel=2e-3), beyond), name
        assert not any(exceeded for other, (_, exceeded) in found.items() if other != name)


def test_soft_contact_is_as_deep_as_it_looks() -> None:
    changes = {"contact.line_stiffness_over_hertz": 1.0}
    assert measured(arc(100.0, 1.0), 0.3, **changes)["squashed_over_d"][0] == pytest.approx(0.05)


def test_a_run_says_once_that_it_has_left_the_limits() -> None:
    """A clove hitch is pulled until it is hard: contacts first, everything else stays within."""
    said: list[str] = []

    class Listening(Silent):
        def message(self, text: str) -> None:
            said.append(text)

    changes = {**COARSE, "steps.pull.displacement": "60 mm", "output.every_displacement": "2 mm"}
    run = kf.pull("clove-hitch", changes, progress=Listening())
    (remark,) = run.summary["remarks"]
    assert remark["said"].startswith("pull: beyond the limits of the rod model from ")
    assert "would squash real sections by 0.1" in remark["said"]
    assert 40.0 < remark["displacement_mm"] < 60.0
    assert said.count(remark["said"]) == 1
    assert remark["said"] in run.notes
    validity = run.summary["validity"]
    assert {name: entry["exceeded"] for name, entry in validity.items()} == {
        "squashed_over_d": True,
        "curvature_times_d": False,
        "turn_per_segment": False,
    }
    assert validity["squashed_over_d"]["largest"] > 0.2


def test_a_loose_knot_is_within_the_limits() -> None:
    run = kf.pull("overhand", {**COARSE, "steps.pull.displacement": "1 mm"}, progress=False)
    assert run.summary["remarks"] == []
    assert not any(entry["exceeded"] for entry in run.summary["validity"].values())
    assert run.summary["validity"]["curvature_times_d"]["largest"] == pytest.approx(0.22, abs=0.03)


def test_hexahedra_have_no_limits_that_are_known() -> None:
    model = build_model(load_scene("overhand", ["rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=10 mm"]))
    assert list(model.reaches(model.straight().x, 1.0)) == []
