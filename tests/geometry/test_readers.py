import json
from pathlib import Path

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.geometry.curve import NaturalSpline
from knotfem.geometry.nurbs import Nurbs
from knotfem.geometry.nurbs_file import read_nurbs
from knotfem.geometry.readers import Choice, CurveFile, read_centreline, read_curve

CLAMPED = [[0, 0, 0, 1], [1, 0, 0, 1], [2, 1, 0, 0.5], [2, 2, 1, 1], [3, 2, 1, 1]]


STRAIGHT = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.5], [3.0, 1.0, 0.0]]


def read(path: Path, text: str | bytes, choice: Choice | None = None) -> CurveFile:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_curve(path, choice)


def points_of(found: CurveFile) -> list[list[float]]:
    assert found.points is not None
    return found.points.tolist()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("comments.csv", "# rod\n\nx,y,z\n0,0,0\n1, 0, 0 # second\n2,0,5e-1\n# between\n3,1,0\n"),
        ("units.csv", "x [mm],y [mm],z [mm]\n0,0,0\n1,0,0\n2,0,0.5\n3,1,0\n"),
        ("suffixes.csv", "x_mm,y_mm,z_mm\n0,0,0\n1,0,0\n2,0,0.5\n3,1,0\n"),
        ("quoted.csv", '"X","Y","Z"\n0,0,0\n1,0,0\n2,0,0.5\n3,1,0\n'),
        ("paraview.csv", "Points:0,Points:1,Points:2\n0,0,0\n1,0,0\n2,0,0.5\n3,1,0\n"),
        ("turned.csv", "z,y,x\n0,0,0\n0,0,1\n0.5,0,2\n0,1,3\n"),
        ("tabs.txt", "x\ty\tz\n0\t0\t0\n1\t0\t0\n2\t0\t0.5\n3\t1\t0\n"),
        ("commas.txt", "x\ty\tz\n0\t0\t0\n1\t0\t0\n2\t0\t0,5\n3\t1\t0\n"),
        ("blanks.xyz", "0 0 0\n1  0 0\n2 0 0.5\n3 1 0\n\n"),
        ("atoms.xyz", "4\na knot\nC 0 0 0\nC 1 0 0\nC\t2 0 0.5\nH 3 1 0\n\n"),
        ("uncommented.xyz", "4\n\nC 0 0 0 0.1\nC 1 0 0 0.1\nC 2 0 0.5 0.1\nC 3 1 0 0.1\n"),
        ("plain.csv", "0,0,0\n1,0,0\n2,0,0.5\n3,1,0\n"),
        ("SPREADSHEET.CSV", "x;y;z\n0;0;0\n1;0;0\n2,0;0;0,5\n3;1;0\n"),
        ("sep.csv", "sep=;\nx;y;z\n0;0;0\n1;0;0\n2,0;0;0,5\n3;1;0\n"),
        ("latin.csv", "# L\xe4nge\nx,y,z\n0,0,0\n1,0,0\n2,0,0.5\n3,1,0\n".encode("latin-1")),
        ("vertices.obj", "o rod\nv 0 0 0\nv 1 0 0\nv 2 0 0.5 1.0\nv 3 1 0\n"),
        ("line.obj", "v 3 1 0\nv 2 0 0.5\nv 1 0 0\nv 0 0 0\nl 4 3\nl 3 2 1\n"),
        ("backwards.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0.5\nv 3 1 0\nl -4 -3 -2 -1\n"),
        ("open.vect", "VECT\n1 4 1\n4\n1\n0 0 0\n1 0 0\n2 0 0.5\n3 1 0\n1 0 0 1\n"),
    ],
)
def test_reads_points(tmp_path: Path, name: str, text: str | bytes) -> None:
    found = read(tmp_path / name, text)
    assert points_of(found) == STRAIGHT
    assert found.warnings == ()
    assert isinstance(read_centreline(tmp_path / name), NaturalSpline)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", "a,b,c\n0,0,0\n1,0,0\n", "line 1 is not the header; found a,b,c; expected x,y,z among"),
        ("a.csv", "0,0,0,1\n1,0,0,1\n", "no header; found 4 numbers in line 1; expected x,y,z, or three numbers"),
        ("a.csv", "x,y,z\n0,0,0\n1,0\n", "line 3 is not a point; found 1,0"),
        ("a.csv", "x,y,z,angle\n0,0,0,0\n1,0,0\n", "line 3 is not a point; found 1,0,0; expected 4 numbers x,y,z,a"),
        ("a.csv", "x,y,z\n0,5,1,5,2,5\n", "line 2 is not a point; found 0,5,1,5,2,5; expected 3 numbers"),
        ("a.csv", "x,y,z\n0,0,0\n1,0,zero\n", "line 3 is not a point"),
        ("a.csv", "x,y,z\n0,0,0\n1,0,0\n2,0,nan\n3,0,0\n", "point 3 is not finite"),
        ("a.csv", "x,y,z\n0,0,0\n1,0,0\n2,0,0\n", "too few points; found 3; expected at least 4"),
        ("a.csv", "x,y,z\n0,0,0\n1,0,0\n1,0,0\n3,0,0\n", "too few points; found 3"),
        ("a.csv", "x,y,z\n", "too few points; found 0"),
        ("a.csv", "", "too few points; found 0"),
        ("a.obj", "v 0 0 0\nl 1 7\n", "line 2 is broken; found l 1 7"),
        ("a.obj", "v 0 0\n", "line 1 is broken; found v 0 0"),
        ("a.vect", "VEC\n", "not a VECT file"),
        ("a.xyz", "4\n\nC 0 0 0\nC 1 0 0\n", "line 1 is cut short or broken; found 4; expected the number of atoms"),
        ("a.xyz", "2\n\n0 0 0\n1 0 0\n", "line 1 is cut short or broken; found 2; expected the number of atoms"),
        ("a.xyz", "1\n\nC 0 0 0\nend\n", "line 4 is cut short or broken; found end; expected the number of atoms"),
        ("a.vect", "VECT\n1 4 0\n4\n0\n0 0 0\n1 0 0\n", "cut short or broken"),
        ("a.vect", "VECT\n1 4 0\n5\n0\n", "the numbers of vertices differ; found 5 vertices in its curves, 4"),
    ],
)
def test_refuses_points(tmp_path: Path, name: str, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path / name, text)
    assert str(tmp_path / name) in str(caught.value)


