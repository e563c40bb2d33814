"""References of manufactured solutions with several sources of error."""

import numpy as np
import pytest

from knotfem.scene import load_scene
from knotfem.study.closed_forms import ClosedForm
from knotfem.study.engine.outcomes import Outcome, State
from knotfem.study.extrapolation import Limit
from knotfem.study.measured import Measured
from knotfem.study.references import falling, mesh_limit, references, series_limits
from knotfem.study.refinement import Level

TRUE = np.linspace(0.5, 2.0, 7)


def entry(series: str, size: float, value: np.ndarray, state: State = "done") -> Measured:
    level = Level(f"{series}-{size}", series, "", size)
    quantities = {"force": value} if state == "done" else {}
    return Measured(level, load_scene("cantilever"), Outcome(state), quantities, size=size)


def refinements() -> dict[str, list[Measured]]:
    def solution(slices: float, step: float) -> np.ndarray:
        return TRUE * (1.0 + 0.03 * slices**2) + 0.02 * step

    sizes = (2.0, 1.0, 0.5)
    return {
        "slice": [entry("slice", h, solution(h, 1.0)) for h in sizes],
        "step": [entry("step", h, solution(1.0, h)) for h in sizes],
        "uniform": [entry("uniform", h, solution(h, h)) for h in sizes],
    }


def test_orders_of_single_series_and_their_sum():
    limits = series_limits(refinements(), "force")
    assert limits["slice"].order == pytest.approx(2.0)
    assert limits["step"].order == pytest.approx(1.0)
    base = TRUE * 1.03 + 0.02
    found = references("force", base, limits)
    (sum_of_limits,) = [r for r in found if "added up" in r.source]
    assert sum_of_limits.value == pytest.approx(TRUE)
    assert sum_of_limits.source == "limits of slice, step added up"
    assert sum_of_limits.error(base) == pytest.approx(np.sqrt(np.mean((base - TRUE) ** 2) / np.mean(TRUE**2)))


def test_least_uncertain_reference_comes_first():
    sure = Limit(TRUE, 0.001, 2.0, "asymptotic")
    unsure = Limit(TRUE + 1.0, 0.5, None, "two levels only")
    assert "refined at once" in references("force", TRUE, {"uniform": sure, "slice": unsure})[0].source
    assert "added up" in references("force", TRUE, {"uniform": unsure, "slice": sure})[0].source
    theory = ClosedForm("sag", 2.0, 0.01, "elastica")
    sag = {"uniform": Limit(np.array([2.1]), 0.2, None, "")}
    assert references("sag", np.array([2.2]), sag, theory)[0].source == "elastica"
    assert references("force", TRUE, {"uniform": unsure}, theory)[0].source != "elastica"


def test_sum_without_the_limit_of_a_choice_is_no_bound():
    sure = Limit(TRUE, 0.001, 2.0, "asymptotic")
    needed = ("section", "slice", "step")
    (part,) = references("force", TRUE, {"slice": sure}, needed=needed)
    assert (part.uncertainty, part.lacks) == (np.inf, ("section", "step"))
    assert part.source == "limits of slice added up; lacks section, step"
    (whole,) = references("force", TRUE, dict.fromkeys(needed, sure), needed=needed)
    assert (whole.lacks, whole.uncertainty < 0.01) == ((), True)
    unsure = Limit(TRUE, 0.5, None, "two levels only")
    assert "refined at once" in references("force", TRUE, {"slice": sure, "uniform": unsure}, needed=needed)[0].source
    theory = ClosedForm("force", 2.0, 0.05, "capstan")
    assert references("force", TRUE, {"slice": sure}, theory, needed)[0].source == "capstan"


def test_limit_of_the_mesh_needs_section_and_slice():
    limits = series_limits(refinements(), "force")
    base = TRUE * 1.03 + 0.02
    assert mesh_limit(base, limits) is None
    section = Limit(base - 0.1, 0.01, None, "")
    found = mesh_limit(base, {**limits, "section": section})
    assert found is not None
    assert found.value == pytest.approx(TRUE + 0.02 - 0.1)
    assert found.uncertainty == pytest.approx(0.01 + limits["slice"].uncertainty)


def test_no_overlap_is_the_exact_penetration():
    (exact,) = references("penetration", np.array([0.02]), {})
    assert (exact.error(np.array([0.02])), exact.uncertainty) == (0.02, 0.0)


def test_no_levels_no_reference():
    assert references("force", TRUE, {}) == []


def test_falling_leaves_out_what_is_not_done_and_equal_sizes():
    levels = [entry("step", 0.5, TRUE), entry("step", 2.0, TRUE), entry("step", 1.0, TRUE, "failed")]
    same = entry("step", 0.5 * (1.0 - 1e-9), TRUE + 1.0)
    assert falling([*levels, same])[1].size == pytest.approx(0.5)
    assert len(falling([*levels, same])) == 2
    nearly = entry("step", 2.1, TRUE)
    assert [e.size for e in falling([nearly, *levels])] == [2.0, 0.5]
