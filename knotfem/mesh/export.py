"""Meshes for other programs: Gmsh `.msh`, VTK `.vtu`, XDMF `.xdmf`, Abaqus and CalculiX `.inp`, all through meshio."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from knotfem.errors import InputError, cannot_write
from knotfem.mesh.rod import RodMesh

if TYPE_CHECKING:
    import meshio

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_WIDTH = ".12e"
"""Numbers of a `.inp` file: CalculiX reads no more than 20 characters of each."""


@dataclass(frozen=True, eq=False)
class Block:
    """Cells of one kind that make a group.

    Attributes:
        group: its name.
        kind: meshio's name of the cells: "hexahedron", "quad" or "line".
        cells: points of each cell in VTK order, shape (E, n).
        abaqus: name of the element in Abaqus and CalculiX; "" for cells that only name a surface.
        data: arrays on the cells by name, shape (E,) or (E, c).
    """

    group: str
    kind: str
    cells: IntArray
    abaqus: str = ""
    data: Mapping[str, FloatArray] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class ExportMesh:
    """A mesh with fields and named sets.

    Attributes:
        points: places in mm, shape (N, 3).
        blocks: groups of cells.
        point_data: arrays on points by name, shape (N,) or (N, c).
        node_sets: points by name.
        cards: what a `.inp` file says after the mesh.
    """

    points: FloatArray
    blocks: list[Block]
    point_data: Mapping[str, FloatArray] = field(default_factory=dict)
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    cards: str = ""


def rod_blocks(mesh: RodMesh, first: int = 0, *, prefix: str = "", element: str = "C3D8I") -> list[Block]:
    """Groups of a rod of hexahedra: `bulk` and `core`, and the surfaces `start_face`, `end_face` and `side`.

    Quadratic hexahedra are cut into eight each.

    Args:
        mesh: the rod.
        first: number of its first node.
        prefix: of the names.
        element: Abaqus's name of the hexahedra; see `knotfem.mesh.deck`.
    """
    surface, q = mesh.surface + first, len(mesh.faces)
    sides = len(surface) - 2 * q
    return [
        Block(f"{prefix}bulk", "hexahedron", mesh.bricks + first, element),
        Block(f"{prefix}core", "line", mesh.core + first, "SPRINGA"),
        Block(f"{prefix}start_face", "quad", surface[sides : sides + q]),
        Block(f"{prefix}end_face", "quad", surface[sides + q :]),
        Block(f"{prefix}side", "quad", surface[:sides]),
    ]


def rod_sets(mesh: RodMesh, first: int = 0, *, prefix: str = "") -> dict[str, IntArray]:
    """Node sets of a rod: `start` and `end`, its end sections, and `axis`."""
    sets = {"start": mesh.section_nodes[0], "end": mesh.section_nodes[-1], "axis": mesh.axis_nodes}
    return {f"{prefix}{name}": nodes + first for name, nodes in sets.items()}


def write_mesh(mesh: ExportMesh, path: str | Path) -> None:
    """Write a mesh in the format that the suffix names.

    - `.msh` (Gmsh 2.2): all groups as physical groups, fields on points and cells;
    - `.vtu`, `.xdmf` (VTK and XDMF with an `.h5` file beside it): cells with volume or length, fields, the number of
      each cell's group as cell array `group`, and each node set as point array of 0 and 1;
    - `.inp` (Abaqus, CalculiX): nodes, elements, element and node sets, then the cards. It has no fields.

    Cells without a field that others have carry 0.

    Args:
        mesh: what to write.
        path: file to write; it and its companion are replaced only when the new ones are complete.

    Raises:
        InputError: no format has this suffix, or the file cannot be written.
    """
    path = Path(path)
    write = _WRITERS.get(path.suffix.lower())
    if write is None:
        raise InputError(
            "no such mesh format", file=path, found=path.suffix or "no suffix", expected=", ".join(_WRITERS)
        )
    folder = None
    try:
        folder = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            write(mesh, folder / path.name)
        for made in sorted(folder.iterdir(), key=lambda made: made.name == path.name):
            made.replace(path.with_name(made.name))
    except OSError as error:
        raise cannot_write(path, error) from error
    finally:
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)


def suffixes() -> list[str]:
    """Suffixes of the formats that can be written."""
    return list(_WRITERS)


def _msh(mesh: ExportMesh, path: Path) -> None:
    dimension = {"hexahedron": 3, "quad": 2, "line": 1}
    tags: list[Any] = [
        np.full(len(block.cells), number, dtype=np.int32) for number, block in enumerate(mesh.blocks, start=1)
    ]
    found = _meshio(mesh, mesh.blocks, _for_gmsh)
    found.cell_data = {"gmsh:physical": tags, "gmsh:geometrical": list(tags), **found.cell_data}
    found.field_data = {
        block.group: np.array([number, dimension[block.kind]]) for number, block in enumerate(mesh.blocks, start=1)
    }
    found.write(path, file_format="gmsh22", binary=False)


def _for_gmsh(values: NDArray[Any]) -> NDArray[Any]:
    """All nine components of symmetric tensors of six, xx yy zz xy yz xz, as Gmsh takes them.

    As Python's floats: of NumPy's, meshio 5.3 writes "np.float64(1.0)".
    """
    if values.ndim == 2 and values.shape[1] == 6:
        values = values[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]]
    return values.astype(np.float64).astype(object)


def _vtu(mesh: ExportMesh, path: Path) -> None:
    _with_sets(mesh).write(path, file_format="vtu")


def _xdmf(mesh: ExportMesh, path: Path) -> None:
    _with_sets(mesh).write(path, file_format="xdmf")


def _abaqus(mesh: ExportMesh, path: Path) -> None:
    import meshio

    blocks = _elements(mesh)
    nothing = np.empty(0, dtype=np.int64)
    sets: dict[str, Any] = {
        block.group: [np.arange(len(other.cells)) if other is block else nothing for other in blocks]
        for block in blocks
    }
    cells: list[Any] = [(block.kind, block.cells) for block in blocks]
    found = meshio.Mesh(mesh.points, cells, point_sets=dict(mesh.node_sets), cell_sets=sets)
    for elements, block in zip(found.cells, blocks, strict=True):
        elements.type = block.abaqus
    meshio.abaqus.write(path, found, float_fmt=_WIDTH, translate_cell_names=False)
    with path.open("a", encoding="utf-8") as file:
        file.write(mesh.cards)


def _elements(mesh: ExportMesh) -> list[Block]:
    return [block for block in mesh.blocks if block.abaqus]


def _with_sets(mesh: ExportMesh) -> meshio.Mesh:
    """Volumes and lines, with groups and node sets as arrays."""
    blocks = _elements(mesh)
    found = _meshio(mesh, blocks)
    found.cell_data["group"] = [np.full(len(block.cells), n, dtype=np.int64) for n, block in enumerate(blocks, start=1)]
    for name, nodes in mesh.node_sets.items():
        found.point_data[name] = np.isin(np.arange(len(mesh.points)), nodes).astype(np.int64)
    return found


def _meshio(
    mesh: ExportMesh, blocks: list[Block], stored: Callable[[NDArray[Any]], NDArray[Any]] = np.asarray
) -> meshio.Mesh:
    """Some groups with all fields, each as `stored` makes it."""
    import meshio

    shapes = {name: values.shape[1:] for block in blocks for name, values in block.data.items()}
    cell_data: dict[str, Any] = {
        name: [stored(block.data.get(name, np.zeros((len(block.cells), *tail)))) for block in blocks]
        for name, tail in shapes.items()
    }
    point_data: dict[str, Any] = {name: stored(values) for name, values in mesh.point_data.items()}
    cells: list[Any] = [(block.kind, block.cells) for block in blocks]
    return meshio.Mesh(mesh.points, cells, point_data=point_data, cell_data=cell_data)


_WRITERS: dict[str, Callable[[ExportMesh, Path], None]] = {
    ".inp": _abaqus,
    ".msh": _msh,
    ".vtu": _vtu,
    ".xdmf": _xdmf,
}
