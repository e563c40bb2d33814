"""Hexahedra with a truss core as the model of a scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from knotfem.contact.report import ContactMap
from knotfem.energy.account import Account
from knotfem.mesh.section import Section
from knotfem.models.base import Fields, Row, SeriesMesh, Simulation
from knotfem.models.contacts import solid_contacts
from knotfem.models.solid.assembly import StepSystem, build_model, step_system
from knotfem.models.solid.body import build_body
from knotfem.models.solid.fields import fields
from knotfem.models.solid.mapping import Increment, mapping
from knotfem.models.solid.profile import profile_rows
from knotfem.run.stepping import newton_settings, threads_of
from knotfem.scene.model import Scene
from knotfem.scene.steps import Step
from knotfem.solver.stepping.integrator import Progress
from knotfem.solver.term import Motion
from knotfem.tie import CentrelinePath


class Solid(Simulation):
    """The three-dimensional model; see `Simulation`."""

    def __init__(self, scene: Scene, section: Section | None = None) -> None:
        """Mesh the rods and make the effects.

        Args:
            scene: what the user asked for.
            section: of all rods, instead of the shipped one.

        Raises:
            InputError: a centreline or a section that cannot be.
        """
        self.scene, self.body = scene, build_body(scene, section)
        self.model = build_model(self.body)
        self.rods, self.effects, self.elastic = self.body.rods, self.model.effects, self.body.elastic
        self.absent, self.sections = self.model.absent, self.body.sections
        self.dofs, self.hexes = 3 * self.body.nodes, self.body.hexes

    def straight(self) -> Motion:
        return Motion.at_rest(np.zeros((self.body.nodes, 3)))

    def mapping(self, paths: list[CentrelinePath], linear_solver: str) -> Iterator[Increment]:
        settings, threads = newton_settings(self), threads_of(self.scene)
        return mapping(self.body, paths, self.mapping_times, settings, threads, linear_solver)

    def equations(
        self, step: Step, start: float, origin: np.ndarray, before: dict[str, np.ndarray], progress: Progress
    ) -> StepSystem:
        return step_system(self.model, step, start, origin, before, threads_of(self.scene))

    def account(self) -> Account:
        return Account(self)

    def kinetic(self, v: np.ndarray) -> float:
        return 0.5 * float(np.einsum("n,ni,ni->", self.body.mass, v, v)) if "inertia" not in self.absent else 0.0

    def centrelines(self, x: np.ndarray) -> list[np.ndarray]:
        return self.body.centrelines(x)

    def profile(self, x: np.ndarray, time: float, displacement: float) -> Iterable[Row]:
        return profile_rows(self.body, x, time, displacement)

    def contacts(self) -> ContactMap:
        return solid_contacts(self.model)

    def series_mesh(self) -> SeriesMesh:
        rods = self.body.rods
        number = np.concatenate([np.full(len(rod.mesh.nodes), float(i)) for i, rod in enumerate(rods)])
        return SeriesMesh(
            np.concatenate([rod.mesh.nodes for rod in rods]),
            np.concatenate([rod.mesh.cells + rod.first for rod in rods]),
            {"arclength": np.concatenate([rod.mesh.nodes[:, 2] for rod in rods]), "rod": number},
        )

    def fields(self, x: np.ndarray) -> Fields:
        return Fields(x, *fields(self.model, x))
