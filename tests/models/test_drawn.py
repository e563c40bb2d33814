"""In which scale curves are taken, and what is said of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from coarse import KNOT

import knotfem as kf
from knotfem import shipped
from knotfem.errors import InputError
from knotfem.geometry.clearance import rod_clearance, strand_clearance
from knotfem.geometry.readers import read_centreline
from knotfem.geometry.resample import equal_chords
from knotfem.models.centreline import Centreline, centrelines_of
from knotfem.scene import load_scene

DRAWN = 6.0 * equal_chords(read_centreline(shipped.centreline_path("overhand")), 240).points


def write(path: Path, points: np.ndarray) -> Path:
    np.savetxt(path, points, delimiter=",", header="x,y,z", comments="")
    return path


def laid(path: Path, points: np.ndarray, **changes: object) -> Centreline:
    keys = {f"rods.0.{key.replace('__', '.')}": value for key, value in changes.items()}
    scene = load_scene("overhand", {"model": "rod", "rods.0.centerline": str(write(path, points)), **keys})
    return centrelines_of(scene)[0]


def test_the_size_of_a_file_is_told(tmp_path: Path) -> None:
    def said(factor: float) -> str:
        return " ".join(laid(tmp_path / "a.csv", factor * DRAWN).warnings)

    assert said(480.0 / 478.5) == ""
    assert "scaled by 1000.1" in said(1e-3)
    assert "the file seems to be in metres" in said(1e-3)
    assert "centimetres" in said(0.1)
    assert "scaled by 0.50" in said(2.0)
    assert "seems" not in said(2.0)


def test_a_shipped_curve_that_changes_its_loops_says_so() -> None:
    (warning,) = centrelines_of(load_scene("overhand", ["rods.0.length=560 mm"]))[0].warnings
    assert "overhand: scaled by 7.0" in warning
    assert "to the length of the rod, 560 mm: its loops are 1.167 times as large, in diameters" in warning
    assert "rods.0.scale = 6 keeps them" in warning
    kept = centrelines_of(load_scene("overhand", {"rods.0.length": "560 mm", "rods.0.scale": 6.0}))[0]
    assert not any("loops" in said for said in kept.warnings)
    assert "its ends are made longer by 40" in str(kept.size)


@pytest.mark.parametrize("name", [name for name in shipped.scene_names() if "/" not in name])
def test_shipped_scenes_and_thicker_ropes_leave_the_loops_as_they_are_drawn(name: str) -> None:
    scene = load_scene(name)
    for one in (scene, scene.with_rope(diameter="10 mm")) if scene.tie.source is None else (scene,):
        lines = centrelines_of(one)
        assert not any("loops" in said for line in lines for said in line.warnings)


def test_in_which_size_a_curve_is_taken_is_recorded(tmp_path: Path) -> None:
    size = laid(tmp_path / "a.csv", 1e-3 * DRAWN).size
    assert size.figures["mm_per_unit"] == pytest.approx(1000.1, abs=0.1)
    assert str(size).endswith("mm per unit, from the length of the rod, 480 mm")
    run = kf.tie("overhand", {**KNOT, "model": "rod"}, progress=False)
    (curve,) = run.summary["curves"].values()
    assert (curve["curve"], curve["ends_longer_mm"]) == ("overhand", 0.0)
    assert kf.check("overhand", {"model": "rod"})["curves"]["rod"].startswith("overhand: 6.0")


def in_unit(path: Path, header: str, points: np.ndarray, **changes: object) -> Centreline:
    np.savetxt(path, points, delimiter=",", header=header, comments="")
    keys = {f"rods.0.{key}": value for key, value in changes.items()}
    scene = load_scene("overhand", {"model": "rod", "rods.0.centerline": str(path), "rods.0.length": "500 mm", **keys})
    return centrelines_of(scene)[0]


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("x_mm,y_mm,z_mm", 1.0),
        ("x [mm],y [mm],z [mm]", 1.0),
        ("x (m),y (m),z (m)", 1000.0),
        ("x_cm,y_cm,z_cm", 10.0),
        ("x/in,y/in,z/in", 25.4),
        ("X_M,Y_M,Z_M", 1000.0),
        ("# x_m,y_m,z_m", 1000.0),
    ],
)
def test_a_unit_in_the_header_is_obeyed(tmp_path: Path, header: str, factor: float) -> None:
    path = tmp_path / "a.csv"
    line = in_unit(path, header, DRAWN / factor)
    assert strand_clearance(line.points, 6.0).distance == pytest.approx(strand_clearance(DRAWN, 6.0).distance, rel=1e-3)
    first = header.lstrip("# ").partition(",")[0]
    said = f'{factor:g} mm per unit, from the unit in its header ("{first}"); its ends are made longer'
    assert said in str(line.size)
    agreed = in_unit(path, header, DRAWN / factor, scale=factor)
    np.testing.assert_allclose(agreed.points, line.points)
    with pytest.raises(InputError, match=r"rods\.0\.scale: another unit than in .*a\.csv; found 3; expected .* header"):
        in_unit(path, header, DRAWN / factor, scale=3.0)


def test_a_unit_in_the_header_scales_with_the_rope(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    np.savetxt(path, DRAWN, delimiter=",", header="x_mm,y_mm,z_mm", comments="")
    keys = {"model": "rod", "rods.0.centerline": str(path), "rods.0.length": "500 mm"}
    before = load_scene("overhand", keys)
    for scene in (before, load_scene(before, {"rods.0.scale": 1.0})):
        lines = [centrelines_of(one)[0].points for one in (scene, scene.with_rope(diameter="12 mm"))]
        np.testing.assert_allclose(lines[1], 2.0 * lines[0], rtol=1e-6, atol=1e-6)


def test_units_that_differ_or_are_unknown(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r'two units in its header; found "x_mm" and "z_m"; expected one'):
        in_unit(tmp_path / "a.csv", "x_mm,y,z_m", DRAWN)
    line = in_unit(tmp_path / "a.csv", "x [px],y [px],z [px]", DRAWN)
    assert any('the unit of the column "x [px]" is not known' in said for said in line.warnings)


def test_radii_may_have_a_unit_of_their_own(tmp_path: Path) -> None:
    def said(header: str, radius: float) -> list[str]:
        rows = np.column_stack([DRAWN / 1000.0, np.full(len(DRAWN), radius)])
        line = in_unit(tmp_path / "a.csv", header, rows)
        return [warning for warning in line.warnings if "its radii" in warning]

    assert said("x_m,y_m,z_m,radius_mm", 3.0) == []
    assert "its radii make a diameter of 8 mm" in said("x_m,y_m,z_m,radius [mm]", 4.0)[0]
    assert said("x_m,y_m,z_m,radius", 0.003) == []


def test_with_a_scale_a_curve_keeps_its_size_and_its_ends_give_the_length(tmp_path: Path) -> None:
    for factor in (1.0, 1000.0):
        line = laid(tmp_path / "a.csv", DRAWN / factor, scale=factor, length="500 mm")
        assert np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum() == pytest.approx(500.0)
        closest, drawn = strand_clearance(line.points, 6.0), strand_clearance(DRAWN, 6.0)
        assert closest.distance == pytest.approx(drawn.distance, rel=1e-3)
        (warning,) = line.warnings
        assert "its ends are made longer by 10.03 mm each to the length" in warning
    with pytest.raises(InputError, match="the curve is longer than its rod"):
        laid(tmp_path / "a.csv", DRAWN, scale=1.0, length="300 mm")


def test_radii_that_contradict_the_diameter_are_told(tmp_path: Path) -> None:
    def said(radius: float) -> list[str]:
        path = tmp_path / "a.csv"
        rows = np.column_stack([DRAWN / 1000.0, np.full(len(DRAWN), radius)])
        np.savetxt(path, rows, delimiter=",", header="x,y,z,radius", comments="")
        scene = load_scene("overhand", {"model": "rod", "rods.0.centerline": str(path), "rods.0.scale": 1000.0})
        return [warning for warning in centrelines_of(scene)[0].warnings if "its radii" in warning]

    assert said(0.003) == []
    assert "its radii make a diameter of 8 mm; the rod has 6 mm" in said(0.004)[0]


def hooked(tmp_path: Path, second: float, **changes: object) -> list[Centreline]:
    """Two interlocked bights of one frame, 0.4 mm apart in chords of 2 mm; the second with leads so much longer."""
    a = np.linspace(0.0, np.pi, 41)[1:-1]
    lead = np.linspace(1.0, 0.0, 40)[:, None]
    bend = np.column_stack([10.0 * np.sin(a), 10.0 * np.cos(a), 0.0 * a])
    first = np.concatenate([[0, 10, 0] - lead * [150, 0, 0], bend, [0, -10, 0] - lead[::-1] * [150, 0, 0]])
    other = np.concatenate(
        [[0, 10, 0] - lead * [150 + second, 0, 0], bend, [0, -10, 0] - lead[::-1] * [150 + second, 0, 0]]
    )
    other = other[:, [0, 2, 1]] * [-1.0, 1.0, 1.0] + [13.5, 0.0, 0.0]
    rods = {"hitch": first, "bight": other}
    keys = {f"rods.{name}.centerline": str(write(tmp_path / f"{name}.csv", x)) for name, x in rods.items()}
    lengths = {"rods.hitch.length": "330 mm", "rods.bight.length": "330 mm"}
    return centrelines_of(load_scene("sheet-bend", {"model": "rod", **keys, **lengths, **changes}))


def test_curves_of_one_frame_keep_their_places_with_one_scale(tmp_path: Path) -> None:
    each = hooked(tmp_path, 20.0)
    assert any("each to its own length: curves drawn in one frame no longer fit" in said for said in each[1].warnings)
    for scales in ({"hitch": 1.0, "bight": 1.0}, {"hitch": 1.0, "bight": "hitch"}):
        lines = hooked(tmp_path, 20.0, **{f"rods.{rod}.scale": scale for rod, scale in scales.items()})
        assert rod_clearance(lines[0].points, lines[1].points).distance == pytest.approx(6.4, abs=0.05)
        assert not any("one frame" in said for line in lines for said in line.warnings)
    other = hooked(tmp_path, 20.0, **{"rods.bight.scale": "hitch"})
    drawn = 330.0 / (300.0 + 10.0 * np.pi)
    assert rod_clearance(other[0].points, other[1].points).distance == pytest.approx(6.4 * drawn, abs=0.1)


def test_rods_pushed_into_each_other_by_their_scales_are_refused_with_the_cure(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"the rod overlaps hitch.*; do they have one scale\?"):
        hooked(tmp_path, -60.0)


def test_a_nurbs_curve_takes_a_scale(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    points = [[0, 0, 0], [0.01, 0, 0], [0.02, 0, 0.01], [0.04, 0, 0]]
    path.write_text(f"points = {points}\norder_u = 4\nuse_endpoint_u = true\n")
    keys = {"model": "rod", "rods.0.centerline": str(path), "rods.0.scale": 1000.0, "rods.0.length": "60 mm"}
    line = centrelines_of(load_scene("cantilever", keys))[0]
    assert line.points[:, 2].max() == pytest.approx(
        1000.0 * read_centreline(path)(np.linspace(0, 1, 400))[:, 2].max(), rel=1e-3
    )
    assert np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum() == pytest.approx(60.0)


def tight(depth: float) -> np.ndarray:
    """The overhand knot scaled so that its strands overlap by a fraction of 6 mm."""
    return DRAWN * (1.0 - depth) * 6.0 / strand_clearance(DRAWN, 6.0).distance


def test_a_small_overlap_is_warned_of_a_deep_one_refused(tmp_path: Path) -> None:
    (warning,) = laid(tmp_path / "a.csv", tight(0.03), scale=1.0).warnings[:1]
    assert "strands overlap by 0.219 mm (3.7 % of the diameter) at s/L = " in warning
    with pytest.raises(InputError, match=r"overlaps itself at s/L.*expected at least the diameter, 6 mm \(5\.4 mm"):
        laid(tmp_path / "a.csv", tight(0.12), scale=1.0)


def test_measured_points_that_overlap_are_taken_smoothed_only(tmp_path: Path) -> None:
    x = tight(0.03)
    noisy = x + np.random.default_rng(3).normal(scale=0.1, size=x.shape)
    with pytest.raises(InputError, match=r"the points scatter by about 0\.1.* mm.*smoothing\.iterations"):
        laid(tmp_path / "a.csv", noisy, scale=1.0)
    rough = x + 6.0 * (noisy - x)
    with pytest.raises(InputError, match=r"turns back between points .*, or smoothing of measured ones"):
        laid(tmp_path / "a.csv", rough, scale=1.0)
    with pytest.raises(InputError, match=r"more iterations|a smoother curve \(smoothing.iterations\)"):
        laid(tmp_path / "a.csv", rough, scale=1.0, smoothing__iterations=30)
    smoothing = {"smoothing__iterations": 100, "smoothing__gamma": 0.5}
    warnings = laid(tmp_path / "a.csv", noisy, scale=1.0, **smoothing).warnings
    assert any("smoothing that keeps the size of loops moves the curve by 0.1" in said for said in warnings)
    assert any("strands overlap by" in said and "diameters apart before smoothing" in said for said in warnings)


def test_points_that_scatter_are_told_where_they_are_not_smoothed(tmp_path: Path) -> None:
    noisy = DRAWN + np.random.default_rng(3).normal(scale=0.1, size=DRAWN.shape)
    (warning,) = (said for said in laid(tmp_path / "a.csv", noisy, scale=1.0).warnings if "scatter" in said)
    assert "its points scatter by about 0.12 mm; smoothing.iterations = 1000" in warning
    assert not any("scatter" in said for said in laid(tmp_path / "a.csv", DRAWN, scale=1.0).warnings)


def test_smoothing_that_brings_strands_too_close_names_the_cure(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"overlaps itself at .* after smoothing; 0\.97 diameters.*keep_size = true"):
        laid(tmp_path / "a.csv", tight(0.03), scale=1.0, smoothing__iterations=200)


def test_a_curve_without_equal_chords_names_file_place_and_cure(tmp_path: Path) -> None:
    x = np.column_stack([np.linspace(0.0, 100.0, 41), np.zeros(41), np.zeros(41)])
    x[20:, 1] = 8.0
    x[21:, 0] -= 4.4
    with pytest.raises(InputError, match=r"a\.csv: the curve has no 8 equal chords.*near s/L = 0\.\d+; expected"):
        laid(tmp_path / "a.csv", np.vstack([x[:20], DRAWN + x[20] - DRAWN[0]]), mesh__element_length="60 mm")
