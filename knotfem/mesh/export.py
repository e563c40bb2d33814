"""Rod meshes for other programs: Gmsh `.msh`, VTK `.vtu`, Abaqus `.inp`, all through meshio."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from knotfem.errors import InputError
from knotfem.mesh.rod import RodMesh

if TYPE_CHECKING:
    import meshio

FloatArray = NDArray[np.float64]

BULK, CORE, LOADING_END, FREE_END, SIDE = range(1, 6)


def export(mesh: RodMesh, path: str | Path, nodes: FloatArray | None = None) -> None:
    """Write a rod as a mesh file of the kind that the suffix names, quadratic hexahedra cut in eight.

    The hexahedra are the group `bulk` and the trusses the group `core`. Beside them
    - `.msh` (Gmsh 2.2) has the surface groups `loading_end`, `free_end` and `side`;
    - `.vtu` (VTK) has the cell array `part` (1 bulk, 2 core) and the point array `arclength` in mm;
    - `.inp` (Abaqus) has the element types of the paper, C3D8H and T3D2, the element sets `bulk` and `core`, and the
      node sets `loading_end`, `free_end` and `axis`. It is a mesh: materials and steps are the user's.

    Args:
        mesh: the rod.
        path: file to write; replaced only when the new one is complete.
        nodes: positions in mm other than the reference, shape (N, 3).

    Raises:
        InputError: the suffix is none of the three, the positions do not fit, or the file cannot be written.
    """
    path = Path(path)
    writers = {".msh": _gmsh, ".vtu": _vtu, ".inp": _abaqus}
    write = writers.get(path.suffix.lower())
    if write is None:
        raise InputError(
            "no such mesh format", file=path, found=path.suffix or "no suffix", expected=", ".join(writers)
        )
    points = mesh.nodes if nodes is None else nodes
    if points.shape != mesh.nodes.shape:
        raise InputError("positions do not fit the mesh", found=points.shape, expected=f"shape {mesh.nodes.shape}")
    temporary = path.with_name(f".{path.name}.part")
    try:
        write(mesh, points, temporary)
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror or error})", file=path) from error
    finally:
        temporary.unlink(missing_ok=True)


def _gmsh(mesh: RodMesh, points: FloatArray, path: Path) -> None:
    import meshio

    surface, q = mesh.surface, len(mesh.faces)
    sides = len(surface) - 2 * q
    groups = [
        ("hexahedron", mesh.bricks, BULK),
        ("line", mesh.core, CORE),
        ("quad", surface[sides : sides + q], LOADING_END),
        ("quad", surface[sides + q :], FREE_END),
        ("quad", surface[:sides], SIDE),
    ]
    tags: list[ArrayLike] = [np.full(len(cells), tag, dtype=np.int32) for _, cells, tag in groups]
    names = {"bulk": (BULK, 3), "core": (CORE, 1), "loading_end": (LOADING_END, 2), "free_end": (FREE_END, 2)}
    names["side"] = (SIDE, 2)
    meshio.Mesh(
        points,
        [(kind, cells) for kind, cells, _ in groups],
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": list(tags)},
        field_data={name: np.array(tag) for name, tag in names.items()},
    ).write(path, file_format="gmsh22", binary=False)


def _vtu(mesh: RodMesh, points: FloatArray, path: Path) -> None:
    import meshio

    parts: list[ArrayLike] = [np.full(len(mesh.bricks), BULK), np.full(len(mesh.core), CORE)]
    meshio.Mesh(
        points,
        [("hexahedron", mesh.bricks), ("line", mesh.core)],
        point_data={"arclength": mesh.nodes[:, 2]},
        cell_data={"part": parts},
    ).write(path, file_format="vtu")


def _abaqus(mesh: RodMesh, points: FloatArray, path: Path) -> None:
    import meshio

    none = np.empty(0, dtype=np.int64)
    rod = meshio.Mesh(
        points,
        [("hexahedron", mesh.bricks), ("line", mesh.core)],
        point_sets={
            "loading_end": mesh.section_nodes[0],
            "free_end": mesh.section_nodes[-1],
            "axis": mesh.axis_nodes,
        },
        cell_sets={"bulk": [np.arange(len(mesh.bricks)), none], "core": [none, np.arange(len(mesh.core))]},
    )
    _name_elements(rod, "C3D8H", "T3D2")
    meshio.abaqus.write(path, rod, translate_cell_names=False)


def _name_elements(mesh: meshio.Mesh, *names: str) -> None:
    """Give the cell blocks Abaqus element names, which meshio cannot tell from the shape alone."""
    for block, name in zip(mesh.cells, names, strict=True):
        block.type = name
