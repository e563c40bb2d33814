"""Fields of the reduced model on the tubes that its rods are, for the time series that ParaView opens."""

from __future__ import annotations

import numpy as np

from knotfem.mesh.rod_layout import RodLayout
from knotfem.models.base import Fields, SeriesMesh
from knotfem.models.rod.model import RodModel
from knotfem.models.rod.profile import at_nodes

AROUND = 24
"""Points around a tube."""
_ANGLE = 2.0 * np.pi * np.arange(AROUND) / AROUND


def tube_rings(layout: RodLayout) -> list[np.ndarray]:
    """Points around each node of each rod, shape [nodes of the rod, AROUND]."""
    points = np.arange(layout.nodes * AROUND).reshape(layout.nodes, AROUND)
    return [points[layout.of(rod)] for rod in range(layout.rods)]


def tube_mesh(layout: RodLayout) -> SeriesMesh:
    """Quadrilaterals of the tubes; the reference is the straight rods along e_z."""
    cells, points = [], []
    for rod, ring in enumerate(tube_rings(layout)):
        ahead = np.roll(ring, -1, axis=1)
        cells.append(np.stack([ring[:-1], ahead[:-1], ahead[1:], ring[1:]], axis=-1).reshape(-1, 4))
        r, z = layout.radius[rod], np.arange(len(ring)) * layout.spacing[rod]
        x, y = np.broadcast_to(r * np.cos(_ANGLE), ring.shape), np.broadcast_to(r * np.sin(_ANGLE), ring.shape)
        points.append(np.stack([x, y, np.broadcast_to(z[:, None], ring.shape)], axis=-1).reshape(-1, 3))
    reference = np.concatenate(points)
    constant = {"arclength": reference[:, 2], "rod": np.repeat(layout.rod, AROUND).astype(float)}
    return SeriesMesh(reference, np.concatenate(cells), constant)


def tube_fields(model: RodModel, poissons_ratios: list[float]) -> Fields:
    """The tubes with tension, curvature, twist, contact pressure and the largest principal strain of their surface.

    The strain is Kirchhoff's: axial strain, plus curvature times the distance from the neutral axis, and the shear of
    the twist. The contact pressure is what carries each sample's force if it is spread as a cosine over the half of
    the circumference that faces it.

    Args:
        model: rods at the state.
        poissons_ratios: of the rods.
    """
    layout, x = model.layout, model.x
    twist, _, curvature, _ = at_nodes(model)
    tension, stretch = (_to_all_nodes(model, values) for values in (model.stretch.tension(x), model.stretch.strain(x)))
    tangent, normal = _directions(model)
    across = np.cos(_ANGLE)[:, None] * normal[:, None] + np.sin(_ANGLE)[:, None] * np.cross(tangent, normal)[:, None]
    r = layout.radius[layout.rod][:, None]
    outer = -np.einsum("nai,ni->na", across, _bend_direction(model, tangent)) * curvature[:, None] * r
    axial = np.log1p(np.maximum(stretch[:, None] + outer, -0.999))
    points = x[:, None, :3] + r[..., None] * across
    data = {
        "tension": _around(tension),
        "curvature": _around(curvature),
        "twist": _around(twist),
        "contact_pressure": contact_pressure(model, across).ravel(),
        "largest_principal_strain": _largest_strain(axial, r * twist[:, None], np.array(poissons_ratios)[layout.rod]),
    }
    return Fields(points.reshape(-1, 3), data, {})


def contact_pressure(model: RodModel, across: np.ndarray) -> np.ndarray:
    """Pressure [MPa] at the points of the tubes, shape [nodes, AROUND]; see `tube_fields`.

    Args:
        model: rods at the state.
        across: unit vectors from the axis to the points, shape [nodes, AROUND, 3].
    """
    layout, x = model.layout, model.x
    pressure = np.zeros(across.shape[:2])
    found = model.contacts()
    if not found.rod.size:
        return pressure
    here, base, part = _on_axis(layout, x, found.rod, found.arclength)
    onto, there = _facing(model, found.other, found.other_arclength, here)
    away = here - onto
    away /= np.linalg.norm(away, axis=1)[:, None]
    sides = [(found.rod, base, part, -away)]
    on_rods = found.other >= 0
    if there is not None:
        sides.append((found.other[on_rods], there[0], there[1], away[on_rods]))
    for side, (rod, node, share, direction) in enumerate(sides):
        force = found.normal_force if side == 0 else found.normal_force[on_rods]
        line = force / layout.spacing[rod] * 2.0 / (np.pi * layout.radius[rod])
        for end, weight in ((0, 1.0 - share), (1, share)):
            facing = np.maximum(np.einsum("kai,ki->ka", across[node + end], direction), 0.0)
            np.add.at(pressure, node + end, (line * weight)[:, None] * facing)
    return pressure


