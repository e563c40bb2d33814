"""Curves made as long as a rod by their ends alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from curve_fixtures import arc

from knotfem.errors import InputError
from knotfem.geometry.fit import fitted
from knotfem.geometry.resample import chords
from knotfem.geometry.slices import Slices, equal_slices

HALF = arc(61, np.pi, 50.0)
LENGTH = 50.0 * np.pi


@pytest.mark.parametrize("slices", [equal_slices(1.0, 100), Slices(np.linspace(0.5, 1.5, 100) / 100.0)])
@pytest.mark.parametrize("longer", [40.0, -15.0, 0.0])
def test_ends_go_on_straight_or_are_cut(slices: Slices, longer: float) -> None:
    wanted = Slices(slices.lengths * (LENGTH + longer))
    curve, added = fitted(HALF, wanted)
    assert added == pytest.approx(longer, abs=0.3)  # chords of slices are shorter than the arc
    found = chords(curve, wanted, LENGTH + longer)
    assert found.scale == pytest.approx(1.0, abs=1e-8)
    radii = np.linalg.norm(found.points, axis=1)
    on_arc = found.points[:, 1] > 1e-3 if longer > 0.0 else np.full(len(radii), True)
    assert radii[on_arc] == pytest.approx(50.0, abs=0.02)
    assert found.points[0, 1] == pytest.approx(-0.5 * longer if longer >= 0.0 else 50.0 * np.sin(0.15), abs=0.2)


def test_a_rod_much_shorter_than_its_curve_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"a\.csv: the curve is longer than its rod; found 157\.\d* mm for a rod of 100 mm"
    ):
        fitted(HALF, equal_slices(100.0, 50), file=Path("a.csv"))
