"""The file of a study: what is refused, and how; axes, names of points."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from knotfem.errors import InputError, SeveralErrors
from knotfem.study.sweep.axes import points_of
from knotfem.study.sweep.study_file import read_study, study_text

FRICTION = {"key": "contact.friction", "values": [0.1, 0.2]}


def study(**changed: Any) -> dict[str, Any]:
    return {"scene": "overhand", "axes": [FRICTION], **changed}


def axis(**values: Any) -> list[Any]:
    points = points_of(read_study(study(axes=[{"key": "contact.friction", **values}])))
    return [point.values["contact.friction"] for point in points]


def test_every_combination_is_a_point_named_by_its_values() -> None:
    zipped = {"rods.0.length": ["400 mm", "500 mm"], "rods.0.mesh.element_length": ["2 mm", "2.5 mm"]}
    points = points_of(read_study(study(axes=[FRICTION, {"zip": zipped}])))
    assert [point.name for point in points] == [
        "friction=0.1_length=400mm_element_length=2mm", "friction=0.1_length=500mm_element_length=2.5mm",
        "friction=0.2_length=400mm_element_length=2mm", "friction=0.2_length=500mm_element_length=2.5mm",
    ]  # fmt: skip
    assert points[1].values == {
        "contact.friction": 0.1, "rods.0.length": "500 mm", "rods.0.mesh.element_length": "2.5 mm",
    }  # fmt: skip
    assert [point.name for point in points_of(read_study({"scene": "overhand"}))] == ["base"]


def test_names_tell_points_apart() -> None:
    both = [{"key": f"rods.{i}.length", "values": ["400 mm"]} for i in range(2)]
    (point,) = points_of(read_study(study(axes=both)))
    assert point.name == "0.length=400mm_1.length=400mm"
    directions = [{"key": "gravity.direction", "values": [[0, 0, 1], [0, 0.0, 1]]}]
    names = [point.name for point in points_of(read_study(study(axes=directions)))]
    assert len(set(names)) == 2
    scenes = [{"key": "scene", "values": ["a/bowline.toml", "b/bowline.toml", "overhand"]}]
    names = [point.name for point in points_of(read_study({"axes": scenes}))]
    assert names[2] == "scene=overhand"
    assert len(set(names)) == 3
    (long,) = points_of(read_study(study(axes=[{"key": "rods.0.centerline", "values": ["x" * 300 + ".csv"]}])))
    assert len(long.name) <= 120


def test_ways_to_give_values() -> None:
    assert axis(linspace=[0.1, 0.4, 7]) == [0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4]
    assert axis(geomspace=[0.1, 1.6, 5]) == [0.1, 0.2, 0.4, 0.8, 1.6]
    assert axis(linspace=["40 mm", "60 mm", 3]) == ["40 mm", "50 mm", "60 mm"]
    assert axis(linspace=[0.5, 0.5, 1]) == [0.5]


def test_drawn_values_depend_on_seed_and_key_alone() -> None:
    drawn = {"low": 0.1, "high": 0.4, "count": 5, "seed": 3}
    first = axis(random=drawn)
    assert first == axis(random=drawn)
    assert first[:3] == axis(random={**drawn, "count": 3}), "more points leave those that are there"
    assert first != axis(random={**drawn, "seed": 4})
    assert all(0.1 <= value <= 0.4 for value in first)
    two = {"zip": {"contact.friction": {"random": drawn}, "obstacles.0.friction": {"random": drawn}}}
    points = points_of(read_study(study(axes=[two])))
    assert [point.values["contact.friction"] for point in points] == first
    assert all(point.values["contact.friction"] != point.values["obstacles.0.friction"] for point in points)
    logarithmic = axis(random={"low": "1 MPa", "high": "1000 MPa", "count": 200, "seed": 1, "logarithmic": True})
    assert 70 < sum(float(value.split()[0]) < 30.0 for value in logarithmic) < 130


@pytest.mark.parametrize(
    ("changed", "key", "text"),
    [
        ({"axis": []}, "axis", '"axes"'),
        ({"axes": [{"key": "contact.friction"}]}, "axes.0", "values in no or several ways"),
        ({"axes": [{**FRICTION, "linspace": [0, 1, 2]}]}, "axes.0", "values, linspace"),
        ({"axes": [{"values": [1]}]}, "axes.0.key", "missing key"),
        ({"axes": [{"key": "a", "linspace": [0.0, 1.0, 0]}]}, "axes.0.linspace.2", "greater than or equal to 1"),
        ({"axes": [{"key": "a", "linspace": ["1 mm", "2 cm", 3]}]}, "axes.0.linspace", "the same unit"),
        ({"axes": [{"key": "a", "geomspace": [0.0, 1.0, 3]}]}, "axes.0.geomspace", "the same sign"),
        ({"axes": [{"key": "a", "random": {"low": 0, "high": 1, "count": 3}}]}, "axes.0.random.seed", "missing key"),
        ({"axes": [{"zip": {"a": [1, 2], "b": [1]}}]}, "axes.0.zip", "a: 2, b: 1"),
        ({"axes": [{"key": "a", "zip": {"b": [1]}}]}, "axes.0.zip", "zip alone"),
        ({"axes": [FRICTION, FRICTION]}, "axes", "used twice"),
        ({"set": {"contact.friction": 0.3}}, "axes", "used twice"),
        ({"scene": None}, "scene", "a shipped scene or a file"),
        ({"collect": {"state": "steps"}}, "collect.state", "a column has this name"),
        ({"collect": {"f": {"table": "force", "column": "force"}}}, "collect.f.column", '"force_N"'),
        ({"collect": {"f": {"table": "forces", "column": "force_N"}}}, "collect.f.table", '"force"'),
        ({"collect": {"f": {"table": "force", "column": "force_N", "at": 60}}}, "collect.f.at", "its unit is missing"),
    ],
)
def test_what_is_wrong_is_named(changed: dict[str, Any], key: str, text: str) -> None:
    tables = {name: value for name, value in study(**changed).items() if value is not None}
    with pytest.raises(InputError) as caught:
        read_study(tables)
    assert caught.value.key == key
    assert text in str(caught.value)


def test_all_that_is_wrong_is_said_at_once(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(
        'scene = "overhand"\n[[axes]]\nkey = "a"\n[[axes]]\nkey = "b"\nlinspace = [1, 2]\n[collect]\nf = 3\n'
    )
    with pytest.raises(SeveralErrors) as caught:
        read_study(file)
    lines = str(caught.value).splitlines()
    assert len(lines) == len(caught.value.errors) == 3
    assert lines[0].startswith(f"{file}: axes.0: values in no or several ways; found none; expected one of values")
    assert f"{file}: axes.1.linspace" in lines[1]
    assert f"{file}: collect.f" in lines[2]


def test_dotted_keys_need_no_quotes(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(
        'scene = "overhand"\n[[axes]]\nzip.contact.friction = [0.1]\nzip.rods.0.length.linspace = ["4 mm", "5 mm", 1]\n'
        "[set]\ntie.path = 'direct'\nrods.0.core = 'none'\n"
    )
    found = read_study(file)
    assert found.keys == ["contact.friction", "rods.0.length"]
    assert found.set == {"tie.path": "direct", "rods.0.core": "none"}
    assert (found.name, found.folder) == ("study", str(tmp_path))


def test_overrides_are_set_for_all_points_and_no_axis() -> None:
    assert read_study(study(set={"model": "fem"}), ["model=rod", "gravity=none"]).set == {
        "model": "rod",
        "gravity": "none",
    }
    with pytest.raises(InputError, match="an axis has this key"):
        read_study(study(), ["contact.friction=0.3"])


def test_study_comes_back_from_its_text(tmp_path: Path) -> None:
    found = read_study(
        study(
            axes=[
                {"zip": {"contact.friction": {"random": {"low": 0.1, "high": 0.4, "count": 3, "seed": 3}},
                         "rods.0.core": [None, None, None]}},
                {"key": "rods.0.length", "linspace": ["400 mm", "500 mm", 3]},
            ],
            set={"gravity": None, "model": "rod"},
            collect={"f": {"table": "force", "column": "force_N", "at": "6 cm"}, "n": "steps"},
        )
    )  # fmt: skip
    text = study_text(found)
    assert tomllib.loads(text)["set"]["gravity"] == "none"
    (tmp_path / "study.toml").write_text(text)
    again = read_study(tmp_path)
    assert [point.name for point in points_of(again)] == [point.name for point in points_of(found)]
    assert again.collect == found.collect
    assert again.folder == found.folder == str(Path.cwd())
    assert study_text(again) == text
