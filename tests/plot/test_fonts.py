"""Names of runs in any script, and with characters that mean something to matplotlib."""

import warnings
from pathlib import Path

import pytest

from knotfem.plot.fonts import fonts_for, literal
from knotfem.plot.plots import plot_force

CURVE = {"displacement_mm": range(5), "force_N": range(5)}


@pytest.mark.parametrize("suffix", ["png", "pdf", "svg"])
def test_a_name_that_no_font_has_is_one_line_instead_of_warnings(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, suffix: str
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plot_force({"run \U000f5abc": CURVE, "other": CURVE}, tmp_path / f"a.{suffix}", radius=3.0)
    assert [record.getMessage() for record in caplog.records] == [
        "no font of this machine has the characters \U000f5abc of a name; boxes stand for them"
    ]


def test_characters_are_taken_from_the_fonts_that_have_them() -> None:
    assert fonts_for(frozenset("abc δ Ж")) == (("DejaVu Sans",), frozenset()) or fonts_for(frozenset("abc"))[1] == set()
    families, missing = fonts_for(frozenset("a\u221e\u2a0c\U0001d538"))
    assert not missing
    assert families[0] in ("sans-serif", "DejaVu Sans")


def test_dollars_and_underscores_are_shown(tmp_path: Path) -> None:
    assert literal("plain") == "plain"
    plot_force({"_hidden": CURVE, "5$ and 6$ \\frac{": CURVE}, tmp_path / "a.svg", radius=3.0)
    text = (tmp_path / "a.svg").read_text()
    assert "_hidden" in text
    assert "5$ and 6$ \\frac{" in text
