import time
from collections.abc import Callable

import numpy as np
import pytest
from curve_fixtures import arc, helix
from numpy.typing import NDArray

from knotfem.geometry.frames import rotation_minimising_frame
from knotfem.geometry.writhe import writhe

Array = NDArray[np.float64]


@pytest.mark.parametrize("hand", [1, -1])
def test_writhe_of_a_long_helix(hand: int) -> None:
    turns, radius, pitch = 40.0, 1.0, 4.0
    slope = np.cos(np.arctan(2 * np.pi * radius / pitch))
    expected = hand * turns * (1.0 - slope)
    assert writhe(helix(801, turns, radius, pitch, hand)) == pytest.approx(expected, rel=0.03)


def test_writhe_of_a_plane_curve_is_zero() -> None:
    assert writhe(arc(40, 5.0)) == pytest.approx(0.0, abs=1e-12)


def test_writhe_is_a_property_of_shape(
    random_curve: Callable[..., Array], rigid: Callable[[int], tuple[Array, Array]]
) -> None:
    x, (rotation, shift) = random_curve(3), rigid(1)
    value = writhe(x)
    assert writhe(3.0 * x @ rotation.T + shift) == pytest.approx(value)
    assert writhe(x * [1, 1, -1]) == pytest.approx(-value)
    assert writhe(x[::-1]) == pytest.approx(value)


def test_twist_and_writhe_of_a_closed_curve_make_a_whole_number(random_curve: Callable[..., Array]) -> None:
    s = np.linspace(0.0, 2.0 * np.pi, 2001)
    x = np.column_stack([np.cos(2 * s) * (3 + np.cos(3 * s)), np.sin(2 * s) * (3 + np.cos(3 * s)), np.sin(3 * s)])
    around = np.vstack([x[-3:-1], x, x[1:3]])
    frames = rotation_minimising_frame(around)[2:-2]
    holonomy = np.arctan2(frames[-1, 0] @ frames[0, 1], frames[-1, 0] @ frames[0, 0])
    gap = -holonomy / (2 * np.pi) + writhe(x)
    assert gap == pytest.approx(round(gap), abs=2e-3)


def test_is_fast(shipped: Callable[[str], Array]) -> None:
    x = shipped("bowline")
    writhe(x)
    begin = time.perf_counter()
    writhe(x)
    assert time.perf_counter() - begin < 0.2
