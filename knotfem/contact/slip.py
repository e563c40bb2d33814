"""Slip between two material points in the plane of a contact, the traction that it mobilises, and derivatives."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.mobilisation import traction_at
from knotfem.geometry.rotation import across, across_rate, cross, dot, unit
from knotfem.types import Arrays


class SlipView(NamedTuple):
    """Friction of each contact of a discrete rod.

    Attributes:
        mu: coefficient, shape [contacts].
        own: angle, radial and axial coordinate of the secondary rod's material point, shape [contacts, 3].
        u: coordinate along the primary rod of its material point, shape [contacts]; of none on an obstacle.
        anchor: the other coordinates of that, as in `own`, or a point of the obstacle [mm].
        stored: slip of the last accepted step in the basis of the contact plane [mm], shape [contacts, 2].
        slip: size of the trial slip [mm], shape [contacts].
        traction: on the secondary rod [N], shape [contacts, 3].
        stick: distance over which friction is mobilised [mm].
    """

    mu: np.ndarray
    own: np.ndarray
    u: np.ndarray
    anchor: np.ndarray
    stored: np.ndarray
    slip: np.ndarray
    traction: np.ndarray
    stick: float


def slip_view(mu: np.ndarray, rows: Arrays, stick: float) -> SlipView:
    """From coefficients, what contacts remember, and the stick distance; nothing slips yet."""
    slip, traction = np.zeros(mu.size), np.zeros((mu.size, 3))
    return SlipView(mu, rows["own"], rows.get("u", np.zeros(0)), rows["anchor"], rows["stored"], slip, traction, stick)


class SlipRoom(NamedTuple):
    """Work space for the slip of one contact.

    Attributes:
        z: difference of the two material points, secondary minus primary [mm], shape [3].
        along: derivative of the secondary rod's centreline, shape [3].
        g: basis of the contact plane, along the secondary rod and across it, shape [2, 3].
        e: trial slip [mm], shape [3].
        size: of the trial slip, shape [1].
        width: length of `along` in the plane, shape [1].
        work: shape [3, 3].
        psi: psi/y of `knotfem.contact.mobilisation` at the trial slip, shape [1].
        M: derivative of the traction by the slip [N/mm], shape [3, 3].
    """

    z: np.ndarray
    along: np.ndarray
    g: np.ndarray
    e: np.ndarray
    size: np.ndarray
    width: np.ndarray
    work: np.ndarray
    psi: np.ndarray
    M: np.ndarray


@kernel
def slip_room() -> SlipRoom:
    """Work space for one contact."""
    return SlipRoom(
        np.empty(3), np.empty(3), np.empty((2, 3)), np.empty(3), np.empty(1), np.empty(1), np.empty((3, 3)),
        np.empty(1), np.empty((3, 3)),
    )  # fmt: skip


@kernel
def contact_basis(x: np.ndarray, base: int, rates: np.ndarray, n: np.ndarray, room: SlipRoom) -> None:
    """Fill `along`, `g` and `width`; `rates` (3) are the weights of the secondary rod's derivative."""
    along, g = room.along, room.g
    for i in range(3):
        along[i] = rates[0] * x[base, i] + rates[1] * x[base + 1, i] + rates[2] * x[base + 2, i]
    across(n, along, g[0])
    room.width[0] = unit(g[0], g[0])
    cross(n, g[0], g[1])


@kernel(inline="always")
def trial_slip(n: np.ndarray, stored: np.ndarray, room: SlipRoom) -> None:
    """Fill `e` and `size` from `z`, `g` and the slip of the last accepted step, shape [2]."""
    z, g, e = room.z, room.g, room.e
    across(n, z, e)
    for i in range(3):
        e[i] = e[i] + stored[0] * g[0, i] + stored[1] * g[1, i]
    room.size[0] = np.sqrt(dot(e, e))


@kernel(inline="always")
def slip_rate(
    n: np.ndarray, stored: np.ndarray, room: SlipRoom, rates: tuple[np.ndarray, np.ndarray, np.ndarray], de: np.ndarray
) -> None:
    """Derivative of the trial slip along those of z, n and `along` into de."""
    dz, dn, dalong = rates
    z, along, g, work = room.z, room.along, room.g, room.work
    across_rate(n, dn, along, dalong, work[0])
    stretch = dot(g[0], work[0])
    for i in range(3):
        work[0, i] = (work[0, i] - stretch * g[0, i]) / room.width[0]
    cross(dn, g[0], work[1])
    cross(n, work[0], work[2])
    across_rate(n, dn, z, dz, de)
    for i in range(3):
        de[i] += stored[0] * work[0, i] + stored[1] * (work[1, i] + work[2, i])


@kernel(inline="always")
def traction_of(room: SlipRoom, limit: float, stick: float, out: np.ndarray) -> None:
    """Traction into out, for the limit mu N [N], and `psi`."""
    room.psi[0] = traction_at(room.e, room.size[0], limit, stick, out)


@kernel(inline="always")
def traction_rate(room: SlipRoom, stick: float, de: np.ndarray, dlimit: float, out: np.ndarray) -> None:
    """Derivative of the traction along those of the slip and of the limit into out, from `M` and `psi`."""
    for i in range(3):
        out[i] = room.M[i, 0] * de[0] + room.M[i, 1] * de[1] + room.M[i, 2] * de[2]
        out[i] += dlimit * room.psi[0] / stick * room.e[i]


@kernel
def cut_slip(room: SlipRoom, stick: float, stored: np.ndarray) -> None:
    """Store the trial slip, cut to the stick distance, shape [2]."""
    scale = stick / room.size[0] if room.size[0] > stick else 1.0
    stored[0], stored[1] = scale * dot(room.e, room.g[0]), scale * dot(room.e, room.g[1])
