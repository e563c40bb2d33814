"""Material points near the smooth centreline: where they are, how they move, and how that changes.

A material point has the coordinates (u, angle, radial, axial): at the point u of the curve, of unit tangent t, it lies
at radial nu + axial t, where nu stands at `angle` from the interpolated material frame. Between the middles of two
edges a and b (u goes from lambda = 0 to 1) that frame is the director of edge a, carried along the great circle to t
and turned by its rotation about the edge and by lambda times the twist m of the vertex: continuous along the whole rod,
and a function of the state alone, so that a rigidly moved rod carries its points with it.

With c the curve's derivative, c = |c| t, and nu spinning by w about t:

    dS = dr + radial (w t x nu - (nu . dc) t/|c|) + axial (dc - t (t . dc))/|c|
    w  = (1 - lambda) dtheta_a + lambda dtheta_b + g_a . de_a + g_b . de_b
    g_a = [lambda k(a, b) - (1 - lambda) k(a0, a) - k(a, t)]/|e_a| - (1 - lambda) k(a, t)/|c|
    g_b = [lambda k(a, b) - lambda k(b0, b)]/|e_b| - lambda k(a, t)/|c|

(k in `knotfem.geometry.rotation`, a0 and b0 the directions of the accepted state).
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
    half_binormal_rate,
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
def material_point(
    x: np.ndarray, base: int, w: np.ndarray, radial: float, axial: float, room: MaterialRoom, S: np.ndarray
) -> None:
    """Place of the point of `room` into S (3); w (3) are the curve's weights."""
    V = room.V
    for i in range(3):
        S[i] = w[0] * x[base, i] + w[1] * x[base + 1, i] + w[2] * x[base + 2, i]
        S[i] += radial * V[NU, i] + axial * V[T, i]


@kernel
def material_gradient(
    base: int, share: float, w: np.ndarray, frames: FrameView, coordinates: np.ndarray, room: MaterialRoom,
    G: np.ndarray,
) -> None:  # fmt: skip
    """dS by the unknowns of three nodes into G (3, 12); `coordinates` are angle, radial and axial part."""
    V, L, per_radius = room.V, room.L, frames.per_radius
    radial, axial = coordinates[1], coordinates[2]
    for i in range(3):
        spin = radial * V[MU, i]
        for c in range(3):
            across = axial * ((1.0 if i == c else 0.0) - V[T, i] * V[T, c]) - radial * V[T, i] * V[NU, c]
            by_a = spin * V[GA, c] + (1.0 - share) * across / L[2]
            by_b = spin * V[GB, c] + share * across / L[2]
            direct = 1.0 if i == c else 0.0
            G[i, c] = w[0] * direct - by_a
            G[i, 4 + c] = w[1] * direct + by_a - by_b
            G[i, 8 + c] = w[2] * direct + by_b
        G[i, 3] = spin * (1.0 - share) * per_radius[base]
        G[i, 7] = spin * share * per_radius[base + 1]
        G[i, 11] = 0.0


@kernel
def material_curvature(
    base: int, share: float, frames: FrameView, coordinates: np.ndarray, room: MaterialRoom, tau: np.ndarray,
    H: np.ndarray,
) -> None:  # fmt: skip
    """Second derivatives of S . tau by the unknowns of three nodes into H (12, 12); see `material_gradient`."""
    tangent0, per_radius = frames.tangent, frames.per_radius
    V, L, work = room.V, room.L, room.work
    radial, axial = coordinates[1], coordinates[2]
    still, dea, deb, dc, da = work[0], work[1], work[2], work[3], work[4]
    db, dt, dnu, dmu = work[5], work[6], work[7], work[8]
    kab, ka0, kb0, kat, ga, gb = work[9], work[10], work[11], work[12], work[13], work[14]
    for i in range(3):
        still[i] = 0.0
    t_tau, mu_tau = dot(V[T], tau), dot(V[MU], tau)
    near, far = 1.0 - share, share
    for column in range(11):
        node, part = column // 4, column % 4
        w = 0.0
        for i in range(3):
            dea[i] = deb[i] = 0.0
        if part < 3:
            if node == 0:
                dea[part] = -1.0
            elif node == 1:
                dea[part], deb[part] = 1.0, -1.0
            else:
                deb[part] = 1.0
            w = dot(V[GA], dea) + dot(V[GB], deb)
        elif node == 0:
            w = near * per_radius[base]
        else:
            w = far * per_radius[base + 1]
        la, lb, lc = dot(V[A], dea), dot(V[B], deb), 0.0
        for i in range(3):
            dc[i] = near * dea[i] + far * deb[i]
        lc = dot(V[T], dc)
        nu_dc = dot(V[NU], dc)
        for i in range(3):
            da[i] = (dea[i] - la * V[A, i]) / L[0]
            db[i] = (deb[i] - lb * V[B, i]) / L[1]
            dt[i] = (dc[i] - lc * V[T, i]) / L[2]
            dnu[i] = w * V[MU, i] - nu_dc / L[2] * V[T, i]
        cross(dt, V[NU], dmu)
        cross(V[T], dnu, still)
        for i in range(3):
            dmu[i] += still[i]
            still[i] = 0.0
        half_binormal_rate(V[A], V[B], V[KAB], da, db, kab)
        half_binormal_rate(tangent0[base], V[A], V[KA0], still, da, ka0)
        half_binormal_rate(tangent0[base + 1], V[B], V[KB0], still, db, kb0)
        half_binormal_rate(V[A], V[T], V[KAT], da, dt, kat)
        for i in range(3):
            kc = kat[i] / L[2] - V[KAT, i] * lc / L[2] ** 2
            own = (far * V[KAB, i] - near * V[KA0, i] - V[KAT, i]) / L[0]
            ga[i] = (far * kab[i] - near * ka0[i] - kat[i] - own * la) / L[0] - near * kc
            own = far * (V[KAB, i] - V[KB0, i]) / L[1]
            gb[i] = (far * (kab[i] - kb0[i]) - own * lb) / L[1] - far * kc
        dt_tau, dmu_tau = dot(dt, tau), dot(dmu, tau)
        for i in range(3):
            bent = -radial * (dnu[i] * t_tau + V[NU, i] * (dt_tau - t_tau * lc / L[2]))
            bent -= axial * (dt[i] * t_tau + V[T, i] * dt_tau + (tau[i] - V[T, i] * t_tau) * lc / L[2])
            bent /= L[2]
            by_a = radial * (ga[i] * mu_tau + V[GA, i] * dmu_tau) + near * bent
            by_b = radial * (gb[i] * mu_tau + V[GB, i] * dmu_tau) + far * bent
            H[i, column] = -by_a
            H[4 + i, column] = by_a - by_b
            H[8 + i, column] = by_b
        H[3, column] = radial * dmu_tau * near * per_radius[base]
        H[7, column] = radial * dmu_tau * far * per_radius[base + 1]
        H[11, column] = 0.0
    for i in range(12):
        H[i, 11] = 0.0
