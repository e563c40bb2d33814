"""Curves for tests: shipped centrelines, arcs, helices, random curves, and rigid motions."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from knotfem.geometry.readers import read_centreline
from knotfem.geometry.resample import equal_chords

CENTRELINES = Path(__file__).parents[1] / "meshes" / "centrelines"


def arc(nodes: int, angle: float, radius: float = 3.0) -> NDArray[np.float64]:
    """Nodes of a circular arc in the plane z = 0 about the origin, from the x axis on, shape (nodes, 3)."""
    a = np.linspace(0.0, angle, nodes)
    return radius * np.column_stack([np.cos(a), np.sin(a), 0.0 * a])


def helix(nodes: int, turns: float, radius: float, pitch: float, hand: int = 1) -> NDArray[np.float64]:
    """Nodes of a helix about the z axis, right-handed for hand 1 and left-handed for -1, shape (nodes, 3)."""
    a = np.linspace(0.0, 2 * np.pi * turns, nodes)
    return np.column_stack([radius * np.cos(a), hand * radius * np.sin(a), pitch * a / (2 * np.pi)])


@cache
def _shipped(name: str) -> NDArray[np.float64]:
    return equal_chords(read_centreline(CENTRELINES / f"{name}.csv"), 600).points


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
    """A smooth open curve of a few random Fourier modes, often knotted."""
    return _random_curve


@pytest.fixture(scope="session")
def rigid() -> Callable[[int], tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """A random rotation matrix, shape (3, 3), and a random translation, shape (3,), for a seed."""

    def motion(seed: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        random = np.random.default_rng(seed)
        return Rotation.from_quat(random.normal(size=4)).as_matrix(), random.normal(size=3)

    return motion
