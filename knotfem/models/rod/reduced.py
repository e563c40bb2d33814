"""Discrete elastic rods as the model of a scene."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.contact.report import ContactMap
from knotfem.energy.account import Account
from knotfem.energy.rod_account import RodAccount
from knotfem.models.base import Fields, Row, SeriesMesh, Simulation
from knotfem.models.conditions import (
    adjust,
    dead_load,
    following_load,
    make_scheme,
    ramp,
    reported_first,
    turn_angle,
    unit,
)
from knotfem.models.registry import REGISTRY
from knotfem.models.rod.build import coarse, core_share, make_rods
from knotfem.models.rod.ends import End, EndFrame, clamped, driven, pinned, turned
from knotfem.models.rod.fields import tube_fields, tube_mesh
from knotfem.models.rod.initial import lay
from knotfem.models.rod.model import Side
from knotfem.models.rod.profile import tension_rows, twist_rows
from knotfem.models.solid.assembly import StepSystem
from knotfem.models.solid.mapping import Increment
from knotfem.scene.model import Scene
from knotfem.scene.steps import Clamped, Driven, Loaded, Pinned, Pull, Step, Turn, Turned
from knotfem.solver.stepping.integrator import Progress
from knotfem.solver.term import Motion
from knotfem.tie import CentrelinePath

SIDES = ("start", "end")


class Reduced(Simulation):
    """The reduced model; see `Simulation`.

    Attributes:
        rod: rods, contacts and where they are.
    """

    def __init__(self, scene: Scene, folder: Path | None = None) -> None:
        """Lay the rods into the knot and make the effects.

        Args:
            scene: what the user asked for.
            folder: of the run.

        Raises:
            InputError: a centreline or a source that cannot be, or a feature that the model does not have.
        """
        self.scene, self.rods = scene, lay(scene, folder)
        self.rod = make_rods(scene, self.rods)
        self.effects = self.rod.effects
        self.elastic = [self.rod.stretch, self.rod.bend, self.rod.twist]
        self.absent = {entry.name: reason for entry in REGISTRY if (reason := entry.absent(scene))}
        self.sections = self.rod.layout.sections
        self.dofs, self.segments = 4 * self.rod.layout.nodes, int(self.rod.layout.edges.size)
        self._frames: dict[Side, EndFrame] | None = {
            (number, side): frame
            for number, laid in enumerate(self.rods)
            for side, frame in zip(SIDES, laid.ends, strict=True)
        }
        self._begun = self._frames

    @property
    def warnings(self) -> list[str]:
        return [*super().warnings, *coarse(self.scene)]

    @property
    def path_kind(self) -> str:
        """The mapping; there is none from a run that is tied already."""
        return super().path_kind if self.scene.tie.source is None else "direct"

    def straight(self) -> Motion:
        return self.rod.progress.motion

    def mapping(self, paths: list[CentrelinePath], linear_solver: str) -> Iterator[Increment]:
        """The centrelines on their way; the rods themselves are laid where these end."""
        for mapping_time in self.mapping_times:
            began = time.perf_counter()
            x = self.rod.x.copy()
            if mapping_time < 1.0:
                x[:, :3] = np.concatenate([path.at(mapping_time) for path in paths])
            stretch = np.concatenate([path.stretch(mapping_time) for path in paths])
            yield Increment(mapping_time, stretch, 0, True, time.perf_counter() - began, x, float("nan"))

    def equations(
        self, step: Step, start: float, origin: np.ndarray, before: dict[str, np.ndarray], progress: Progress
    ) -> StepSystem:
        self.rod.progress = progress
        frames = self._begun = self._end_frames()
        self._frames = None
        ends: dict[Side, End] = {}
        supports: dict[str, np.ndarray] = {}
        drives: list[tuple[str, np.ndarray, np.ndarray]] = []
        for number, laid in enumerate(self.rods):
            for side in SIDES:
                wanted, frame = getattr(step.ends[laid.scene.name], side), frames[number, side]
                label, node = f"{laid.scene.name}.{side}", self._end_node(number, side)
                if isinstance(wanted, Clamped | Pinned | Driven | Turned):
                    supports[label] = node
                match wanted:
                    case Clamped():
                        ends[number, side] = clamped(frame)
                    case Pinned():
                        ends[number, side] = pinned(frame)
                    case Driven():
                        assert isinstance(step, Pull)
                        direction = unit(wanted.direction)
                        ends[number, side] = driven(frame, direction, ramp(step, start))
                        drives.append((label, node, direction))
                    case Turned():
                        assert isinstance(step, Turn)
                        angle = turn_angle(wanted.turns, step, start)
                        ends[number, side] = turned(frame, frame.tangent, angle)
                    case Loaded():
                        bore = before.get(label, np.zeros(3))
                        if wanted.following:
                            outward = -frame.tangent if side == "start" else frame.tangent
                            history = following_load(wanted, outward, label, bore, step, start)
                            ends[number, side] = End(following=history)
                        else:
                            ends[number, side] = End(force=dead_load(wanted, bore, step, start))
                        drives.append((label, node, unit(wanted.direction)))
        adjust(self.named, self.scene, step, start)
        self.rod.scheme = make_scheme(self.scene, step)
        steps = progress.dt, progress.increment_dt
        system = self.rod.begin(ends)
        progress.dt, progress.increment_dt = steps
        return StepSystem(system, supports, reported_first(drives, step))

    def state(self, inside: bool) -> dict[str, Any]:
        frames = self._begun if inside and self._begun is not None else self._end_frames()
        return {"frames": {f"{rod}.{side}": vars(frame) for (rod, side), frame in frames.items()}}

    def restore(self, state: dict[str, Any]) -> None:
        frames: Mapping[str, dict[str, np.ndarray]] = state["frames"]
        self._frames = {}
        for label, frame in frames.items():
            number, side = label.split(".")
            self._frames[int(number), side] = EndFrame(**frame)

    def account(self) -> Account:
        return RodAccount(self, self.rod)

    def kinetic(self, v: np.ndarray) -> float:
        return self.rod.ledger.energies.kinetic

    def centrelines(self, x: np.ndarray) -> list[np.ndarray]:
        layout = self.rod.layout
        return [x[layout.of(number), :3] for number in range(layout.rods)]

    def profile(self, x: np.ndarray, time: float, displacement: float) -> Iterable[Row]:
        shares = [core_share(laid.scene) for laid in self.rods]
        names = [laid.scene.name for laid in self.rods]
        return tension_rows(self.rod, names, shares, time, displacement)

    def twist(self, x: np.ndarray, time: float, displacement: float) -> Iterable[Row]:
        return twist_rows(self.rod, [laid.scene.name for laid in self.rods], time, displacement)

    def contacts(self) -> ContactMap:
        return self.rod.contacts()

    def series_mesh(self) -> SeriesMesh:
        return tube_mesh(self.rod.layout)

    def fields(self, x: np.ndarray) -> Fields:
        return tube_fields(self.rod, [laid.scene.material.poissons_ratio for laid in self.rods])

    def _end_node(self, number: int, side: str) -> np.ndarray:
        nodes = self.rod.layout.of(number)
        return np.array([nodes.start if side == "start" else nodes.stop - 1])

    def _end_frames(self) -> dict[Side, EndFrame]:
        """How the ends lie: as laid or restored, else as the last step left them."""
        if self._frames is not None:
            return self._frames
        return {(number, side): self.rod.end_frame(number, side) for number in range(len(self.rods)) for side in SIDES}
