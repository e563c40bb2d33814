"""Slip of a spring between two material points in the plane of a contact, and its derivatives."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.law import sliding_work
from knotfem.geometry.rotation import cross, dot


class SpringView(NamedTuple):
    """Friction of each contact of a discrete rod.

    Attributes:
        mu: coefficient, shape [contacts].
        own: angle, radial and axial coordinate of the secondary rod's material point, shape [contacts, 3].
        u: coordinate along the primary rod of its material point, shape [contacts]; of none on an obstacle.
        anchor: the other coordinates of that, as in `own`, or a point of the obstacle [mm].
        stored: elastic slip in the basis of the contact plane [mm], shape [contacts, 2].
        slip: size of the trial slip [mm], shape [contacts].
        traction: on the secondary rod [N], shape [contacts, 3].
        spring: tangential line stiffness [N/mm^2].
    """

    mu: np.ndarray
    own: np.ndarray
    u: np.ndarray
    anchor: np.ndarray
    stored: np.ndarray
    slip: np.ndarray
    traction: np.ndarray
    spring: float


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
    """

    z: np.ndarray
    along: np.ndarray
    g: np.ndarray
    e: np.ndarray
    size: np.ndarray
    width: np.ndarray
    work: np.ndarray


@kernel
def slip_room() -> SlipRoom:
    """Work space for one contact."""
    return SlipRoom(np.empty(3), np.empty(3), np.empty((2, 3)), np.empty(3), np.empty(1), np.empty(1), np.empty((3, 3)))


@kernel
def contact_basis(x: np.ndarray, base: int, rates: np.ndarray, n: np.ndarray, room: SlipRoom) -> None:
    """Fill `along`, `g` and `width`; `rates` (3) are the weights of the secondary rod's derivative."""
    along, g = room.along, room.g
    for i in range(3):
        along[i] = rates[0] * x[base, i] + rates[1] * x[base + 1, i] + rates[2] * x[base + 2, i]
    part = dot(n, along)
    for i in range(3):
        g[0, i] = along[i] - part * n[i]
    size = np.sqrt(dot(g[0], g[0]))
    for i in range(3):
        g[0, i] /= size
    cross(n, g[0], g[1])
    room.width[0] = size


@kernel(inline="always")
def trial_slip(n: np.ndarray, stored: np.ndarray, room: SlipRoom) -> None:
    """Fill `e` and `size` from `z`, `g` and the elastic slip of the last accepted step, shape [2]."""
    z, g, e = room.z, room.g, room.e
    along = dot(n, z)
    for i in range(3):
        e[i] = z[i] - along * n[i] + stored[0] * g[0, i] + stored[1] * g[1, i]
    room.size[0] = np.sqrt(dot(e, e))


@kernel(inline="always")
def slip_rate(
    n: np.ndarray, stored: np.ndarray, room: SlipRoom, rates: tuple[np.ndarray, np.ndarray, np.ndarray], de: np.ndarray
) -> None:
    """Derivative of the trial slip along those of z, n and `along` into de."""
    dz, dn, dalong = rates
    z, along, g, work = room.z, room.along, room.g, room.work
    nz, na = dot(n, z), dot(n, along)
    turn = dot(n, dz) + dot(dn, z)
    lean = dot(n, dalong) + dot(dn, along)
    for i in range(3):
        work[0, i] = dalong[i] - dn[i] * na - n[i] * lean
    stretch = dot(g[0], work[0])
    for i in range(3):
        work[0, i] = (work[0, i] - stretch * g[0, i]) / room.width[0]
    cross(dn, g[0], work[1])
    cross(n, work[0], work[2])
    for i in range(3):
        de[i] = dz[i] - dn[i] * nz - n[i] * turn
        de[i] += stored[0] * work[0, i] + stored[1] * (work[1, i] + work[2, i])


@kernel(inline="always")
def traction_of(room: SlipRoom, stiffness: float, limit: float, out: np.ndarray) -> bool:
    """Traction into out; returns whether the contact slides."""
    scale = stiffness
    slides = stiffness * room.size[0] > limit
    if slides:
        scale = limit / room.size[0]
    for i in range(3):
        out[i] = scale * room.e[i]
    return slides


@kernel(inline="always")
def traction_rate(
    room: SlipRoom, stiffness: float, limit: float, slides: bool, de: np.ndarray, dlimit: float, out: np.ndarray
) -> None:
    """Derivative of the traction along those of the slip and of the limit into out."""
    if not slides:
        for i in range(3):
            out[i] = stiffness * de[i]
        return
    e, size = room.e, room.size[0]
    along = dot(e, de) / (size * size)
    for i in range(3):
        out[i] = limit / size * (de[i] - along * e[i]) + dlimit * e[i] / size


@kernel
def release_slip(spring: float, stored: np.ndarray) -> float:
    """Let a contact without friction forget its elastic slip, shape [2]; returns the work that is lost [N mm]."""
    before = np.sqrt(stored[0] ** 2 + stored[1] ** 2)
    stored[0] = stored[1] = 0.0
    return sliding_work(spring, before, 0.0, before)


@kernel
def cut_slip(room: SlipRoom, spring: float, limit: float, stored: np.ndarray) -> tuple[float, float]:
    """Store the trial slip, cut to the limit, shape [2]; returns work of sliding and energy that stays [N mm]."""
    size, lost, scale = room.size[0], 0.0, 1.0
    if spring * size > limit:
        before = np.sqrt(stored[0] ** 2 + stored[1] ** 2)
        scale = limit / (spring * size)
        lost = sliding_work(spring, before, scale * size, size)
    stored[0], stored[1] = scale * dot(room.e, room.g[0]), scale * dot(room.e, room.g[1])
    return lost, 0.5 * spring * (scale * size) ** 2
