"""Parallel transport on the unit sphere and its first-order variation.

P(a -> b), the smallest rotation that takes the unit vector a to b, carries a vector v across a to
v - (v . b)/(1 + a . b) (a + b). When a and b vary, the carried vector spins about b by -k(a, b) . (da + db) more than a
vector that moves with b without spin, where k(a, b) = a x b/(1 + a . b), half the curvature binormal of Bergou et al.
(ACM Trans. Graph. 27, 2008, Eq. 1): the solid angle that the arc sweeps. All of the rod's derivatives are built from k.
"""

from __future__ import annotations

import math

from knotfem.compiled import kernel


@kernel(inline="always")
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(inline="always")
def cross(a, b, out):
    """a x b into out, which must be neither."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@kernel(inline="always")
def unit(v, out):
    """v / |v| into out; returns |v|."""
    size = math.sqrt(dot(v, v))
    for i in range(3):
        out[i] = v[i] / size
    return size


@kernel(inline="always")
def transport(a, b, v, out):
    """v, across the unit vector a, carried by the smallest rotation to b."""
    share = dot(v, b) / (1.0 + dot(a, b))
    for i in range(3):
        out[i] = v[i] - share * (a[i] + b[i])


@kernel(inline="always")
def half_binormal(a, b, out):
    """k(a, b) = a x b/(1 + a . b) into out."""
    cross(a, b, out)
    scale = 1.0 / (1.0 + dot(a, b))
    for i in range(3):
        out[i] *= scale


@kernel(inline="always")
def half_binormal_rate(a, b, k, da, db, out):
    """Derivative of k(a, b) along (da, db) into out."""
    scale = 1.0 / (1.0 + dot(a, b))
    turn = dot(da, b) + dot(a, db)
    out[0] = scale * (da[1] * b[2] - da[2] * b[1] + a[1] * db[2] - a[2] * db[1] - turn * k[0])
    out[1] = scale * (da[2] * b[0] - da[0] * b[2] + a[2] * db[0] - a[0] * db[2] - turn * k[1])
    out[2] = scale * (da[0] * b[1] - da[1] * b[0] + a[0] * db[1] - a[1] * db[0] - turn * k[2])


@kernel(inline="always")
def angle_about(t, u, v):
    """Angle from u to v about the unit vector t, both across it, in (-pi, pi]."""
    x = t[0] * (u[1] * v[2] - u[2] * v[1])
    x += t[1] * (u[2] * v[0] - u[0] * v[2])
    x += t[2] * (u[0] * v[1] - u[1] * v[0])
    return math.atan2(x, dot(u, v))


@kernel(inline="always")
def nearest_turn(angle, reference):
    """The angle plus the whole turns that bring it nearest to the reference."""
    turn = 2.0 * math.pi
    return angle + turn * math.floor((reference - angle) / turn + 0.5)
