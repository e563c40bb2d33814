"""Solids of hexahedra: homogeneous and twisted rods, patches of distorted bricks, Cook's membrane."""

from __future__ import annotations

from functools import partial

import numpy as np

from knotfem.geometry.finite_rotation import rotate
from knotfem.models.material import NeoHooke
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.formulation import brick_formulation
from knotfem.solver.constraints import Prescribed, held
from knotfem.solver.nonlinear.tolerance import Sections
from knotfem.solver.schemes import Scheme
from knotfem.solver.system import System
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.load import EndForce
from knotfem.verify.benchmarks.rods import (
    WHOLE_STEPS,
    accepted_steps,
    at_rest,
    beam_clamp,
    cross_sections,
    final_state,
    make_rod,
    moduli,
    static,
)
from knotfem.verify.case import Case, Quantity

CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float
)


def bricks(
    nodes: np.ndarray, hexes: np.ndarray, shear: float, bulk: float, *, incompatible: bool = False
) -> Elasticity:
    """Q1P0 on hexahedra of any shape: one "slice" in which every element has tables of its own."""
    form = brick_formulation("hex8-incompatible" if incompatible else "hex8", nodes[hexes])
    return Elasticity(hexes[None], form, NeoHooke(shear), bulk)


def _one_section(nodes: int) -> Sections:
    """For a solid that is no rod: all of its nodes belong to one section."""
    return Sections.single(np.zeros(nodes, dtype=int))


def stretched(stretch: float, element: str) -> list[Quantity]:
    """Incompressible neo-Hookean: P = G (lambda - lambda^-2) A."""
    rod = make_rod(30.0, 6, poisson=0.49999, element=element)
    X, far = rod.mesh.nodes, rod.sections[-1]
    top = Prescribed(far, lambda time: X[far] + [0.0, 0.0, 30.0 * (stretch - 1.0)], components=(False, False, True))
    x, system, _ = static(rod.terms, X, [*beam_clamp(rod), top], cross_sections(rod))
    expected = rod.bulk.shear_modulus * (stretch - stretch**-2) * rod.area
    return [Quantity("P [N]", float(system.residual(x)[far, 2].sum()), float(expected), 0.005)]


def torsion(element: str) -> list[Quantity]:
    """Rivlin: M = pi/2 G r^4 tau, N = -pi/4 G r^4 tau^2 at fixed length, here at tau r = 0.5."""
    rod = make_rod(30.0, 48, poisson=0.49999, element=element)
    X, near, far = rod.mesh.nodes, rod.sections[0], rod.sections[-1]
    tau = 0.5 / 3.0
    centre, z_axis = X[rod.axis[-1]], np.array([0.0, 0.0, 1.0])
    twisted = Prescribed(far, lambda t: centre + rotate(X[far] - centre, z_axis, tau * 30.0 * t))
    system = System(rod.terms, Unknowns(len(X)), make_solver("auto"), Scheme(), [held(near, X[near]), twisted])
    steps = accepted_steps(system, at_rest(X), cross_sections(rod), [1.0], first=0.25, largest=0.25, newton=WHOLE_STEPS)
    x = final_state(steps).x
    force = system.residual(x)[far]
    G = rod.bulk.shear_modulus
    torque = float(np.cross(x[far] - x[rod.axis[-1]], force).sum(axis=0)[2])
    return [
        Quantity("M [N mm]", torque, 0.5 * np.pi * G * 81.0 * tau, 0.02),
        Quantity("N [N]", float(force[:, 2].sum()), -0.25 * np.pi * G * 81.0 * tau**2, 0.02),
    ]


