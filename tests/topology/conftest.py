from collections.abc import Callable

import numpy as np
import pytest
from curve_fixtures import random_curve, rigid, shipped
from numpy.typing import NDArray

__all__ = ["closed_braid", "random_curve", "rigid", "shipped"]


def _closed_braid(word: list[int]) -> list[NDArray[np.float64]]:
    """Closed polygons round the z axis; generator +i crosses strand i over strand i + 1, right-handed."""
    width = max(map(abs, word)) + 1
    order = list(range(width))
    path: list[list[tuple[float, float, float]]] = [[] for _ in order]
    for level, generator in enumerate(word):
        i, start, middle = abs(generator) - 1, 2 * np.pi * level / len(word), 2 * np.pi * (level + 0.5) / len(word)
        for place, strand in enumerate(order):
            path[strand].append((start, place, 0.0))
            side = {i: 1.0, i + 1: -1.0}.get(place, 0.0)
            path[strand].append((middle, place + 0.5 * side, 0.4 * side * np.sign(generator)))
        order[i], order[i + 1] = order[i + 1], order[i]
    place_after = {strand: place for place, strand in enumerate(order)}
    polygons, seen = [], set()
    for first in range(width):
        points, strand = [], first
        while strand not in seen:
            seen.add(strand)
            points += path[strand]
            strand = place_after[strand]
        if points:
            angle, radius, height = np.array(points).T
            polygons.append(np.column_stack([(4 + radius) * np.cos(angle), (4 + radius) * np.sin(angle), height]))
    return polygons


@pytest.fixture(scope="session")
def closed_braid() -> Callable[[list[int]], list[NDArray[np.float64]]]:
    """The polygons of a closed braid word."""
    return _closed_braid
