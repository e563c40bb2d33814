"""Small motions about straight rods: the assembled tangent and mass against beam theory."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.sparse import diags_array
from scipy.sparse.linalg import eigsh

from knotfem.scene.stiffness import mass_per_length
from knotfem.solver.constraints import Prescribed
from knotfem.solver.schemes import Scheme
from knotfem.solver.system import System
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.load import EndForce
from knotfem.verify.benchmarks.rods import Rod, at_rest, beam_clamp, cross_sections, make_rod, static
from knotfem.verify.case import Case, Quantity


def lowest(rod: Rod, system: System, x: np.ndarray, count: int) -> np.ndarray:
    """Smallest squared circular frequencies [1/s^2]; negative ones where the state is unstable."""
    _, matrix = system.tangent(x)
    free = ~system.fixed.ravel()
    mass = diags_array(np.repeat(rod.mass, 3)[free])
    values = eigsh(matrix.to_scipy()[free][:, free], k=count, M=mass, sigma=-1e-3, return_eigenvectors=False)
    return np.sort(values)


def frequencies(element: str, slices: int) -> list[Quantity]:
    """The first three pairs of modes of a cantilever."""
    rod = make_rod(180.0, slices, radius=1.5, element=element)
    system = System(rod.terms, Unknowns(len(rod.mesh.nodes)), make_solver("superlu"), Scheme(), beam_clamp(rod))
    system.begin(at_rest(rod.mesh.nodes), 1.0)
    found = np.sqrt(lowest(rod, system, rod.mesh.nodes, 6))
    scale = np.sqrt(rod.bending / mass_per_length(rod.density, 1.5)) / 180.0**2
    return [
        Quantity(
            "omega [1/s]",
            float(found[2 * number + k]),
            float(root**2 * scale),
            0.01,
            condition=f"mode {number + 1}{'ab'[k]}",
        )
        for number, root in enumerate((1.8751, 4.6941, 7.8548))
        for k in (0, 1)
    ]


def pinned(fraction: float) -> tuple[float, float]:
    """A pinned rod with a load at the ends of its axis: the load over the critical one, and the smallest eigenvalue."""
    rod = make_rod(120.0, 40, radius=1.5)
    load = fraction * np.pi**2 * rod.bending / 120.0**2
    X, ends, middle = rod.mesh.nodes, rod.axis[[0, -1]], rod.axis[[20]]
    spoke = rod.sections[0][rod.mesh.section.ring[:1]]
    supports = [
        Prescribed(ends, lambda time: X[ends], components=(True, True, False)),
        Prescribed(middle, lambda time: X[middle], components=(False, False, True)),
        Prescribed(spoke, lambda time: X[spoke], components=(False, True, False)),
    ]
    presses = [
        EndForce(rod.sections[end], rod.end_weights, lambda t, sign=sign: np.array([0.0, 0.0, sign * load]))
        for end, sign in ((0, 1.0), (-1, -1.0))
    ]
    x, system, _ = static([*rod.terms, *presses], X, supports, cross_sections(rod))
    return fraction, float(lowest(rod, system, x, 2)[0])


def clamped(fraction: float) -> tuple[float, float]:
    """The same between two beam clamps, one moved by what the load shortens the rod."""
    rod = make_rod(180.0, 60, radius=1.5)
    load = fraction * 4.0 * np.pi**2 * rod.bending / 180.0**2
    X, far, tip = rod.mesh.nodes, rod.sections[-1], rod.axis[[-1]]
    strain = -load / (rod.youngs * rod.area)
    strain += 1.0 * strain**2
    supports = [
        *beam_clamp(rod),
        Prescribed(far, lambda time: X[far] + [0.0, 0.0, 180.0 * strain], components=(False, False, True)),
        Prescribed(tip, lambda time: X[tip], components=(True, True, False)),
    ]
    x, system, _ = static(rod.terms, X, supports, cross_sections(rod))
    pressed = -float(system.residual(x)[far, 2].sum())
    return pressed / load * fraction, float(lowest(rod, system, x, 2)[0])


def buckling(support: Callable[[float], tuple[float, float]]) -> list[Quantity]:
    """The smallest eigenvalue changes sign at the critical load: 0.99 and 1.01 of it bracket the sign change."""
    (before, low), (after, high) = support(0.99), support(1.01)
    return [
        Quantity("smallest eigenvalue [1/s^2]", low, 0.0, kind="at least", condition="0.99 P_critical"),
        Quantity("smallest eigenvalue [1/s^2]", high, 0.0, kind="at most", condition="1.01 P_critical"),
        Quantity("P / P_critical", before + (after - before) * low / (low - high), 1.0, 0.01),
    ]


CASES = [
    *(
        Case(
            "frequencies",
            partial(frequencies, element, slices),
            "cantilever, first three pairs of modes",
            "Euler and Bernoulli",
            f"{element}, {slices} x 12, L / r = 120",
            element,
        )
        for element, slices in (("hex8-reduced", 60), ("hex8", 400))
    ),
    *(
        Case(
            "buckling",
            partial(buckling, support),
            f"column, {support.__name__} ends",
            "Euler",
            f"hex8-reduced, {mesh}",
            support.__name__,
        )
        for support, mesh in ((pinned, "40 x 12, L / r = 80"), (clamped, "60 x 12, L / r = 120"))
    ),
]
