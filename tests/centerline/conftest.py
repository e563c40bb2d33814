from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from knotfem.geometry.curve import read_centerline
from knotfem.geometry.resample import equal_chords

CENTRELINES = Path(__file__).parents[2] / "meshes" / "centrelines"


@cache
def _shipped(name: str) -> NDArray[np.float64]:
    return equal_chords(read_centerline(CENTRELINES / f"{name}.csv"), 600).points


@pytest.fixture(scope="session")
def shipped() -> Callable[[str], NDArray[np.float64]]:
    """A shipped centreline at 600 equal chords, in the units of its file."""
    return lambda name: _shipped(name).copy()


def _random_curve(seed: int, modes: int = 8, points: int = 201) -> NDArray[np.float64]:
    random, s = np.random.default_rng(seed), np.pi * np.linspace(0.0, 1.0, points)
    x = np.zeros((points, 3))
    for k in range(1, modes + 1):
        x += np.outer(np.cos(k * s), random.normal(size=3)) + np.outer(np.sin(k * s), random.normal(size=3))
    return x


@pytest.fixture(scope="session")
def random_curve() -> Callable[..., NDArray[np.float64]]:
    """A smooth open curve out of a few random Fourier modes, often knotted."""
    return _random_curve


@pytest.fixture(scope="session")
def rigid() -> Callable[[int], tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """A random rotation matrix and shift."""

    def motion(seed: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return Rotation.random(random_state=seed).as_matrix(), np.random.default_rng(seed).normal(size=3)

    return motion


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
