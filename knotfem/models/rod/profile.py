"""Rows of the tables of discrete rods: tension and twist along the rods."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from knotfem.models.base import Row
from knotfem.models.rod.assembly import DiscreteRods
from knotfem.scene.rods import Rod


def tension_rows(
    rods: DiscreteRods, scene: Sequence[Rod], x: np.ndarray, time: float, displacement: float
) -> Iterator[Row]:
    """Rows of tension.csv: a row for each node.

    The tension is that of the nodal forces that one part of the rod exerts on the other, the mean of both sides of a
    node; the axial force of the segments is divided between core and bulk by their stiffness. What the rods bend by has
    no part in the axial force, so that the two are two ways to one figure.

    Args:
        rods: in the state last loaded.
        scene: what the user asked for.
        x: positions and rotations, shape [nodes, 4].
        time: [s].
        displacement: of the reported end [mm].
    """
    inner = np.zeros_like(x[:, :3])
    for term in (rods.stretch, rods.bend, rods.twist, *rods.damping):
        part = np.zeros_like(x)
        term.assemble(x, part, None)
        inner += part[:, :3]
    torque, moment = at_nodes(rods, x)[1::2]
    tension = rods.tension(x)
    for number, rod in enumerate(scene):
        nodes, core = rods.layout.of(number), rod.core_axial_stiffness / rod.axial_stiffness
        place = x[nodes, :3]
        edge = np.diff(place, axis=0)
        tangent = _to_nodes(edge / np.linalg.norm(edge, axis=1)[:, None])
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        force = _to_nodes(-np.cumsum(inner[nodes], axis=0)[:-1])
        along = np.einsum("ni,ni->n", force, tangent)
        across = np.linalg.norm(force - along[:, None] * tangent, axis=1)
        axial = _to_nodes(tension[rods.layout.rod[rods.layout.edges] == number])
        for i, s in enumerate(_arclength(rods, number)):
            yield {
                "displacement_mm": displacement,
                "arclength_mm": float(s),
                "s_over_L": i / (len(place) - 1),
                "tension_N": float(along[i]),
                "core_N": float(core * axial[i]),
                "bulk_N": float((1.0 - core) * axial[i]),
                "rod": rod.name,
                "time_s": time,
                "shear_N": float(across[i]),
                "bending_moment_Nmm": float(moment[nodes][i]),
                "torque_Nmm": float(torque[nodes][i]),
                "x_mm": float(place[i, 0]),
                "y_mm": float(place[i, 1]),
                "z_mm": float(place[i, 2]),
            }


def twist_rows(
    rods: DiscreteRods, scene: Sequence[Rod], x: np.ndarray, time: float, displacement: float
) -> Iterator[Row]:
    """Rows of twist.csv: a row for each node; see `tension_rows`."""
    twist, torque, curvature, moment = at_nodes(rods, x)
    for number, rod in enumerate(scene):
        first = rods.layout.of(number).start
        arclength = _arclength(rods, number)
        for i, s in enumerate(arclength):
            yield {
                "displacement_mm": displacement,
                "arclength_mm": float(s),
                "s_over_L": i / (len(arclength) - 1),
                "twist_rad_per_mm": float(twist[first + i]),
                "torque_Nmm": float(torque[first + i]),
                "curvature_per_mm": float(curvature[first + i]),
                "bending_moment_Nmm": float(moment[first + i]),
                "rod": rod.name,
                "time_s": time,
            }


def at_nodes(rods: DiscreteRods, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Twist per length [rad/mm], torque [N mm], curvature [1/mm], bending moment [N mm], shape [nodes] each.

    Internal damping has its part in the torque, not in the bending moment, which is that of the curvature.
    At an end they are those of its clamp, nothing where there is none.
    """
    frames = rods.frames
    where = np.concatenate([rods.layout.inner, frames.clamped])
    moment = np.linalg.norm(rods.bend.moment(x), axis=1)
    vertices = frames.twists(x) / frames.cell, rods.torque(x), rods.bend.curvature(x), moment
    nodes = np.zeros((4, rods.layout.nodes))
    nodes[:, where] = vertices
    return nodes[0], nodes[1], nodes[2], nodes[3]


def _arclength(rods: DiscreteRods, number: int) -> np.ndarray:
    nodes = rods.layout.of(number)
    return np.arange(nodes.stop - nodes.start) * rods.layout.spacing[number]


def _to_nodes(segments: np.ndarray) -> np.ndarray:
    """Means of the segments on either side of each node; at the ends there is one."""
    return np.concatenate([segments[:1], 0.5 * (segments[1:] + segments[:-1]), segments[-1:]])
