"""Compiled loops of the damping of bends.

An edge of direction t in the first state and a now carries a vector v with its material: c = R v, R the smallest
rotation from t to a and then a turn by theta about a. With v the first direction of the edge beyond the vertex and b
its present one, |b - c|^2/2 = 1 - f. As a function of free vectors a and b, with w = t . v, q = 1 + t . a and
s = (w + v . a)/q,

    f   = cos(theta) F_1 + sin(theta) F_2 + (1 - cos(theta)) w a . b
    F_1 = b . p,           p = v - s (t + a) + 2 w a
    F_2 = b . (a x v) - s b . (a x t)
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.geometry.rotation import cross, dot
from knotfem.models.rod.frames import VertexView, edge, rotation_of
from knotfem.sparse.scatter import MatrixView, add_blocks


class FirstView(NamedTuple):
    """The state from which the change of a bend is measured.

    Attributes:
        tangent: direction of each edge and clamp, shape [nodes + clamps, 3].
        offset: to be added to the rotation of each about itself for its turn since then [rad], same length.
    """

    tangent: np.ndarray
    offset: np.ndarray


@kernel
def carried(t: np.ndarray, v: np.ndarray, a: np.ndarray, theta: float, out: np.ndarray) -> None:
    """c = R v into out."""
    w, p, n = dot(t, v), np.empty(3), np.empty(3)
    s = (w + dot(v, a)) / (1.0 + dot(t, a))
    for i in range(3):
        p[i] = v[i] - s * (t[i] + a[i]) + 2.0 * w * a[i]
    cross(a, p, n)
    for i in range(3):
        out[i] = math.cos(theta) * p[i] + math.sin(theta) * n[i] + (1.0 - math.cos(theta)) * w * a[i]


@kernel
def _derivatives(
    t: np.ndarray, v: np.ndarray, a: np.ndarray, b: np.ndarray, theta: float, g: np.ndarray, H: np.ndarray
) -> None:
    """Gradient (7) and second derivative (7, 7) of f by (a, b, theta), a and b taken as free vectors."""
    C, S, w = math.cos(theta), math.sin(theta), dot(t, v)
    q = 1.0 + dot(t, a)
    s = (w + dot(v, a)) / q
    along, ab = dot(b, t) + dot(a, b), dot(a, b)
    slope, p = np.empty(3), np.empty(3)
    vb, tb, at, av = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    cross(v, b, vb)
    cross(t, b, tb)
    cross(a, t, at)
    cross(a, v, av)
    for i in range(3):
        slope[i] = (v[i] - s * t[i]) / q
        p[i] = v[i] - s * (t[i] + a[i]) + 2.0 * w * a[i]
    triple = dot(a, tb)
    f1, f2, f3 = dot(b, p), dot(a, vb) - s * triple, w * ab
    skew_v = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    skew_t = np.array([[0.0, -t[2], t[1]], [t[2], 0.0, -t[0]], [-t[1], t[0], 0.0]])
    for i in range(3):
        a1, a2, a3 = (2.0 * w - s) * b[i] - slope[i] * along, vb[i] - slope[i] * triple - s * tb[i], w * b[i]
        b1, b2, b3 = p[i], av[i] - s * at[i], w * a[i]
        g[i] = C * a1 + S * a2 + (1.0 - C) * a3
        g[3 + i] = C * b1 + S * b2 + (1.0 - C) * b3
        H[i, 6] = H[6, i] = C * a2 + S * (a3 - a1)
        H[3 + i, 6] = H[6, 3 + i] = C * b2 + S * (b3 - b1)
        for j in range(3):
            same = 1.0 if i == j else 0.0
            bent = -(slope[i] * t[j] + t[i] * slope[j]) / q
            H[i, j] = -C * (bent * along + slope[i] * b[j] + b[i] * slope[j])
            H[i, j] -= S * (bent * triple + slope[i] * tb[j] + tb[i] * slope[j])
            H[i, 3 + j] = C * ((2.0 * w - s) * same - slope[i] * (t[j] + a[j])) + (1.0 - C) * w * same
            H[i, 3 + j] += S * (skew_v[i, j] - slope[i] * at[j] - s * skew_t[i, j])
            H[3 + j, i] = H[i, 3 + j]
            H[3 + i, 3 + j] = 0.0
    g[6] = C * f2 + S * (f3 - f1)
    H[6, 6] = C * (f3 - f1) - S * f2


@kernel
def _project(d: np.ndarray, length: float, at: int, g: np.ndarray, H: np.ndarray) -> None:
    """From derivatives by a unit vector, in the three places from `at`, to those by the edge that it points along."""
    radial = 0.0
    for i in range(3):
        radial += d[i] * g[at + i]
    for i in range(3):
        g[at + i] = (g[at + i] - radial * d[i]) / length
    for m in range(7):
        share = 0.0
        for i in range(3):
            share += d[i] * H[at + i, m]
        for i in range(3):
            H[at + i, m] = (H[at + i, m] - share * d[i]) / length
    for m in range(7):
        share = 0.0
        for i in range(3):
            share += d[i] * H[m, at + i]
        for i in range(3):
            H[m, at + i] = (H[m, at + i] - share * d[i]) / length
    for i in range(3):
        for j in range(3):
            same = 1.0 if i == j else 0.0
            H[at + i, at + j] -= radial * (same - d[i] * d[j]) / length**2
            H[at + i, at + j] -= (d[i] * g[at + j] + g[at + i] * d[j]) / length


@kernel(inline="always")
def _turn_since(x: np.ndarray, per_radius: np.ndarray, first: FirstView, j: int) -> float:
    """Turn of an edge or clamp about itself since the first state [rad]."""
    return rotation_of(x, per_radius, j) + first.offset[j]


@kernel
def _both_ends(
    x: np.ndarray, vertices: VertexView, first: FirstView, base: int, other: int,
    directions: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> None:  # fmt: skip
    """Direction of the edge `base` into a; of the edge `other`, now and as carried with `base`, into b and c."""
    a, b, c = directions
    edge(x, vertices.tangent, base, a)
    edge(x, vertices.tangent, other, b)
    theta = _turn_since(x, vertices.per_radius, first, base)
    carried(first.tangent[base], first.tangent[other], a, theta, c)


@kernel
def potential(x: np.ndarray, vertices: VertexView, first: FirstView, modulus: np.ndarray) -> float:
    """modulus/4 (|b - c|^2 one way and the other) of all vertices."""
    a, b, c = np.empty(3), np.empty(3), np.empty(3)
    total = 0.0
    for k in range(modulus.size):
        for side in range(2):
            base, other = vertices.edges[k, side], vertices.edges[k, 1 - side]
            _both_ends(x, vertices, first, base, other, (a, b, c))
            for i in range(3):
                total += 0.25 * modulus[k] * (b[i] - c[i]) ** 2
    return total


@kernel
def clamp_couples(
    x: np.ndarray, vertices: VertexView, first: FirstView, modulus: np.ndarray, clamps: int
) -> np.ndarray:
    """Couple of each clamp on its rod from the last vertices, which are the clamps'; shape [clamps, 3].

    As a clamp turns by d, b . c changes by d . (b x c) where b is the clamp's, by d . (c x b) where c is.
    """
    a, b, c, turn = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    couples = np.zeros((clamps, 3))
    before = modulus.size - clamps
    for k in range(clamps):
        for side in range(2):
            base, other = vertices.edges[before + k, side], vertices.edges[before + k, 1 - side]
            _both_ends(x, vertices, first, base, other, (a, b, c))
            cross(b, c, turn)
            sign = 1.0 if base >= x.shape[0] else -1.0
            for i in range(3):
                couples[k, i] += 0.5 * sign * modulus[before + k] * turn[i]
    return couples


@kernel
def assemble(
    x: np.ndarray, vertices: VertexView, first: FirstView, modulus: np.ndarray, residual: np.ndarray, matrix: MatrixView
) -> bool:
    """Residual and tangent of all vertices; see `potential`. False outside the pattern."""
    a, b = np.empty(3), np.empty(3)
    g, H = np.empty(7), np.empty((7, 7))
    places = np.empty(13, np.int64)
    signs, parts = np.empty(13), np.empty(13, np.int64)
    block = np.zeros((16, 16))
    per_radius, tangent0, tangent = vertices.per_radius, vertices.tangent, first.tangent
    for k in range(modulus.size):
        stencil = vertices.stencil[k]
        block[:] = 0.0
        for side in range(2):
            base, other = vertices.edges[k, side], vertices.edges[k, 1 - side]
            la = edge(x, tangent0, base, a)
            lb = edge(x, tangent0, other, b)
            theta = _turn_since(x, per_radius, first, base)
            _derivatives(tangent[base], tangent[other], a, b, theta, g, H)
            _project(a, la, 0, g, H)
            _project(b, lb, 3, g, H)
            weight = -0.5 * modulus[k]
            for end in range(2):
                for i in range(3):
                    for which in range(2):
                        m = 6 * end + 3 * which + i
                        p = 2 * side + end if which == 0 else 2 * (1 - side) + end
                        places[m], parts[m] = 4 * p + i, 3 * which + i
                        signs[m] = -1.0 if end == 0 else 1.0
            places[12], parts[12] = 8 * side + 3, 6
            signs[12] = per_radius[base] if base < x.shape[0] else 0.0
            for m in range(13):
                node = stencil[places[m] // 4]
                if node >= 0:
                    residual[node, places[m] % 4] += weight * signs[m] * g[parts[m]]
                if matrix.wanted:
                    for n in range(13):
                        block[places[m], places[n]] += weight * signs[m] * signs[n] * H[parts[m], parts[n]]
        if matrix.wanted and not add_blocks(matrix, stencil, stencil, block):
            return False
    return True
