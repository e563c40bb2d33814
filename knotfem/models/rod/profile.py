"""Rows of the tables of discrete rods: tension and twist along the rods."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from knotfem.geometry.vectors import along_and_across
from knotfem.models.base import Row
from knotfem.models.profile import SectionForces, section_tangents, tension_rows
from knotfem.models.rod.assembly import DiscreteRods
from knotfem.scene.rods import Rod


def profile_rows(
    rods: DiscreteRods, scene: Sequence[Rod], x: np.ndarray, time: float, displacement: float
) -> Iterator[Row]:
    """Rows of tension.csv: a row for each node.

    The tension is that of the nodal forces that one part of the rod exerts on the other, taken from both sides to a
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
    for term in (rods.stretch, rods.bend, rods.twist, *(rods.damping or ())):
        part = np.zeros_like(x)
        term.assemble(x, part, None)
        inner += part[:, :3]
    torque, moment = at_nodes(rods, x)[1::2]
    tension = rods.tension(x)
    for number, rod in enumerate(scene):
        nodes, core = rods.layout.of(number), rod.core_axial_stiffness / rod.axial_stiffness
        slices = rods.layout.slices(number)
        force = slices.at_sections(-np.cumsum(inner[nodes], axis=0)[:-1])
        along, across = along_and_across(force, section_tangents(x[nodes, :3]))
        axial = slices.at_sections(tension[rods.layout.rod[rods.layout.edges] == number])
        forces = SectionForces(
            slices,
            x[nodes, :3],
            along,
            core * axial,
            (1.0 - core) * axial,
            across,
            moment[nodes],
            torque[nodes],
        )
        yield from tension_rows(rod.name, forces, time, displacement)


def twist_rows(
    rods: DiscreteRods, scene: Sequence[Rod], x: np.ndarray, time: float, displacement: float
) -> Iterator[Row]:
    """Rows of twist.csv: a row for each node; see `profile_rows`."""
    twist, torque, curvature, moment = at_nodes(rods, x)
    for number, rod in enumerate(scene):
        first, slices = rods.layout.of(number).start, rods.layout.slices(number)
        for i, (s, fraction) in enumerate(zip(slices.arclength, slices.fractions, strict=True)):
            yield {
                "displacement_mm": displacement,
                "arclength_mm": float(s),
                "s_over_L": float(fraction),
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
