import json
from pathlib import Path

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.geometry.curve import NaturalSpline
from knotfem.geometry.nurbs import Nurbs
from knotfem.geometry.readers import read_centreline, read_csv, read_nurbs, unused_columns

CLAMPED = [[0, 0, 0, 1], [1, 0, 0, 1], [2, 1, 0, 0.5], [2, 2, 1, 1], [3, 2, 1, 1]]


def test_reads_csv_with_comments(tmp_path: Path) -> None:
    path = tmp_path / "knot.csv"
    path.write_text("# rod\n\nx,y,z\n0,0,0\n1, 0, 0 # second\n2,0,1e-1\n# between\n3,1,0\n")
    assert read_csv(path).tolist() == [[0, 0, 0], [1, 0, 0], [2, 0, 0.1], [3, 1, 0]]
    assert isinstance(read_centreline(path), NaturalSpline)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,0,0\n1,0,0\n", "line 1 is not the header; found 0,0,0; expected x,y,z"),
        ("x,y,z\n0,0,0\n1,0\n", "line 3 is not a point; found 1,0"),
        ("x,y,z,angle\n0,0,0,0\n1,0,0\n", "line 3 is not a point; found 1,0,0; expected 4 numbers x,y,z,angle"),
        ("x,y,z\n0,0,0\n1,0,zero\n", "line 3 is not a point"),
        ("x,y,z\n0,0,0\n1,0,0\n2,0,nan\n3,0,0\n", "point 3 is not finite"),
        ("x,y,z\n0,0,0\n1,0,0\n2,0,0\n", "too few points; found 3; expected at least 4"),
        ("x,y,z\n", "too few points; found 0"),
        ("", "too few points; found 0"),
        ("x,y,z\n0,0,0\n1,0,0\n1,0,0\n3,0,0\n", "points 2 and 3 are the same"),
    ],
)
def test_refuses_csv(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "knot.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        read_csv(path)
    assert str(path) in str(caught.value)


def test_refuses_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be read \(No such file"):
        read_centreline(tmp_path / "absent.csv")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(InputError, match="cannot be read"):
        read_centreline(tmp_path / "folder.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(InputError, match="not a text file"):
        read_centreline(tmp_path / "binary.csv")
    with pytest.raises(
        InputError, match=r"unknown kind of centreline file; found \.stl; expected \.csv, \.json or \.toml"
    ):
        read_centreline(tmp_path / "knot.stl")


def test_json_and_toml_hold_the_same_curve(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(json.dumps({"points": CLAMPED, "order_u": 4, "use_endpoint_u": True}))
    (tmp_path / "a.toml").write_text(f"points = {CLAMPED}\ndegree = 3\nknots = [0, 0, 0, 0, 1, 2, 2, 2, 2]\n")
    a, b = read_centreline(tmp_path / "a.json"), read_centreline(tmp_path / "a.toml")
    assert isinstance(a, Nurbs)
    t = np.linspace(*a.domain, 20)
    assert b(t) == pytest.approx(a(t))
    assert a(t)[[0, -1]] == pytest.approx(np.array(CLAMPED)[[0, -1], :3])


def test_weight_may_be_left_out(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"points": [p[:3] for p in CLAMPED], "order_u": 3}))
    assert read_nurbs(path).weights.tolist() == [1.0] * 5


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"points": CLAMPED, "order_u": 4, "use_cyclic_u": True}, "use_cyclic_u: the curve is closed"),
        ({"points": CLAMPED, "order_u": 4, "order": 3}, "order: unknown key"),
        ({"points": CLAMPED}, "either order_u or degree"),
        ({"points": CLAMPED, "order_u": 4, "degree": 3}, "either order_u or degree"),
        ({"points": CLAMPED, "degree": 3}, "knots are missing"),
        ({"points": CLAMPED, "degree": 3, "knots": [0, 1]}, r"wrong number of knots; found 2; expected 9"),
        ({"points": CLAMPED, "degree": 1, "knots": [0, 1, 2, 1, 4, 5, 6]}, "knots do not rise"),
        ({"points": CLAMPED, "degree": 1, "knots": "uniform"}, "not a list of numbers"),
        ({"points": CLAMPED, "order_u": 6}, "too few control points; found 5; expected at least 6"),
        ({"points": CLAMPED, "order_u": 1}, "degree is too low"),
        ({"points": CLAMPED, "order_u": 3.5}, "order_u: not a whole number"),
        ({"points": CLAMPED, "order_u": 4, "use_endpoint_u": 1}, "use_endpoint_u: not a flag"),
        ({"order_u": 4}, "no control points"),
        ({"points": [[0, 0], [1, 1]], "order_u": 2}, "wrong shape"),
        ({"points": [[0, 0, 0], [1, 0]], "order_u": 2}, "no control points"),
        ({"points": [[0, 0, 0, 1], [1, 0, 0, 0]], "order_u": 2}, "weight is not positive; found 0"),
        ({"points": [[0, 0, 0, 1], [1, float("nan"), 0, 1]], "order_u": 2}, "not finite"),
        ([1, 2], "not a NURBS curve; found list"),
    ],
)
def test_refuses_nurbs(tmp_path: Path, data: object, message: str) -> None:
    path = tmp_path / "knot.json"
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=message) as caught:
        read_nurbs(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("name", ["knot.json", "knot.toml"])
def test_refuses_broken_text(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("{ points = ")
    with pytest.raises(InputError, match=r"broken (JSON|TOML)"):
        read_centreline(tmp_path / name)


def test_further_columns_are_named_and_left_out(tmp_path: Path) -> None:
    path = tmp_path / "twisted.csv"
    path.write_text("# of another program\nx,y,z,angle\n0,0,0,0.1\n1,0,0,0.2\n2,0,1e-1,0.3\n3,1,0,0.4\n")
    assert unused_columns(path) == ["angle"]
    assert read_csv(path).tolist() == [[0, 0, 0], [1, 0, 0], [2, 0, 0.1], [3, 1, 0]]
    plain = tmp_path / "plain.csv"
    plain.write_text("x,y,z\n0,0,0\n1,0,0\n2,0,0\n3,0,1\n")
    assert unused_columns(plain) == []
