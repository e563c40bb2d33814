"""What verbs say fits the terminal and is in words."""

import io
import re

import pytest
from click.testing import CliRunner

from knotfem.results.compare import RELATIVE, Figure
from knotfem.results.compare_text import comparison_text
from knotfem.run.progress import make_progress
from knotfem.run.step_figures import StepReport
from knotfem_cli.main import VERBS, knotfem_command
from knotfem_cli.text import facts, spoken, width_of

LONG = StepReport("pull", 0.25, 6.2, 124.75, 0.1234, 0.5, 1140, 0.034, 5)


def run(*arguments: str, columns: int | None = None) -> str:
    env = {} if columns is None else {"COLUMNS": str(columns)}
    return CliRunner().invoke(knotfem_command, list(arguments), env=env).output


@pytest.mark.parametrize("columns", [60, 80])
@pytest.mark.parametrize("verb", ["check bowline", "scenes", "doctor"])
def test_lines_fit(verb, columns):
    text = run(*verb.split(), columns=columns)
    facts_of = text[text.rindex("[steps.ends") :] if verb.startswith("check") else text
    lines = [line for line in facts_of.splitlines() if len(line.split()) > 1]
    assert len(lines) > 5
    assert max(map(len, lines)) <= columns


def test_lines_are_not_wrapped_without_a_terminal(monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    assert width_of(io.StringIO()) is None
    assert "Bowline under a dead load B/(9.1 r^2), made at friction 0.35, which is then lowered" in run("scenes")


def test_verbs_are_told_in_whole_sentences():
    listed = run("--help", columns=80).partition("Commands:")[2]
    assert len(listed.strip().splitlines()) == len(VERBS)
    assert "..." not in listed


def test_check_says_it_in_words():
    text = run("check", "bowline", columns=80)
    for strange in ("[[0.33]]", "keys of the other model", "dofs", "hexes", "1 1/s", "segments"):
        assert strange not in text
    for plain in ("mu 0.33", "keys without effect in this model", "degrees of freedom", "rod  300 of 2 mm"):
        assert plain in text


def test_names_of_files_in_words():
    assert spoken("max_penetration_over_d") == "largest penetration over d"
    assert spoken("final_force_N") == "final force [N]"
    assert spoken("steps") == "steps"


def test_facts_wrap_below_themselves():
    text = facts({"a": "word " * 12, "a much longer name than half": "value of it"}, width=40)
    assert max(map(len, text.splitlines())) <= 40
    assert re.search(r"^a {2,}word", text)
    assert "value of it" in text


@pytest.mark.parametrize("columns", [60, 80, 140])
def test_progress_fits_and_keeps_what_matters(monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    stream = io.StringIO()
    progress = make_progress(stream=stream)
    progress.step(LONG)
    (line,) = stream.getvalue().splitlines()
    assert len(line) <= columns
    assert "124.75 mm  0.1234 N" in line
    assert ("simulated" in line) == (columns >= 120)


def test_mapping_and_relaxing_show_no_zeros():
    stream = io.StringIO()
    progress = make_progress(stream=stream)
    progress.step(StepReport("mapping", 0.4, 0.4, kind="mapping", stretch=(0.93, 1.04)))
    progress.step(StepReport("mapping", 0.5, 0.5, iterations=1, kind="mapping", stretch=(0.93, 1.04), due=True))
    progress.step(StepReport("relax", contacts=3, penetration=0.01, iterations=2, kind="relax"))
    first, second, third = stream.getvalue().splitlines()
    assert first == "mapping   40.0 %  stretch 0.930 to 1.040"
    assert second.endswith("stretch 0.930 to 1.040  1 iteration")
    assert third == "relax    3 contacts  0.010 mm deep  2 iterations"


def test_comparison_of_nine_runs_fits_80_characters():
    labels = [f"runs/bowline-friction-0.{i}" for i in range(9)]
    cells = [None, *(0.1 * i for i in range(8))]
    figures = [
        Figure("force curve before locking, L2 difference", RELATIVE, cells, "L2 before"),
        *(Figure(f"some figure of a knot {i}", "mm", [float(i + j) for j in range(9)], f"fig {i}") for i in range(12)),
        Figure("pulled to", "mm", [60.0] * 9, "pulled"),
    ]
    text = comparison_text(labels, figures, 80)
    lines = text.splitlines()
    assert max(map(len, lines)) <= 80
    blocks = text.split("\n\n")
    assert sum("bowline-friction-0.7" in line for line in lines) == len(blocks) - 1
    assert all(f"fig {i} [mm]" in text for i in range(12))
    assert blocks[-1] == "the same for all: pulled to 60 mm"
    whole = comparison_text(labels[:2], [Figure(f.name, f.unit, f.cells[:2], f.short) for f in figures], 120)
    assert "force curve before locking, L2 difference" in whole
    assert len(whole.splitlines()) == len(figures) + 1


def test_large_differences_are_given_as_multiples():
    text = comparison_text(
        ["a", "b"], [Figure("force", RELATIVE, [None, 1759.9475]), Figure("x", RELATIVE, [None, 0.5])]
    )
    assert "1.76e+03 times" in text
    assert "50.00 %" in text
    assert "175994" not in text
