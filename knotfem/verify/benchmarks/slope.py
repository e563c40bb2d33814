"""A block on a slope: a short rod lying along a cylinder so wide that it is a plane.

Contact is looked for on eight lines of samples only: the rod is an octagonal prism, which rests on two of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from knotfem.contact.friction import Friction
from knotfem.contact.law import Penalty
from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.rigid import Cylinder
from knotfem.contact.tube_obstacle_friction import TubeObstacleFriction
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance
from knotfem.solver.schemes import BackwardEuler
from knotfem.solver.stepping.integrator import AcceptedStep
from knotfem.solver.system import System
from knotfem.solver.term import TimeStep
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.gravity import Gravity
from knotfem.terms.inertia import Inertia
from knotfem.verify.benchmarks.rods import accepted_steps, at_rest, cross_sections, make_rod, surfaces
from knotfem.verify.case import Case, Quantity

G = 9810.0
MU = 0.3
STICK = 0.1
STEP = 2e-3
LEVEL = 0.06
"""Time during which the plane is level, so that the block comes to rest on it [s]."""


class Tilting(Gravity):
    """Weight across the plane; between the times `LEVEL` and twice `LEVEL` it turns until it has a part along it."""

    def __init__(self, mass: np.ndarray, angle: float) -> None:
        super().__init__(mass, np.zeros(3))
        self.angle = angle

    def begin(self, step: TimeStep) -> None:
        angle = self.angle * min(max(step.end / LEVEL - 1.0, 0.0), 1.0)
        self.acceleration = G * np.array([-np.cos(angle), 0.0, np.sin(angle)])


def block(angle: float, steps: int) -> tuple[Iterator[AcceptedStep], ObstacleContact, np.ndarray]:
    """Accepted steps of the block, its contact with the plane, and the mass of each node."""
    rod = make_rod(18.0, 6, section=4)
    radius, eighth = 1e5, np.pi / 8.0
    c, s = np.cos(eighth), np.sin(eighth)
    x = rod.mesh.nodes @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    surface, samples = surfaces([rod], 3.0)
    plane = Cylinder(np.array([-3.0 * c - radius, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), radius)
    contact = ObstacleContact(surface, samples, Penalty(11.4, 0.2), plane)
    terms = [*rod.terms, Inertia(rod.mass), Tilting(rod.mass, angle), contact]
    terms.append(Friction(contact, TubeObstacleFriction(STICK), np.array([MU])))
    system = System(terms, Unknowns(len(rod.mesh.nodes)), make_solver("superlu"), BackwardEuler())
    newton = Newton(ForceTolerance(1e-9, 1e-8), Armijo(whole_below=10.0), largest_move=10.0)
    times, sections = [STEP * steps], cross_sections(rod)
    accepted = accepted_steps(system, at_rest(x), sections, times, first=STEP, largest=STEP, move=100.0, newton=newton)
    return accepted, contact, rod.mass


def slides(tangent: float) -> list[Quantity]:
    """Above the angle of friction it slips down with g (sin - mu cos)."""
    angle = np.arctan(tangent)
    steps, contact, mass = block(angle, 120)
    weights = mass / mass.sum()
    speeds = np.array([(step.state.time, weights @ step.state.v[:, 2]) for step in steps])[-30:]
    found = float(np.polyfit(speeds[:, 0], speeds[:, 1], 1)[0])
    return [
        Quantity("acceleration [mm/s^2]", found, float(G * (np.sin(angle) - MU * np.cos(angle))), 0.01),
        Quantity("normal force [N]", float(contact.touch.force.sum()), float(G * np.cos(angle) * mass.sum()), 0.001),
    ]


def holds(count: int) -> list[Quantity]:
    """At 0.9 of the tangent of the angle of friction it moves by the elastic slip and then rests."""
    elastic = STICK * (1.0 - np.sqrt(1.0 - 0.9))
    steps, _, mass = block(np.arctan(0.9 * MU), count)
    weights = mass / mass.sum()
    places = np.array([weights @ step.state.x[:, 2] for step in steps]) - 9.0
    drift = float(np.abs(places[100:] - places[100]).max())
    return [
        Quantity("elastic slip [mm]", float(places[-1]), float(elastic), 0.1),
        Quantity("drift [mm]", drift, float(0.1 * elastic), kind="at most", condition=f"{count} steps"),
    ]


_MESH = "hex8-reduced, 6 x 4, backward Euler 2 ms"

CASES = [
    *(
        Case(
            "slope",
            partial(slides, ratio * MU),
            f"block on a slope, tan = {ratio:g} mu",
            "g (sin - mu cos)",
            _MESH,
            f"slips-{ratio:g}",
        )
        for ratio in (1.02, 1.5)
    ),
    Case("slope", partial(holds, 300), "block on a slope, tan = 0.9 mu", "a tenth of the slip", _MESH, "holds"),
    Case(
        "slope",
        partial(holds, 10_000),
        "block on a slope, tan = 0.9 mu, 10^4 steps",
        "a tenth of the slip",
        _MESH,
        "holds-10000",
        slow=True,
    ),
]
