"""What the compiled loops over hexahedra take: tables, law, unknowns, and what is kept of the condensation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class ElementView(NamedTuple):
    """Hexahedra of one rod; all layers have the tables of one, which are stretched along the rod.

    Attributes:
        nodes: connectivity, shape [slices, quads, n].
        grads: reference gradients [1/mm], shape [quads, points, n, 3].
        weights: reference volumes [mm^3], shape [quads, points].
        psi: pressure functions, shape [quads, points, q].
        modes: functions psi_m of the incompatible modes, shape [quads, points, k].
        centre: rates c_am of the shape functions at the centre, shape [n, k].
        stiffness: G^-1 [MPa/mm^3], shape [quads, q, q].
        heights: lengths of the layers over that of the tables, shape [slices].
    """

    nodes: np.ndarray
    grads: np.ndarray
    weights: np.ndarray
    psi: np.ndarray
    modes: np.ndarray
    centre: np.ndarray
    stiffness: np.ndarray
    heights: np.ndarray


class PlacesView(NamedTuple):
    """A matrix and where the elements' blocks stand in it: a flat one, for Numba's parallel loops take no nested tuple.

    Attributes:
        wanted: whether there is one; without, only the residual is assembled.
        node_ptr: start of each node's neighbours, shape [nodes + 1].
        data: values.
        upper: whether only the upper triangle is stored.
        slots: places of pairs of nodes among the first one's neighbours, shape [slices quads, n, n], or -1.
    """

    wanted: bool
    node_ptr: np.ndarray
    data: np.ndarray
    upper: bool
    slots: np.ndarray


class LawView(NamedTuple):
    """The law at the integration points.

    Attributes:
        mu: shear modulus [MPa] of a law that is linear in I1.
        first: dW/dI1 [MPa], shape [slices, quads, points]; empty for a linear law.
        second: d2W/dI1^2 [MPa], of the same shape.
    """

    mu: float
    first: np.ndarray
    second: np.ndarray


class UnknownsView(NamedTuple):
    """Unknowns that elements have besides the positions of their nodes.

    Attributes:
        pressure: p_q [MPa], shape [slices, quads, q].
        modes: beta of the incompatible modes, shape [slices, quads, k, 3].
    """

    pressure: np.ndarray
    modes: np.ndarray


class CondensedView(NamedTuple):
    """How the elements' own unknowns follow the nodes.

    Attributes:
        b: b_q, shape [slices, quads, q, 3 (n + k)].
        excess: G^-1 R [MPa], shape [slices, quads, q].
        follow: A^-1 [K_beta,x, f_beta] of the modes, shape [slices, quads, 3 k, 3 n + 1].
    """

    b: np.ndarray
    excess: np.ndarray
    follow: np.ndarray


class ModesView(NamedTuple):
    """What the incompatible modes of one element need and fill; the k modes stand behind the n nodes.

    Attributes:
        tangents: t_m at the element's centre, shape [k, 3].
        along: psi_m t_m . h_k, which multiplied by J is the modes' change of volume, filled, shape [3, k].
        inv: inverse of the deformation gradient, shape [3, 3].
        s: deviatoric Kirchhoff stress times volume, shape [3, 3].
        g: spatial gradients of the nodes, shape [3, n + k].
        sg: forces of the deviatoric stress on nodes and modes, filled for these, shape [3, n + k].
        f: forces, added to, shape [3, n + k].
        K: stiffness, added to, shape [3, 3, n + k, n + k].
    """

    tangents: np.ndarray
    along: np.ndarray
    inv: np.ndarray
    s: np.ndarray
    g: np.ndarray
    sg: np.ndarray
    f: np.ndarray
    K: np.ndarray
