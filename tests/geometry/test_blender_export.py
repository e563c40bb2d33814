import json
import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from knotfem.geometry.readers import read_nurbs

SCRIPT = Path(__file__).parents[2] / "docs" / "blender_export.py"


class Vector(list):
    """The little of Blender's vector that the script uses."""

    @property
    def w(self) -> float:
        return self[3]

    def to_3d(self) -> "Vector":
        return Vector(self[:3])


class Matrix:
    """A world matrix that moves by (1, 2, 3)."""

    def __matmul__(self, vector: Vector) -> Vector:
        return Vector([vector[0] + 1.0, vector[1] + 2.0, vector[2] + 3.0])


def export(monkeypatch: pytest.MonkeyPatch, path: Path, *splines: Any) -> None:
    bpy: Any = ModuleType("bpy")
    bpy.path = SimpleNamespace(abspath=lambda name: str(path / name.removeprefix("//")))
    curve_object = SimpleNamespace(name="Knot", data=SimpleNamespace(splines=splines), matrix_world=Matrix())
    bpy.context = SimpleNamespace(object=curve_object)
    monkeypatch.setitem(sys.modules, "bpy", bpy)
    runpy.run_path(str(SCRIPT))


def nurbs(**changes: Any) -> SimpleNamespace:
    points = [Vector([float(k), float(k % 2), 0.0, 1.0 + k]) for k in range(6)]
    flags = {"type": "NURBS", "order_u": 4, "use_cyclic_u": False, "use_endpoint_u": True, "use_bezier_u": False}
    return SimpleNamespace(points=[SimpleNamespace(co=co) for co in points], **(flags | changes))


def test_nurbs_goes_through(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    export(monkeypatch, tmp_path, nurbs())
    curve = read_nurbs(tmp_path / "knot.json")
    assert curve.degree == 3
    assert curve.weights.tolist() == [1, 2, 3, 4, 5, 6]
    assert curve(np.array(curve.domain)) == pytest.approx(np.array([[1, 2, 3], [6, 3, 3]]))


def test_bezier_goes_through(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    corners = [Vector([float(k), 0.0, 0.0]) for k in range(9)]
    points = [SimpleNamespace(handle_left=a, co=b, handle_right=c) for a, b, c in np.reshape(corners, (3, 3, 3))]
    export(monkeypatch, tmp_path, SimpleNamespace(type="BEZIER", bezier_points=points, use_cyclic_u=False))
    curve = read_nurbs(tmp_path / "knot.json")
    assert curve.domain == (0.0, 2.0)
    assert curve(np.array([0.0, 1.0, 2.0]))[:, 0] == pytest.approx([2.0, 5.0, 8.0])


def test_what_is_no_rod_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="2 splines, expected one"):
        export(monkeypatch, tmp_path, nurbs(), nurbs())
    with pytest.raises(ValueError, match="POLY spline"):
        export(monkeypatch, tmp_path, nurbs(type="POLY"))
    assert not (tmp_path / "knot.json").exists()


def test_example_in_the_document_can_be_read(tmp_path: Path) -> None:
    text = SCRIPT.with_name("blender.md").read_text(encoding="utf-8")
    example = text.split("```json\n")[1].split("```")[0]
    (tmp_path / "a.json").write_text(example)
    assert len(read_nurbs(tmp_path / "a.json").points) == len(json.loads(example)["points"])
