"""Small motions about straight rods: the assembled tangent and mass against beam theory."""

import numpy as np
import pytest
from scipy.sparse import diags_array
from scipy.sparse.linalg import eigsh
from specimens import Rod, agree, beam_clamp, make_rod, static

from knotfem.effects.load import EndForce
from knotfem.solver.effect import Motion, StepStart
from knotfem.solver.linear import make_solver
from knotfem.solver.schemes import Scheme
from knotfem.solver.system import Prescribed, System


def lowest(rod: Rod, system: System, x: np.ndarray, count: int) -> np.ndarray:
    """Smallest squared circular frequencies [1/s^2]; negative ones where the state is unstable."""
    _, matrix = system.tangent(x)
    free = ~system.fixed.ravel()
    mass = diags_array(np.repeat(rod.mass, 3)[free])
    values = eigsh(matrix.to_scipy()[free][:, free], k=count, M=mass, sigma=-1e-3, return_eigenvectors=False)
    return np.sort(values)


def test_cantilever_frequencies():
    rod = make_rod(180.0, 60, radius=1.5)
    system = System(rod.effects, len(rod.mesh.nodes), make_solver("superlu"), Scheme(), beam_clamp(rod))
    system.begin(StepStart(Motion.at_rest(rod.mesh.nodes), 1.0))
    found = np.sqrt(lowest(rod, system, rod.mesh.nodes, 6))
    scale = np.sqrt(rod.bending / (rod.density * np.pi * 1.5**2)) / 180.0**2
    for number, root in enumerate((1.8751, 4.6941, 7.8548)):
        np.testing.assert_allclose(found[2 * number], found[2 * number + 1], rtol=0.01)
        agree(f"cantilever, mode {number + 1}, omega [1/s]", found[2 * number], root**2 * scale, 0.01)


def pinned(share: float) -> float:
    """Smallest eigenvalue under a share of the pinned rod's critical load, pressed at the ends of its axis."""
    rod = make_rod(120.0, 40, radius=1.5)
    load = share * np.pi**2 * rod.bending / 120.0**2
    X, ends, middle = rod.mesh.nodes, rod.axis[[0, -1]], rod.axis[[20]]
    spoke = rod.sections[0][rod.mesh.section.ring[:1]]
    supports = [
        Prescribed(ends, lambda time: X[ends], components=(True, True, False)),
        Prescribed(middle, lambda time: X[middle], components=(False, False, True)),
        Prescribed(spoke, lambda time: X[spoke], components=(False, True, False)),
    ]
    presses = [
        EndForce(rod.sections[end], rod.end_weights, np.array([0.0, 0.0, sign]), lambda t: load)
        for end, sign in ((0, 1.0), (-1, -1.0))
    ]
    x, system, _ = static([*rod.effects, *presses], X, supports, rod.section_index)
    return float(lowest(rod, system, x, 2)[0])


def clamped(share: float) -> float:
    """The same between two beam clamps, one moved by what the load shortens the rod."""
    rod = make_rod(180.0, 60, radius=1.5)
    load = share * 4.0 * np.pi**2 * rod.bending / 180.0**2
    area = rod.bulk.formulation.weights.sum() / rod.mesh.element_length
    X, far, tip = rod.mesh.nodes, rod.sections[-1], rod.axis[[-1]]
    strain = -load / (1.25 * area)
    strain += 1.0 * strain**2
    supports = [
        *beam_clamp(rod),
        Prescribed(far, lambda time: X[far] + [0.0, 0.0, 180.0 * strain], components=(False, False, True)),
        Prescribed(tip, lambda time: X[tip], components=(True, True, False)),
    ]
    x, system, _ = static(rod.effects, X, supports, rod.section_index)
    agree(f"clamped column at {share} of its load, P [N]", -float(system.residual(x)[far, 2].sum()), load, 0.001)
    return float(lowest(rod, system, x, 2)[0])


@pytest.mark.parametrize("support", [pinned, clamped])
def test_euler_buckling(support):
    """The smallest eigenvalue changes sign within 1 % of the critical load."""
    low, high = support(0.99), support(1.01)
    assert low > 0.0 > high
    critical = 0.99 + 0.02 * low / (low - high)
    agree(f"Euler buckling, {support.__name__}, P / P_critical", critical, 1.0, 0.01)
