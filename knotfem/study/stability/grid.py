"""Points of a stability diagram: one knot under a dead load, by friction between rods and by the size of the load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from knotfem.run.directory import RunDirectory
from knotfem.scene.load import load_scene
from knotfem.scene.model import Scene
from knotfem.study.column_meanings import STABILITY_KEYS
from knotfem.study.dead_load import FREE_LOAD, Directions, Lowering, dead_load
from knotfem.study.sweep.axes import Point
from knotfem.study.sweep.plan import DEFAULTS, Planned, planned
from knotfem.study.sweep.table import RUNS

FRICTION = tuple(round(0.05 * i, 2) for i in range(9))
"""Of the paper's 54 points (Fig. 4b)."""
STIFFNESS = (5.0, 6.0, 7.4, 9.1, 13.9, 25.0)
"""B/(T0 r^2), likewise."""
KEYS = tuple(STABILITY_KEYS)
"""Columns of the table with the values of a point."""
COLLECT = {
    "knot_before": "knot_before",
    "rests": "verdict_evidence.at_rest",
    "onset_friction": "verdict_evidence.onset.friction",
    "lost_friction": "verdict_evidence.lost.friction",
    "lost": "verdict_evidence.lost.what",
}
KEPT, LOWERED = "kept", "lowered"
"""Protocols: friction stays what it was when the knot was tied, or falls once the free ends are let go."""


@dataclass(frozen=True, eq=False)
class Grid:
    """What a stability diagram is made of.

    Attributes:
        scene: whose knot it is, with its model.
        models: with which it is computed.
        friction: coefficients between rods.
        stiffness: x = B/(T0 r^2).
        loaded, free: ends and directions, see `dead_load`; None for those of the scene.
        free_load: load on a free end over T0.
        lowering: rate and end of the falling friction.
        ramp: nominal time in which T0 rises; None applies it at once.
    """

    scene: Scene
    models: tuple[str, ...]
    friction: tuple[float, ...] = FRICTION
    stiffness: tuple[float, ...] = STIFFNESS
    loaded: Directions | None = None
    free: Directions | None = None
    free_load: float = FREE_LOAD
    lowering: Lowering = field(default_factory=Lowering)
    ramp: str | None = None
    _scenes: dict[str, Scene] = field(default_factory=dict, repr=False)

    def tension(self, stiffness: float) -> float:
        """T0 [N] of a knot with x = B/(T0 r^2)."""
        return self.scene.force_scale / stiffness

    def point(self, folder: Path, model: str, stiffness: float, friction: float, protocol: str = KEPT) -> Planned:
        """One point, ready to run.

        Args:
            folder: of the study.
            model: "fem" or "rod".
            stiffness: x.
            friction: between rods; where it is lowered, that with which the knot is tied.
            protocol: `KEPT` or `LOWERED`.

        Raises:
            InputError: the values make no valid scene, or the folder holds a run of another scene.
        """
        load = self.tension(stiffness)
        values: Mapping[str, Any] = {
            "model": model, "protocol": protocol, "friction": friction, "x": stiffness, "tension_N": load,
        }  # fmt: skip
        name = f"{model}_x={stiffness:g}_" + (f"friction={friction:g}" if protocol == KEPT else LOWERED)
        scene = dead_load(
            self._scene(model),
            load,
            loaded=self.loaded,
            free=self.free,
            free_load=self.free_load,
            friction=friction,
            ramp=self.ramp,
            lowering=self.lowering if protocol == LOWERED else None,
        )
        return planned(Point(name, values), RunDirectory(folder / RUNS / name), scene)

    def points(self, folder: Path) -> list[Planned]:
        """All points of the grid; large frictions first, since a knot that holds takes least time."""
        return [
            self.point(folder, model, stiffness, friction)
            for model in self.models
            for friction in sorted(self.friction, reverse=True)
            for stiffness in self.stiffness
        ]

    def lowered(self, folder: Path) -> list[Planned]:
        """For each load a knot that is tied at the largest friction, which then falls."""
        start = max(self.friction)
        return [
            self.point(folder, model, stiffness, start, LOWERED)
            for model in self.models
            for stiffness in self.stiffness
        ]

    def _scene(self, model: str) -> Scene:
        if model not in self._scenes:
            self._scenes[model] = load_scene(self.scene, {**DEFAULTS, "model": model, "output.fields": False})
        return self._scenes[model]
