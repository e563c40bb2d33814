"""Discrete elastic rods as the model of a scene."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from knotfem.geometry.finite_rotation import rotate
from knotfem.models.base import (
    SIDES,
    Additions,
    EndNodes,
    Equations,
    Increment,
    Model,
    RigidMotion,
    Row,
    made_terms,
)
from knotfem.models.conditions import conditions_of, make_scheme
from knotfem.models.described import described
from knotfem.models.effects import absent_effects, idle_effects
from knotfem.models.ends import ends_of
from knotfem.models.limits import Reach
from knotfem.models.rod.build import coarse, make_rods
from knotfem.models.rod.fields import tube_fields, tube_mesh
from knotfem.models.rod.initial import EndFrame, SourceRod, initial_rods
from knotfem.models.rod.limits import reaches
from knotfem.models.rod.profile import profile_rows, twist_rows
from knotfem.models.series import Fields, SeriesMesh
from knotfem.models.shared_terms import obstacles_of, viscous_drag
from knotfem.scene.model import Scene
from knotfem.scene.steps import Step
from knotfem.solver.constraints import Clamp, Prescribed
from knotfem.solver.nonlinear.tolerance import Sections
from knotfem.solver.state import State
from knotfem.threads import threads_of
from knotfem.tie import CentrelinePath

FRAMES = "frames-1"
"""Label of the frames' history variables."""


