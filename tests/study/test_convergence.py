"""A whole convergence study of runs whose errors follow a known law."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from manufactured import LAW, TRUE_BENT, TRUE_FORCE, cpu_of, error_of, write_run, write_series

from knotfem.errors import InputError, KnotLost, NotConverged
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.scene import load_scene
from knotfem.study import files, records, tables
from knotfem.study import jobs as module
from knotfem.study.convergence import chosen, run_convergence
from knotfem.study.engine.outcomes import Outcome
from knotfem.study.refinement import SIZED, Level

SINGLE = ("slice", "section", "step", "penalty", "ramp", "tolerance", "sampling", "stick", "rate", "settling")
NAMES = (*SINGLE, "uniform", "element")
PULL = "steps.1.displacement=30 mm"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("cost")
    write_series(path, (PULL,), NAMES, failed="slice-x2")
    return path


@pytest.fixture(scope="module")
def study(folder):
    return run_convergence("overhand", [PULL], folder, budget=None, names=NAMES, tell=lambda text: None)


def test_orders_are_those_of_the_law(study):
    found = study.limits["force"]
    for series, (_, order) in LAW.items():
        assert found[series].order == pytest.approx(order, rel=1e-3), series
        assert found[series].asymptotic
    assert found["tolerance"].behaviour == "no effect"


def test_reference_is_the_truth_within_what_it_says(study):
    reference = study.references["force"][0]
    assert reference.value[-1] == pytest.approx(TRUE_FORCE, rel=reference.uncertainty)
    assert reference.uncertainty < 0.02
    (added_up,) = [other for other in study.references["force"] if "added up" in other.source]
    assert added_up.value[-1] == pytest.approx(TRUE_FORCE, rel=1e-4)


def test_errors_and_costs_of_levels(study):
    uncertainty = study.references["force"][0].uncertainty
    for entry in study.measured:
        if entry.done:
            assert study.error(entry, "force") == pytest.approx(error_of(entry.scene), abs=uncertainty), (
                entry.level.name
            )
            assert entry.cpu["total"] == pytest.approx(cpu_of(entry.scene))
            assert entry.cpu["other"] == pytest.approx(0.1 * entry.cpu["total"])
    assert study.error(study.base, "penetration") == pytest.approx(0.01)
    assert study.base.quantities["knot_size"][0] == pytest.approx(TRUE_BENT, rel=0.05)
    fine = next(entry for entry in study.measured if entry.level.name == "slice-x0.5")
    assert study.own_error(fine, "force") == pytest.approx(0.25 * LAW["slice"][0], abs=1e-4)


def test_own_error_of_an_element_is_that_of_its_mesh(study):
    of = {entry.level.name: study.own_error(entry, "force") for entry in study.measured}
    section, slices = LAW["section"][0], LAW["slice"][0]
    assert of["base"] == pytest.approx(section + slices, abs=1e-4)
    assert of["element-hex8"] == pytest.approx(section + slices, abs=1e-4)
    assert of["element-hex8-4-x2"] == pytest.approx(3.0 * section + 4.0 * slices, rel=2e-3)


def test_failed_level_is_in_the_table_without_an_error(study):
    failed = next(entry for entry in study.measured if entry.level.name == "slice-x2")
    assert (failed.done, failed.outcome.reason) == (False, "strands passed through each other")
    assert np.isnan(study.error(failed, "force"))
    assert any("slice-x2 (failed)" in line for line in tables.recommendations(study))


def test_recommendation_is_the_cheapest_within_the_target(study):
    for target in (0.05, 0.02):
        cheapest = study.cheapest(target)
        if cheapest is None:
            assert all(not study.promised_error(entry) <= target for entry in study.measured if entry.done)
            continue
        assert study.promised_error(cheapest) <= target
        for entry in study.measured:
            if entry.done and study.promised_error(entry) <= target:
                assert entry.cpu["total"] >= cheapest.cpu["total"]
    assert study.cheapest(0.05) is not None
    assert study.cheapest(1e-6) is None


def test_luck_is_no_bound(study):
    """The bound of a coarse level that happens upon the reference itself is the error of the scene that refines it."""
    truth = study.references["force"][0].value
    lucky = [
        replace(entry, quantities={**entry.quantities, "force": truth}) if entry.level.name == "section-4" else entry
        for entry in study.measured
    ]
    (coarse,) = [entry for entry in lucky if entry.level.name == "section-4"]
    changed = replace(study, measured=lucky)
    assert changed.error(coarse, "force") == 0.0
    assert changed.error_bound(coarse) >= changed.error(study.base, "force") > 0.0


def test_combination_is_bounded_no_better_than_its_element(study):
    truth = study.references["force"][0].value
    (element,) = [entry for entry in study.measured if entry.level.name == "element-hex8-4-x2"]
    level = replace(element.level, name="element-hex8-4-x2+step-x0.25", series="chosen")
    lucky = replace(element, level=level, quantities={**element.quantities, "force": truth})
    changed = replace(study, measured=[*study.measured, lucky])
    assert changed.error(lucky, "force") == 0.0
    assert changed.error_bound(lucky) >= changed.error_bound(element) > 0.0


def test_luck_is_not_combined(study):
    """An element whose coarse mesh happens upon the limit is an option with the error of its finer mesh."""
    limit = study.own_limit("element", "force").value
    series = {
        **study.series,
        "element": [
            replace(entry, quantities={**entry.quantities, "force": limit})
            if entry.level.name == "element-hex8-4-x2"
            else entry
            for entry in study.series["element"]
        ],
    }
    names = [level.name for level in chosen(replace(study, series=series))]
    assert not any("element-hex8-4-x2" in name for name in names)


def test_files(study, folder, tmp_path):
    record = records.record_of(study)
    files.write_study(study, tmp_path)
    table = read_table(tmp_path / "cost.csv")
    assert list(table["rung"]) == [entry.level.name for entry in study.measured]
    assert {"force_error", "force_own_error", "contact_cpu_s", "peak_memory_mb", "pareto"} <= set(table)
    assert table["pareto"].sum() == len(study.front)
    assert [setting.level for setting in record.settings] == [entry.level.name for entry in study.offers]
    bounds = [setting.bound for setting in record.settings]
    assert bounds == sorted(bounds, reverse=True)
    assert all(study.cheapest(1.01 * bound) in study.offers for bound in bounds)
    assert (tmp_path / "cost.png").stat().st_size > 10_000
    assert json.loads((tmp_path / "recommendation.json").read_text())["scene"] == "overhand"


def test_series_without_sizes_give_no_reference(folder, tmp_path):
    study = run_convergence("overhand", [PULL], folder, budget=None, names=["element"], tell=lambda text: None)
    assert study.cheapest(0.5) is None
    assert study.front == []
    assert tables.recommendations(study)[0] == "nothing is recommended: no refinement series gives a reference"
    files.write_study(study, tmp_path)
    assert not (tmp_path / "recommendation.json").exists()
    with pytest.raises(InputError, match="no reference"):
        records.record_of(study)


def test_reference_that_lacks_series_recommends_nothing(study, folder, tmp_path):
    files.write_study(study, tmp_path)
    part = run_convergence("overhand", [PULL], folder, budget=None, names=["slice"], tell=lambda text: None)
    assert (part.cheapest(0.5), part.front) == (None, [])
    (line, *_) = tables.recommendations(part)
    assert line == (
        "nothing is recommended: the reference lacks section, step, penalty, ramp, tolerance, sampling, stick, rate, "
        "settling; run these series too, or uniform"
    )
    with pytest.raises(InputError, match="nothing bounds the reference; found limits of slice added up; lacks"):
        records.record_of(part)
    files.write_study(part, tmp_path)
    assert not (tmp_path / "recommendation.json").exists()
    whole = run_convergence("overhand", [PULL], folder, budget=None, names=SINGLE, tell=lambda text: None)
    assert records.record_of(whole).reference == f"limits of {', '.join(l for l in SIZED if l in SINGLE)} added up"


def test_table_names_front_orders_and_sources(study):
    from rich.console import Console

    console = Console(width=400)
    with console.capture() as captured:
        console.print(*tables.tables(study), sep="\n")
    text = captured.get()
    assert re.search(r"\* +uniform-108", text)
    assert re.search(r"slice +force +asymptotic +2\.00", text)
    assert "limits of section, slice, step, penalty, ramp, tolerance, sampling, stick, rate, settling added up" in text
    assert "failed, strands passed through each other" in text


def test_combination_follows_from_the_series_and_is_run(folder, monkeypatch):
    taken: list[Level] = []

    def work(self, engine, waiting):
        for level in waiting:
            taken.append(level)
            write_run(self.run_of(level), self.scene_of(level))
            self.outcomes[level.name] = Outcome("done")

    monkeypatch.setattr(module.Jobs, "work", work)
    names = ["slice", "section", "step", "chosen"]
    study = run_convergence("overhand", [PULL], folder, budget=None, names=names, tell=lambda text: None)
    assert taken
    assert {entry.level.series for entry in study.measured} >= {"chosen"}
    for level in taken:
        parts = level.name.split("+")
        assert len(parts) > 1
        combined = next(entry for entry in study.measured if entry.level == level)
        changed = {entry.level.name: entry.scene for entry in study.measured}
        for part in parts:
            if part.startswith("section"):
                together, alone = combined.scene, changed[part]
                assert together is not None
                assert alone is not None
                assert together.rods[0].mesh.section_elements == alone.rods[0].mesh.section_elements


def test_scene_that_fails_has_no_table(tmp_path):
    write_run(
        RunDirectory(tmp_path / "runs" / "base"),
        load_scene("overhand", ["output.fields=false", PULL]),
        state="failed",
        reason="lost",
    )
    with pytest.raises(NotConverged, match="the scene itself fails: lost"):
        run_convergence("overhand", [PULL], tmp_path, budget=None, names=["slice"], tell=lambda text: None)


@pytest.mark.parametrize("kind", [InputError, NotConverged, KnotLost])
def test_failure_of_the_scene_itself_keeps_its_exit_code(tmp_path, kind):
    run = RunDirectory(tmp_path / "runs" / "base")
    write_run(run, load_scene("overhand", ["output.fields=false", PULL]), state="failed")
    run.write_status("failed", reason="lost", exit_code=kind.exit_code)
    with pytest.raises(kind, match="the scene itself fails: lost"):
        run_convergence("overhand", [PULL], tmp_path, budget=None, names=["slice"], tell=lambda text: None)


def test_folder_of_another_window_is_refused(folder):
    with pytest.raises(InputError, match="another scene"):
        run_convergence("overhand", [], folder, budget=None, names=["slice"], tell=lambda text: None)
