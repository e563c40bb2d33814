"""Pictures of a run at a stored state."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.models.solid.body import mesh_of
from knotfem.plot.frames import read_frame, read_mesh, read_times
from knotfem.plot.render import Cylinder, render_mesh
from knotfem.results.profile import stored_states
from knotfem.run.directory import RunDirectory
from knotfem.scene.model import Scene

DIVERGING = "coolwarm"
"""Map of values of either sign, nothing in its middle."""
COLOURS = {
    "strain": ("largest_principal_strain", "largest principal strain (logarithmic)", "viridis"),
    "tension": ("tension", "tension [N]", "plasma"),
    "pressure": ("contact_pressure", "contact pressure [MPa]", "inferno"),
    "curvature": ("curvature", "curvature [1/mm]", "viridis"),
    "twist": ("twist", "twist [rad/mm]", DIVERGING),
    "none": ("", "", "viridis"),
}


def render(run: RunDirectory, out: Path, colour: str = "strain", at: float | None = None) -> None:
    """Draw the rods of a run into a PNG file.

    Args:
        run: with a time series.
        out: file.
        colour: a key of `COLOURS`; curvature and twist are fields of the rod model only.
        at: stored displacement [mm], the nearest is taken; None for the last state.

    Raises:
        InputError: no series, nothing stored near `at`, or no such field in it.
        MissingDependency: pyvista or an OpenGL library is absent.
    """
    path = run.path / "results.vtkhdf"
    if not path.exists():
        raise InputError("no time series is stored", file=run.path, expected="a run with output.fields = true")
    frame = read_frame(path, _frame_number(run, path, at))
    _, cells = read_mesh(path)
    name, label, colours = COLOURS[colour]
    scalars = frame.point_data.get(name, frame.cell_data.get(name))
    if name and scalars is None:
        expected = "another colour, or a run of the rod model"
        raise InputError("this field is not stored", file=path, key="--colour", found=colour, expected=expected)
    cylinders = [Cylinder(o.point, o.axis, 0.5 * o.diameter) for o in run.scene.obstacles]
    render_mesh(
        frame.points,
        cells,
        out,
        scalars=None if scalars is None else np.asarray(scalars, dtype=np.float64),
        rings=_rings(run.scene, len(frame.points)),
        cylinders=cylinders,
        label=label,
        colour_map=colours,
        limits=_around_nothing(scalars) if colours == DIVERGING else None,
    )


def _around_nothing(values: np.ndarray | None) -> tuple[float, float] | None:
    """Limits as far below nothing as above; none where all is nothing."""
    size = 0.0 if values is None else float(np.abs(values).max())
    return (-size, size) if size > 0.0 else None


def _rings(scene: Scene, points: int) -> list[np.ndarray]:
    """Points around each section of each rod, shape [sections, around]."""
    if scene.model == "rod":
        sections = [rod.slices + 1 for rod in scene.rods]
        grid = np.arange(points).reshape(sum(sections), -1)
        return np.split(grid, np.cumsum(sections)[:-1])
    rings, first = [], 0
    for rod in scene.rods:
        mesh = mesh_of(rod)
        rings.append(mesh.ring_nodes + first)
        first += len(mesh.nodes)
    return rings


def _frame_number(run: RunDirectory, path: Path, at: float | None) -> int:
    times = read_times(path)
    if not len(times):
        raise InputError("no state is stored yet", file=path)
    if at is None:
        return -1
    time, _ = stored_states(run).nearest(at)
    return int(np.argmin(np.abs(times - time)))