def patch(poisson: float, *, incompatible: bool = False) -> list[Quantity]:
    """A linear field on the boundary is met exactly inside, from a start that is not it."""
    rng = np.random.default_rng(1)
    line = np.linspace(0.0, 1.0, 4)
    X = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    inner = np.all((X > 0.0) & (X < 1.0), axis=1)
    X[inner] += rng.uniform(-0.08, 0.08, (np.count_nonzero(inner), 3))
    i = np.arange(64).reshape(4, 4, 4)
    lower = [i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]]
    hexes = np.stack([n[..., :-1] for n in lower] + [n[..., 1:] for n in lower], axis=-1).reshape(-1, 8)
    bulk = bricks(X, hexes, *moduli(1.0, poisson), incompatible=incompatible)
    F = np.eye(3) + 0.2 * rng.standard_normal((3, 3))
    goal = X @ F.T
    outside = np.flatnonzero(~inner)
    start = X.copy()
    start[inner] += rng.uniform(-0.05, 0.05, (np.count_nonzero(inner), 3))
    x, _, _ = static([bulk], start, [held(outside, goal[outside])], _one_section(64), tolerance=1e-12)
    pressure = moduli(1.0, poisson)[1] * (np.linalg.det(F) - 1.0)
    found = bulk.pressure.reshape(len(hexes), -1)
    found[:, 0] -= pressure
    return [
        Quantity("deviation from the linear field", float(np.abs(x - goal).max()), 1e-10, kind="at most"),
        Quantity("deviation of pressure", float(np.abs(found / pressure).max()), 1e-8, kind="at most"),
    ]


def cook(cells: int, tip: float) -> list[Quantity]:
    """Vertical move of the upper right corner of Cook's membrane, one layer of bricks held in z."""
    line = np.linspace(0.0, 1.0, cells + 1)
    u, v = np.meshgrid(line, line, indexing="ij")
    flat = np.stack([48.0 * u, 44.0 * u + v * (44.0 - 28.0 * u)], axis=-1).reshape(-1, 2)
    count = len(flat)
    X = np.concatenate([np.column_stack([flat, np.full(count, z)]) for z in (0.0, 1.0)])
    i = np.arange(count).reshape(cells + 1, cells + 1)
    quads = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], axis=-1).reshape(-1, 4)
    bulk = bricks(X, np.concatenate([quads, quads + count], axis=1), 80.1938, 400889.8)
    weights = np.full(cells + 1, 0.5 / cells)
    weights[[0, -1]] *= 0.5
    left, right = (np.concatenate([edge, edge + count]) for edge in (i[0], i[-1]))
    load = EndForce(right, np.concatenate([weights, weights]), lambda t: np.array([0.0, 100.0 * t, 0.0]))
    flatness = Prescribed(np.arange(2 * count), lambda time: X, components=(False, False, True))
    system = System([bulk, load], Unknowns(2 * count), make_solver("auto"), Scheme(), [held(left, X[left]), flatness])
    steps = accepted_steps(
        system, at_rest(X), _one_section(2 * count), [1.0], first=0.25, largest=0.25, move=1e3, newton=WHOLE_STEPS
    )
    x = final_state(steps).x
    return [Quantity("tip", float(x[i[-1, -1], 1] - 60.0), tip, 0.005)]


_ELEMENTS = ("hex8-reduced", "hex8", "hex8-incompatible", "hex27")

CASES = [
    *(
        Case(
            "stretch",
            partial(stretched, stretch, element),
            f"neo-Hookean rod stretched to {stretch:g}",
            "P = G (lambda - lambda^-2) A",
            f"{element}, 6 x 12, nu = 0.49999",
            f"{element}-{stretch:g}",
        )
        for element in _ELEMENTS
        for stretch in (0.8, 1.3, 2.0)
    ),
    *(
        Case(
            "torsion",
            partial(torsion, element),
            "finite torsion at fixed length, tau r = 0.5",
            "Rivlin 1949",
            f"{element}, 48 x 12, nu = 0.49999",
            element,
        )
        for element in _ELEMENTS
    ),
    *(
        Case(
            "patch",
            partial(patch, poisson, incompatible=element == "hex8-incompatible"),
            f"patch of distorted bricks, nu = {poisson:g}",
            "linear field",
            f"{element}, 3 x 3 x 3",
            f"{poisson:g}" if element == "hex8" else f"{element}-{poisson:g}",
        )
        for element, poisson in (
            ("hex8", 0.3),
            ("hex8", 0.4999),
            ("hex8-incompatible", 0.3),
            ("hex8-incompatible", 0.49),
        )
    ),
    *(
        Case(
            "cook",
            partial(cook, cells, tip),
            f"Cook's membrane, {cells} x {cells}",
            "two other programs on this mesh",
            f"hex8, {cells} x {cells} x 1, plane strain",
            f"{cells}",
        )
        for cells, tip in ((8, 6.619), (32, 6.884))
    ),
]
