"""Fields of discrete rods on the tubes that they are, for the time series that ParaView opens."""

from __future__ import annotations

import numpy as np

from knotfem.contact.report import ContactReport
from knotfem.geometry.frames import material_frames
from knotfem.geometry.measures import vertex_means
from knotfem.geometry.vectors import unit_vectors
from knotfem.mesh.rod import side_quads
from knotfem.mesh.rod_layout import RodLayout
from knotfem.mesh.section import regular_polygon
from knotfem.models.rod.assembly import DiscreteRods
from knotfem.models.rod.profile import at_nodes
from knotfem.models.series import Fields, SeriesMesh

AROUND = 24
"""Points around a tube."""
_COS, _SIN = regular_polygon(AROUND).T


def tube_rings(layout: RodLayout) -> list[np.ndarray]:
    """Points around each node of each rod, shape [nodes of the rod, AROUND]."""
    points = np.arange(layout.nodes * AROUND).reshape(layout.nodes, AROUND)
    return [points[layout.of(rod)] for rod in range(layout.rods)]


def tube_mesh(layout: RodLayout) -> SeriesMesh:
    """Quadrilaterals of the tubes; the reference is the straight rods along e_z."""
    cells, points = [], []
    for rod, ring in enumerate(tube_rings(layout)):
        cells.append(side_quads(ring))
        r, z = layout.radius[rod], layout.arclength[layout.of(rod)]
        x, y = np.broadcast_to(r * _COS, ring.shape), np.broadcast_to(r * _SIN, ring.shape)
        points.append(np.stack([x, y, np.broadcast_to(z[:, None], ring.shape)], axis=-1).reshape(-1, 3))
    reference = np.concatenate(points)
    constant = {"arclength": reference[:, 2], "rod": np.repeat(layout.rod, AROUND).astype(float)}
    return SeriesMesh(reference, np.concatenate(cells), constant)


def tube_fields(rods: DiscreteRods, found: ContactReport, x: np.ndarray, poissons_ratios: list[float]) -> Fields:
    """The tubes with tension, curvature, twist, contact pressure and the largest principal strain of their surface.

    The strain is Kirchhoff's: axial strain, plus curvature times the distance from the neutral axis, and the shear of
    the twist. The contact pressure is what carries each sample's force if it is spread as a cosine over the half of
    the circumference that faces it.

    Args:
        rods: in the state last loaded.
        found: samples in contact.
        x: positions and rotations, shape [nodes, 4].
        poissons_ratios: of the rods.
    """
    layout = rods.layout
    twist, _, curvature, _ = at_nodes(rods, x)
    tension, stretch = (_at_nodes(layout, values) for values in (rods.stretch.tension(x), rods.stretch.strain(x)))
    tangent, frames = _frames(rods, x)
    across = _COS[:, None] * frames[:, None, 0] + _SIN[:, None] * frames[:, None, 1]
    r = layout.radius[layout.rod][:, None]
    outer = -np.einsum("nai,ni->na", across, _bend_direction(rods, x, tangent)) * curvature[:, None] * r
    axial = np.log1p(np.maximum(stretch[:, None] + outer, -0.999))
    points = x[:, None, :3] + r[..., None] * across
    data = {
        "tension": _around(tension),
        "curvature": _around(curvature),
        "twist": _around(twist),
        "contact_pressure": contact_pressure(layout, found, x, across).ravel(),
        "largest_principal_strain": _largest_strain(axial, r * twist[:, None], np.array(poissons_ratios)[layout.rod]),
    }
    return Fields(points.reshape(-1, 3), data, {})


