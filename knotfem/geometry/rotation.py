"""Parallel transport of directors and its first derivative, for compiled loops over single vectors.

P(a -> b) is the smallest rotation that takes the unit vector a to the unit vector b. It takes a vector v perpendicular
to a to

    P v = v - (v . b)/(1 + a . b) (a + b).

It is not defined for b = -a, and rounding errors grow as 1/(1 + a . b) near there. When a and b change by da and db,
and v is transported along with a, then P v rotates about b by

    -k(a, b) . (da + db),    k(a, b) = a x b/(1 + a . b),

relative to a vector that is transported along with b. All derivatives of bending and twisting of the rod model are
built from k, which is half the curvature binormal.
Source: Bergou, Wardetzky, Robinson, Audoly and Grinspun, ACM Trans. Graph. 27, 63 (2008), Eq. (1).

The same formulas for NumPy arrays, with checks, stand in `knotfem.geometry.finite_rotation`.
"""

from __future__ import annotations

import math

from knotfem.compiled import kernel
from knotfem.types import Array


@kernel(inline="always")
def dot(a: Array, b: Array) -> float:
    """Scalar product of two vectors, shape (3,) each."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(inline="always")
def cross(a: Array, b: Array, out: Array) -> None:
    """Vector product a x b into out, which must be another array than a and b; shape (3,) each."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@kernel(inline="always")
def unit(v: Array, out: Array) -> float:
    """v/|v| into out, which may be v itself, shape (3,) each; returns |v|."""
    size = math.sqrt(dot(v, v))
    for i in range(3):
        out[i] = v[i] / size
    return size


@kernel(inline="always")
def across(direction: Array, v: Array, out: Array) -> float:
    """Part of v perpendicular to a unit vector into out, which may be v itself, shape (3,) each; returns its length."""
    along = dot(direction, v)
    for i in range(3):
        out[i] = v[i] - along * direction[i]
    return math.sqrt(dot(out, out))


@kernel(inline="always")
def across_rate(direction: Array, turn: Array, v: Array, dv: Array, out: Array) -> None:
    """Derivative of that part into out, given those of direction and v, turn and dv; shape (3,) each."""
    along, rate = dot(direction, v), dot(direction, dv) + dot(turn, v)
    for i in range(3):
        out[i] = dv[i] - turn[i] * along - direction[i] * rate


@kernel(inline="always")
def transport(a: Array, b: Array, v: Array, out: Array) -> None:
    """P(a -> b) v into out, which may be v itself; a and b of length 1, v perpendicular to a; shape (3,) each."""
    weight = dot(v, b) / (1.0 + dot(a, b))
    for i in range(3):
        out[i] = v[i] - weight * (a[i] + b[i])


@kernel(inline="always")
def half_binormal(a: Array, b: Array, out: Array) -> None:
    """k(a, b) = a x b/(1 + a . b) into out; shape (3,) each."""
    cross(a, b, out)
    scale = 1.0 / (1.0 + dot(a, b))
    for i in range(3):
        out[i] *= scale


@kernel(inline="always")
def half_binormal_rate(a: Array, b: Array, k: Array, da: Array, db: Array, out: Array) -> None:
    """Derivative of k(a, b) in the direction (da, db) into out, given k itself; shape (3,) each."""
    scale = 1.0 / (1.0 + dot(a, b))
    cosine_rate = dot(da, b) + dot(a, db)
    out[0] = scale * (da[1] * b[2] - da[2] * b[1] + a[1] * db[2] - a[2] * db[1] - cosine_rate * k[0])
    out[1] = scale * (da[2] * b[0] - da[0] * b[2] + a[2] * db[0] - a[0] * db[2] - cosine_rate * k[1])
    out[2] = scale * (da[0] * b[1] - da[1] * b[0] + a[0] * db[1] - a[1] * db[0] - cosine_rate * k[2])


@kernel(inline="always")
def angle_about(t: Array, u: Array, v: Array) -> float:
    """Angle from u to v about the unit vector t [rad], right-handed, in (-pi, pi]; u and v perpendicular to t."""
    x = t[0] * (u[1] * v[2] - u[2] * v[1])
    x += t[1] * (u[2] * v[0] - u[0] * v[2])
    x += t[2] * (u[0] * v[1] - u[1] * v[0])
    return math.atan2(x, dot(u, v))


@kernel(inline="always")
def nearest_turn(angle: float, reference: float) -> float:
    """The angle plus the multiple of 2 pi that brings it nearest to the reference; all in rad."""
    turn = 2.0 * math.pi
    return angle + turn * math.floor((reference - angle) / turn + 0.5)
