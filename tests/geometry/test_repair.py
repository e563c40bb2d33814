"""Points that stand twice, are exchanged or missing; curves that are closed; noise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.geometry.readers import Choice, CurveFile, read_curve
from knotfem.geometry.repair import scatter


def helix(turns: float = 2.0, count: int = 120) -> np.ndarray:
    a = np.linspace(0.0, 2.0 * np.pi * turns, count)
    return np.column_stack([10.0 * np.cos(a), 10.0 * np.sin(a), 3.0 * a])


def trefoil(count: int = 200) -> np.ndarray:
    """Closed, its first point not repeated."""
    a = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    r = 20.0 + 8.0 * np.cos(3.0 * a)
    return np.column_stack([r * np.cos(2.0 * a), r * np.sin(2.0 * a), 8.0 * np.sin(3.0 * a)])


def read(path: Path, points: np.ndarray, choice: Choice | None = None) -> CurveFile:
    file = path / "curve.csv"
    np.savetxt(file, points, delimiter=",", header="x,y,z", comments="")
    return read_curve(file, choice)


def count(found: CurveFile) -> int:
    assert found.points is not None
    return len(found.points)


def test_a_plain_curve_is_taken_as_it_is(tmp_path: Path) -> None:
    found = read(tmp_path, helix())
    assert count(found) == 120
    assert found.warnings == ()


@pytest.mark.parametrize("apart", [0.0, 1e-8])
def test_points_that_stand_twice_are_dropped_and_named(tmp_path: Path, apart: float) -> None:
    x = np.insert(helix(), [40, 80], helix()[[39, 79]] + apart, axis=0)
    found = read(tmp_path, x)
    assert found.points is not None
    assert np.array_equal(found.points, helix())
    (warning,) = found.warnings
    assert "points 40 and 41 (lines 41 and 42), points 81 and 82 (lines 82 and 83) are the same" in warning


def test_exchanged_points_are_refused(tmp_path: Path) -> None:
    x = helix()
    x[[50, 51]] = x[[51, 50]]
    with pytest.raises(InputError, match=r"turns back between points 51 and 52 \(lines 52 and 53\)"):
        read(tmp_path, x)
    (warning,) = read(tmp_path, x, Choice(smoothed=True)).warnings
    assert "turns back between points 51 and 52" in warning


def test_a_gap_where_the_curve_bends_is_refused_a_wide_chord_warned_of(tmp_path: Path) -> None:
    x = helix(4.0, 2000)
    with pytest.raises(InputError, match=r"a gap: the chord between points 500 and 501 .*is \d+ times the"):
        read(tmp_path, np.delete(x, slice(500, 800), axis=0))
    (warning,) = read(tmp_path, np.delete(x, slice(500, 513), axis=0)).warnings
    assert "points 500 and 501 (lines 501 and 502) is 14 times the median chord; a spline bridges the gap" in warning
    coarse = helix(4.0, 200)
    (warning,) = read(tmp_path, np.delete(coarse, slice(50, 59), axis=0)).warnings
    assert "points 50 and 51 (lines 51 and 52) is 9 times the median chord; a spline bridges the gap" in warning
    assert read(tmp_path, np.delete(coarse, slice(50, 52), axis=0)).warnings == ()


def test_a_straight_lead_of_few_points_is_no_gap(tmp_path: Path) -> None:
    x = helix(4.0, 2000)
    out = x[-1] - x[-2]
    assert read(tmp_path, np.vstack([x, x[-1] + 500.0 * out, x[-1] + 1000.0 * out])).warnings == ()
    (warning,) = read(tmp_path, np.vstack([x, x[-1] + 500.0 * out, x[-1] + 501.0 * out])).warnings
    assert "is 500 times the median chord; a spline bridges the gap: are points missing?" in warning


def test_a_closed_curve_is_recognised_however_it_is_written(tmp_path: Path) -> None:
    x = trefoil()
    for points in (x, np.vstack([x, x[:1]])):
        with pytest.raises(InputError, match=r"the curve is closed.*cut_at = 1"):
            read(tmp_path, points)
    (tmp_path / "closed.vect").write_text("VECT\n1 4 0\n-4\n0\n0 0 0\n1 0 0\n2 3 0.5\n3 1 0\n")
    with pytest.raises(InputError, match="the curve is closed"):
        read_curve(tmp_path / "closed.vect")
    (tmp_path / "closed.obj").write_text("v 0 0 0\nv 5 0 0\nv 5 5 0\nv 0 5 1\nl 1 2 3 4 1\n")
    with pytest.raises(InputError, match="the curve is closed"):
        read_curve(tmp_path / "closed.obj")


def test_ends_that_are_near_but_do_not_meet_leave_a_curve_open(tmp_path: Path) -> None:
    """A loop whose two leads cross near their ends, one chord apart."""
    a = np.linspace(-0.25 * np.pi, 1.25 * np.pi, 100)
    loop = np.column_stack([10.0 * np.cos(a), 10.0 * np.sin(a), 0.01 * a])
    lead = np.linspace(0.0, 1.0, 20)[:, None] * 10.0 * np.sqrt(0.5)
    leads = loop[0] - (lead + 0.3)[::-1] * [1, 1, 0], loop[-1] + (lead + 0.3) * [1, -1, 0]
    curve = np.concatenate([leads[0], loop, leads[1]])
    assert np.linalg.norm(curve[-1] - curve[0]) < 1.5 * 15.0 * np.pi / 100.0
    assert count(read(tmp_path, curve)) == len(curve)


@pytest.mark.parametrize("repeated", [False, True])
def test_a_closed_curve_is_cut_where_asked(tmp_path: Path, repeated: bool) -> None:
    x = trefoil()
    written = np.vstack([x, x[:1]]) if repeated else x
    found = read(tmp_path, written, Choice(cut_at=101, apart=0.05)).points
    assert found is not None
    length = np.linalg.norm(np.diff(x, axis=0, append=x[:1]), axis=1).sum()
    assert found[0] == pytest.approx(x[100])
    assert 0.05 * length <= np.linalg.norm(found[-1] - found[0]) < 0.08 * length
    assert 180 < len(found) < 198
    with pytest.raises(InputError, match="no such point; found 201; expected 1 to 200"):
        read(tmp_path, written, Choice(cut_at=201))
    with pytest.raises(InputError, match="only a closed curve is cut"):
        read(tmp_path, helix(), Choice(cut_at=1))


@pytest.mark.parametrize("every", [1, 2, 3])
def test_points_of_a_drawn_knot_have_no_errors_however_few_they_are(shipped, every: int) -> None:
    assert scatter(shipped("overhand")[:: 12 * every]) == 0.0


@pytest.mark.parametrize("noise", [0.05, 0.5])
def test_scatter_is_the_noise_of_points(noise: float) -> None:
    x = helix()
    assert scatter(x) < 1e-4
    assert scatter(x[:10]) == 0.0
    noisy = x + np.random.default_rng(1).normal(scale=noise, size=x.shape)
    assert scatter(noisy) == pytest.approx(noise, rel=0.4)
