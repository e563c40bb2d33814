"""Curves, frames and sections for the tests of the mapping, written apart from the package's own."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

CENTRELINES = Path(__file__).parents[2] / "meshes" / "centrelines"


def equal_chords(name: str, edges: int) -> np.ndarray:
    """Vertices (edges + 1, 3) with chords of 1 mm on a shipped curve."""
    rows = [line for line in (CENTRELINES / f"{name}.csv").read_text().splitlines() if not line.startswith("#")]
    knots = np.array([row.split(",") for row in rows[1:]], dtype=float)
    chords = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
    spline = CubicSpline(chords, knots, bc_type="natural")
    parameter = np.linspace(0.0, chords[-1], edges + 1)
    for _ in range(40):
        points = spline(parameter)
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        parameter = np.interp(np.linspace(0.0, along[-1], edges + 1), along, parameter)
        parameter[[0, -1]] = 0.0, chords[-1]
    points = spline(parameter)
    return points * edges / np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


@pytest.fixture(scope="session")
def knot() -> Callable[[str, int], np.ndarray]:
    return equal_chords


@pytest.fixture(scope="session")
def bowline() -> np.ndarray:
    return equal_chords("bowline", 600)


@pytest.fixture(scope="session")
def overhand() -> np.ndarray:
    return equal_chords("overhand", 120)


@pytest.fixture
def rotation() -> np.ndarray:
    q, r = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))
