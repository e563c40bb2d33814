"""A whole cost table from runs whose errors follow a known law."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from manufactured import LAW, TRUE_BENT, TRUE_FORCE, cpu_of, error_of, write_ladders, write_run

from knotfem.errors import InputError, KnotLost, NotConverged
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.scene import load_scene
from knotfem.study import files, records, tables
from knotfem.study.ladders import SIZED, Rung
from knotfem.study.study import chosen, run_study

SINGLE = ("slice", "section", "step", "penalty", "tolerance", "sampling", "stick")
NAMES = (*SINGLE, "uniform", "element")
PULL = "steps.1.displacement=30 mm"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("cost")
    write_ladders(path, (PULL,), NAMES, failed="slice-x2")
    return path


@pytest.fixture(scope="module")
def study(folder):
    return run_study("overhand", [PULL], folder, budget=None, names=NAMES, jobs=1, tell=lambda text: None)


def test_orders_are_those_of_the_law(study):
    found = study.limits["force"]
    for ladder, (_, order) in LAW.items():
        assert found[ladder].order == pytest.approx(order, rel=1e-3), ladder
        assert found[ladder].asymptotic
    assert found["tolerance"].verdict == "no effect"


def test_reference_is_the_truth_within_what_it_says(study):
    reference = study.references["force"][0]
    assert reference.value[-1] == pytest.approx(TRUE_FORCE, rel=reference.uncertainty)
    assert reference.uncertainty < 0.02
    (added_up,) = [other for other in study.references["force"] if "added up" in other.source]
    assert added_up.value[-1] == pytest.approx(TRUE_FORCE, rel=1e-4)


def test_errors_and_costs_of_rungs(study):
    uncertainty = study.references["force"][0].uncertainty
    for entry in study.measured:
        if entry.done:
            assert study.error(entry, "force") == pytest.approx(error_of(entry.scene), abs=uncertainty), entry.rung.name
            assert entry.cpu["total"] == pytest.approx(cpu_of(entry.scene))
            assert entry.cpu["other"] == pytest.approx(0.1 * entry.cpu["total"])
    assert study.error(study.base, "penetration") == pytest.approx(0.01)
    assert study.base.quantities["knot_size"][0] == pytest.approx(TRUE_BENT, rel=0.05)
    fine = next(entry for entry in study.measured if entry.rung.name == "slice-x0.5")
    assert study.own_error(fine, "force") == pytest.approx(0.25 * LAW["slice"][0], abs=1e-4)


def test_own_error_of_an_element_is_that_of_its_mesh(study):
    of = {entry.rung.name: study.own_error(entry, "force") for entry in study.measured}
    section, slices = LAW["section"][0], LAW["slice"][0]
    assert of["base"] == pytest.approx(section + slices, abs=1e-4)
    assert of["element-hex8"] == pytest.approx(section + slices, abs=1e-4)
    assert of["element-hex8-4-x2"] == pytest.approx(3.0 * section + 4.0 * slices, rel=2e-3)


def test_failed_rung_is_in_the_table_without_an_error(study):
    failed = next(entry for entry in study.measured if entry.rung.name == "slice-x2")
    assert (failed.done, failed.outcome.reason) == (False, "strands passed through each other")
    assert np.isnan(study.error(failed, "force"))
    assert any("slice-x2 (failed)" in line for line in tables.recommendations(study))


def test_recommendation_is_the_cheapest_within_the_target(study):
    for target in (0.05, 0.02):
        cheapest = study.cheapest(target)
        if cheapest is None:
            assert all(not study.bound(entry) <= target for entry in study.measured if entry.done)
            continue
        assert study.bound(cheapest) <= target
        for entry in study.measured:
            if entry.done and study.bound(entry) <= target:
                assert entry.cpu["total"] >= cheapest.cpu["total"]
    assert study.cheapest(0.05) is not None
    assert study.cheapest(1e-6) is None


def test_luck_is_not_trusted(study):
    """A coarse rung that happens upon the reference itself is trusted with the error of the scene that refines it."""
    truth = study.references["force"][0].value
    lucky = [
        replace(entry, quantities={**entry.quantities, "force": truth}) if entry.rung.name == "section-4" else entry
        for entry in study.measured
    ]
    (coarse,) = [entry for entry in lucky if entry.rung.name == "section-4"]
    changed = replace(study, measured=lucky)
    assert changed.error(coarse, "force") == 0.0
    assert changed.trusted(coarse) >= changed.error(study.base, "force") > 0.0


def test_combination_is_trusted_no_more_than_its_element(study):
    truth = study.references["force"][0].value
    (element,) = [entry for entry in study.measured if entry.rung.name == "element-hex8-4-x2"]
    rung = replace(element.rung, name="element-hex8-4-x2+step-x0.25", ladder="chosen")
    lucky = replace(element, rung=rung, quantities={**element.quantities, "force": truth})
    changed = replace(study, measured=[*study.measured, lucky])
    assert changed.error(lucky, "force") == 0.0
    assert changed.trusted(lucky) >= changed.trusted(element) > 0.0


def test_luck_is_not_combined(study):
    """An element whose coarse mesh happens upon the limit is an option with the error of its finer mesh."""
    limit = study.own_limit("element", "force").value
    ladders = {
        **study.ladders,
        "element": [
            replace(entry, quantities={**entry.quantities, "force": limit})
            if entry.rung.name == "element-hex8-4-x2"
            else entry
            for entry in study.ladders["element"]
        ],
    }
    names = [rung.name for rung in chosen(replace(study, ladders=ladders))]
    assert not any("element-hex8-4-x2" in name for name in names)


def test_files(study, folder, tmp_path):
    record = records.record_of(study)
    files.write_study(study, tmp_path)
    table = read_table(tmp_path / "cost.csv")
    assert list(table["rung"]) == [entry.rung.name for entry in study.measured]
    assert {"force_error", "force_own_error", "contact_cpu_s", "peak_memory_mb", "pareto"} <= set(table)
    assert table["pareto"].sum() == len(study.front)
    assert [setting.rung for setting in record.settings] == [entry.rung.name for entry in study.offers]
    bounds = [setting.bound for setting in record.settings]
    assert bounds == sorted(bounds, reverse=True)
    assert all(study.cheapest(1.01 * bound) in study.offers for bound in bounds)
    assert (tmp_path / "cost.png").stat().st_size > 10_000
    assert json.loads((tmp_path / "recommendation.json").read_text())["scene"] == "overhand"


def test_ladders_without_sizes_give_no_reference(folder, tmp_path):
    study = run_study("overhand", [PULL], folder, budget=None, names=["element"], jobs=1, tell=lambda text: None)
    assert study.cheapest(0.5) is None
    assert study.front == []
    assert tables.recommendations(study)[0] == "nothing is recommended: no ladder gives a reference"
    files.write_study(study, tmp_path)
    assert not (tmp_path / "recommendation.json").exists()
    with pytest.raises(InputError, match="no reference"):
        records.record_of(study)


def test_reference_that_lacks_ladders_recommends_nothing(study, folder, tmp_path):
    files.write_study(study, tmp_path)
    part = run_study("overhand", [PULL], folder, budget=None, names=["slice"], jobs=1, tell=lambda text: None)
    assert (part.cheapest(0.5), part.front) == (None, [])
    (line, *_) = tables.recommendations(part)
    assert line == (
        "nothing is recommended: the reference lacks section, step, penalty, tolerance, sampling, stick; "
        "run these ladders too, or uniform"
    )
    with pytest.raises(InputError, match="nothing bounds the reference; found limits of slice added up; lacks"):
        records.record_of(part)
    files.write_study(part, tmp_path)
    assert not (tmp_path / "recommendation.json").exists()
    whole = run_study("overhand", [PULL], folder, budget=None, names=SINGLE, jobs=1, tell=lambda text: None)
    assert records.record_of(whole).reference == f"limits of {', '.join(l for l in SIZED if l in SINGLE)} added up"


def test_table_names_front_orders_and_sources(study):
    from rich.console import Console

    console = Console(width=400)
    with console.capture() as captured:
        console.print(*tables.tables(study), sep="\n")
    text = captured.get()
    assert re.search(r"\* +uniform-108", text)
    assert re.search(r"slice +force +asymptotic +2\.00", text)
    assert "limits of section, slice, step, penalty, tolerance, sampling, stick added up" in text
    assert "failed, strands passed through each other" in text


def test_combination_follows_from_the_ladders_and_is_run(folder, monkeypatch):
    from knotfem.study import campaign

    taken: list[Rung] = []

    def start(self, rung):
        taken.append(rung)
        write_run(self.run_of(rung), self.scene_of(rung))
        return campaign.subprocess.Popen(["true"])

    monkeypatch.setattr(campaign.Campaign, "_start", start)
    names = ["slice", "section", "step", "chosen"]
    study = run_study("overhand", [PULL], folder, budget=None, names=names, jobs=1, tell=lambda text: None)
    assert taken
    assert {entry.rung.ladder for entry in study.measured} >= {"chosen"}
    for rung in taken:
        parts = rung.name.split("+")
        assert len(parts) > 1
        combined = next(entry for entry in study.measured if entry.rung == rung)
        changed = {entry.rung.name: entry.scene for entry in study.measured}
        for part in parts:
            if part.startswith("section"):
                assert combined.scene.rods[0].mesh.section_elements == changed[part].rods[0].mesh.section_elements


def test_scene_that_fails_has_no_table(tmp_path):
    write_run(
        RunDirectory(tmp_path / "runs" / "base"),
        load_scene("overhand", ["output.fields=false", PULL]),
        state="failed",
        reason="lost",
    )
    with pytest.raises(NotConverged, match="the scene itself fails: lost"):
        run_study("overhand", [PULL], tmp_path, budget=None, names=["slice"], jobs=1, tell=lambda text: None)


@pytest.mark.parametrize("kind", [InputError, NotConverged, KnotLost])
def test_failure_of_the_scene_itself_keeps_its_exit_code(tmp_path, kind):
    run = RunDirectory(tmp_path / "runs" / "base")
    write_run(run, load_scene("overhand", ["output.fields=false", PULL]), state="failed")
    run.write_status("failed", reason="lost", exit_code=kind.exit_code)
    with pytest.raises(kind, match="the scene itself fails: lost"):
        run_study("overhand", [PULL], tmp_path, budget=None, names=["slice"], jobs=1, tell=lambda text: None)


def test_folder_of_another_window_is_refused(folder):
    with pytest.raises(InputError, match="another scene"):
        run_study("overhand", [], folder, budget=None, names=["slice"], jobs=1, tell=lambda text: None)
