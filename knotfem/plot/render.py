"""Pictures of rods and cylinders, drawn off screen by pyvista."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.files import write_atomically
from knotfem.plot.colour_bar import BAR, add_colour_bar
from knotfem.plot.opengl import prepare
from knotfem.plot.scale_bar import STRIP, add_scale_bar, on_white
from knotfem.plot.surface import Surface, boundary, on_nodes, smooth_tube
from knotfem.types import Array, Index

PLAIN = ("#e08a2c", "#3f78b5", "#5aa469", "#b55d8c")
_HEIGHT = 1400
ROUNDING = 1e-6
"""Ends of the colour bar that are smaller, over its length, are zero: fields are stored in single precision."""
GLOSS: dict[str, Any] = {"ambient": 0.22, "diffuse": 0.75, "specular": 0.25, "specular_power": 25}


@dataclass(frozen=True)
class Cylinder:
    """A rigid cylinder to draw.

    Attributes:
        origin: point in the middle of its axis in mm, shape (3,).
        axis: direction of its axis, shape (3,).
        radius: in mm.
        length: in mm; infinite ones are drawn as far as the rods lie around them.
    """

    origin: ArrayLike
    axis: ArrayLike
    radius: float
    length: float = float("inf")

    def extent(self, cloud: Array) -> tuple[Array, Array, float]:
        """Middle, direction and length of the part that is drawn.

        Args:
            cloud: points of the rods in mm, shape (p, 3).
        """
        axis = np.asarray(self.axis, dtype=np.float64)
        axis = axis / np.linalg.norm(axis)
        origin = np.asarray(self.origin, dtype=np.float64)
        if np.isfinite(self.length):
            return origin, axis, self.length
        offset = cloud - origin
        along = offset @ axis
        around = np.linalg.norm(offset - along[:, None] * axis, axis=1) < 2 * self.radius
        span = along[around] if around.any() else np.array([-self.radius, self.radius])
        low, high = float(span.min()) - self.radius / 2, float(span.max()) + self.radius / 2
        return origin + axis * (low + high) / 2, axis, high - low


@dataclass(frozen=True, eq=False)
class Look:
    """What is drawn of rods of hexahedra, and in which colours.

    Attributes:
        scalars: what to colour by, on nodes, shape (N,), or on hexahedra, shape (E,) (then averaged to the nodes).
        rings: boundary nodes of each section, shape (n + 1, k), one array a rod: drawn as smooth tubes. Without them
            the faces of the hexahedra are drawn.
        cylinders: obstacles.
        label: name and unit of the scalar, beside the colour bar.
        colour_map: a matplotlib colour map, or colours from the lowest to the highest value.
        limits: smallest and largest value of the colour map; those of the drawn surface if left out.
    """

    scalars: Array | None = None
    rings: Sequence[Index] = ()
    cylinders: Sequence[Cylinder] = ()
    label: str = ""
    colour_map: str | tuple[str, ...] = "viridis"
    limits: tuple[float, float] | None = None

    def surfaces(self, points: Array, hexes: Index) -> list[Surface]:
        """Surfaces of rods, with their values.

        Args:
            points: see `render_mesh`.
            hexes: likewise.

        Raises:
            InputError: the arrays do not fit.
        """
        values = self.scalars
        if values is not None and len(values) == len(hexes) != len(points):
            values = on_nodes(hexes, np.asarray(values, dtype=np.float64), len(points))
        if values is not None and np.shape(values) != (len(points),):
            expected = f"{len(points)} on nodes or {len(hexes)} on hexahedra"
            raise InputError("scalars do not fit the mesh", found=f"shape {np.shape(values)}", expected=expected)
        if self.rings:
            return [smooth_tube(points[r], None if values is None else values[r]) for r in self.rings]
        return [boundary(points, hexes, values)]


@dataclass(frozen=True)
class Camera:
    """Where to look from.

    Attributes:
        direction: from the eye to the scene, shape (3,).
        up: direction that points up in the picture, shape (3,).
        target: points in mm that fill the picture, shape (m, 3); all rods if left out.
        margin: space around the target, as a fraction of the picture.
        zoom: how many times as large, about the middle of the target.
    """

    direction: ArrayLike = (0.25, 1.0, -0.12)
    up: ArrayLike = (0.0, 0.0, 1.0)
    target: Array | None = None
    margin: float = 0.06
    zoom: float = 1.0


def zoomed(camera: Camera, target: Array, radius: float) -> Camera:
    """The same view, framing points of a centreline and the rod around them.

    Args:
        camera: view.
        target: points in mm, shape (m, 3); see `knotfem.geometry.clearance.close_strands`.
        radius: of the rod in mm.
    """
    corners = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]) * radius
    return replace(camera, target=np.concatenate([target + corner for corner in corners]))


def render_mesh(
    points: Array,
    hexes: Index,
    out: str | Path,
    look: Look | None = None,
    *,
    title: str | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] | None = None,
) -> None:
    """Draw rods of hexahedra into a PNG file.

    Args:
        points: positions in mm, shape (N, 3).
        hexes: nodes of each hexahedron in VTK order, shape (E, 8).
        out: PNG file to write.
        look: what is drawn of them.
        title: heading.
        camera: view; from -y, z upwards, by default.
        size: width and height of the picture in pixels; fitted to the target if left out.

    Raises:
        InputError: the suffix is not .png, the arrays do not fit, or the file cannot be written.
        MissingDependency: pyvista or an OpenGL library is absent.
    """
    out, look = Path(out), look or Look()
    surfaces = look.surfaces(points, hexes)
    if out.suffix.lower() != ".png":
        raise InputError("no such picture format", file=out, found=out.suffix or "no suffix", expected=".png")
    prepare()
    import pyvista as pv

    coloured = any(surface.values is not None for surface in surfaces) or look.limits is not None
    view = _Frame(camera or Camera(), _cloud(surfaces), size, bar=coloured)
    plotter: Any = pv.Plotter(off_screen=True, window_size=list(view.size), lighting="none")
    try:
        plotter.set_background("white")
        mapper = _add_scene(plotter, surfaces, look)
        if mapper is not None:
            add_colour_bar(plotter, mapper)
            _text(plotter, look.label, left=False)
        if title:
            _text(plotter, title, left=True)
        view.look(plotter)
        add_scale_bar(plotter, 2.0 * view.scale / view.size[1])
        plotter.enable_anti_aliasing("ssaa")
        _save(plotter, out)
    finally:
        plotter.close()


def show_mesh(points: Array, hexes: Index, look: Look | None = None) -> object:
    """Show rods of hexahedra in a window, or in a notebook's output; arguments as for `render_mesh`.

    Returns:
        What pyvista's plotter gives back, such as a notebook's viewer.

    Raises:
        InputError: the arrays do not fit.
        MissingDependency: pyvista or an OpenGL library is absent.
    """
    look = look or Look()
    surfaces = look.surfaces(points, hexes)
    prepare(off_screen=False)
    import pyvista as pv

    plotter: Any = pv.Plotter()
    mapper = _add_scene(plotter, surfaces, look)
    if mapper is not None:
        plotter.add_scalar_bar(title=look.label, mapper=mapper)
    return plotter.show()


def _add_scene(plotter: Any, surfaces: Sequence[Surface], look: Look) -> Any:
    """Draw rods and obstacles; returns what colours the first rod by its values, or None without values."""
    mapper, cloud = None, _cloud(surfaces)
    limits = _limits(surfaces) if look.limits is None else look.limits
    colouring: dict[str, Any] = {
        "scalars": "values",
        "cmap": _colour_map(look),
        "clim": limits,
        "show_scalar_bar": False,
    }
    for i, surface in enumerate(surfaces):
        kind = {"color": PLAIN[i % len(PLAIN)]} if surface.values is None else colouring
        actor = plotter.add_mesh(polygons(surface), smooth_shading=bool(look.rings), **GLOSS, **kind)
        if surface.values is not None and mapper is None:
            mapper = actor.mapper
    for cylinder in look.cylinders:
        plotter.add_mesh(
            _cylinder(cylinder, cloud), color="#b9bec4", smooth_shading=True, split_sharp_edges=True, **GLOSS
        )
    return mapper


def _colour_map(look: Look) -> Any:
    if isinstance(look.colour_map, str):
        return look.colour_map
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("given", list(look.colour_map))


def _cloud(surfaces: Sequence[Surface]) -> Array:
    return np.concatenate([surface.points for surface in surfaces])


def _limits(surfaces: Sequence[Surface]) -> tuple[float, float] | None:
    values = [surface.values for surface in surfaces if surface.values is not None]
    if not values:
        return None
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    low, high = (0.0 if abs(end) <= ROUNDING * (high - low) else end for end in (low, high))
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def polygons(surface: Surface) -> Any:
    import pyvista as pv

    triangle = surface.faces[:, 2] == surface.faces[:, 3]
    quads, triangles = surface.faces[~triangle], surface.faces[triangle, :3]
    faces = [np.column_stack([np.full(len(part), part.shape[1]), part]).ravel() for part in (quads, triangles)]
    mesh = pv.PolyData(np.ascontiguousarray(surface.points), np.concatenate(faces))
    if surface.values is not None:
        mesh.point_data["values"] = surface.values
    return mesh


def _cylinder(cylinder: Cylinder, cloud: Array) -> Any:
    import pyvista as pv

    centre, axis, length = cylinder.extent(cloud)
    return pv.Cylinder(center=centre, direction=axis, radius=cylinder.radius, height=length, resolution=96)


def _text(plotter: Any, text: str, *, left: bool) -> None:
    """A line at the upper edge of the picture."""
    width, height = plotter.window_size
    margin = height // 50
    place = (margin if left else width - margin, height - margin)
    actor = plotter.add_text(text, position=place, font_size=height // 75, color="black")
    actor.prop.justification_horizontal = "left" if left else "right"
    actor.prop.justification_vertical = "top"
    on_white(actor)


class _Frame:
    """A parallel projection that fits the target, with room on the right for a colour bar and below for a scale."""

    def __init__(self, camera: Camera, cloud: Array, size: tuple[int, int] | None, *, bar: bool) -> None:
        forward = np.asarray(camera.direction, dtype=np.float64)
        self.forward = forward / np.linalg.norm(forward)
        right = np.cross(self.forward, np.asarray(camera.up, dtype=np.float64))
        self.right = right / np.linalg.norm(right)
        self.up = np.cross(self.right, self.forward)
        target = cloud if camera.target is None else np.asarray(camera.target)
        across, high = target @ self.right, target @ self.up
        width, height = float(np.ptp(across)), float(np.ptp(high))
        room = BAR if bar else 0.0
        ratio = float(np.clip(width / max(height, 1e-9), 0.55, 1.8)) + room
        self.size = (int(_HEIGHT * ratio), _HEIGHT) if size is None else size
        ratio = self.size[0] / self.size[1]
        fitted = max(height / 2 / (1 - STRIP), width / 2 / (ratio - room), 1e-6) * (1 + 2 * camera.margin)
        self.scale = fitted / camera.zoom
        middle = (across.min() + across.max()) / 2 + room * self.scale
        depth = float((cloud @ self.forward).mean())
        self.focus = (
            middle * self.right + ((high.min() + high.max()) / 2 - STRIP * self.scale) * self.up + depth * self.forward
        )
        self.reach = float(np.linalg.norm(np.ptp(cloud, axis=0))) + 1.0

    def look(self, plotter: Any) -> None:
        """Point the plotter's camera, with light from over the left shoulder."""
        import pyvista as pv

        plotter.camera.parallel_projection = True
        plotter.camera.parallel_scale = self.scale
        plotter.camera.focal_point = self.focus
        plotter.camera.position = self.focus - 2 * self.reach * self.forward
        plotter.camera.up = self.up
        plotter.camera.clipping_range = (0.5 * self.reach, 3.5 * self.reach)
        for offset, intensity in (
            (0.7 * self.up - 0.6 * self.right, 0.8),
            (0.8 * self.right - 0.2 * self.up, 0.25),
            (np.zeros(3), 0.2),
        ):
            eye = self.focus - self.forward + offset
            plotter.add_light(pv.Light(position=tuple(eye), focal_point=tuple(self.focus), intensity=intensity))


def _save(plotter: Any, out: Path) -> None:
    from PIL import Image

    picture = BytesIO()
    Image.fromarray(plotter.screenshot(return_img=True)).save(picture, format="PNG")
    write_atomically(out, picture.getvalue())
