"""A curve of straight segments and circular arcs beside a shipped one: a polygon whose corners are rounded.

The vertices begin on the curve, closer where it bends more, and move until the new curve is as near to it as it can be
without coming closer to itself than 1.05 d. Each corner is rounded by the largest arc that leaves its neighbours half
of the shorter side; what is left of the longer ones is straight. `meshes/centrelines/bowline_arcs.csv` was made with
20 vertices.

Run with: python benchmarks/segments_and_arcs.py [NAME] [VERTICES] [FILE.csv]
"""

from __future__ import annotations

import sys

import numpy as np
from scipy.optimize import minimize
from scipy.spatial.distance import cdist

from knotfem.geometry.clearance import strand_clearance
from knotfem.geometry.readers import read_centreline
from knotfem.shipped import centreline_path

DIAMETER = 6.0
"""Of the rod [mm]."""
LEAST_CLEARANCE, LEAST_RADIUS = 1.05 * DIAMETER, 5.5
"""Between strands and of arcs [mm]."""


def rounded(vertices: np.ndarray, points: int = 13) -> tuple[np.ndarray, np.ndarray]:
    """Points of the rounded polygon, shape [n, 3], and the radii of its arcs [mm], with so many points an arc."""
    sides = np.diff(vertices, axis=0)
    lengths = np.linalg.norm(sides, axis=1)
    along = sides / lengths[:, None]
    room = np.concatenate([lengths[:1], 0.5 * lengths[1:-1], lengths[-1:]])
    tangents = np.minimum(room[:-1], room[1:])
    cosines = np.clip(np.sum(along[:-1] * along[1:], axis=1), -1.0, 1.0)
    angles = np.arccos(cosines)
    radii = tangents / np.tan(0.5 * np.maximum(angles, 1e-9))
    parts = [vertices[:1]]
    for i, (angle, radius, tangent) in enumerate(zip(angles, radii, tangents, strict=True)):
        normal = along[i + 1] - cosines[i] * along[i]
        normal /= max(float(np.linalg.norm(normal)), 1e-12)
        a = np.linspace(0.0, angle, points)[:, None]
        begin = vertices[i + 1] - tangent * along[i]
        parts.append(begin + radius * (np.sin(a) * along[i] + (1.0 - np.cos(a)) * normal))
    return np.concatenate([*parts, vertices[-1:]]), radii


def evenly(points: np.ndarray, spacing: float) -> np.ndarray:
    """Points so far apart along a polygon, shape [n, 3]."""
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    places = np.linspace(0.0, s[-1], int(s[-1] / spacing) + 1)
    return np.column_stack([np.interp(places, s, axis) for axis in points.T])


def fitted(curve: np.ndarray, count: int) -> np.ndarray:
    """Vertices of the polygon, shape [count, 3], for points of a curve, shape [n, 3]."""
    steps = np.gradient(curve, axis=0)
    bends = np.linalg.norm(np.gradient(steps / np.linalg.norm(steps, axis=1)[:, None], axis=0), axis=1) + 0.006
    weight = np.concatenate([[0.0], np.cumsum(bends[1:])])
    first = curve[np.interp(np.linspace(0.0, weight[-1], count), weight, np.arange(len(curve))).round().astype(int)]

    def cost(unknowns: np.ndarray) -> float:
        vertices = unknowns.reshape(count, 3)
        line, radii = rounded(vertices)
        line = evenly(line, 1.5)
        off = np.mean(cdist(line, curve).min(axis=1) ** 2) + np.mean(cdist(curve[::3], line).min(axis=1) ** 2)
        i, j = np.triu_indices(len(line), int(4.0 * DIAMETER / 1.5))
        close = np.maximum(LEAST_CLEARANCE - np.linalg.norm(line[i] - line[j], axis=1), 0.0)
        tight = np.maximum(LEAST_RADIUS - radii, 0.0)
        return float(off + 20.0 * np.sum(close**2) + 0.5 * np.sum(tight**2) + 0.02 * np.mean((vertices - first) ** 2))

    found = minimize(cost, first.ravel(), method="L-BFGS-B", options={"maxiter": 60, "maxfun": 180 * count})
    return found.x.reshape(count, 3).round(1)


def main(name: str = "bowline", count: str = "20", out: str = "") -> None:
    """Fit, say how well, and write points 2 mm apart."""
    drawn = read_centreline(centreline_path(name))
    curve = drawn(np.linspace(*drawn.domain, 601))
    line, radii = rounded(fitted(curve, int(count)), 400)
    line = evenly(line, 2.0)
    print(f"{len(radii)} arcs, radii {radii.min():.1f} to {radii.max():.1f} mm, {len(line)} points")
    print(f"farthest from {name}: {cdist(curve, line).min(axis=1).max():.1f} mm")
    print(f"strands at least {strand_clearance(line, DIAMETER).distance:.1f} mm apart")
    if out:
        np.savetxt(out, line, fmt="%.3f", delimiter=",", header="x,y,z", comments="")


if __name__ == "__main__":
    main(*sys.argv[1:])
