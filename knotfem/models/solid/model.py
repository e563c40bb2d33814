"""Hexahedra with a truss core as the model of a scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from knotfem.geometry.finite_rotation import rotate
from knotfem.geometry.vectors import unit
from knotfem.mesh.section import Section
from knotfem.models.base import Additions, EndNodes, Equations, Increment, Model, RigidMotion, Row, made_terms
from knotfem.models.conditions import conditions_of, make_scheme
from knotfem.models.described import described
from knotfem.models.effects import absent_effects, idle_effects
from knotfem.models.ends import ends_of
from knotfem.models.newton import newton_of
from knotfem.models.series import Fields, SeriesMesh
from knotfem.models.shared_terms import obstacles_of
from knotfem.models.solid.assembly import make_terms
from knotfem.models.solid.body import SolidRod, build_body
from knotfem.models.solid.fields import fields
from knotfem.models.solid.mapping import mapping
from knotfem.models.solid.profile import profile_rows
from knotfem.scene.model import Scene
from knotfem.scene.steps import Step
from knotfem.solver.constraints import Clamp, Prescribed
from knotfem.solver.state import Motion, State
from knotfem.solver.system import System
from knotfem.sparse.linear import make_solver
from knotfem.threads import threads_of
from knotfem.tie import CentrelinePath


class SolidModel(Model):
    """The three-dimensional model; see `Model`.

    Args:
        scene: what the user asked for.
        additions: of the user's own.
        section: of all rods, instead of the scene's.

    Attributes:
        body: rods.

    Raises:
        InputError: a centreline or a section that cannot be.
    """

    width = 3

    def __init__(self, scene: Scene, additions: Additions | None = None, section: Section | None = None) -> None:
        extra = Additions() if additions is None else additions
        self.scene, self.body = scene, build_body(scene, section, extra.materials)
        self.targets = [rod.target for rod in self.body.rods]
        self.nodes, self.hexes, self.sections = self.body.nodes, self.body.hexes, self.body.sections
        obstacles = obstacles_of(scene, extra.obstacles)
        self.terms = make_terms(self.body, obstacles)
        self.terms += made_terms(self, extra)
        self.absent = absent_effects(scene)
        self.obstacle_names = [obstacle.name for obstacle in obstacles]
        self.warnings = [*self.body.warnings, *idle_effects(scene)]

    def describe(self) -> dict[str, str]:
        return described(self.terms, self.scene)

    def straight(self) -> State:
        return State.of(Motion.at_rest(np.zeros((self.nodes, 3))), {})

    def mapping(self, paths: list[CentrelinePath], linear_solver: str) -> Iterator[Increment]:
        return mapping(self.body, paths, self.mapping_times, newton_of(self), threads_of(self.scene), linear_solver)

    def end_nodes(self, rod: int, side: str) -> EndNodes:
        return self.body.rods[rod].end(side)

    def outward(self, rod: int, side: str, origin: State) -> np.ndarray:
        end = self.end_nodes(rod, side)
        return origin.x[end.outer] - origin.x[end.inner]

    def constrained(self, rod: int, side: str, motion: RigidMotion, origin: State) -> tuple[Prescribed, list[Clamp]]:
        body = self.body.rods[rod]
        end = self.end_nodes(rod, side)
        nodes = end.nodes if motion.oriented else np.array([end.outer])
        x = origin.x[nodes].copy()
        translation, rotation = motion.translation, motion.rotation
        centre, axis = origin.x[end.outer].copy(), _section_normal(body, end.nodes, origin.x)

        def places(time: float) -> np.ndarray:
            here = x if rotation is None else centre + rotate(x - centre, axis, rotation(time))
            return here if translation is None else here + translation(time)

        return Prescribed(nodes, places, self.end_label(rod, side)), []

    def equations(self, step: Step, origin: State, before: dict[str, np.ndarray]) -> Equations:
        scene = self.scene
        ends = ends_of(self, step, origin, before)
        system = System(
            [*self.terms, *ends.loads],
            self.body.unknowns,
            make_solver(scene.solver.linear, threads_of(scene)),
            make_scheme(scene, step),
            ends.prescribed,
            conditions=conditions_of(scene, step, origin.time),
        )
        return Equations(system, ends.supports, ends.drives)

    def axis_nodes(self, rod: int) -> np.ndarray:
        return self.body.rods[rod].axis_nodes

    def smallest_j(self) -> float:
        return min(rod.bulk.smallest_j for rod in self.body.rods)

    def tension_profile(self, x: np.ndarray, time: float, displacement: float) -> Iterable[Row]:
        return profile_rows(self.body, x, time, displacement)

    def series_mesh(self) -> SeriesMesh:
        rods = self.body.rods
        number = np.concatenate([np.full(len(rod.mesh.nodes), float(i)) for i, rod in enumerate(rods)])
        return SeriesMesh(
            np.concatenate([rod.mesh.nodes for rod in rods]),
            np.concatenate([rod.mesh.cells + rod.first for rod in rods]),
            {"arclength": np.concatenate([rod.mesh.nodes[:, 2] for rod in rods]), "rod": number},
        )

    def fields(self, x: np.ndarray) -> Fields:
        return Fields(x, *fields(self.body, self.terms, x))


def _section_normal(rod: SolidRod, nodes: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Mean normal of an end section in the direction of the arclength, shape [3]."""
    across = x[nodes[rod.mesh.section.ring]] - x[nodes[rod.mesh.section.axis]]
    return unit(np.cross(across, np.roll(across, -1, axis=0)).sum(axis=0))
