"""The picture of error against cost is drawn, also where there is little to draw."""

import pytest

from knotfem.errors import InputError
from knotfem.plot.pareto import plot_pareto


@pytest.mark.parametrize("front", [[(1.0, 0.1, 0.1), (4.0, 0.02, 0.05)], []])
def test_picture(tmp_path, front):
    out = tmp_path / "cost.png"
    series = {"slice": [(1.0, 0.1), (2.0, 0.05), (4.0, 0.02)], "step": []}
    plot_pareto(series, front, out, label="force", uncertainty=0.01, title="bowline")
    assert out.read_bytes().startswith(b"\x89PNG")


def test_unknown_format(tmp_path):
    with pytest.raises(InputError, match="picture format"):
        plot_pareto({}, [], tmp_path / "cost.gif", label="force")
