import re
import subprocess
import sys

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.plot.plots import plot_comparison, plot_force, plot_stretch, plot_tension

S = np.linspace(0, 1, 101)
TENSION = {"s_over_L": S, "tension_N": 0.4 * (1 - S), "core_N": 0.3 * (1 - S), "bulk_N": 0.1 * (1 - S)}


def texts(path) -> str:
    return path.read_text()


def test_force_is_drawn_in_radii_and_millimetres(tmp_path):
    rows = [{"displacement_mm": 3.0 * i, "force_N": 0.1 * i**2} for i in range(12)]
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    plot_force({"mu 0.30": rows, "mu 0.37": columns}, tmp_path / "force.svg", radius=3.0, title="bowline")
    svg = texts(tmp_path / "force.svg")
    for text in ("mu 0.30", "mu 0.37", "bowline", "displacement", "(mm)", "(N)"):
        assert text in svg
    ticks = [float(text) for text in re.findall(r">(\d+)</text>", svg)]
    assert ticks.count(10.0) >= 1
    assert max(ticks) == 30.0


def test_rows_and_columns_give_the_same_picture(tmp_path):
    rows = [{"displacement_mm": float(i), "force_N": float(i)} for i in range(5)]
    plot_force({"": rows}, tmp_path / "a.png", radius=3.0)
    plot_force({"": {"displacement_mm": range(5), "force_N": range(5)}}, tmp_path / "b.png", radius=3.0)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    plot_force({"": {"displacement_mm": range(5), "force_N": range(1, 6)}}, tmp_path / "c.png", radius=3.0)
    assert (tmp_path / "a.png").read_bytes() != (tmp_path / "c.png").read_bytes()


def test_tension_shows_both_integrations_and_core_and_bulk(tmp_path):
    plot_tension({"": TENSION}, tmp_path / "one.svg", applied=0.4, levels=(0.475,), drops=((0.2, 0.5),))
    svg = texts(tmp_path / "one.svg")
    assert all(text in svg for text in ("nodal forces", "stresses", "core", "bulk", "arclength"))
    plot_tension({"fine": TENSION, "coarse": TENSION}, tmp_path / "two.svg", applied=0.4)
    svg = texts(tmp_path / "two.svg")
    assert "stresses" not in svg
    assert "fine" in svg
    assert "coarse" in svg


def test_stretch_takes_a_curve_a_time(tmp_path):
    times = np.linspace(0, 1, 7)
    stretch = 1 + 0.2 * np.outer(np.sin(np.pi * times), np.sin(9 * S))
    plot_stretch(S, stretch, times, tmp_path / "stretch.svg", threshold=0.3)
    svg = texts(tmp_path / "stretch.svg")
    assert "stretch" in svg
    assert "mapping time" in svg
    assert len({line for line in svg.split('"') if line.startswith("stroke: #") or "stroke: #" in line}) > 7
    with pytest.raises(ValueError, match="expected \\(7, 101\\)"):
        plot_stretch(S, stretch.T, times, tmp_path / "bad.svg")


def test_compared_profiles_have_a_colour_a_run_and_a_line_a_rod(tmp_path):
    force = {"displacement_mm": np.arange(5.0), "force_N": np.arange(5.0)}
    rods = {"hitch": {"s_over_L": S, "tension": 1 - S}, "bight": {"s_over_L": S, "tension": S}}
    runs = {"a": rods, "b": rods}
    plot_comparison(
        dict.fromkeys(runs, force),
        runs,
        tmp_path / "two.svg",
        radii=dict.fromkeys(runs, 3.0),
        locking=2.0,
        at=[3.0, 3.5],
    )
    svg = texts(tmp_path / "two.svg")
    assert all(
        text in svg for text in (">hitch<", ">bight<", "stroke-dasharray: 5.18,2.24", "3, 3.5", "begins to lock")
    )
    one = {run: {"hitch": tables["hitch"]} for run, tables in runs.items()}
    plot_comparison(dict.fromkeys(one, force), one, tmp_path / "one.svg", radii=dict.fromkeys(one, 3.0), step="load")
    svg = texts(tmp_path / "one.svg")
    assert "hitch" not in svg
    assert "end of load" in svg


def test_refusals_leave_no_file(tmp_path):
    with pytest.raises(InputError, match=r"found \.gif; expected \.png, \.pdf, \.svg"):
        plot_force({"": TENSION}, tmp_path / "a.gif", radius=3.0)
    with pytest.raises(InputError, match=r"^displacement_mm: no such column.*found s_over_L, tension_N"):
        plot_force({"": TENSION}, tmp_path / "a.png", radius=3.0)
    with pytest.raises(InputError, match="cannot be written"):
        plot_tension({"": TENSION}, tmp_path / "absent" / "a.png", applied=0.4)
    assert list(tmp_path.iterdir()) == []


def test_pyplot_and_its_display_are_not_touched(tmp_path):
    code = f"""
import sys
from knotfem.plot.plots import plot_force
heavy = "matplotlib" in sys.modules
plot_force({{"": {{"displacement_mm": [0, 1], "force_N": [0, 1]}}}}, {str(tmp_path / "a.png")!r}, radius=1.0)
print(heavy, "matplotlib.pyplot" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False False\n"
