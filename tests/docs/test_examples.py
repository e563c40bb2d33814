"""The examples of the documents run as they are, without a display."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import matplotlib as mpl
import nbformat
import pytest
from matplotlib import pyplot
from nbclient import NotebookClient

import knotfem as kf

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "docs" / "examples"


@pytest.mark.parametrize(
    ("name", "pictures"),
    [
        ("ten_lines", ["force.png", "knot.png", "tension.png"]),
        pytest.param("three_knots", ["three_knots.png"], marks=pytest.mark.slow),
    ],
)
def test_scripts(name: str, pictures: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    mpl.use("agg")
    try:
        runpy.run_path(str(EXAMPLES / f"{name}.py"))
    finally:
        pyplot.close("all")
    assert sorted(path.name for path in tmp_path.iterdir()) == pictures


def test_notebook(tmp_path: Path) -> None:
    notebook = nbformat.read(EXAMPLES / "bowline.ipynb", as_version=4)
    nbformat.validate(notebook)
    NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()


def test_a_term_of_your_own(monkeypatch: pytest.MonkeyPatch) -> None:
    block = re.search(r"```python\n(.*?)```", (ROOT / "docs" / "new-term.md").read_text(encoding="utf-8"), re.DOTALL)
    assert block is not None
    short = {"rods.0.mesh.element_length": "6 mm", "steps.pull.displacement": "1 mm"}
    pull = kf.pull
    monkeypatch.setattr(kf, "pull", lambda scene, changes, **given: pull(scene, {**changes, **short}, **given))
    names: dict[str, Any] = {}
    exec(block.group(1), names)
    assert names["run"].energy["spring"].min() > 0.0


def test_theory() -> None:
    block = re.search(r"```python\n(.*?)```", (ROOT / "docs" / "theory.md").read_text(encoding="utf-8"), re.DOTALL)
    assert block is not None
    names: dict[str, Any] = {}
    exec(block.group(1), names)
    fit = names["fit"]
    assert abs(fit.alpha - kf.theory.PAPER.alpha) < 2.0 * fit.alpha_error
    assert abs(fit.beta - kf.theory.PAPER.beta) < 2.0 * fit.beta_error


def test_the_table_of_theory() -> None:
    text = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| (.*) \|$", text, re.MULTILINE)
    theory = kf.theory
    assert [float(row[0]) for row in rows] == [5.0, 6.0, 7.4, 9.1, 13.9, 25.0]
    for x, *columns in rows:
        laws = (theory.stiff_friction, theory.stiff_friction_error, theory.critical_friction)
        assert columns == [*(f"{law(float(x)):.4f}" for law in laws), theory.failure_mode(float(x))]


def test_the_ten_lines_of_the_readme_are_the_script() -> None:
    block = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert block is not None
    assert block.group(1) == (EXAMPLES / "ten_lines.py").read_text(encoding="utf-8")