class RodModel(Model):
    """Discrete rods; see `Model`.

    Args:
        scene: what the user asked for.
        additions: of the user's own.
        source: rods as another run has left them, from which these set out, or none.

    Attributes:
        discrete: rods and their terms.

    Raises:
        InputError: a centreline along which no rod can lie.
    """

    width = 4

    def __init__(self, scene: Scene, additions: Additions | None = None, source: Sequence[SourceRod] = ()) -> None:
        extra = Additions() if additions is None else additions
        initial = initial_rods(scene, source)
        self.scene, self.targets = scene, [rod.target for rod in initial]
        obstacles = obstacles_of(scene, extra.obstacles)
        self.discrete = make_rods(scene, initial, obstacles)
        layout = self.discrete.layout
        self.nodes, self.segments = layout.nodes, int(layout.edges.size)
        self.sections = Sections(np.arange(layout.nodes), layout.first[:-1])
        self.terms = [*self.discrete.terms]
        self._further = [*viscous_drag(scene, *self.discrete.edges), *made_terms(self, extra)]
        self.terms += self._further
        self.absent = absent_effects(scene)
        self.obstacle_names = [obstacle.name for obstacle in obstacles]
        self.warnings = [
            *(warning for rod in initial for warning in rod.target.warnings),
            *coarse(scene),
            *idle_effects(scene),
        ]
        self._tied = bool(source)
        self._initial = self._held(initial_ends=[rod.ends for rod in initial])
        self.discrete.load(self._initial)

    def _held(self, initial_ends: Sequence[tuple[EndFrame, EndFrame]]) -> State:
        """The initial state, all ends clamped as the initial configuration has them."""
        clamps = [
            _clamp(self.end_nodes(rod, side).outer, frame)
            for rod, ends in enumerate(initial_ends)
            for side, frame in zip(SIDES, ends, strict=True)
        ]
        return self.discrete.clamped(self.discrete.initial, clamps)

    @property
    def path_kind(self) -> str:
        """The mapping; there is none from a run that is tied already."""
        return "direct" if self._tied else super().path_kind

    def describe(self) -> dict[str, str]:
        said = described([term for term in self.terms if term is not self.discrete.frames], self.scene)
        if any(rod.core is not None for rod in self.rods):
            said["core"] = "in the EA of the stretch"
        return said

    def straight(self) -> State:
        return self._initial

    def mapping(self, paths: list[CentrelinePath], linear_solver: str) -> Iterator[Increment]:
        """The centrelines on their way; the rods themselves begin where these end."""
        for mapping_time in self.mapping_times:
            began = time.perf_counter()
            state = self._initial
            if mapping_time < 1.0:
                x = state.x.copy()
                x[:, :3] = np.concatenate([path.at(mapping_time) for path in paths])
                state = State(x, state.v, state.a, state.time, state.history)
            stretch = np.concatenate([path.stretch(mapping_time) for path in paths])
            yield Increment(mapping_time, stretch, 0, True, time.perf_counter() - began, state, float("nan"))

    def origin(self, state: State) -> State:
        return State.of(state, {FRAMES: state.history[FRAMES]})

    def adapted(self, state: State, equations: Equations) -> State:
        return self.discrete.clamped(state, equations.system.conditions.clamps)

    def end_nodes(self, rod: int, side: str) -> EndNodes:
        nodes = self.discrete.layout.of(rod)
        outer, inner = (nodes.start, nodes.start + 1) if side == "start" else (nodes.stop - 1, nodes.stop - 2)
        return EndNodes(np.array([outer]), np.ones(1), outer, inner)

    def outward(self, rod: int, side: str, origin: State) -> np.ndarray:
        tangent = self._end_frame(rod, side, origin).tangent
        return -tangent if side == "start" else tangent

    def constrained(self, rod: int, side: str, motion: RigidMotion, origin: State) -> tuple[Prescribed, list[Clamp]]:
        node, frame = self.end_nodes(rod, side).outer, self._end_frame(rod, side, origin)
        place, translation = origin.x[node, :3].copy(), motion.translation
        nodes, label = np.array([node]), self.end_label(rod, side)

        def places(time: float) -> np.ndarray:
            return (place if translation is None else place + translation(time))[None]

        clamps = [_clamp(node, frame, motion)] if motion.oriented else []
        return Prescribed(nodes, places, label), clamps

    def equations(self, step: Step, origin: State, before: dict[str, np.ndarray]) -> Equations:
        scene = self.scene
        ends = ends_of(self, step, origin, before)
        system = self.discrete.system(
            make_scheme(scene, step),
            ends.prescribed,
            loads=[*self._further, *ends.loads],
            conditions=conditions_of(scene, step, origin.time, ends.clamps),
            linear_solver=scene.solver.linear,
            threads=threads_of(scene),
        )
        return Equations(system, ends.supports, ends.drives)

    def axis_nodes(self, rod: int) -> np.ndarray:
        nodes = self.discrete.layout.of(rod)
        return np.arange(nodes.start, nodes.stop)

    def reaches(self, x: np.ndarray, penetration: float) -> Sequence[Reach]:
        return reaches(self.scene, self.centrelines(x), penetration)

    def clamp_couples(self, x: np.ndarray) -> np.ndarray:
        return self.discrete.clamp_couples(x)

    def tension_profile(self, x: np.ndarray, time: float, displacement: float) -> Iterable[Row]:
        return profile_rows(self.discrete, self.rods, x, time, displacement)

    def twist_profile(self, x: np.ndarray, time: float, displacement: float) -> Iterable[Row]:
        return twist_rows(self.discrete, self.rods, x, time, displacement)

    def series_mesh(self) -> SeriesMesh:
        return tube_mesh(self.discrete.layout)

    def fields(self, x: np.ndarray) -> Fields:
        ratios = [rod.material.poissons_ratio for rod in self.rods]
        return tube_fields(self.discrete, self.contacts(), x, ratios)

    def _end_frame(self, rod: int, side: str, state: State) -> EndFrame:
        """Orientation of an end: as its clamp has it, or as the rod itself has it where there is none."""
        end = self.end_nodes(rod, side)
        history = state.history[FRAMES]
        held = np.flatnonzero(history["clamped"] == end.outer)
        if held.size:
            row = self.nodes + int(held[0])
            return EndFrame(history["tangent"][row].copy(), history["director"][row].copy())
        frames = self.discrete.frames.of(history)
        edge = min(end.outer, end.inner)
        return EndFrame(frames.current(state.x)[0][edge], frames.material(state.x)[edge])


def _clamp(node: int, frame: EndFrame, motion: RigidMotion | None = None) -> Clamp:
    rotation = None if motion is None else motion.rotation

    def orientation(time: float) -> tuple[np.ndarray, np.ndarray]:
        if rotation is None:
            return frame.tangent, frame.director
        return frame.tangent, rotate(frame.director, frame.tangent, rotation(time))

    return Clamp(node, orientation)
