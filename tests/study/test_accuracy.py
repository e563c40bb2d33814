"""Stored settings: found by class, applied without dimension, refused where none is accurate enough."""

import json
from dataclasses import asdict, replace

import pytest

from knotfem.errors import InputError
from knotfem.scene import load_scene, scene_to_toml
from knotfem.scene.steps import Pull
from knotfem.study import accuracy, records
from knotfem.study.accuracy import accurate_overrides, parse_fraction, recommended
from knotfem.study.records import Record, Setting, store, stored, user_file
from knotfem.study.similarity import class_of

COARSE = Setting(
    "slice-x2",
    0.04,
    0.005,
    50.0,
    60.0,
    400.0,
    "fem",
    "hex8",
    12,
    2 / 3,
    0.5,
    2e-7,
    48.0,
    0.125,
    1 / 60,
    0.0002,
    0.02,
)
FINE = replace(COARSE, level="uniform-48", error=0.006, cpu_s=900.0, section_elements=48, element_length=1 / 6)
REDUCED = replace(COARSE, level="model-rod", error=0.03, cpu_s=2.0, model="rod")


def record(
    scene: str, *settings: Setting, kind: str = "knot-on-obstacle", model: str = "fem", window: float = 16.5
) -> Record:
    machine = {"processor": "Model T", "processors": 2}
    return Record(scene, model, kind, "force", window, (0.33, 0.39), settings, "limits", "1.0", "2026-01-01", machine)


BOWLINE = record("bowline", COARSE, FINE)
OTHER = ("name=other",)