def _facing(
    model: RodModel, other: np.ndarray, arclength: np.ndarray, here: np.ndarray
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray] | None]:
    """The point that each sample presses on, and node and share of it for those on rods."""
    onto, there = np.empty_like(here), None
    rods = other >= 0
    if rods.any():
        onto[rods], base, part = _on_axis(model.layout, model.x, other[rods], arclength[rods])
        there = base, part
    for number, (cylinder, _) in enumerate(model.cylinders):
        mine = other == -1 - number
        offset = here[mine] - cylinder.origin
        onto[mine] = cylinder.origin + (offset @ cylinder.axis)[:, None] * cylinder.axis
    return onto, there


def _on_axis(
    layout: RodLayout, x: np.ndarray, rod: np.ndarray, arclength: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places at arclengths of rods, the node behind each, and the share of the one ahead."""
    count = np.diff(layout.first)[rod]
    u = np.clip(arclength / layout.spacing[rod], 0.0, count - 1.0)
    base = np.minimum(u.astype(np.int64), count - 2)
    part, node = u - base, layout.first[rod] + base
    return (1.0 - part)[:, None] * x[node, :3] + part[:, None] * x[node + 1, :3], node, part


def _directions(model: RodModel) -> tuple[np.ndarray, np.ndarray]:
    """Tangents and material directors at all nodes, shape [nodes, 3] each."""
    edges = model.layout.edges
    tangent = _unit(_to_all_nodes(model, model.frames.current(model.x)[0][edges]))
    director = _to_all_nodes(model, model.frames.material(model.x)[edges])
    return tangent, _unit(director - np.einsum("ni,ni->n", director, tangent)[:, None] * tangent)


def _bend_direction(model: RodModel, tangent: np.ndarray) -> np.ndarray:
    """Unit vectors towards the centres of curvature, zero where a rod is straight, shape [nodes, 3]."""
    t = model.frames.current(model.x)[0][: model.layout.nodes]
    inner = model.layout.inner
    towards = np.zeros_like(tangent)
    towards[inner] = t[inner] - t[inner - 1]
    for rod in range(model.layout.rods):
        nodes = model.layout.of(rod)
        towards[nodes.start], towards[nodes.stop - 1] = towards[nodes.start + 1], towards[nodes.stop - 2]
    towards -= np.einsum("ni,ni->n", towards, tangent)[:, None] * tangent
    size = np.linalg.norm(towards, axis=1)
    return towards / np.where(size > 1e-12, size, np.inf)[:, None]


def _largest_strain(axial: np.ndarray, shear: np.ndarray, poissons_ratio: np.ndarray) -> np.ndarray:
    """Largest eigenvalue of axial and hoop strain with the shear between them, or the radial strain."""
    lateral = -poissons_ratio[:, None] * axial
    mean, half = 0.5 * (axial + lateral), 0.5 * (axial - lateral)
    return np.maximum(mean + np.sqrt(half**2 + 0.25 * shear**2), lateral).ravel()


def _to_all_nodes(model: RodModel, edges: np.ndarray) -> np.ndarray:
    """Means of the values on the edges at each node."""
    layout = model.layout
    total, count = np.zeros((layout.nodes, *edges.shape[1:])), np.zeros(layout.nodes)
    for end in (0, 1):
        total[layout.edges + end] += edges
        count[layout.edges + end] += 1.0
    return total / count.reshape(-1, *[1] * (edges.ndim - 1))


def _around(nodes: np.ndarray) -> np.ndarray:
    return np.repeat(nodes, AROUND)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]
