"""Forces on points that a discrete rod carries on rigid arms: their gradient, and how that changes.

A force at the end of an arm D from the point u of the curve, fixed to the cross-section there, acts along the motion

    dS = dr + w t x D + [dc (t . D) - t (dc . D)]/|c|

with w, c and t of `knotfem.contact.material_points`. Friction acts where two surfaces touch, not where the material
points that it remembers have gone since the last accepted step: a strand that rolls takes these out of the contact
without any slip, and its friction would get an arm that grows with the length of the step.
"""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.material_frames import FrameView
from knotfem.contact.material_points import GA, GB, KA0, KAB, KAT, KB0, A, B, MaterialRoom, T
from knotfem.geometry.rotation import cross, dot, half_binormal_rate


@kernel
def arm_gradient(
    base: int, share: float, w: np.ndarray, frames: FrameView, arm: np.ndarray, room: MaterialRoom, G: np.ndarray
) -> None:
    """dS by the unknowns of three nodes into G (3, 12); `room` is filled by `material_frame`, w (3) are weights."""
    V, L, per_radius = room.V, room.L, frames.per_radius
    m, along = room.work[15], dot(V[T], arm)
    cross(V[T], arm, m)
    for i in range(3):
        for c in range(3):
            direct = 1.0 if i == c else 0.0
            across = (along * direct - V[T, i] * arm[c]) / L[2]
            by_a = m[i] * V[GA, c] + (1.0 - share) * across
            by_b = m[i] * V[GB, c] + share * across
            G[i, c] = w[0] * direct - by_a
            G[i, 4 + c] = w[1] * direct + by_a - by_b
            G[i, 8 + c] = w[2] * direct + by_b
        G[i, 3] = m[i] * (1.0 - share) * per_radius[base]
        G[i, 7] = m[i] * share * per_radius[base + 1]
        G[i, 11] = 0.0


@kernel
def arm_curvature(
    base: int, share: float, frames: FrameView, arm: np.ndarray, force: np.ndarray, room: MaterialRoom, H: np.ndarray
) -> None:
    """Derivatives of G . force by the unknowns of three nodes into H (12, 12), for an arm that stays as it is."""
    V, L, work = room.V, room.L, room.work
    still, dea, deb, dc, da, db, dt, dm = work[0], work[1], work[2], work[3], work[4], work[5], work[6], work[7]
    kab, ka0, kb0, kat, dga, dgb = work[8], work[9], work[10], work[11], work[12], work[13]
    cross(V[T], arm, dm)
    moment, along, aligned = dot(dm, force), dot(V[T], arm), dot(V[T], force)
    near, far = 1.0 - share, share
    H[:] = 0.0
    for i in range(3):
        still[i] = 0.0
    for column in range(11):
        node, part = column // 4, column % 4
        if part == 3:
            continue
        for i in range(3):
            dea[i] = deb[i] = 0.0
        if node == 0:
            dea[part] = -1.0
        elif node == 1:
            dea[part], deb[part] = 1.0, -1.0
        else:
            deb[part] = 1.0
        la, lb = dot(V[A], dea), dot(V[B], deb)
        for i in range(3):
            dc[i] = near * dea[i] + far * deb[i]
        lc = dot(V[T], dc)
        for i in range(3):
            da[i] = (dea[i] - la * V[A, i]) / L[0]
            db[i] = (deb[i] - lb * V[B, i]) / L[1]
            dt[i] = (dc[i] - lc * V[T, i]) / L[2]
        half_binormal_rate(V[A], V[B], V[KAB], da, db, kab)
        half_binormal_rate(frames.tangent[base], V[A], V[KA0], still, da, ka0)
        half_binormal_rate(frames.tangent[base + 1], V[B], V[KB0], still, db, kb0)
        half_binormal_rate(V[A], V[T], V[KAT], da, dt, kat)
        for i in range(3):
            kc = kat[i] / L[2] - V[KAT, i] * lc / L[2] ** 2
            own = (far * V[KAB, i] - near * V[KA0, i] - V[KAT, i]) / L[0]
            dga[i] = (far * kab[i] - near * ka0[i] - kat[i] - own * la) / L[0] - near * kc
            own = far * (V[KAB, i] - V[KB0, i]) / L[1]
            dgb[i] = (far * (kab[i] - kb0[i]) - own * lb) / L[1] - far * kc
        cross(dt, arm, dm)
        turned, tilted, leant = dot(dm, force), dot(dt, arm), dot(dt, force)
        for i in range(3):
            bent = (tilted * force[i] - leant * arm[i]) / L[2]
            bent -= (along * force[i] - aligned * arm[i]) * lc / L[2] ** 2
            by_a = turned * V[GA, i] + moment * dga[i] + near * bent
            by_b = turned * V[GB, i] + moment * dgb[i] + far * bent
            H[i, column] = -by_a
            H[4 + i, column] = by_a - by_b
            H[8 + i, column] = by_b
        H[3, column] = turned * near * frames.per_radius[base]
        H[7, column] = turned * far * frames.per_radius[base + 1]


@kernel
def arm_swing(base: int, share: float, frames: FrameView, force: np.ndarray, room: MaterialRoom, K: np.ndarray) -> None:
    """Derivatives of G . force by the arm into K (12, 3)."""
    V, L = room.V, room.L
    m, aligned = room.work[15], dot(V[T], force)
    cross(force, V[T], m)
    for j in range(3):
        for i in range(3):
            bent = (V[T, j] * force[i] - (aligned if i == j else 0.0)) / L[2]
            by_a = m[j] * V[GA, i] + (1.0 - share) * bent
            by_b = m[j] * V[GB, i] + share * bent
            K[i, j] = -by_a
            K[4 + i, j] = by_a - by_b
            K[8 + i, j] = by_b
        K[3, j] = m[j] * (1.0 - share) * frames.per_radius[base]
        K[7, j] = m[j] * share * frames.per_radius[base + 1]
        K[11, j] = 0.0