TWO = {
    "two.csv": "x,y,z\n0,0,0\n1,0,0\n2,0,0\n3,0,0\n\n0,0,9\n1,0,9\n2,0,9\n3,0,9\n",
    "twice.csv": "x,y,z\n0,0,0\n1,0,0\n2,0,0\n3,0,0\n\nx,y,z\n0,0,9\n1,0,9\n2,0,9\n3,0,9\n",
    "two.obj": "".join(f"v {i} 0 {z}\n" for z in (0, 9) for i in range(4)) + "l 1 2 3 4\nl 5 6 7 8\n",
    "two.xyz": "".join(f"4\n{z}\n" + "".join(f"C {i} 0 {z}\n" for i in range(4)) for z in (0, 9)),
    "two.vect": "VECT\n2 8 0\n4 4\n0 0\n" + "".join(f"{i} 0 {z}\n" for z in (0, 9) for i in range(4)),
}


@pytest.mark.parametrize("name", TWO)
def test_of_several_curves_one_must_be_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"2 curves in one file.*second begins in line .*curve = 1 or 2") as caught:
        read(tmp_path / name, TWO[name])
    if name == "two.csv":
        assert "blank line 6 ends the first, the second begins in line 7" in str(caught.value)
    for number, height in ((1, 0.0), (2, 9.0)):
        assert points_of(read(tmp_path / name, TWO[name], Choice(number)))[3] == [3.0, 0.0, height]
    with pytest.raises(InputError, match="no such curve; found curve = 3"):
        read(tmp_path / name, TWO[name], Choice(3))


def test_refuses_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be read \(No such file"):
        read_centreline(tmp_path / "absent.csv")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(InputError, match="cannot be read"):
        read_centreline(tmp_path / "folder.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(InputError, match="not a text file; expected UTF-8 or Latin-1 text"):
        read_centreline(tmp_path / "binary.csv")
    with pytest.raises(
        InputError, match=r"unknown kind of centreline file; found \.stl; expected \.csv, .*\.json or \.toml"
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
    found = read(path, "# of another program\nid,x,y,z,angle\n1,0,0,0,0.1\n2,1,0,0,0.2\n3,2,0,0.5,0.3\n4,3,1,0,0.4\n")
    assert points_of(found) == STRAIGHT
    columns = [warning.partition('the column "')[2].partition('"')[0] for warning in found.warnings]
    assert columns == ["id", "angle"]
    assert "rods.N.twist" in found.warnings[0]


@pytest.mark.parametrize("choice", [Choice(curve=1), Choice(cut_at=2)])
def test_what_means_nothing_to_a_nurbs_curve_is_refused(tmp_path: Path, choice: Choice) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"points": CLAMPED, "order_u": 4, "use_endpoint_u": True}))
    with pytest.raises(InputError, match=r"(curve|cut_at): only for files of points; found \d; expected none"):
        read_curve(path, choice)


@pytest.mark.parametrize("header", ["x [kg],y [kg],z [kg]", "x_kg,y_kg,z_kg", "# x/kg,y/kg,z/kg"])
def test_an_unknown_unit_of_length_is_reported_in_every_notation(tmp_path: Path, header: str) -> None:
    found = read(tmp_path / "heavy.csv", f"{header}\n0,0,0\n1,0,0\n2,0,0.5\n3,1,0\n")
    assert (points_of(found), found.unit) == (STRAIGHT, None)
    assert "is not known; the file counts as without one" in found.warnings[0]


def test_columns_named_x_have_precedence_over_names_with_a_suffix(tmp_path: Path) -> None:
    found = read(tmp_path / "both.csv", "x_old,x,y,z\n9,0,0,0\n9,1,0,0\n9,2,0,0.5\n9,3,1,0\n")
    assert points_of(found) == STRAIGHT


def test_radii_are_read(tmp_path: Path) -> None:
    found = read(tmp_path / "thick.csv", "x,y,z,radius\n0,0,0,3\n1,0,0,3\n2,0,0.5,3\n3,1,0,4\n")
    assert (points_of(found), found.radius, found.warnings) == (STRAIGHT, 3.0, ())