@pytest.fixture(autouse=True)
def only_these(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setattr(accuracy, "stored", lambda: [BOWLINE])


@pytest.mark.parametrize(("text", "fraction"), [("2%", 0.02), (" 0.5 % ", 0.005), ("0.01", 0.01), ("1e-3", 0.001)])
def test_fractions(text, fraction):
    assert parse_fraction(text) == pytest.approx(fraction)


@pytest.mark.parametrize("text", ["2", "0%", "-1%", "two", "", "5 mm", "nan", "1e%e"])
def test_no_fractions(text):
    with pytest.raises(InputError, match="not an accuracy"):
        parse_fraction(text)


def test_classes():
    kinds = {
        "bowline": "knot-on-obstacle", "clove-hitch": "knot-on-obstacle", "capstan": "rod-on-obstacle",
        "overhand": "knot", "cantilever": "free-rod", "sheet-bend": "several-rods", "crossed-rods": "several-rods",
    }  # fmt: skip
    assert {name: class_of(load_scene(name)) for name in kinds} == kinds


def test_cheapest_within_the_target():
    scene = load_scene("bowline")
    assert recommended(scene, 0.05, [BOWLINE])[1] is COARSE
    assert recommended(scene, 0.02, [BOWLINE])[1] is FINE
    assert recommended(scene, 0.044, [BOWLINE])[1] is FINE, "the reference's uncertainty counts"


def test_own_scene_goes_before_its_class():
    scene = load_scene("bowline")
    other = record("clove-hitch", replace(COARSE, cpu_s=1.0))
    assert recommended(scene, 0.05, [other, BOWLINE])[0] is BOWLINE
    assert recommended(load_scene("clove-hitch"), 0.05, [other, BOWLINE])[0] is other


def test_of_other_scenes_the_nearest_counts_and_not_the_cheapest():
    cheap = record("short", replace(COARSE, cpu_s=1.0), window=1.0)
    scene = load_scene("bowline", OTHER)
    assert recommended(scene, 0.05, [cheap, BOWLINE])[0] is BOWLINE
    assert recommended(scene, 0.05, [BOWLINE, cheap])[0] is BOWLINE
    rubbing = replace(cheap, scene="rough", window=16.5, frictions=(1.0, 1.0))
    assert recommended(scene, 0.05, [rubbing, BOWLINE])[0] is BOWLINE


def test_model_that_the_scene_names_is_kept():
    both = record("bowline", COARSE, REDUCED)
    assert recommended(load_scene("bowline"), 0.05, [both])[1] is REDUCED
    assert recommended(load_scene("bowline", ["model=fem"]), 0.05, [both])[1] is COARSE
    assert recommended(load_scene("bowline", ['model="rod"']), 0.05, [both])[1] is REDUCED
    with pytest.raises(InputError, match=r"measured with other models only; found model fem; .*--model fem --store"):
        recommended(load_scene("bowline", ["model=fem"]), 0.05, [record("bowline", REDUCED)])


def test_limit_of_the_rod_model_says_nothing_of_hexahedra():
    light = record("bowline", replace(REDUCED, error=0.001), model="rod")
    with pytest.raises(InputError, match="measured with other models only"):
        recommended(load_scene("bowline"), 0.05, [light])
    rods = load_scene("bowline", ["model=rod"])
    assert recommended(rods, 0.02, [light, record("bowline", REDUCED)])[0] is light
    both = record("bowline", COARSE, REDUCED)
    assert recommended(rods, 0.05, [light, both])[0] is both, "an error against hexahedra promises more"


def test_finer_than_any_is_refused():
    with pytest.raises(InputError, match=r"found 1\.00%; expected 1\.10% or more \(knotfem cost bowline"):
        accurate_overrides("bowline", [], "1%")
    with pytest.raises(InputError, match=r"class knot; .*expected a scene of a class that was measured"):
        accurate_overrides("overhand", [], "5%")


def test_settings_are_applied_and_recorded():
    overrides, says = accurate_overrides("bowline", ["steps.1.displacement=30 mm"], "2%")
    scene = load_scene("bowline", overrides)
    assert (scene.rods[0].mesh.section_elements, scene.rods[0].mesh.element) == (48, "hex8")
    assert scene.rods[0].mesh.element_length == pytest.approx(1.0)
    pull = scene.steps[1]
    assert isinstance(pull, Pull)
    assert pull.displacement == 30.0
    assert scene.accuracy is not None
    assert (scene.accuracy.wanted, scene.accuracy.level, scene.accuracy.scene) == (0.02, "uniform-48", "bowline")
    assert scene.accuracy.measured == pytest.approx(0.011)
    assert says.startswith(
        "2.00% in the force: settings of uniform-48 (model fem, element hex8, "
        "section of 48 elements, slices of 0.167 d, step 0.5 d, penalty 48, tolerance 1.026e-05 N, "
        "at most 0.0002 of the load carried by drag, slip of 0.02 d in a step that settles), "
        "measured on bowline against the reference of the model fem"
    )
    assert "error 0.60% +- 0.50%, 60 s there (Model T, 2 processors) for a pull of 16.5 d" in says


def test_extrapolations_are_said():
    assert "extrapolation" not in accurate_overrides("bowline", [], "5%")[1]
    changed = [*OTHER, "contact.friction=0.1", "steps.1.displacement=30 mm"]
    assert accurate_overrides("bowline", changed, "5%")[1].endswith(
        "; an extrapolation: another scene, a pull of 16.5 d there and 5 d here, "
        "friction 0.33, 0.39 there and 0.1, 0.39 here"
    )


def test_change_of_model_is_said(monkeypatch):
    monkeypatch.setattr(accuracy, "stored", lambda: [record("bowline", COARSE, REDUCED)])
    overrides, says = accurate_overrides("bowline", [], "5%")
    assert load_scene("bowline", overrides).model == "rod"
    assert "settings of model-rod (model rod in place of fem, slices of 0.667 d, step 0.5 d, tolerance" in says
    assert "against the reference of the model fem" in says


def test_what_equilibrium_means_is_taken_from_the_measurement(monkeypatch):
    monkeypatch.setattr(accuracy, "stored", lambda: [record("bowline", replace(COARSE, rate=0.001, settling=0.25))])
    overrides, says = accurate_overrides("bowline", [], "5%")
    found = load_scene("bowline", overrides).quasi_static
    assert (found.tolerance, found.settling_slip_over_diameter) == (0.001, 0.25)
    assert "at most 0.001 of the load carried by drag, slip of 0.25 d in a step that settles" in says
    with pytest.raises(InputError, match="--accuracy decides this"):
        accurate_overrides("bowline", ["quasi_static.tolerance=0.01"], "5%")
    real = ["steps.1.rate=real", "steps.1.speed=4 mm/s"]
    assert accurate_overrides("bowline", real, "5%")[1].endswith("; an extrapolation: steps in real time")


def test_what_was_measured_without_quasi_static_steps_says_so_and_leaves_them_alone(monkeypatch):
    older = record("bowline", replace(COARSE, rate=None, settling=None))
    monkeypatch.setattr(accuracy, "stored", lambda: [older])
    overrides, says = accurate_overrides("bowline", [], "5%")
    assert "measured on bowline before there were quasi-static steps, against" in says
    assert not any(override.startswith("quasi_static") for override in overrides)


def test_scene_with_its_accuracy_is_written_and_read_as_the_same(tmp_path):
    scene = load_scene("bowline", accurate_overrides("bowline", [], "5%")[0])
    (tmp_path / "scene.toml").write_text(scene_to_toml(scene))
    assert load_scene(tmp_path / "scene.toml") == scene


def test_scaled_rod_gets_scaled_settings():
    larger = ["rods.0.diameter=12 mm", "rods.0.length=1200 mm", "obstacles.0.diameter=40 mm"]
    scene = load_scene("bowline", accurate_overrides("bowline", larger, "2%")[0])
    assert scene.rods[0].mesh.element_length == pytest.approx(2.0)
    assert scene.solver.force_tolerance == pytest.approx(2e-7 * 1.425 * 144.0)


@pytest.mark.parametrize(
    "override", ["rods.0.mesh.element_length=1 mm", "solver.move_over_diameter=0.1", "contact.stick_over_diameter=0.1"]
)
def test_override_of_what_accuracy_decides_is_refused(override):
    with pytest.raises(InputError, match="--accuracy decides this"):
        accurate_overrides("bowline", [override], "5%")


def test_run_keeps_its_settings(tmp_path):
    (tmp_path / "scene.toml").touch()
    with pytest.raises(InputError, match="a run keeps its settings"):
        accurate_overrides(str(tmp_path), [], "5%")


def test_store_replaces_the_same_scene_and_is_read_first():
    store(record("bowline", COARSE), user_file())
    store(record("capstan", COARSE), user_file())
    light = record("bowline", REDUCED, model="rod")
    assert store(light, user_file()) is None
    replaced = store(BOWLINE, user_file())
    assert replaced == record("bowline", COARSE)
    found = stored()
    assert [entry.scene for entry in found[:3]] == ["bowline", "bowline", "capstan"]
    assert found[:2] == [BOWLINE, light]


def test_store_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        store(BOWLINE, tmp_path / "file" / "kept.json")


def test_damaged_store_is_refused():
    path = user_file()
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps({"measured": [{**asdict(BOWLINE), "window": 1.0, "surprise": 2}]}))
    with pytest.raises(InputError, match="no recommendations"):
        stored()


def test_store_of_an_older_version_can_be_read():
    path = user_file()
    path.parent.mkdir(parents=True)
    older = asdict(BOWLINE)
    for setting in older["settings"]:
        setting["rung"] = setting.pop("level")
    path.write_text(json.dumps({"measured": [older]}))
    assert stored()[0] == BOWLINE


def test_scene_of_an_older_version_can_be_read(tmp_path):
    scene = load_scene("bowline", accurate_overrides("bowline", [], "5%")[0])
    text = scene_to_toml(scene)
    assert '\nlevel = "slice-x2"\n' in text
    (tmp_path / "scene.toml").write_text(text.replace('\nlevel = "', '\nrung = "'))
    assert load_scene(tmp_path / "scene.toml") == scene


def test_shipped_records_can_be_read():
    for entry in records.stored():
        assert entry.settings
        assert all(setting.bound > 0.0 for setting in entry.settings)
