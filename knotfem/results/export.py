"""A stored state of a run for other programs: mesh, fields, sets, and a deck that CalculiX runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.slices import Slices
from knotfem.mesh.deck import Solid, Springs, carried, deck, rigid_motion
from knotfem.mesh.export import Block, ExportMesh, rod_blocks, rod_sets, write_mesh
from knotfem.mesh.rod import RodMesh
from knotfem.models.centreline import slices_of
from knotfem.models.solid.body import meshes_of
from knotfem.results.fields import StateFields
from knotfem.results.run import Run
from knotfem.results.states import RunState
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod

AXIAL = ("tension", "curvature", "twist", "arclength", "rod")
"""Fields of the rod model that are the same all around a section; of others the largest value is taken."""
Meshes = Sequence[tuple[RodMesh, int]]
"""See `meshes_of`."""


def export(
    source: Run | RunState,
    path: str | Path,
    at: float | str | None = None,
    *,
    step: str | None = None,
    reference: bool = False,
) -> RunState:
    """Write the rods in a stored state as a mesh of the kind that the suffix names.

    Hexahedra have the groups `bulk` and `core`, the node sets `start`, `end` and `axis`, and (in `.msh`) the surfaces
    `start_face`, `end_face` and `side`; discrete rods are lines, the group `beam`, with the same node sets. Of several
    rods each name begins with that of its rod. Fields are those of the time series and `displacement`; see
    `knotfem.mesh.export.write_mesh` for what each format takes.

    A `.inp` file of hexahedra is a deck of static steps: with `reference` the straight rod, placed so that its start is
    where it is in the state, and its end is carried from there to where that is; without it the deformed mesh, free of
    stress, with its ends held.

    Args:
        source: a run, or one of its states.
        path: file with the suffix .inp, .msh, .vtu or .xdmf.
        at: stored displacement of a run over all its steps, [mm] or such as "60 mm", the nearest is taken; None for the
            last state.
        step: name of the step that the state is to be of; None for any.
        reference: write the straight rods instead of the deformed ones; fields are still those of the state.

    Returns:
        The state that was written.

    Raises:
        InputError: no such state or format, or the file cannot be written.
    """
    state = source.state(at, step) if isinstance(source, Run) else source
    fields, scene = state.fields, state.scene
    if scene.model == "rod":
        made = _lines(fields, scene, reference)
    else:
        meshes = meshes_of(scene)
        made = _hexahedra(fields, scene, meshes, reference)
        if Path(path).suffix.lower() == ".inp":
            made = _with_deck(made, fields, scene, meshes, reference)
    write_mesh(made, path)
    return state


def _hexahedra(fields: StateFields, scene: Scene, meshes: Meshes, reference: bool) -> ExportMesh:
    nodes = sum(len(mesh.nodes) for mesh, _ in meshes)
    if nodes != len(fields.points):
        problem, found = "the stored mesh is not that of the scene", f"{len(fields.points)} points"
        raise InputError(problem, found=found, expected=f"{nodes} points")
    blocks: list[Block] = []
    sets: dict[str, np.ndarray] = {}
    displacement = fields.points - fields.reference
    cell = 0
    for rod, (mesh, first) in zip(scene.rods, meshes, strict=True):
        prefix = _prefix(rod, scene)
        own = {name: values[cell : cell + len(mesh.hexes)] for name, values in fields.cell_data.items()}
        blocks += _with_fields(mesh, rod_blocks(mesh, first, prefix=prefix), own, rod.core is not None)
        sets |= rod_sets(mesh, first, prefix=prefix)
        cell += len(mesh.hexes)
    points = fields.reference if reference else fields.points
    return ExportMesh(points, blocks, {**fields.point_data, "displacement": displacement}, sets)


def _with_deck(made: ExportMesh, fields: StateFields, scene: Scene, meshes: Meshes, reference: bool) -> ExportMesh:
    """With the cards of a deck; straight rods are placed where they start."""
    materials: list[Solid | Springs] = []
    held: list[str] = []
    blocks = list(made.blocks)
    points, paths = made.points.copy(), []
    for rod, (mesh, first) in zip(scene.rods, meshes, strict=True):
        prefix = _prefix(rod, scene)
        materials += _materials(rod, mesh, prefix)
        for core in [block for block in blocks if block.group == f"{prefix}core"]:
            place = blocks.index(core)
            blocks[place : place + 1] = _in_groups(core, _core_groups(mesh, prefix))
        held += [f"{prefix}start"] if reference else [f"{prefix}start", f"{prefix}end"]
        if reference:
            own = slice(first, first + len(mesh.nodes))
            start, end = mesh.section_nodes[[0, -1]] + first
            rotation, before, after = rigid_motion(points[start], fields.points[start])
            points[own] = after + (points[own] - before) @ rotation.T
            paths.append((end, carried(points[end], fields.points[end])))
    stages: list[dict[int, np.ndarray]] = [{} for _ in range(max((len(path) for _, path in paths), default=0))]
    for end, path in paths:
        for number, stage in enumerate(stages):
            places = path[min(number, len(path) - 1)]
            stage |= {int(node): place - points[node] for node, place in zip(end, places, strict=True)}
    return replace(made, points=points, blocks=blocks, cards=deck(materials, held, stages))


def _with_fields(mesh: RodMesh, blocks: list[Block], cells: dict[str, np.ndarray], core: bool) -> list[Block]:
    """The hexahedra with their fields, the core with the tension of its slices, the surfaces as they are."""
    bulk, line, *surfaces = blocks
    parts = len(mesh.bricks) // len(mesh.hexes)
    data = {name: np.repeat(values, parts, axis=0) for name, values in cells.items()}
    found = [Block(bulk.group, bulk.kind, bulk.cells, bulk.abaqus, data)]
    if core:
        slices = {}
        if "tension" in cells:
            slices["tension"] = np.repeat(cells["tension"][:: len(mesh.section.quads)], mesh.span)
        found.append(Block(line.group, line.kind, line.cells, line.abaqus, slices))
    return found + surfaces


def _materials(rod: Rod, mesh: RodMesh, prefix: str) -> list[Solid | Springs]:
    law = rod.material
    found: list[Solid | Springs] = [Solid(f"{prefix}bulk", law.shear_modulus, law.bulk_modulus, law.density)]
    if rod.core is not None:
        lengths = [mesh.element_length] if Slices(mesh.lengths).equal else mesh.lengths
        names = _core_groups(mesh, prefix)
        found += [Springs(name, rod.core.axial_stiffness / h) for name, h in zip(names, lengths, strict=True)]
    return found


def _core_groups(mesh: RodMesh, prefix: str) -> list[str]:
    """The group of a core, or one for each edge where these differ in length and so in stiffness."""
    core = f"{prefix}core"
    return [core] if Slices(mesh.lengths).equal else [f"{core}_{i}" for i in range(mesh.slices)]


def _in_groups(block: Block, groups: Sequence[str]) -> list[Block]:
    """A core, cut into its groups."""
    if len(groups) == 1:
        return [block]
    edges = zip(groups, block.cells, strict=True)
    return [Block(name, block.kind, edge[None], block.abaqus) for name, edge in edges]


def _lines(fields: StateFields, scene: Scene, reference: bool) -> ExportMesh:
    """Centrelines of the tubes of the rod model, with the fields around each section brought to it."""
    counts = [slices.count + 1 for slices in slices_of(scene)]
    around = len(fields.points) // sum(counts)
    sections = fields.points.reshape(-1, around, 3).mean(axis=1)
    straight = fields.reference.reshape(-1, around, 3).mean(axis=1)
    data = {"displacement": sections - straight}
    for name, values in fields.point_data.items():
        if values.ndim == 1:
            rows = values.reshape(-1, around)
            data[name] = rows[:, 0].astype(np.float64) if name in AXIAL else rows.max(axis=1).astype(np.float64)
    blocks, sets, first = [], {}, 0
    for rod, count in zip(scene.rods, counts, strict=True):
        prefix, nodes = _prefix(rod, scene), first + np.arange(count)
        blocks.append(Block(f"{prefix}beam", "line", np.column_stack([nodes[:-1], nodes[1:]]), "B31"))
        sets |= {f"{prefix}start": nodes[:1], f"{prefix}end": nodes[-1:], f"{prefix}axis": nodes}
        first += count
    return ExportMesh(straight if reference else sections, blocks, data, sets)


def _prefix(rod: Rod, scene: Scene) -> str:
    return f"{rod.name}_" if len(scene.rods) > 1 else ""
