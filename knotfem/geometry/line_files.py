"""Curves in files of lines: XYZ, Wavefront OBJ, Geomview VECT."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.polyline import Polyline, polyline
from knotfem.geometry.text_table import read_table


def read_xyz(path: Path, text: str) -> list[Polyline]:
    """Curves of an XYZ file of atoms: their number, a comment, and a symbol and three numbers for each; or of a table.

    Args:
        path: of the file, for messages.
        text: its content.

    Raises:
        InputError: see `knotfem.geometry.text_table.read_table`; or fewer atoms than their number says.
    """
    lines = text.rstrip().splitlines()
    if not lines or not lines[0].strip().isdecimal():
        return read_table(path, text)
    curves: list[Polyline] = []
    at = 0
    while at < len(lines):
        try:
            atoms = range(at + 2, at + 2 + int(lines[at]))
            points = [[float(word) for word in lines[atom].split()[1:4]] for atom in atoms]
            curves.append(polyline(np.array(points).reshape(-1, 3), np.array(atoms, dtype=np.int64) + 1))
        except (ValueError, IndexError):
            problem = f"what begins in line {at + 1} is cut short or broken"
            expected = "the number of atoms, a comment, then a symbol and three numbers for each"
            raise InputError(problem, file=path, found=lines[at], expected=expected) from None
        at = atoms.stop
    return curves


def read_obj(path: Path, text: str) -> list[Polyline]:
    """Curves of a Wavefront OBJ file: vertices `v` and lines `l`; without lines, the vertices in their order.

    Lines that begin where the one before ends are one curve; one that ends at its first vertex is closed.

    Args:
        path: of the file, for messages.
        text: its content.

    Raises:
        InputError: a line of the file that is broken.
    """
    vertices: list[list[float]] = []
    where: list[int] = []
    chains: list[list[int]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        kind, *rest = line.split("#", 1)[0].split() or [""]
        try:
            if kind == "v":
                vertices.append([float(rest[i]) for i in range(3)])
                where.append(number)
            elif kind == "l":
                chain = [_vertex(entry, len(vertices)) for entry in rest]
                if chains and chain and chains[-1][-1] == chain[0]:
                    chains[-1] += chain[1:]
                elif chain:
                    chains.append(chain)
        except (ValueError, IndexError):
            expected = "three numbers after v, numbers of vertices after l"
            raise InputError(f"line {number} is broken", file=path, found=line.strip(), expected=expected) from None
    points, lines = np.array(vertices, dtype=np.float64).reshape(-1, 3), np.array(where, dtype=np.int64)
    curves = []
    for chain in chains or [list(range(len(points)))]:
        closed = len(chain) > 2 and chain[0] == chain[-1]
        rows = np.array(chain[: len(chain) - closed], dtype=np.int64)
        curves.append(polyline(points[rows], lines[rows], closed=closed))
    return curves


def _vertex(entry: str, count: int) -> int:
    """Index of a vertex, which OBJ counts from 1, or from the last one backwards."""
    number = int(entry.split("/")[0])
    index = number - 1 if number > 0 else count + number
    if not 0 <= index < count:
        raise IndexError
    return index


def read_vect(path: Path, text: str) -> list[Polyline]:
    """Curves of a Geomview VECT file; those with a negative count of vertices are closed.

    Args:
        path: of the file, for messages.
        text: its content.

    Raises:
        InputError: another file, or one that is cut short.
    """
    words = _words(text)
    if next(words, (0, ""))[1] != "VECT":
        raise InputError("not a VECT file", file=path, expected="VECT in its first line")
    try:
        polylines, vertices, _ = (int(next(words)[1]) for _ in range(3))
        counts = [int(next(words)[1]) for _ in range(polylines)]
        for _ in range(polylines):
            next(words)
        if sum(map(abs, counts)) != vertices:
            found = f"{sum(map(abs, counts))} vertices in its curves, {vertices} in its second line"
            raise InputError("the numbers of vertices differ", file=path, found=found)
        return [_vect_curve(words, count) for count in counts]
    except (ValueError, StopIteration, RuntimeError):
        expected = "VECT, numbers of curves, vertices and colours, then their data"
        raise InputError("the file is cut short or broken", file=path, expected=expected) from None


def _vect_curve(words: Iterator[tuple[int, str]], count: int) -> Polyline:
    lines: list[int] = []
    values: list[float] = []
    for _ in range(3 * abs(count)):
        line, word = next(words)
        lines.append(line)
        values.append(float(word))
    points = np.array(values, dtype=np.float64).reshape(-1, 3)
    return polyline(points, np.array(lines[::3], dtype=np.int64), closed=count < 0)


def _words(text: str) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(text.splitlines(), start=1):
        for word in line.split("#", 1)[0].split():
            yield number, word
