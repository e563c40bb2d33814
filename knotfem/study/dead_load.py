"""The protocol by which the paper tells whether a knot holds a dead load.

The knot comes to rest as it was tied. The load acts on the loaded end, the free ends being held, until the rods are at
rest. Then the free ends are let go under a small load, until the rods are at rest or the knot has unravelled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from knotfem.errors import InputError
from knotfem.geometry.vectors import unit
from knotfem.models.base import SIDES
from knotfem.scene.load import Overrides, load_scene
from knotfem.scene.model import Scene
from knotfem.scene.quantity import FORCE, parse_quantity
from knotfem.scene.steps import Driven, Loaded
from knotfem.stability.ends import Place, free_ends, loaded_ends

FREE_LOAD = 0.05
"""Load on each free end over that on the loaded end, by default: the paper's 1/20."""
LONGEST = "1000 s"
"""Of a release in real time; without meaning in a quasi-static one."""

Directions = Mapping[str, Sequence[float]]
"""Direction, of any length, by the label of an end such as "rod.start"."""
Places = dict[Place, dict[str, Any]]
"""What happens to ends."""


@dataclass(frozen=True)
class Lowering:
    """Friction between rods that falls once the free ends are let go.

    Attributes:
        rate: by which it falls [1/s]; how far loads are is told by times, so the rate only matters next to others.
        to: where it ends.
        every: an output is due each time it has fallen by so much.
    """

    rate: float = 0.01
    to: float = 0.0
    every: float = 0.01


def dead_load(
    source: str | Path | Scene,
    load: float | str,
    overrides: Overrides = (),
    *,
    loaded: Directions | None = None,
    free: Directions | None = None,
    free_load: float = FREE_LOAD,
    friction: float | None = None,
    ramp: float | str | None = None,
    lowering: Lowering | None = None,
    weight: bool = False,
) -> Scene:
    """A scene whose loading steps are replaced by the protocol.

    Its steps are called "relax" (as the scene has it), "load", "rest" (with a ramp), "let-go" and "lower" (with a
    lowering). All of them end the run as soon as the knot has unravelled.

    Args:
        source: a shipped name, a TOML file, or a scene.
        load: on each loaded end, [N] or such as "1.1 N".
        overrides: see `load_scene`.
        loaded: ends that are loaded, and where to; by default those that the first step of the scene with such ends
            drives or loads, in its directions.
        free: ends that are let go, and the direction of the small load on each; by default the free ends of the first
            step that has some, else all that are not loaded, loaded opposite to the first loaded end.
        free_load: small load over the load.
        friction: between rods; None for the scene's.
        ramp: nominal time in which the load rises from 0, [s] or such as "10 s". None applies it at once, as the paper
            says; then the rods move to rest under the whole load. A ramp takes them through smaller loads first, at
            which a stiff rod is less stable.
        lowering: lowers friction between rods once the free ends are let go, to find the friction at which the knot is
            lost; None keeps it.
        weight: whether gravity acts, where the scene has it.

    Raises:
        InputError: the scene has no loaded or no free end and none is named, or `load_scene` refuses it.
    """
    scene = load_scene(source, overrides)
    force = parse_quantity(load, FORCE, "load") if isinstance(load, str) else float(load)
    pulls, drops = places_of(scene, loaded, free)
    large = {place: load_of(force, direction) for place, direction in pulls.items()}
    small = {place: load_of(free_load * force, direction) for place, direction in drops.items()}
    held, gone = ends_of(large), ends_of({**large, **small})
    coefficient = scene.contact.friction if friction is None else friction
    changes: dict[str, Any] = {"contact.friction": coefficient, "steps": [*tying_of(scene), *_loading(held, ramp)]}
    changes["steps"].append({"name": "let-go", "kind": "release", "duration": LONGEST, "ends": gone})
    if lowering is not None:
        changes["steps"].append(_lower(lowering, coefficient, gone))
        changes["output.every_time"] = f"{lowering.every / lowering.rate} s"
    if not weight and scene.gravity is not None:
        changes["gravity"] = None
    return load_scene(scene, changes)


