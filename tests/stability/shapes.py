"""A ring wound about straight strands, and the samples in contact of such rods."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from knotfem.contact.report import ContactReport
from knotfem.stability.crossings import Crossing
from knotfem.stability.unit import Line

D = 6.0


def line(points: np.ndarray) -> Line:
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return Line(points, np.concatenate([[0.0], np.cumsum(lengths)]))


def ring(turns: float, radius: float = D, pitch: float = D) -> Line:
    """About the z axis, with straight ends of 60 mm along its tangents."""
    angle = np.linspace(0.0, 2.0 * np.pi * turns, 200)
    arc = np.stack([radius * np.cos(angle), radius * np.sin(angle), pitch * angle / (2.0 * np.pi)], axis=1)
    ends = [arc[i] - arc[j] for i, j in ((0, 1), (-1, -2))]
    along = np.linspace(60.0, 2.0, 30)[:, None]
    before, after = (p + along * e / np.linalg.norm(e) for p, e in zip((arc[0], arc[-1]), ends, strict=True))
    return line(np.concatenate([before, arc, after[::-1]]))


def straight(x: float = 0.0) -> Line:
    """Along z at y = 0."""
    z = np.linspace(-60.0, 60.0, 61)
    return line(np.stack([np.full_like(z, x), 0.0 * z, z], axis=1))


def place_on(found: Line, point: Sequence[float]) -> float:
    """Arclength of the vertex nearest to a point."""
    return float(found.arclengths[np.linalg.norm(found.points - np.asarray(point), axis=1).argmin()])


def wound(turns: float, count: int) -> tuple[list[Line], list[Crossing]]:
    """A ring, rod 0, about a straight strand, rod 1, which touch at `count` places."""
    lines = [ring(turns), straight()]
    crossings = []
    for angle in np.linspace(0.0, 2.0 * np.pi * turns, count):
        at = [D * np.cos(angle), D * np.sin(angle), D * angle / (2.0 * np.pi)]
        places = place_on(lines[0], at), place_on(lines[1], [0.0, 0.0, at[2]])
        crossings.append(Crossing((0, 1), places, (0.0, 0.0), 1.0, 1.0))
    return lines, crossings


def report(samples: Sequence[tuple[int, float, int, float]], force: float = 1.0) -> ContactReport:
    """Of samples (rod, arclength, other, its arclength)."""
    rod, s, other, t = (np.array(column) for column in zip(*samples, strict=True))
    n = rod.size
    full = np.full(n, force)
    return ContactReport(rod, s, other, t, np.zeros(n), np.zeros((n, 3)), full, 0.3 * full, np.ones(n, dtype=bool))