def contact_pressure(layout: RodLayout, found: ContactReport, x: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Pressure [MPa] at the points of the tubes, shape [nodes, AROUND]; see `tube_fields`.

    Args:
        layout: of the rods.
        found: samples in contact.
        x: positions, shape [nodes, 4].
        across: unit vectors from the axis to the points, shape [nodes, AROUND, 3].
    """
    pressure = np.zeros(across.shape[:2])
    if not found.rod.size:
        return pressure
    _, base, part = _on_axis(layout, x, found.rod, found.arclength)
    sides = [(found.rod, base, part, -found.normal, found.normal_force)]
    on_rods = found.other >= 0
    if on_rods.any():
        other = found.other[on_rods]
        _, there, weight = _on_axis(layout, x, other, found.other_arclength[on_rods])
        sides.append((other, there, weight, found.normal[on_rods], found.normal_force[on_rods]))
    cell = np.concatenate([vertex_means(layout.slices(rod).lengths) for rod in range(layout.rods)])
    for rod, node, ahead, direction, force in sides:
        for end, weight in ((0, 1.0 - ahead), (1, ahead)):
            line = force / cell[node + end] * 2.0 / (np.pi * layout.radius[rod])
            facing = np.maximum(np.einsum("kai,ki->ka", across[node + end], direction), 0.0)
            np.add.at(pressure, node + end, (line * weight)[:, None] * facing)
    return pressure


def _on_axis(
    layout: RodLayout, x: np.ndarray, rod: np.ndarray, arclength: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places at arclengths of rods, the node behind each, and the weight of the one ahead."""
    node = np.empty(rod.size, dtype=np.int64)
    for number in range(layout.rods):
        own, nodes = rod == number, layout.of(number)
        inner = layout.arclength[nodes][1:-1]
        node[own] = nodes.start + np.searchsorted(inner, arclength[own], side="right")
    part = np.clip((arclength - layout.arclength[node]) / layout.spacing[node], 0.0, 1.0)
    return (1.0 - part)[:, None] * x[node, :3] + part[:, None] * x[node + 1, :3], node, part


def _frames(rods: DiscreteRods, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tangents, shape [nodes, 3], and material frames, shape [nodes, 3, 3], at all nodes."""
    edges = rods.layout.edges
    tangent = unit_vectors(_at_nodes(rods.layout, rods.frames.current(x)[0][edges]))
    return tangent, material_frames(tangent, _at_nodes(rods.layout, rods.frames.material(x)[edges]))


def _bend_direction(rods: DiscreteRods, x: np.ndarray, tangent: np.ndarray) -> np.ndarray:
    """Unit vectors towards the centres of curvature, zero where a rod is straight, shape [nodes, 3]."""
    layout = rods.layout
    t = rods.frames.current(x)[0][: layout.nodes]
    inner = layout.inner
    towards = np.zeros_like(tangent)
    towards[inner] = t[inner] - t[inner - 1]
    for rod in range(layout.rods):
        nodes = layout.of(rod)
        towards[nodes.start], towards[nodes.stop - 1] = towards[nodes.start + 1], towards[nodes.stop - 2]
    towards -= np.einsum("ni,ni->n", towards, tangent)[:, None] * tangent
    size = np.linalg.norm(towards, axis=1)
    return towards / np.where(size > 1e-12, size, np.inf)[:, None]


def _largest_strain(axial: np.ndarray, shear: np.ndarray, poissons_ratio: np.ndarray) -> np.ndarray:
    """Largest eigenvalue of axial and hoop strain with the shear between them, or the radial strain."""
    lateral = -poissons_ratio[:, None] * axial
    mean, half = 0.5 * (axial + lateral), 0.5 * (axial - lateral)
    return np.maximum(mean + np.sqrt(half**2 + 0.25 * shear**2), lateral).ravel()


def _at_nodes(layout: RodLayout, edges: np.ndarray) -> np.ndarray:
    """Values on the edges of all rods taken to each node."""
    rod = layout.rod[layout.edges]
    return np.concatenate([layout.slices(number).at_sections(edges[rod == number]) for number in range(layout.rods)])


def _around(nodes: np.ndarray) -> np.ndarray:
    return np.repeat(nodes, AROUND)
