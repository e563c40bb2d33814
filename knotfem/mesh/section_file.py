"""Cross-sections in files: any format of meshio is read, Gmsh's is written."""

from __future__ import annotations

from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.files import check_regular
from knotfem.mesh.numbering import number_section
from knotfem.mesh.section import Section
from knotfem.mesh.section_check import unit_disc

if TYPE_CHECKING:
    import meshio

_IGNORED = ("vertex", "line", "line3")
"""Cells that groups of nodes and edges leave in a file."""
_LEFT_OUT = ("ansys",)
"""Formats whose reader in meshio does not end where a file is cut off."""


def read_section(path: str | Path) -> Section:
    """Read a cross-section mesh and verify it.

    The file holds a disc of any size in any plane, meshed by quadrilaterals of four nodes: .msh, .vtk, .vtu, .inp and
    whatever else meshio reads. It is scaled to radius 1 about its axis node, and turned by at most half a step of the
    boundary so that a boundary node lies at angle 0.

    Args:
        path: mesh file.

    Raises:
        InputError: the file is missing or unreadable, or holds something else than such a disc with a node on its
            axis and boundary nodes at equal angles; see `section_check`.
    """
    path = Path(path)
    check_regular(path)
    mesh = _read(path)
    others = sorted({block.type for block in mesh.cells} - {"quad", *_IGNORED})
    blocks = [block.data for block in mesh.cells if block.type == "quad" and len(block.data)]
    if others or not blocks:
        found = ", ".join(others or sorted({block.type for block in mesh.cells})) or "no cells"
        raise InputError(
            "a cross-section holds quadrilaterals of four nodes and nothing else",
            file=path,
            found=found,
            expected="quad cells (in gmsh: recombine the surface, order 1)",
        )
    quads = np.concatenate(blocks).astype(np.int64)
    if quads.min() < 0 or quads.max() >= len(mesh.points):
        raise InputError(
            "a quadrilateral names a node that is not there",
            file=path,
            found=f"node number {quads.max() + 1}",
            expected=f"at most {len(mesh.points)}",
        )
    points, quads = unit_disc(np.asarray(mesh.points, dtype=np.float64), quads, path)
    return number_section(points, quads, path)


def write_section(section: Section, path: str | Path) -> None:
    """Write a cross-section as Gmsh 2.2 text, with the physical groups `section`, `ring` and `axis`.

    Args:
        section: the cross-section, of four-node quadrilaterals.
        path: file to write; read back by `read_section`.
    """
    import meshio

    edges = np.column_stack([section.ring, np.roll(section.ring, -1)])
    points = np.column_stack([section.points, np.zeros(len(section.points))])
    cells = [("quad", section.quads), ("line", edges), ("vertex", np.array([[section.axis]]))]
    tags: list[ArrayLike] = [np.full(len(block), tag, dtype=np.int32) for tag, (_, block) in enumerate(cells, start=1)]
    names = {"section": np.array([1, 2]), "ring": np.array([2, 1]), "axis": np.array([3, 0])}
    mesh = meshio.Mesh(
        points,
        cells,
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": list(tags)},
        field_data=names,
    )
    mesh.write(path, file_format="gmsh22", binary=False)


def _read(path: Path) -> meshio.Mesh:
    """A mesh in any format that the suffix may stand for; meshio itself would print, and end the process."""
    import meshio

    if not path.is_file():
        raise InputError("no such cross-section mesh", file=path, expected="a mesh file")
    named = meshio.extension_to_filetypes.get(path.suffix.lower(), [])
    formats = [name for name in dict.fromkeys(named) if name not in _LEFT_OUT]
    if not formats:
        known = ", ".join(sorted(meshio.extension_to_filetypes))
        raise InputError("no mesh format has this suffix", file=path, found=path.suffix or "none", expected=known)
    problems = []
    for name in formats:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            try:
                return meshio.read(path, file_format=name)
            except (Exception, SystemExit) as error:  # a damaged file makes the readers raise anything
                problems.append(f"{name}: {' '.join(str(error).split()) or type(error).__name__}")
    raise InputError(f"cannot be read as a mesh ({'; '.join(problems)})", file=path, expected="a sound mesh file")