def places_of(
    scene: Scene, loaded: Directions | None, free: Directions | None
) -> tuple[Mapping[Place, Sequence[float]], Mapping[Place, Sequence[float]]]:
    """Directions of the loads on the loaded and on the free ends.

    Args:
        scene: whose ends they are.
        loaded: see `dead_load`.
        free: see there.

    Raises:
        InputError: there is no loaded or no free end, one is both, or nothing bears the load.
    """
    pulls = _loaded(scene) if loaded is None else _named(scene, loaded, "loaded")
    away = [-value for value in unit(next(iter(pulls.values())))]
    drops = dict.fromkeys(_free(scene, pulls), away) if free is None else _named(scene, free, "free")
    if set(pulls) & set(drops):
        raise InputError("an end is both loaded and free", key="free", found=", ".join(map(".".join, drops)))
    held = len(SIDES) * len(scene.rods) - len(pulls) - len(drops)
    if not (held or scene.obstacles or len(pulls) > 1):
        raise InputError(
            "nothing bears the load: all other ends are let go",
            key="free",
            found=", ".join(map(".".join, drops)),
            expected="an obstacle, another rod, or an end that is held or loaded",
        )
    return pulls, drops


def free_directions(source: str | Path | Scene, overrides: Overrides, direction: Sequence[float]) -> Directions:
    """One direction for all ends that `dead_load` lets go by default.

    Raises:
        InputError: it is not a direction, or the scene has no loaded or no free end.
    """
    if len(direction) != 3 or not any(direction):
        raise InputError("no direction", key="direction", found=str(list(direction)), expected="three numbers")
    scene = load_scene(source, overrides)
    return {".".join(place): tuple(direction) for place in _free(scene, _loaded(scene))}


def tying_of(scene: Scene) -> list[dict[str, Any]]:
    """Steps of a scene that tie the knot; one that relaxes where it has none."""
    steps = [step.model_dump(mode="json", exclude_none=True) for step in scene.tying_steps]
    return steps or [{"kind": "relax"}]


def _loading(held: dict[str, Any], ramp: float | str | None) -> list[dict[str, Any]]:
    shared = {"ends": held, "until": "decided", "must_hold": False}
    if ramp is None:
        return [{"name": "load", "kind": "relax", **shared}]
    duration = ramp if isinstance(ramp, str) else f"{ramp} s"
    return [
        {"name": "load", "kind": "load", "duration": duration, **shared},
        {"name": "rest", "kind": "relax", **shared},
    ]


def _lower(lowering: Lowering, start: float, ends: dict[str, Any]) -> dict[str, Any]:
    if not (lowering.rate > 0.0 and lowering.every > 0.0 and 0.0 <= lowering.to < start):
        expected = f"a rate above 0 that lowers it from {start:g}"
        raise InputError("friction does not fall", key="lowering", found=str(lowering), expected=expected)
    duration = f"{(start - lowering.to) / lowering.rate} s"
    schedule = [{"time": "0 s", "friction": start}, {"time": duration, "friction": lowering.to}]
    return {"name": "lower", "kind": "release", "duration": duration, "friction_schedule": schedule, "ends": ends}


def _loaded(scene: Scene) -> dict[Place, Sequence[float]]:
    for step in scene.steps:
        if places := loaded_ends(step):
            ends = step.all_ends()
            return {place: end.direction for place in places if isinstance(end := ends[place], Driven | Loaded)}
    raise InputError(
        "no end is loaded", key="loaded", expected='an end and a direction, such as {"rod.start": [0, 0, 1]}'
    )


def _free(scene: Scene, loaded: Mapping[Place, object]) -> list[Place]:
    for step in scene.steps:
        if places := [place for place in free_ends(step) if place not in loaded]:
            return places
    others = [(rod.name, side) for rod in scene.rods for side in SIDES if (rod.name, side) not in loaded]
    if not others:
        raise InputError("no end is left to let go", key="free", expected="an end that is not loaded")
    return others


def _named(scene: Scene, directions: Directions, key: str) -> dict[Place, Sequence[float]]:
    known = [f"{rod.name}.{side}" for rod in scene.rods for side in SIDES]
    for label in directions:
        if label not in known:
            raise InputError("no such end", key=key, found=label, expected=", ".join(known))
    if not directions:
        raise InputError("no end", key=key, expected=", ".join(known))
    return {(label.rpartition(".")[0], label.rpartition(".")[2]): tuple(d) for label, d in directions.items()}


def load_of(force: float, direction: Sequence[float]) -> dict[str, Any]:
    """An end that bears a force [N]; free without one."""
    if force == 0.0:
        return {"motion": "free"}
    return {"motion": "loaded", "force": f"{force} N", "direction": list(direction)}


def ends_of(moves: Mapping[Place, Mapping[str, Any]]) -> dict[str, Any]:
    """Ends of a step, by rod and side."""
    ends: dict[str, Any] = {}
    for (rod, side), move in moves.items():
        ends.setdefault(rod, {})[side] = move
    return ends
