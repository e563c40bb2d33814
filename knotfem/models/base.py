"""What a run asks of the model of a scene, be it hexahedra or reduced rods."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from knotfem.contact.report import ContactMap
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod
from knotfem.scene.steps import Step
from knotfem.solver.stepping.integrator import Progress
from knotfem.solver.term import Motion, Term
from knotfem.tie import CentrelinePath, make_path

if TYPE_CHECKING:
    from knotfem.energy.account import Account
    from knotfem.models.centreline import Centreline
    from knotfem.models.solid.assembly import StepSystem
    from knotfem.models.solid.mapping import Increment

Row = dict[str, float | str]
"""A line of a table."""


class Strand(Protocol):
    """One rod."""

    @property
    def scene(self) -> Rod:
        """What the user asked for."""
        ...

    @property
    def target(self) -> Centreline:
        """Where it lies when tied."""
        ...


@dataclass(frozen=True, eq=False)
class SeriesMesh:
    """The mesh of a time series.

    Attributes:
        reference: places of its points [mm], shape [points, 3].
        cells: points of each cell, shape [cells, 8] for hexahedra, [cells, 4] for quadrilaterals.
        point_data: arrays on points that never change.
    """

    reference: np.ndarray
    cells: np.ndarray
    point_data: dict[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Fields:
    """A state as the time series takes it.

    Attributes:
        points: places [mm], shape [points, 3].
        point_data: arrays on points.
        cell_data: arrays on cells.
    """

    points: np.ndarray
    point_data: dict[str, np.ndarray]
    cell_data: dict[str, np.ndarray]


class Simulation(ABC):
    """A model of a scene; the driver marches it and the outputs read it.

    Attributes:
        scene: what the user asked for.
        rods: in the scene's order.
        effects: those that outlive a step, in the order in which they are assembled.
        elastic: those of them that store what deforms the rods.
        absent: effects that the scene does not call for, each with why.
        sections: cross-section of each node, see `knotfem.solver.nonlinear.newton.out_of_balance`.
        dofs: unknowns.
        hexes: hexahedra.
        segments: of discrete rods.
    """

    scene: Scene
    rods: Sequence[Strand]
    effects: Sequence[Term]
    elastic: Sequence[Term]
    absent: dict[str, str]
    sections: np.ndarray
    dofs: int
    hexes: int = 0
    segments: int = 0

    def named(self, name: str) -> list:
        """All effects of a name."""
        return [effect for effect in self.effects if effect.name == name]

    @property
    def diameter(self) -> float:
        """Of the thinnest rod [mm]."""
        return self.scene.diameter

    @property
    def force_scale(self) -> float:
        """B/r^2 of the softest rod [N]."""
        return min(rod.scene.material.youngs_modulus * np.pi * rod.scene.diameter**2 / 16.0 for rod in self.rods)

    @property
    def warnings(self) -> list[str]:
        """What deserves one."""
        return [warning for rod in self.rods for warning in rod.target.warnings]

    @property
    def path_kind(self) -> str:
        """The mapping."""
        return self.scene.tie.path

    @property
    def mapping_times(self) -> list[float]:
        """Mapping times of the increments."""
        tie = self.scene.tie
        return [1.0] if self.path_kind == "direct" else [i / tie.increments for i in range(1, tie.increments + 1)]

    def paths(self) -> list[CentrelinePath]:
        """Mapping of each rod, as the scene has it."""
        tie = self.scene.tie
        direction = None if tie.optimise_direction else (0.0, 0.0, 1.0)
        return [
            make_path(
                self.path_kind, rod.target.points, direction=direction, degree=tie.degree, threshold=tie.threshold
            )
            for rod in self.rods
        ]

    def state(self, inside: bool) -> dict[str, Any]:
        """For a checkpoint: what neither effects nor account remember.

        Args:
            inside: whether a step is under way.
        """
        return {}

    def restore(self, state: dict[str, Any]) -> None:
        """From a checkpoint."""
        assert not state, "a model with a state of its own restores it"

    @abstractmethod
    def straight(self) -> Motion:
        """The motion before the mapping."""

    @abstractmethod
    def mapping(self, paths: list[CentrelinePath], linear_solver: str) -> Iterator[Increment]:
        """Carry the straight rods along their paths."""

    @abstractmethod
    def equations(
        self, step: Step, start: float, origin: np.ndarray, before: dict[str, np.ndarray], progress: Progress
    ) -> StepSystem:
        """Equations of a step.

        Args:
            step: what happens to the ends.
            start: time at which the step begins [s].
            origin: state at that time, shape [nodes, unknowns].
            before: force on each loaded end when the step begins [N], by label, shape [3].
            progress: where the march sets out, later than `start` where the step is resumed.
        """

    @abstractmethod
    def account(self) -> Account:
        """A new account."""

    @abstractmethod
    def kinetic(self, v: np.ndarray) -> float:
        """Kinetic energy [N mm] at these velocities [mm/s]."""

    @abstractmethod
    def centrelines(self, x: np.ndarray) -> list[np.ndarray]:
        """Vertices of each rod [mm], shapes [sections, 3]."""

    @abstractmethod
    def profile(self, x: np.ndarray, time: float, displacement: float) -> Iterable[Row]:
        """Rows of tension.csv: a row a section of every rod."""

    def twist(self, x: np.ndarray, time: float, displacement: float) -> Iterable[Row]:
        """Rows of twist.csv: a row a node of every discrete rod."""
        return ()

    @abstractmethod
    def contacts(self) -> ContactMap:
        """Where strands press on each other and on obstacles in the last accepted state."""

    @abstractmethod
    def series_mesh(self) -> SeriesMesh:
        """The mesh of the time series."""

    @abstractmethod
    def fields(self, x: np.ndarray) -> Fields:
        """Fields of a state."""


def make_simulation(scene: Scene, folder: Path | None = None) -> Simulation:
    """The model that a scene names.

    Args:
        scene: what the user asked for.
        folder: of the run.

    Raises:
        InputError: a centreline or a section that cannot be, or a feature that the model does not have.
    """
    if scene.model == "rod":
        from knotfem.models.rod.reduced import Reduced

        return Reduced(scene, folder)
    from knotfem.models.solid.solid import Solid

    return Solid(scene)
