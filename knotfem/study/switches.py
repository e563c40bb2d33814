"""Each effect of a scene switched off in turn: what it costs and what it changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from knotfem.errors import InputError
from knotfem.models.effects import DAMPING, EFFECTS, VISCOUS_DRAG
from knotfem.scene.model import Scene
from knotfem.study.convergence import make_jobs, require_base
from knotfem.study.engine.places import Place
from knotfem.study.measured import Measured, measure
from knotfem.study.quantities import LABELS, scale_of
from knotfem.study.references import Reference
from knotfem.study.refinement import Level, base_level

if TYPE_CHECKING:
    from rich.console import RenderableType


def _core(scene: Scene) -> list[str]:
    return [f"rods.{i}.core=none" for i in range(len(scene.rods))]


def _damping(scene: Scene) -> list[str]:
    return [f"rods.{i}.material.relaxation_time=0 s" for i in range(len(scene.rods))]


def _pairs(scene: Scene, *, obstacles: bool) -> list[str]:
    named = {obstacle.name for obstacle in scene.obstacles}
    return [
        f"contact.pairs.{i}.friction=0.0"
        for i, pair in enumerate(scene.contact.pairs)
        if bool(named & set(pair.between)) == obstacles
    ]


def _schedules(scene: Scene) -> list[str]:
    return [f"steps.{i}.friction_schedule=none" for i, step in enumerate(scene.steps) if step.friction_schedule]


def _friction(scene: Scene) -> list[str]:
    return ["contact.friction=0.0", *_pairs(scene, obstacles=False), *_schedules(scene)]


def _obstacle_friction(scene: Scene) -> list[str]:
    own = [f"obstacles.{i}.friction=0.0" for i in range(len(scene.obstacles))]
    return [*own, *_pairs(scene, obstacles=True)]


def _obstacles(scene: Scene) -> list[str]:
    places = [i for i, pair in enumerate(scene.contact.pairs) if {o.name for o in scene.obstacles} & set(pair.between)]
    return [*(f"contact.pairs.{i}=none" for i in reversed(places)), "obstacles=[]"]


SWITCHES: dict[str, Callable[[Scene], list[str]]] = {
    "core": _core,
    DAMPING.name: _damping,
    "inertia": lambda scene: ["inertia.scheme=quasi-static"],
    "drag": lambda scene: ["drag=none"],
    "gravity": lambda scene: ["gravity=none"],
    "contact": lambda scene: ["contact.enabled=false", *_schedules(scene)],
    "friction": _friction,
    "cylinder": _obstacles,
    "cylinder friction": _obstacle_friction,
    VISCOUS_DRAG.name: lambda scene: ["effects.viscous_drag=none"],
}
"""Overrides that take an effect out of a scene; it could not do without loads and numerical drag."""


@dataclass(frozen=True, eq=False)
class EffectsStudy:
    """What effects cost and change.

    Attributes:
        scene: with all of them.
        base: its run.
        without: the run without each effect.
    """

    scene: Scene
    base: Measured
    without: dict[str, Measured]

    def fraction(self, effect: str) -> float:
        """CPU seconds spent in the effect itself over those of the whole run."""
        return self.base.effects.get(effect, 0.0) / self.base.cpu["total"]

    def saved(self, effect: str) -> float:
        """CPU seconds that a run without it takes less, over those of the whole run; NaN where there is no such run."""
        entry = self.without[effect]
        return 1.0 - entry.cpu["total"] / self.base.cpu["total"] if entry.done else float("nan")

    def change(self, effect: str, name: str) -> float:
        """Relative change of a quantity without the effect; NaN where it has no such quantity."""
        entry, value = self.without[effect], self.base.quantities[name]
        if name not in entry.quantities or entry.quantities[name].shape != value.shape:
            return float("nan")
        return Reference(value, scale_of(name, value), 0.0, "").error(entry.quantities[name])


def effects_of(scene: Scene) -> list[str]:
    """Effects that a scene calls for and could do without."""
    return [effect.name for effect in EFFECTS if effect.name in SWITCHES and effect.wanted(scene)]


def run_effects(
    source: str,
    overrides: Sequence[str],
    folder: Path,
    *,
    budget: float | None,
    place: Place | None = None,
    tell: Callable[[str], None],
) -> EffectsStudy:
    """Run a scene as it is and without each of its effects; see `convergence.run_convergence`.

    Raises:
        InputError: it has none.
        KnotfemError: the scene itself did not run to its end.
    """
    jobs = make_jobs(source, overrides, folder, budget=budget, place=place, tell=tell)
    base = base_level()
    scene = jobs.scene_of(base)
    levels = {
        name: Level(
            f"without-{name.replace(' ', '-')}", "effects", f"without {name}", None, tuple(SWITCHES[name](scene))
        )
        for name in effects_of(scene)
    }
    if not levels:
        raise InputError("no effect to switch off", key="--effects", expected=f"one of {', '.join(SWITCHES)}")
    jobs.run([base, *levels.values()])
    require_base(jobs)
    return EffectsStudy(scene, measure(jobs, base), {name: measure(jobs, level) for name, level in levels.items()})


def effects_rows(study: EffectsStudy) -> list[dict[str, Any]]:
    """Rows of effects.csv, one for each effect."""
    return [
        {
            "effect": name,
            "state": entry.outcome.state,
            "reason": entry.outcome.reason,
            "cpu_s": study.base.effects.get(name, 0.0),
            "share": study.fraction(name),
            "saved_share": study.saved(name),
            **{f"{quantity}_change": study.change(name, quantity) for quantity in study.base.quantities},
        }
        for name, entry in study.without.items()
    ]


def effects_table(study: EffectsStudy) -> RenderableType:
    """What the terminal shows."""
    from rich.table import Table

    table = Table(title=f"{study.scene.name}: what each effect costs, and what a run without it changes, in %")
    for column in ("effect", "CPU s", "of the run", "saved", *(LABELS[name] for name in study.base.quantities), ""):
        table.add_column(column, justify="left" if column in ("effect", "") else "right")
    for name, entry in study.without.items():
        figures = [study.fraction(name), study.saved(name), *(study.change(name, q) for q in study.base.quantities)]
        shown = ["" if np.isnan(figure) else f"{100.0 * figure:.3g}" for figure in figures]
        why = "" if entry.done else f"{entry.outcome.state}: {entry.outcome.reason}"
        table.add_row(name, f"{study.base.effects.get(name, 0.0):.2f}", *shown, why)
    return table
