"""What runs are compared by: force curve, its end, tension profile, knot size, penetration, shape."""

from __future__ import annotations

import numpy as np

from knotfem.errors import InputError
from knotfem.results.run import Run
from knotfem.run.schedule import FIRST_MOVE_OVER_DIAMETER
from knotfem.scene.model import Scene
from knotfem.scene.steps import Pull
from knotfem.study.extrapolation import rms

LABELS = {
    "force": "force curve (L2)",
    "force_end": "force at the end",
    "tension": "tension profile (L2)",
    "knot_size": "knot size",
    "sag": "sag",
    "shape": "centreline (L2)",
    "penetration": "penetration over d",
}
"""Quantities in the order of tables; the first that a scene has is what its runs are ranked by."""
RANKED_BY = ("force", "sag", "shape")
GRID = 200

Quantities = dict[str, np.ndarray]
"""Values by name, each of shape [n]: curves on an even grid that all runs of a scene share, or one value."""


def read_quantities(run: Run) -> Quantities:
    """What a finished run came to.

    Curves are sampled evenly so that their root mean square is an L2 norm: the force against the displacement of each
    pull [N], tension [N] and centreline [mm] against arclength at the end. The knot size is the bent length of the
    rods [mm], see `bent_length`; the sag is how far the rod's far end hangs below the near one [mm], where nothing
    pulls; the penetration is the deepest one over the diameter.

    Raises:
        InputError: the run has no results.
    """
    scene = run.scene
    found = _forces(run, scene)
    rods = _profiles(run)
    places = [np.stack([rod[f"{axis}_mm"] for axis in "xyz"], axis=1) for rod in rods]
    found["tension"] = np.concatenate([_sampled(rod["s_over_L"], rod["tension_N"]) for rod in rods])
    found["shape"] = np.concatenate(
        [_sampled(rod["s_over_L"], x[:, i]) for rod, x in zip(rods, places, strict=True) for i in range(3)]
    )
    if scene.contact.enabled:
        found["knot_size"] = np.array([sum(bent_length(x) for x in places)])
        found["penetration"] = np.array([float(run.summary["max_penetration_over_d"])])
    elif scene.gravity is not None and "force" not in found:
        down = np.array(scene.gravity.direction) / np.linalg.norm(scene.gravity.direction)
        found["sag"] = np.array([float((x[-1] - x[0]) @ down) for x in places])
    return {name: found[name] for name in LABELS if name in found}


def scale_of(name: str, reference: np.ndarray) -> float:
    """What errors of a quantity are divided by.

    The reference's own root mean square; for penetrations 1, they are in diameters already; for centrelines the
    root mean square distance of their points from their mean [mm].
    """
    if name == "penetration":
        return 1.0
    if name == "shape":
        lines = reference.reshape(-1, 3, GRID)
        centred = lines - lines.mean(axis=(0, 2), keepdims=True)
        return rms(centred)
    return rms(reference)


def main_quantity(names: list[str]) -> str:
    """What runs are ranked by: the force curve where there is one, else sag or shape."""
    return next(name for name in RANKED_BY if name in names)


def bent_length(points: np.ndarray) -> float:
    """Length over which a curve is bent: (sum of turning)^2 over the sum of squared curvature.

    It is the arclength of a circular arc between straight ends, whatever its radius, and for any curve the length of
    the arc of the same total turning and the same bending energy. 0 for a straight line.

    Args:
        points: vertices [mm], shape [n, 3].
    """
    chords = np.diff(points, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    t = chords / lengths[:, None]
    angles = np.arctan2(np.linalg.norm(np.cross(t[:-1], t[1:]), axis=1), np.sum(t[:-1] * t[1:], axis=1))
    if float(np.sum(angles**2)) <= 1e-12:
        return 0.0
    return float(np.sum(angles)) ** 2 / float(np.sum(angles**2 / (0.5 * (lengths[1:] + lengths[:-1]))))


def _forces(run: Run, scene: Scene) -> Quantities:
    pulls = [step for step in scene.loading_steps if isinstance(step, Pull)]
    if not pulls:
        return {}
    table = run.table("force")
    curves = []
    for step in pulls:
        rows = table["step"] == step.name
        if not rows.any():
            raise InputError("no forces are stored of this step", file=run.path, key=step.name)
        first = FIRST_MOVE_OVER_DIAMETER * scene.diameter
        grid = np.linspace(min(first, 0.5 * step.displacement), step.displacement, GRID)
        curves.append(np.interp(grid, table["step_displacement_mm"][rows], table["force_N"][rows]))
    return {"force": np.concatenate(curves), "force_end": curves[-1][-1:]}


def _profiles(run: Run) -> list[dict[str, np.ndarray]]:
    last = run.tension()
    return [last.of(rod.name).table for rod in run.scene.rods]


def _sampled(s: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.interp(np.linspace(0.0, 1.0, GRID), s, values)
