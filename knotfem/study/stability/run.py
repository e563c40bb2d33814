"""The verb `stability`: for which friction and load does a knot hold."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

from knotfem.errors import InputError
from knotfem.scene.load import Overrides, load_scene
from knotfem.scene.model import Scene
from knotfem.scene.quantity import FORCE, parse_quantity
from knotfem.study.dead_load import FREE_LOAD, Directions, Lowering
from knotfem.study.engine.places import Place, place_of
from knotfem.study.progress import StudyProgress, showing
from knotfem.study.stability.boundary import next_friction
from knotfem.study.stability.diagram import StabilityDiagram, boundary_of, known_verdicts
from knotfem.study.stability.grid import COLLECT, FRICTION, KEPT, KEYS, STIFFNESS, Grid
from knotfem.study.sweep.plan import Planned, cost_of
from knotfem.study.sweep.points import WAITING, Asked, Points, folder_at
from knotfem.study.sweep.table import StudyTable
from knotfem.topology.closures import name_of

BOWLINE = "8_20"
"""Knot of a bowline whose ends are continued to infinity."""
MODELS = ("fem", "rod")


def is_bowline(knots: Iterable[str]) -> bool:
    """Whether all points with a knot are bowlines by most closures, such as "8_20 (by 11 of 12 closures; 6_3 by 1)"."""
    return {name_of(knot) for knot in knots if knot} == {BOWLINE}


def stability(
    source: str | Path | Scene,
    overrides: Overrides = (),
    *,
    friction: Sequence[float] = FRICTION,
    x: Sequence[float] | None = None,
    load: Sequence[float | str] | None = None,
    models: Sequence[str] = (),
    grid: bool = True,
    boundary: float | None = None,
    lowered: bool | Lowering = False,
    loaded: Directions | None = None,
    free: Directions | None = None,
    free_load: float = FREE_LOAD,
    ramp: str | None = None,
    out: str | Path | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    cluster: str | Path | None = None,
    progress: StudyProgress | bool = True,
) -> StabilityDiagram:
    """Find for which friction, and for which load T0 = B/(x r^2), a knot holds.

    Each point is a run of `dead_load`: the knot comes to rest, bears T0 with its free ends held, and then has its free
    ends let go under a small load, until it is at rest or has unravelled. The defaults are the 54 points of Fig. 4b of
    Aymon et al., Extreme Mech. Lett. 81, 102413 (2025). The folder keeps all runs: the same call goes on with a study
    that was stopped, and another one takes from it what it needs too.

    Args:
        source: a shipped name, a TOML file, or a scene with a loaded and a free end.
        overrides: changes of its keys.
        friction: coefficients between rods.
        x: B/(T0 r^2), by the bending stiffness of the softest rod; 5, 6, 7.4, 9.1, 13.9 and 25 by default.
        load: T0 instead of x, [N] or such as "2 N".
        models: "fem", "rod" or both; by default that of the scene.
        grid: whether to run all combinations; without, `boundary` or `lowered` only.
        boundary: width of a bracket in friction to which the boundary is then found by bisection, for each x.
        lowered: whether to find the boundary by friction that falls, too, from the largest one.
        loaded: see `dead_load`.
        free: likewise.
        free_load: likewise.
        ramp: likewise.
        out: folder of the results; stability/NAME by default.
        jobs: runs at a time on this machine.
        scheduler: address of a dask scheduler that runs already, such as "tcp://host:8786".
        cluster: TOML file that says what to ask a cluster's batch system for.
        progress: whether to show progress, or an object that is told.

    Returns:
        The diagram; study.csv, boundary.csv, stability.png and, for a bowline, fit.json are in the folder.

    Raises:
        InputError: an argument is wrong, or the folder holds runs of another scene.
        NotConverged: no point could be computed.
        Stopped: by SIGTERM; all runs have written checkpoints.
        Interrupted: by Ctrl-C, likewise.
        KnotfemError: the scheduler is gone, or runs crashed.
    """
    asked = asked_of(
        source, overrides, friction=friction, x=x, load=load, models=models, grid=grid, boundary=boundary,
        lowered=lowered, loaded=loaded, free=free, free_load=free_load, ramp=ramp, out=out,
    )  # fmt: skip
    place = place_of(jobs, scheduler, cluster)
    with showing(progress) as shown:
        return asked.run(place, shown)


@dataclass(frozen=True, eq=False)
class StabilityStudy:
    """What is asked for.

    Attributes:
        grid: of friction and load.
        whole: whether all its points are run.
        width: of the brackets of the boundary, or none.
        lowered: whether friction is lowered, too.
        text: of study.toml.
        folder: of the results.
    """

    grid: Grid
    whole: bool
    width: float | None
    lowered: bool
    text: str
    folder: Path

    @cached_property
    def planned(self) -> list[Planned]:
        """The points that are known from the start."""
        points = self.grid.points(self.folder) if self.whole else []
        return points + (self.grid.lowered(self.folder) if self.lowered else [])

    def follow(self, table: StudyTable) -> list[Planned]:
        """Points by which brackets become narrower, at most one for each model and load."""
        assert self.width is not None, "asked only where there is one"
        known = known_verdicts(table)
        names = ("model", "protocol", "x", "friction", "state")
        rows = list(zip(*(table[name].tolist() for name in names), strict=True))
        limits = min(self.grid.friction), max(self.grid.friction)
        found: list[Planned] = []
        for model, x in product(self.grid.models, self.grid.stiffness):
            states = {row[3]: row[4] for row in rows if row[:3] == (model, KEPT, x)}
            if WAITING in states.values():
                continue
            friction = next_friction(known.get((model, x), {}), frozenset(states), limits, self.width)
            if friction is not None:
                found.append(self.grid.point(self.folder, model, x, friction))
        return found

    def cost(self, place: Place) -> dict[str, Any]:
        """What it would take, but for the points that a bisection adds; nothing is run."""
        found = cost_of(self.planned, self.folder, place)
        if self.width is not None:
            span = max(self.grid.friction) - min(self.grid.friction)
            steps = 2 + math.ceil(math.log2(max(span / self.width, 1.0)))
            found["runs of the bisection, at most"] = len(self.grid.models) * len(self.grid.stiffness) * steps
        return found

    def run(self, place: Place, progress: StudyProgress) -> StabilityDiagram:
        """Run it; see `stability`."""
        asked = Asked(self.grid.scene.name, KEYS, COLLECT, self.text)
        follow = None if self.width is None else self.follow
        table = Points(asked, self.folder, self.planned, place, progress, follow).run()
        bowline = len(self.grid.scene.rods) == 1 and is_bowline(table["knot_before"].tolist())
        diagram = StabilityDiagram(table, boundary_of(table), bowline)
        diagram.write()
        return diagram


def asked_of(
    source: str | Path | Scene,
    overrides: Overrides,
    *,
    friction: Sequence[float],
    x: Sequence[float] | None,
    load: Sequence[float | str] | None,
    models: Sequence[str],
    grid: bool,
    boundary: float | None,
    lowered: bool | Lowering,
    loaded: Directions | None,
    free: Directions | None,
    free_load: float,
    ramp: str | None,
    out: str | Path | None,
) -> StabilityStudy:
    """What is asked for; see `stability`.

    Raises:
        InputError: an argument is wrong, or the place of the results is a file.
    """
    if not friction or min(friction) < 0.0:
        raise InputError("no friction coefficients", key="friction", found=str(list(friction)), expected="0 or above")
    scene = load_scene(source, overrides)
    if load is not None:
        x = _stiffness(scene, x, load)
    elif x is None:
        x = STIFFNESS
    if not x or min(x) <= 0.0:
        raise InputError("no loads", key="x", found=str(list(x)), expected="numbers above 0")
    for key, values in (("friction", friction), ("x", x)):
        if len(set(values)) < len(values):
            raise InputError("the same value twice", key=key, found=str(list(values)), expected="each once")
    if boundary is not None and not 1e-4 <= boundary <= 0.5:
        raise InputError("no such width", key="boundary", found=f"{boundary:g}", expected="from 0.0001 to 0.5")
    if boundary is not None and len(set(friction)) < 2:
        found = str(list(friction))
        raise InputError("nothing to bisect", key="friction", found=found, expected="a smallest and a largest one")
    if wrong := [model for model in models if model not in MODELS]:
        raise InputError("no such model", key="model", found=", ".join(wrong), expected=", ".join(MODELS))
    if not (grid or boundary is not None or lowered):
        raise InputError("nothing to run", key="grid", expected="the grid, its boundary, or friction that is lowered")
    lowering = lowered if isinstance(lowered, Lowering) else Lowering()
    chosen = tuple(models) or (scene.model,)
    of = Grid(
        scene, chosen, tuple(friction), tuple(x), loaded, free, free_load, lowering, ramp
    )  # fmt: skip
    settings = {
        "scene": scene.name, "models": list(chosen), "friction": list(friction), "x": list(x), "grid": grid,
        "boundary": boundary, "lowered": bool(lowered), "lowering_rate": lowering.rate, "free_load": free_load,
        "loaded": loaded, "free": free, "ramp": ramp, "rope": None if scene.rope is None else str(scene.rope),
    }  # fmt: skip
    folder = folder_at(Path(out) if out is not None else Path("stability") / scene.name)
    return StabilityStudy(of, grid, boundary, bool(lowered), _text(settings), folder)


def _stiffness(scene: Scene, x: Sequence[float] | None, load: Sequence[float | str]) -> list[float]:
    """B/(T0 r^2) of loads T0, in [N] or as text.

    Raises:
        InputError: values of both are given, or a load is none.
    """
    if x is not None:
        found = f"x = {list(x)}, load = {list(load)}"
        raise InputError("one load said in two ways", key="load", found=found, expected="x = B/(T0 r^2) or the load T0")
    loads = [parse_quantity(one, FORCE, "load") if isinstance(one, str) else one for one in load]
    if not loads or not 0.0 < min(loads) < math.inf:
        raise InputError("no loads", key="load", found=str(list(load)), expected="forces above 0")
    return [scene.force_scale / one for one in loads]


def _text(settings: dict[str, Any]) -> str:
    import tomlkit

    plain = {
        key: {name: list(value) for name, value in setting.items()} if isinstance(setting, dict) else setting
        for key, setting in settings.items()
        if setting is not None
    }
    return tomlkit.dumps(plain)
