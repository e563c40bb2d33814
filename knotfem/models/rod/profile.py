"""Rows of the reduced model's tables: tension and twist along the rods."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from knotfem.models.base import Row
from knotfem.models.rod.model import RodModel


def tension_rows(
    model: RodModel, names: Sequence[str], core_shares: Sequence[float], time: float, displacement: float
) -> Iterator[Row]:
    """Rows of tension.csv: a row a node.

    The tension is that of the nodal forces that one part of the rod exerts on the other, the mean of both sides of a
    node; core and bulk share the axial force of the segments by their stiffness. What the rods bend by has no part in
    the axial force, so that the two are two ways to one figure.

    Args:
        model: rods at the state.
        names: of the rods.
        core_shares: share of each rod's core in its axial stiffness.
        time: [s].
        displacement: of the reported end [mm].
    """
    x = model.x
    inner = np.zeros_like(x[:, :3])
    for effect in (model.stretch, model.bend, model.twist, *(model.damping or ())):
        part = np.zeros_like(x)
        effect.assemble(x, part, None)
        inner += part[:, :3]
    torque, moment = at_nodes(model)[1::2]
    for number, (name, share) in enumerate(zip(names, core_shares, strict=True)):
        nodes = model.layout.of(number)
        place = x[nodes, :3]
        edge = np.diff(place, axis=0)
        tangent = _to_nodes(edge / np.linalg.norm(edge, axis=1)[:, None])
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        force = _to_nodes(-np.cumsum(inner[nodes], axis=0)[:-1])
        along = np.einsum("ni,ni->n", force, tangent)
        across = np.linalg.norm(force - along[:, None] * tangent, axis=1)
        axial = _to_nodes(model.tension(number))
        for i, s in enumerate(_arclength(model, number)):
            yield {
                "displacement_mm": displacement,
                "arclength_mm": float(s),
                "s_over_L": i / (len(place) - 1),
                "tension_N": float(along[i]),
                "core_N": float(share * axial[i]),
                "bulk_N": float((1.0 - share) * axial[i]),
                "rod": name,
                "time_s": time,
                "shear_N": float(across[i]),
                "bending_moment_Nmm": float(moment[nodes][i]),
                "torque_Nmm": float(torque[nodes][i]),
                "x_mm": float(place[i, 0]),
                "y_mm": float(place[i, 1]),
                "z_mm": float(place[i, 2]),
            }


def twist_rows(model: RodModel, names: Sequence[str], time: float, displacement: float) -> Iterator[Row]:
    """Rows of twist.csv: a row a node; see `tension_rows`."""
    twist, torque, curvature, moment = at_nodes(model)
    for number, name in enumerate(names):
        first = model.layout.of(number).start
        arclength = _arclength(model, number)
        for i, s in enumerate(arclength):
            yield {
                "displacement_mm": displacement,
                "arclength_mm": float(s),
                "s_over_L": i / (len(arclength) - 1),
                "twist_rad_per_mm": float(twist[first + i]),
                "torque_Nmm": float(torque[first + i]),
                "curvature_per_mm": float(curvature[first + i]),
                "bending_moment_Nmm": float(moment[first + i]),
                "rod": name,
                "time_s": time,
            }


def at_nodes(model: RodModel) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Twist per length [rad/mm], torque [N mm], curvature [1/mm], bending moment [N mm], shape [nodes] each.

    Internal damping has its part in the torque, not in the bending moment, which is that of the curvature.
    At an end they are those of its clamp, nothing where there is none.
    """
    frames, x = model.frames, model.x
    where = np.concatenate([model.layout.inner, np.array([clamp.node for clamp in frames.clamps], dtype=np.int64)])
    moment = np.linalg.norm(model.bend.moment(x), axis=1)
    torque = model.twist.torque(x)
    if model.damping is not None:
        torque = torque + model.damping.twist.torque(x)
    hinges = frames.twists(x) / frames.cell, torque, model.bend.curvature(x), moment
    nodes = np.zeros((4, model.layout.nodes))
    nodes[:, where] = hinges
    return nodes[0], nodes[1], nodes[2], nodes[3]


def _arclength(model: RodModel, number: int) -> np.ndarray:
    nodes = model.layout.of(number)
    return np.arange(nodes.stop - nodes.start) * model.layout.spacing[number]


def _to_nodes(segments: np.ndarray) -> np.ndarray:
    """Means of the segments on either side of each node; at the ends there is one."""
    return np.concatenate([segments[:1], 0.5 * (segments[1:] + segments[:-1]), segments[-1:]])
