import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.geometry.points import as_points


def test_returns_the_points() -> None:
    assert np.array_equal(as_points([[0, 0, 0], [1, 2, 3]]), [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([[0, 0], [1, 1]], "wrong shape"),
        ([0, 0, 0], "wrong shape"),
        ([[0, 0, 0], [1, np.nan, 0]], "point 2 is not finite"),
        ([[0, 0, 0], [np.inf, 0, 0]], "point 2 is not finite"),
        ([[0, 0, 0]], "too few points; found 1; expected at least 2"),
        ([[0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 0]], "points 2 and 3 are the same"),
        ([[1, 1, 1], [1, 1, 1]], "points 1 and 2 are the same"),
    ],
)
def test_refuses(points: list, message: str) -> None:
    with pytest.raises(InputError, match=message):
        as_points(points)
