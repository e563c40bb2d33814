"""Closed forms of scenes that have one, each with how far the solid may be from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.scene.model import Scene
from knotfem.scene.steps import Clamped, Driven, Free, Loaded, Pull
from knotfem.theory import tension_ratio

TURNS = {"capstan_half": np.pi}
"""Angle of contact of shipped centrelines that go round a cylinder [rad]."""
CAPSTAN_BOUND = 0.05
"""What the capstan's law leaves out: bending (T >> B/rho^2 is required) and how contact sets in."""


@dataclass(frozen=True)
class ClosedForm:
    """A value from theory.

    Attributes:
        quantity: see `quantities`.
        value: [mm] or [N].
        bound: largest relative deviation of a correct solution of this scene.
        source: for people.
    """

    quantity: str
    value: float
    bound: float
    source: str


def closed_form(scene: Scene) -> ClosedForm | None:
    """The closed form of a scene, or None."""
    return _cantilever(scene) or _capstan(scene)


def heavy_cantilever(load: float) -> float:
    """Sag over length of a horizontal inextensible cantilever under its own weight, theta'' = -load (1 - s) cos theta.

    Args:
        load: weight a length times length^3 over bending stiffness.
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import root_scalar

    def hang(tip: float) -> np.ndarray:
        """Slope, curvature and sag at the clamp for a slope at the tip, integrated from there."""
        found = solve_ivp(
            lambda u, y: [y[1], -load * u * np.cos(y[0]), np.sin(y[0])],
            (0.0, 1.0),
            [tip, 0.0, 0.0],
            rtol=1e-10,
            atol=1e-12,
        )
        return found.y[:, -1]

    tip = root_scalar(lambda slope: hang(slope)[0], bracket=(1e-9, 0.5 * np.pi), xtol=1e-12).root
    return float(hang(tip)[2])


def _cantilever(scene: Scene) -> ClosedForm | None:
    (rod, *others), last = scene.rods, scene.steps[-1] if scene.steps else None
    if others or last is None or scene.contact.enabled or scene.gravity is None or rod.centerline != "straight":
        return None
    ends = last.ends[rod.name]
    if not isinstance(ends.start, Clamped) or not isinstance(ends.end, Free) or scene.rods[0].rotation.angle != 0.0:
        return None
    down = np.array(scene.gravity.direction) / np.linalg.norm(scene.gravity.direction)
    if abs(down[0]) > 1e-12:
        return None
    weight = rod.mass_per_length * scene.gravity.acceleration
    load = weight * rod.length**3 / rod.bending_stiffness
    stretch = weight * rod.length / rod.axial_stiffness
    if scene.model == "rod":
        return ClosedForm("sag", heavy_cantilever(load) * rod.length, stretch + 1e-6, "heavy elastica")
    bound = stretch + rod.diameter / (2.0 * rod.length)
    source = "heavy elastica; the clamped end holds the section's width"
    return ClosedForm("sag", heavy_cantilever(load) * rod.length, bound, source)


def _capstan(scene: Scene) -> ClosedForm | None:
    rod, last = scene.rods[0], scene.steps[-1] if scene.steps else None
    if len(scene.rods) > 1 or len(scene.obstacles) != 1 or not isinstance(last, Pull) or not scene.contact.enabled:
        return None
    start, end = last.ends[rod.name].start, last.ends[rod.name].end
    if rod.centerline not in TURNS or not isinstance(start, Driven) or not isinstance(end, Loaded):
        return None
    obstacle = scene.obstacles[0]
    rho = 0.5 * (obstacle.diameter + rod.diameter)
    if end.force < 5.0 * rod.bending_stiffness / rho**2:
        return None
    mu = scene.friction_between(rod.name, obstacle.name)
    ratio = tension_ratio(mu, TURNS[rod.centerline], rod.radius / rho)
    return ClosedForm("force_end", end.force * ratio, CAPSTAN_BOUND, "capstan law of a thick rod")
