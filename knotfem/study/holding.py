"""How much a knot holds: tighten it, let its free ends go, pull until it slips."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from knotfem.api import Out, pull
from knotfem.results.run import Run
from knotfem.run.progress import Progress
from knotfem.scene.load import Overrides, load_scene
from knotfem.scene.model import Scene
from knotfem.scene.quantity import FORCE, LENGTH, parse_quantity
from knotfem.stability.verdict import SLIP_OVER_DIAMETER
from knotfem.study.dead_load import LONGEST, Directions, Places, ends_of, load_of, places_of, tying_of

REACH_OVER_SLIP = 5.0
"""The last pull goes this many times as far as the slip, unless told otherwise or the knot slips before."""


def holding_scene(
    source: str | Path | Scene,
    tighten: float | str,
    overrides: Overrides = (),
    *,
    slip: float | str | None = None,
    displacement: float | str | None = None,
    loaded: Directions | None = None,
    free: Directions | None = None,
    free_load: float = 0.0,
    weight: bool = False,
) -> Scene:
    """A scene whose loading steps are replaced by the recipe.

    - "tighten": the loaded ends bear a force, the free ends being held, until the rods are at rest;
    - "let-go": the loaded ends are held where they are and the free ends let go, until the rods are at rest;
    - "pull": the loaded ends are pulled on until a free end has been drawn in by the slip, or to the displacement.

    `Run.holding` of the run then tells the force that the knot holds. All of them end the run as soon as the knot has
    unravelled.

    Args:
        source: a shipped name, a TOML file, or a scene.
        tighten: force on each loaded end, [N] or such as "2 N"; 0 pulls the knot as it was tied.
        overrides: see `load_scene`.
        slip: length that a free end may be drawn in by, [mm] or such as "6 mm"; None for one diameter of the thinnest
            rod.
        displacement: of the pull at most, [mm] or such as "60 mm"; None for 5 times the slip.
        loaded: see `knotfem.study.dead_load.dead_load`.
        free: see there.
        free_load: force on each free end over the one that tightens, from when it is let go.
        weight: whether gravity acts, where the scene has it.

    Raises:
        InputError: the scene has no loaded or no free end and none is named, or `load_scene` refuses it.
    """
    scene = load_scene(source, overrides)
    force = parse_quantity(tighten, FORCE, "tighten") if isinstance(tighten, str) else float(tighten)
    length = _length(slip, "slip", SLIP_OVER_DIAMETER * min(rod.diameter for rod in scene.rods))
    reach = _length(displacement, "displacement", REACH_OVER_SLIP * length)
    pulls, drops = places_of(scene, loaded, free)
    gone: Places = {place: load_of(free_load * force, direction) for place, direction in drops.items()}
    held: Places = {place: load_of(force, direction) for place, direction in pulls.items()}
    driven: Places = {place: {"motion": "driven", "direction": list(direction)} for place, direction in pulls.items()}
    decided = {"until": "decided", "must_hold": False}
    steps: list[dict[str, Any]] = tying_of(scene)
    if force > 0.0:
        steps.append({"name": "tighten", "kind": "relax", "ends": ends_of(held), **decided})
    steps += [
        {"name": "let-go", "kind": "release", "duration": LONGEST, "ends": ends_of(gone)},
        {
            "name": "pull",
            "kind": "pull",
            "displacement": f"{reach} mm",
            "slip": f"{length} mm",
            "ends": ends_of({**driven, **gone}),
            **decided,
        },
    ]
    changes: dict[str, Any] = {"steps": steps}
    if not weight and scene.gravity is not None:
        changes["gravity"] = None
    return load_scene(scene, changes)


def hold(
    source: str | Path | Scene,
    overrides: Overrides = (),
    *,
    tighten: float | str,
    slip: float | str | None = None,
    displacement: float | str | None = None,
    loaded: Directions | None = None,
    free: Directions | None = None,
    free_load: float = 0.0,
    weight: bool = False,
    out: Out = None,
    force: bool = False,
    progress: Progress | bool = True,
) -> Run:
    """Tighten a knot, let its free ends go, pull until it slips: `holding_scene`, run.

    Args:
        source: see `holding_scene`, as all arguments that are not named here.
        overrides: likewise.
        tighten: likewise.
        slip: likewise.
        displacement: likewise.
        loaded: likewise.
        free: likewise.
        free_load: likewise.
        weight: likewise.
        out: folder for a run directory; True for runs/SCENE-N; None runs in memory.
        force: replace a run that is in the folder.
        progress: see `knotfem.api.pull`.

    Returns:
        The run, whose `holding()` tells the force.

    Raises:
        KnotfemError: see `holding_scene` and `knotfem.api.pull`.
    """
    scene = holding_scene(
        source,
        tighten,
        overrides,
        slip=slip,
        displacement=displacement,
        loaded=loaded,
        free=free,
        free_load=free_load,
        weight=weight,
    )
    return pull(scene, out=out, force=force, progress=progress)


def _length(given: float | str | None, key: str, default: float) -> float:
    if given is None:
        return default
    return parse_quantity(given, LENGTH, key) if isinstance(given, str) else float(given)
