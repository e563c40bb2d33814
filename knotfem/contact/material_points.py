"""Material points near the smooth centreline: where they are, how they move, and how that changes.

A material point has the coordinates (u, angle, radial, axial): at the point u of the curve, of unit tangent t, it lies
at radial nu + axial t, where nu stands at `angle` from the interpolated material frame. Between the middles of two
edges a and b (u goes from lambda = 0 to 1) that frame is the director of edge a, carried along the great circle to t
and turned by its rotation about the edge and by lambda times the twist m of the vertex: continuous along the whole rod,
and a function of the state alone, so that a rigidly moved rod carries its points with it.

With c the curve's derivative, c = |c| t, the cross-section spins about t by

    w  = (1 - lambda) dtheta_a + lambda dtheta_b + g_a . de_a + g_b . de_b
    g_a = [lambda k(a, b) - (1 - lambda) k(a0, a) - k(a, t)]/|e_a| - (1 - lambda) k(a, t)/|c|
    g_b = [lambda k(a, b) - lambda k(b0, b)]/|e_b| - lambda k(a, t)/|c|

(k in `knotfem.geometry.rotation`, a0 and b0 the directions of the accepted state); how a point on it then moves, see
`knotfem.contact.arms`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.material_frames import FrameView
from knotfem.geometry.rotation import (
    angle_about,
    cross,
    dot,
    half_binormal,
    nearest_turn,
    transport,
    unit,
)

A, B, T, NU, MU, KAB, KA0, KB0, KAT, GA, GB = range(11)
"""Rows of `MaterialRoom.V`: directions of the edges and of the curve, nu, t x nu, the four k, g_a, g_b."""


class MaterialRoom(NamedTuple):
    """Vectors and scalars that describe one material point, and work space.

    Attributes:
        V: shape [11, 3], see above.
        L: lengths of the two edges and of the curve's derivative, shape [8].
        work: shape [16, 3].
    """

    V: np.ndarray
    L: np.ndarray
    work: np.ndarray


@kernel
def material_room() -> MaterialRoom:
    """Work space for one point."""
    return MaterialRoom(np.empty((11, 3)), np.empty(8), np.empty((16, 3)))


@kernel
def material_frame(x: np.ndarray, base: int, share: float, frames: FrameView, angle: float, room: MaterialRoom) -> None:
    """Fill `room` for a point between the edges base and base + 1, at the fraction `share` of the way."""
    tangent0, director0, turn0, per_radius = frames
    V, L = room.V, room.L
    j = base
    f, g, v = V[GA], V[GB], V[KAT]
    for i in range(3):
        V[A, i], V[B, i] = x[j + 1, i] - x[j, i], x[j + 2, i] - x[j + 1, i]
        V[T, i] = (1.0 - share) * V[A, i] + share * V[B, i]
    L[0], L[1], L[2] = unit(V[A], V[A]), unit(V[B], V[B]), unit(V[T], V[T])
    transport(tangent0[j], V[A], director0[j], f)
    transport(tangent0[j + 1], V[B], director0[j + 1], g)
    transport(V[A], V[B], f, v)
    turn = nearest_turn(angle_about(V[B], v, g), turn0[j])
    near, far = x[j, 3] * per_radius[j], x[j + 1, 3] * per_radius[j + 1]
    beta = angle + near + share * (far - near + turn)
    transport(V[A], V[T], f, v)
    cross(V[T], v, V[MU])
    c, s = math.cos(beta), math.sin(beta)
    for i in range(3):
        V[NU, i] = c * v[i] + s * V[MU, i]
    cross(V[T], V[NU], V[MU])
    half_binormal(V[A], V[B], V[KAB])
    half_binormal(tangent0[j], V[A], V[KA0])
    half_binormal(tangent0[j + 1], V[B], V[KB0])
    half_binormal(V[A], V[T], V[KAT])
    for i in range(3):
        k = share * V[KAB, i]
        V[GA, i] = (k - (1.0 - share) * V[KA0, i] - V[KAT, i]) / L[0] - (1.0 - share) * V[KAT, i] / L[2]
        V[GB, i] = (k - share * V[KB0, i]) / L[1] - share * V[KAT, i] / L[2]


@kernel
def material_coordinates(
    x: np.ndarray, base: int, share: float, frames: FrameView, d: np.ndarray, room: MaterialRoom, out: np.ndarray
) -> None:
    """Angle from the interpolated material frame, radial and axial part of a vector d from the centreline into out."""
    material_frame(x, base, share, frames, 0.0, room)
    V = room.V
    out[0] = math.atan2(dot(d, V[MU]), dot(d, V[NU]))
    out[2] = dot(d, V[T])
    out[1] = np.sqrt(max(dot(d, d) - out[2] ** 2, 0.0))


@kernel
def material_arm(radial: float, axial: float, room: MaterialRoom, arm: np.ndarray) -> None:
    """Vector from the curve to the point of `room` into arm (3)."""
    V = room.V
    for i in range(3):
        arm[i] = radial * V[NU, i] + axial * V[T, i]


@kernel
def material_point(
    x: np.ndarray, base: int, w: np.ndarray, radial: float, axial: float, room: MaterialRoom, S: np.ndarray
) -> None:
    """Place of the point of `room` into S (3); w (3) are the curve's weights."""
    material_arm(radial, axial, room, S)
    for i in range(3):
        S[i] += w[0] * x[base, i] + w[1] * x[base + 1, i] + w[2] * x[base + 2, i]
