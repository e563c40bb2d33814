"""Hexahedral rods that touch: two crossing ones, and one on a cylinder or another rigid surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from specimens import Rod, make_rod, surfaces

from knotfem.contact.friction import Friction
from knotfem.contact.law import Penalty
from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.pairs import PairContact
from knotfem.contact.rigid import Cylinder, RigidSurface
from knotfem.contact.tube_friction import TubeFriction
from knotfem.contact.tube_obstacle_friction import TubeObstacleFriction
from knotfem.geometry.slices import Slices

LAW = Penalty(stiffness=11.4, ramp=0.2)
STICK = 0.1


@dataclass(eq=False)
class Crossing:
    """Two rods, the second turned and laid across the first with a small overlap."""

    rods: list[Rod]
    x: np.ndarray
    contact: PairContact
    friction: Friction

    def slip(self, distance: float = 0.03) -> None:
        """Move every anchor at random by about a distance in mm; some pairs then slide, most stick."""
        self.contact.update(self.x)
        self.friction.update(self.x)
        slices = distance / self.contact.surface.stations.longest[0]
        anchor = self.friction.view.anchor
        anchor += np.random.default_rng(3).uniform(-slices, slices, anchor.shape)


def crossed(order: tuple[int, int] = (0, 1), noise: float = 0.02, mu: float = 0.4, graded: bool = False) -> Crossing:
    """Rods of different slices and sections; `order` says which is numbered first."""
    sizes = [(_slices(20, graded), 12), (_slices(15, graded), 20)]
    placed = {}
    for number in (0, 1):
        slices, section = sizes[number]
        rod = make_rod(30.0, slices, section=section)
        x = rod.mesh.nodes - [0.0, 0.0, 15.0]
        if number == 1:
            c, s = np.cos(1.2), np.sin(1.2)
            x = x @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]).T + [5.8, 0.3, 0.7]
        placed[number] = x + noise * np.random.default_rng(number).standard_normal(x.shape)
    rods, parts, first = [], [], 0
    for number in order:
        slices, section = sizes[number]
        rods.append(make_rod(30.0, slices, section=section, first=first))
        parts.append(placed[number])
        first += len(placed[number])
    contact = PairContact(*surfaces(rods, 0.75), LAW)
    friction = Friction(contact, TubeFriction(STICK), np.full((2, 2), mu))
    return Crossing(rods, np.vstack(parts), contact, friction)


def _slices(count: int, graded: bool) -> int | Slices:
    lengths = 1.0 + 0.4 * np.sin(np.arange(count))
    return Slices(lengths * 30.0 / lengths.sum()) if graded else count


@dataclass(eq=False)
class Resting:
    """A rod pressed a little into a rigid surface."""

    rod: Rod
    x: np.ndarray
    contact: ObstacleContact
    friction: Friction

    @property
    def cylinder(self) -> Cylinder:
        assert isinstance(self.contact.obstacle, Cylinder)
        return self.contact.obstacle

    def slip(self, distance: float = 0.08) -> None:
        """Move every anchor at random by about a distance in mm."""
        self.contact.update(self.x)
        self.friction.update(self.x)
        anchor = self.friction.view.anchor
        anchor += np.random.default_rng(3).uniform(-distance, distance, anchor.shape)


def resting(turn: np.ndarray | None = None, shift: float = 0.0, on: RigidSurface | None = None) -> Resting:
    """Optionally turned and moved as a whole; on a cylinder that crosses the rod at an angle unless told otherwise."""
    Q = np.eye(3) if turn is None else turn
    rod = make_rod(24.0, 16)
    x = rod.mesh.nodes + 0.02 * np.random.default_rng(0).standard_normal(rod.mesh.nodes.shape)
    axis = np.array([0.0, np.cos(0.4), np.sin(0.4)])
    cylinder = Cylinder(Q @ np.array([12.93, 0.4, 12.0]) + shift, Q @ axis, 10.0)
    contact = ObstacleContact(*surfaces([rod], 0.75), LAW, cylinder if on is None else on)
    friction = Friction(contact, TubeObstacleFriction(STICK), np.array([0.39]), scheduled=False)
    return Resting(rod, x @ Q.T + shift, contact, friction)


@pytest.fixture
def crossing() -> Crossing:
    return crossed()


@pytest.fixture
def rest() -> Resting:
    return resting()


@pytest.fixture
def make_crossing():
    return crossed


@pytest.fixture
def make_rest():
    return resting
