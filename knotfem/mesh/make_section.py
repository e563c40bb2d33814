"""The cross-section of a rod: one that ships, one that gmsh makes, or the user's own file."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from knotfem import shipped
from knotfem.errors import InputError
from knotfem.mesh.blocks import mesh_blocks
from knotfem.mesh.layout import LARGEST, layouts, nearest_count
from knotfem.mesh.numbering import number_section
from knotfem.mesh.quadratic import FIVE, five, quadratic
from knotfem.mesh.section import Section
from knotfem.mesh.section_file import read_section
from knotfem.mesh.smoothing import smooth


def make_section(elements: int) -> Section:
    """Mesh the unit disc with a chosen number of quadrilaterals (gmsh transfinite blocks, then smoothed).

    Args:
        elements: number of quadrilaterals, a key of `layouts()`; 44 is the paper's.

    Returns:
        The section, with the eight-fold mirror symmetry of the square.

    Raises:
        InputError: there is no layout with that many quadrilaterals.
        MissingDependency: gmsh or a system library that it loads is absent.
    """
    layout = layouts().get(elements)
    if layout is None:
        raise InputError(
            "no cross-section with that many elements",
            key="section_elements",
            found=elements,
            expected=f"{nearest_count(elements)}, the nearest that can be had",
        )
    smoothed = smooth(number_section(*mesh_blocks(layout)))
    return number_section(smoothed.points, smoothed.quads)


def possible_elements(elements: int, order: int = 1) -> int:
    """The number of quadrilaterals, next to the one asked for, with which a disc can be meshed well.

    Args:
        elements: asked for.
        order: 1 for quadrilaterals of four nodes, 2 of nine, of which five make a disc too.

    Raises:
        InputError: far more than any rod needs.
    """
    if elements > LARGEST:
        raise InputError(
            "too many elements in a cross-section",
            key="section_elements",
            found=elements,
            expected=f"at most {LARGEST}",
        )
    return FIVE if order == 2 and elements == FIVE else nearest_count(elements)


def section_of(elements: int, order: int = 1) -> Section:
    """A section with so many quadrilaterals, or with the nearest number that can be had (`possible_elements`).

    Args:
        elements: asked for.
        order: 1 for quadrilaterals of four nodes, 2 of nine.

    Returns:
        The shipped section where there is one, to the last bit; else one that gmsh makes.

    Raises:
        InputError: far more than any rod needs.
        MissingDependency: gmsh is needed and absent.
    """
    count = possible_elements(elements, order)
    if order == 2 and count == FIVE:
        return five()
    section = _linear(count)
    return section if order == 1 else quadratic(section)


def section_from(path: str | Path, order: int = 1) -> Section:
    """A section from a user's file.

    Args:
        path: see `read_section`.
        order: 1 for quadrilaterals of four nodes, 2 to raise them to nine.

    Raises:
        InputError: see `read_section`.
    """
    section = read_section(path)
    return section if order == 1 else quadratic(section)


def chosen_section(file: str | None, elements: int, order: int = 1) -> Section:
    """The section that a rod asks for: from the user's file where there is one, else with so many quadrilaterals.

    Args:
        file: see `section_from`.
        elements: see `section_of`.
        order: likewise.

    Raises:
        InputError: see `section_from` and `section_of`.
        MissingDependency: see `section_of`.
    """
    return section_of(elements, order) if file is None else section_from(file, order)


def other_count(elements: int, order: int = 1) -> str | None:
    """What must be said where a section cannot have the number of quadrilaterals asked for; None where it has it."""
    made = possible_elements(elements, order)
    if made == elements:
        return None
    return f"mesh.section_elements: asked for {elements} quadrilaterals, made {made}, the nearest that mesh a disc well"


@cache
def _linear(count: int) -> Section:
    if count in shipped.section_counts():
        return read_section(shipped.section_path(count))
    return make_section(count)
