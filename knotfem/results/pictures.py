"""Pictures of a run at a stored state."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from knotfem.errors import InputError
from knotfem.models.centreline import slices_of
from knotfem.models.solid.body import meshes_of
from knotfem.plot.render import Cylinder, Look, render_mesh, show_mesh, zoomed
from knotfem.results.fields import StateFields
from knotfem.results.view import camera_for, knot_points
from knotfem.run.colours import COLOURS, DIVERGING, OLDER
from knotfem.scene.model import Scene

_LOG = logging.getLogger("knotfem")
ZOOMS = (0.1, 100.0)
"""Smallest and largest zoom of a picture."""


def draw(
    fields: StateFields,
    scene: Scene,
    out: Path,
    colour: str = "strain",
    *,
    focus: Literal["all", "knot"] = "all",
    zoom: float = 1.0,
    view: Sequence[float] | None = None,
) -> None:
    """Draw the rods in a stored state into a PNG file.

    Args:
        fields: of the state.
        scene: of the run.
        out: file.
        colour: a key of `COLOURS`; curvature and twist are fields of the rod model only.
        focus: what fills the picture: "all" rods, or the "knot", where strands are close to each other, with the
            obstacle where they are close to it there.
        zoom: how many times as large, about the middle of the picture.
        view: direction from the knot to the eye, shape (3,); None for that of `knotfem.results.view.camera_for`.

    Raises:
        InputError: no such colour, no such field in the state, no knot to focus on, a zoom out of bounds, or no view.
        MissingDependency: pyvista or an OpenGL library is absent.
    """
    if not ZOOMS[0] <= zoom <= ZOOMS[1]:
        raise InputError("no such zoom", key="zoom", found=f"{zoom:g}", expected=f"{ZOOMS[0]:g} to {ZOOMS[1]:g}")
    look = _look(fields, scene, colour)
    lines = [fields.points[rings].mean(axis=1) for rings in look.rings]
    camera = replace(camera_for(scene, lines, view), zoom=zoom)
    if focus == "knot":
        camera = zoomed(camera, knot_points(scene, lines), 0.5 * max(rod.diameter for rod in scene.rods))
    render_mesh(fields.points, fields.cells, out, look, camera=camera)


def show(fields: StateFields, scene: Scene, colour: str = "strain") -> object:
    """Show the rods in a stored state in a window, or in a notebook's output.

    Args:
        fields: of the state.
        scene: of the run.
        colour: see `draw`.

    Returns:
        What pyvista's plotter gives back, such as a notebook's viewer.

    Raises:
        InputError: see `draw`.
        MissingDependency: see `draw`.
    """
    return show_mesh(fields.points, fields.cells, _look(fields, scene, colour))


def _look(fields: StateFields, scene: Scene, colour: str) -> Look:
    """How the rods and obstacles of a state are drawn."""
    scalars, label, colours = _scalars(fields, colour)
    return Look(
        scalars,
        _rings(scene, len(fields.points)),
        [Cylinder(o.point, o.axis, 0.5 * o.diameter) for o in scene.obstacles],
        label,
        colours,
        _symmetric(scalars) if colours == DIVERGING else None,
    )


def _scalars(fields: StateFields, colour: str) -> tuple[np.ndarray | None, str, str | tuple[str, ...]]:
    if colour in OLDER:
        _LOG.warning(
            'the colour "%s" is called "%s" now; the field "pressure" is the mean stress', colour, OLDER[colour]
        )
        colour = OLDER[colour]
    if colour not in COLOURS:
        raise InputError("no such colour", key="colour", found=colour, expected=", ".join(COLOURS))
    name, label, colours = COLOURS[colour]
    found = fields.cell_data.get(name, fields.point_data.get(name))
    if name and found is None:
        expected = "another colour, or a run of the rod model"
        raise InputError("this field is not stored", key="--colour", found=colour, expected=expected)
    return None if found is None else np.asarray(found, dtype=np.float64), label, colours


def _symmetric(values: np.ndarray | None) -> tuple[float, float] | None:
    """Limits of equal size with either sign; none where all values are zero."""
    size = 0.0 if values is None else float(np.abs(values).max())
    return (-size, size) if size > 0.0 else None


def _rings(scene: Scene, points: int) -> list[np.ndarray]:
    """Points around each section of each rod, shape [sections, around]."""
    if scene.model == "rod":
        sections = [slices.count + 1 for slices in slices_of(scene)]
        grid = np.arange(points).reshape(sum(sections), -1)
        return np.split(grid, np.cumsum(sections)[:-1])
    return [mesh.ring_nodes + first for mesh, first in meshes_of(scene)]
