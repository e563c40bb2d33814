"""What a run asks of the model of a scene, be it hexahedra or discrete rods."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from knotfem.contact.report import ContactReport
from knotfem.errors import InputError
from knotfem.models.centreline import Centreline
from knotfem.models.curve_size import Size
from knotfem.models.limits import Reach
from knotfem.models.material import Material
from knotfem.models.series import Fields, SeriesMesh
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod
from knotfem.scene.steps import Step
from knotfem.solver.constraints import Clamp, Prescribed
from knotfem.solver.nonlinear.tolerance import Sections
from knotfem.solver.state import State
from knotfem.solver.system import System
from knotfem.solver.term import Role, Term
from knotfem.tie import CentrelinePath, make_path

if TYPE_CHECKING:
    from knotfem.contact.rigid import RigidSurface  # with compiled loops, for scenes with obstacles only

Row = dict[str, float | str]
"""A line of a table."""
SIDES = ("start", "end")


@dataclass(frozen=True, eq=False)
class Increment:
    """One increment of the mapping.

    Attributes:
        mapping_time: 0 to 1.
        stretch: of every edge of every rod, shape [edges].
        iterations: of Newton's method.
        solved: whether the rods could follow; only the last increment must.
        wall: [s].
        state: that the rods are in.
        smallest_j: smallest determinant of the deformation gradient; nan where there is none.
        system: what was solved, with its clock; None where nothing was.
    """

    mapping_time: float
    stretch: np.ndarray
    iterations: int
    solved: bool
    wall: float
    state: State
    smallest_j: float
    system: System | None = None


@dataclass(frozen=True, eq=False)
class EndNodes:
    """The end of a rod.

    Attributes:
        nodes: that a force on it is distributed over, shape [n].
        weights: fraction on each, shape [n].
        outer: axis node of the end.
        inner: axis node beside it.
    """

    nodes: np.ndarray
    weights: np.ndarray
    outer: int
    inner: int


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """Motion of an end section, relative to where it lay when the step began.

    Attributes:
        translation: [mm], shape [3], as a function of time [s]; None for none.
        rotation: about the rod's tangent there [rad], right-handed in the direction of the arclength; None for none.
        oriented: whether the orientation is given too; else the end may turn freely.
    """

    translation: Callable[[float], np.ndarray] | None = None
    rotation: Callable[[float], float] | None = None
    oriented: bool = True


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations of a scene's step.

    Attributes:
        system: terms and constraints.
        supports: nodes of each held or driven end, by its label such as "rod.start".
        drives: label, nodes and unit direction of each driven or loaded end; the first is the one that is reported.
    """

    system: System
    supports: dict[str, np.ndarray]
    drives: Sequence[tuple[str, np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A rigid body.

    Attributes:
        surface: what it is.
        friction: Coulomb coefficient of the rods on it, one number or that of each rod, shape [rods].
        name: for tables.
    """

    surface: RigidSurface
    friction: float | np.ndarray = 0.0
    name: str = "obstacle"


TermMaker = Term | Callable[["Model"], Term]
"""A term of the user's own, or a function that makes it from the model, whose numbering it may need."""


@dataclass(frozen=True, eq=False)
class Additions:
    """What a user adds to a scene as objects.

    Attributes:
        terms: forces.
        obstacles: rigid bodies.
        materials: laws of the bulk of hexahedra, by the rod's name.
    """

    terms: Sequence[TermMaker] = ()
    obstacles: Sequence[Obstacle] = ()
    materials: Mapping[str, Material] = field(default_factory=dict)

    @property
    def empty(self) -> bool:
        """Whether there are none."""
        return not (self.terms or self.obstacles or self.materials)


def no_term(given: object) -> InputError:
    """The error for what was passed in place of a term."""
    found = given.__name__ if isinstance(given, type) else repr(given)
    return InputError("no term", key="terms", found=found, expected="a knotfem.Term, or a function that makes one")


def made_terms(model: Model, additions: Additions) -> list[Term]:
    """Terms of the user's own.

    Raises:
        InputError: what was passed is no term and makes none, or a name is missing.
    """
    made: list[Term] = []
    for given in additions.terms:
        term = given(model) if callable(given) else given
        if not isinstance(term, Term):
            raise no_term(term)
        if not term.name:
            raise InputError("no name", key="terms", found=type(term).__name__, expected="a name of its own")
        made.append(term)
    return made


class Model(ABC):
    """A model of a scene. It never changes; states do.

    Attributes:
        width: unknowns of a node.
        scene: what the user asked for.
        targets: where each rod lies when tied, and its slices.
        terms: of all steps, in the order in which they are assembled.
        absent: effects that the scene does not call for, each with why.
        obstacle_names: of the scene and of the user's own.
        sections: cross-sections, over which resultants are summed.
        nodes: number of nodes.
        hexes: hexahedra.
        segments: of discrete rods.
        warnings: what deserves one.
    """

    width: ClassVar[int]

    scene: Scene
    targets: Sequence[Centreline]
    terms: list[Term]
    absent: dict[str, str]
    obstacle_names: list[str]
    sections: Sections
    nodes: int
    hexes: int = 0
    segments: int = 0
    warnings: list[str]

    @property
    def rods(self) -> tuple[Rod, ...]:
        """Rods of the scene."""
        return self.scene.rods

    @property
    def dofs(self) -> int:
        """Number of unknowns."""
        return self.width * self.nodes

    @property
    def diameter(self) -> float:
        """Of the thinnest rod [mm]."""
        return self.scene.diameter

    @property
    def force_scale(self) -> float:
        """B/r^2 of the softest rod [N]."""
        return self.scene.force_scale

    @property
    def mass(self) -> float:
        """Of all rods [tonne]."""
        return sum(rod.material.density * np.pi * rod.diameter**2 / 4.0 * rod.length for rod in self.rods)

    @property
    def path_kind(self) -> str:
        """The mapping."""
        return self.scene.tie.path

    @property
    def mapping_times(self) -> list[float]:
        """Mapping times of the increments."""
        tie = self.scene.tie
        return [1.0] if self.path_kind == "direct" else [i / tie.increments for i in range(1, tie.increments + 1)]

    @property
    def slices(self) -> dict[str, dict[str, float]]:
        """Number of slices of each rod, and the shortest and the longest of them [mm], by the rod's name."""
        found = {}
        for rod, target in zip(self.rods, self.targets, strict=True):
            lengths = target.slices.lengths
            found[rod.name] = {
                "number": lengths.size,
                "shortest_mm": float(lengths.min()),
                "longest_mm": float(lengths.max()),
            }
        return found

    @property
    def curves(self) -> dict[str, Size]:
        """In which size the curve of each rod is taken, by the rod's name."""
        return {rod.name: target.size for rod, target in zip(self.rods, self.targets, strict=True)}

    def end_label(self, rod: int, side: str) -> str:
        """Name of an end, such as "rod.start"."""
        return f"{self.rods[rod].name}.{side}"

    def paths(self) -> list[CentrelinePath]:
        """Mapping of each rod, as the scene has it."""
        tie = self.scene.tie
        direction = None if tie.optimise_direction else (0.0, 0.0, 1.0)
        return [
            make_path(
                self.path_kind,
                target.points,
                direction=direction,
                degree=tie.degree,
                threshold=tie.threshold,
                slices=None if target.slices.equal else target.slices,
            )
            for target in self.targets
        ]

    def origin(self, state: State) -> State:
        """What must be known, while a step is under way, of the state that it set out from."""
        return State.of(state, {})

    def adapted(self, state: State, equations: Equations) -> State:
        """A state as the equations of a step that begins there take it."""
        return state

    def clamp_couples(self, x: np.ndarray) -> np.ndarray:
        """Couple of each clamp on its rod [N mm], shape [clamps, 3], in the state last loaded."""
        return np.zeros((0, 3))

    def twist_profile(self, x: np.ndarray, time: float, displacement: float) -> Iterable[Row]:
        """Rows of twist.csv: a row for each node of every discrete rod."""
        return ()

    def reaches(self, x: np.ndarray, penetration: float) -> Sequence[Reach]:
        """How far a state has come towards the limits of the model; nothing where it has none that are known.

        Args:
            x: unknowns, shape [nodes, width].
            penetration: deepest [mm].
        """
        return ()

    def smallest_j(self) -> float:
        """Smallest determinant of the deformation gradient in the state last assembled; 1 where there is none."""
        return 1.0

    @abstractmethod
    def describe(self) -> dict[str, str]:
        """What each effect is, with its figures, by name."""

    @abstractmethod
    def straight(self) -> State:
        """The state before the mapping."""

    @abstractmethod
    def mapping(self, paths: list[CentrelinePath], linear_solver: str) -> Iterator[Increment]:
        """Carry the straight rods along their paths."""

    @abstractmethod
    def end_nodes(self, rod: int, side: str) -> EndNodes:
        """Nodes of an end."""

    @abstractmethod
    def outward(self, rod: int, side: str, origin: State) -> np.ndarray:
        """Direction out of the rod at an end, of any length, shape [3]."""

    @abstractmethod
    def constrained(self, rod: int, side: str, motion: RigidMotion, origin: State) -> tuple[Prescribed, list[Clamp]]:
        """Constraints of an end that moves so, the step beginning at `origin`."""

    @abstractmethod
    def equations(self, step: Step, origin: State, before: dict[str, np.ndarray]) -> Equations:
        """Equations of a step.

        Args:
            step: what happens to the ends.
            origin: state at which it begins, see `origin`.
            before: force on each loaded end then [N], by label, shape [3]; none for an end that bore none.
        """

    @abstractmethod
    def axis_nodes(self, rod: int) -> np.ndarray:
        """Nodes on the centreline of a rod, shape [n]."""

    def centrelines(self, x: np.ndarray) -> list[np.ndarray]:
        """Vertices of each rod [mm], shape [n, 3] each."""
        return [x[self.axis_nodes(rod), :3] for rod in range(len(self.rods))]

    @abstractmethod
    def tension_profile(self, x: np.ndarray, time: float, displacement: float) -> Iterable[Row]:
        """Rows of tension.csv: a row for each section of every rod, in the state last loaded."""

    def contacts(self) -> ContactReport:
        """Where strands press on each other and on obstacles, in the state last assembled."""
        if not any(term.role is Role.CONTACT for term in self.terms):
            return ContactReport.empty()
        from knotfem.contact.collect import contact_report

        return contact_report(self.terms)

    @abstractmethod
    def series_mesh(self) -> SeriesMesh:
        """The mesh of the time series."""

    @abstractmethod
    def fields(self, x: np.ndarray) -> Fields:
        """Fields of the state last assembled."""
