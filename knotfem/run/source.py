"""The three-dimensional run from whose state the rod model sets out: read once, then kept in the new run's folder."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.errors import InputError
from knotfem.files import read_json, write_json
from knotfem.geometry.frames import material_frames, tangents
from knotfem.geometry.slices import Slices
from knotfem.mesh.rod import RodMesh
from knotfem.models.rod.initial import SourceRod
from knotfem.run.checkpoint import RunCheckpoint, read_checkpoint
from knotfem.run.directory import SOURCE, RunDirectory
from knotfem.scene.model import Scene

_KEPT = ("points", "fractions", "frames")


def source_rods(scene: Scene, folder: Path | None = None) -> list[SourceRod]:
    """The rods of the run that a scene names as its source, in the state that it names; none where it names no run.

    Args:
        scene: what is to be run.
        folder: of the run that sets out, which keeps what it has read and needs the source no more.

    Raises:
        InputError: no such run, it is not tied, of another model or of other rods or obstacles; or what was kept of it
            is damaged.
    """
    if scene.tie.source is None:
        return []
    if folder is None:
        return _read(scene)
    kept = folder / SOURCE
    if not kept.exists():
        rods = {rod.name: vars(left) for rod, left in zip(scene.rods, _read(scene), strict=True)}
        write_json(kept, {"run": scene.tie.source, "state": scene.tie.source_state, "rods": rods})
    try:
        rods = read_json(kept)["rods"]
        return [SourceRod(*(np.array(rods[rod.name][key]) for key in _KEPT)) for rod in scene.rods]
    except (KeyError, TypeError) as error:
        raise InputError(f"damaged ({error})", file=kept, expected="the rods of another run") from None


def _read(scene: Scene) -> list[SourceRod]:
    source = RunDirectory.open(str(scene.tie.source))
    if source.scene.model != "fem":
        raise InputError("the source is a rod run", file=source.path, key="model", found="rod", expected="fem")
    source.check_scene()
    ours, theirs = _compared(scene), _compared(source.scene)
    for key in [*ours, *theirs]:
        found, expected = theirs.get(key, "none"), ours.get(key, "none")
        if found != expected:
            raise InputError("differs from the scene", file=source.path, key=key, found=found, expected=expected)
    tied = source.tied_checkpoint()
    from knotfem.models.solid.body import meshes_of

    path = tied if scene.tie.source_state == "tied" else source.checkpoints.paths()[-1]
    x = np.asarray(RunCheckpoint.of(read_checkpoint(path)).simulation["now"]["state"]["x"])
    return [_framed(x[mesh.section_nodes + first], mesh) for mesh, first in meshes_of(source.scene)]


def _framed(sections: np.ndarray, mesh: RodMesh) -> SourceRod:
    """Axis and frames of the sections of a mesh, which lie at shape [sections, nodes a section, 3]."""
    points, d1 = sections[:, mesh.section.axis], mesh.nodes[mesh.section_nodes[0], 0]
    directors = np.einsum("k,ski->si", d1, sections - points[:, None])
    return SourceRod(points, Slices(mesh.lengths).fractions, material_frames(tangents(points), directors))


def _compared(scene: Scene) -> dict[str, str]:
    """What the source and the scene must have in common, by key."""
    material = {"youngs_modulus", "bulk_over_shear", "density"}
    rod = {"name": True, "length": True, "diameter": True, "material": material, "core": True}
    shared = {"rods": {"__all__": rod}, "obstacles": {"__all__": {"diameter", "point", "axis"}}}
    return dict(_leaves(scene.model_dump(mode="json", include=shared, exclude_none=True)))


def _leaves(value: Any, key: str = "") -> Iterator[tuple[str, str]]:
    if not isinstance(value, dict | list):
        yield key.removeprefix("."), str(value)
        return
    for part, item in value.items() if isinstance(value, dict) else enumerate(value):
        yield from _leaves(item, f"{key}.{part}")
