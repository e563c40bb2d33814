"""A block on a slope: a short rod lying along a cylinder so wide that it is a plane.

Touched by eight lines of samples only, the rod is an octagonal prism; it rests on two of them.
"""

import numpy as np
import pytest
from specimens import agree, make_rod, march, surfaces

from knotfem.effects.cylinder import Cylinder, CylinderFriction
from knotfem.effects.gravity import Gravity
from knotfem.effects.inertia import Inertia
from knotfem.effects.penalty import Penalty
from knotfem.solver.effect import Motion, StepStart
from knotfem.solver.linear import make_solver
from knotfem.solver.march import March
from knotfem.solver.newton import NewtonSettings
from knotfem.solver.schemes import BackwardEuler
from knotfem.solver.system import System

G = 9810.0
MU = 0.3
STEP = 2e-3
LEVEL = 0.06
"""Seconds during which the plane stays level, for the block to come to rest on it."""


class Tilting(Gravity):
    """Weight across the plane and, from `LEVEL` on within `LEVEL` more, a share of it along the plane."""

    def __init__(self, mass: np.ndarray, angle: float) -> None:
        super().__init__(mass, np.zeros(3))
        self.angle = angle

    def begin(self, start: StepStart) -> None:
        angle = self.angle * min(max(start.end / LEVEL - 1.0, 0.0), 1.0)
        self.acceleration = G * np.array([-np.cos(angle), 0.0, np.sin(angle)])


def block(angle: float, steps: int) -> tuple[March, Cylinder, np.ndarray]:
    """A march of the block, the plane, and the share of each node in the block's mass."""
    rod = make_rod(18.0, 6, section=4)
    radius, eighth = 1e5, np.pi / 8.0
    c, s = np.cos(eighth), np.sin(eighth)
    x = rod.mesh.nodes @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    samples = surfaces([rod], 3.0)[1]
    plane = Cylinder(
        samples, Penalty(11.4, 0.2, 0.1), np.array([-3.0 * c - radius, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), radius
    )
    scheme = BackwardEuler()
    effects = [*rod.effects, Inertia(rod.mass, scheme), Tilting(rod.mass, angle), plane]
    effects.append(CylinderFriction(plane, np.array([MU])))
    system = System(effects, len(rod.mesh.nodes), make_solver("superlu"), scheme)
    settings = NewtonSettings(force_tolerance=1e-9, resultant_tolerance=1e-8, largest_move=10.0, endgame_move=10.0)
    steps_of = march(
        system,
        Motion.at_rest(x),
        rod.section_index,
        [STEP * steps],
        first=STEP,
        largest=STEP,
        move=100.0,
        settings=settings,
    )
    return steps_of, plane, rod.mass / rod.mass.sum()


@pytest.mark.parametrize("tangent", [1.02 * MU, 1.5 * MU])
def test_slides_down_with_the_acceleration_of_the_textbook(tangent):
    angle = np.arctan(tangent)
    steps, plane, share = block(angle, 120)
    speeds = np.array([(step.motion.time, share @ step.motion.v[:, 2]) for step in steps])[-30:]
    found = np.polyfit(speeds[:, 0], speeds[:, 1], 1)[0]
    expected = G * (np.sin(angle) - MU * np.cos(angle))
    agree(f"block on a slope, tan = {tangent / MU:.2f} mu, acceleration [mm/s^2]", found, expected, 0.01)
    weight = G * np.cos(angle) * float(steps.system.effects[1].mass.sum())
    assert plane.force.sum() == pytest.approx(weight, rel=1e-3)


def holds(count: int) -> None:
    """At 0.9 of the angle of friction the block moves elastically by 0.068 mm and then stays."""
    elastic = 0.1 * (1.0 - np.sqrt(1.0 - 0.9))
    steps, _, share = block(np.arctan(0.9 * MU), count)
    places = np.array([share @ step.motion.x[:, 2] for step in steps]) - 9.0
    drift = float(np.abs(places[100:] - places[100]).max())
    print(f"\nblock on a slope, tan = 0.9 mu, {count} steps: moved {places[-1]:.4f} mm, then {drift:.1e} mm", end="")
    assert places[-1] > 0.9 * elastic
    assert drift < 0.1 * elastic


def test_holds_below_the_angle_of_friction():
    holds(300)


@pytest.mark.slow
def test_holds_ten_thousand_steps():
    holds(10_000)
