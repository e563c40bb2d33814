"""Similarity of scenes: their class, and the figures in which scenes of one class differ."""

from __future__ import annotations

from knotfem.scene.model import Scene
from knotfem.scene.steps import Pull

NEAR = 2.5
"""Distance of strands, in diameters, below which a rod along this centreline is a knot."""


def class_of(scene: Scene) -> str:
    """Class of scenes that share recommendations: what touches what.

    Raises:
        InputError: a centreline along which no rod can lie.
    """
    if not scene.contact.enabled:
        return "free-rod"
    kind = "several-rods" if len(scene.rods) > 1 else "knot" if _meets_itself(scene) else "rod"
    if scene.obstacles:
        return f"{kind}-on-obstacle"
    return "free-rod" if kind == "rod" else kind


def window_of(scene: Scene) -> float:
    """Displacement of all pulls over the diameter."""
    return sum(step.displacement for step in scene.loading_steps if isinstance(step, Pull)) / scene.diameter


def frictions_of(scene: Scene) -> tuple[float, float]:
    """The largest coefficients of friction: between rods, and of a rod on an obstacle."""
    if not scene.contact.enabled:
        return 0.0, 0.0
    rods, obstacles = [rod.name for rod in scene.rods], [obstacle.name for obstacle in scene.obstacles]
    return (
        max(scene.friction_between(a, b) for a in rods for b in rods),
        max((scene.friction_between(a, b) for a in rods for b in obstacles), default=0.0),
    )


def _meets_itself(scene: Scene) -> bool:
    from knotfem.geometry.clearance import strand_clearance
    from knotfem.models.centreline import centrelines_of

    (rod,) = scene.rods
    (line,) = centrelines_of(scene)
    return strand_clearance(line.points, rod.diameter).distance < NEAR * rod.diameter
