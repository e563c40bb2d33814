import numpy as np
import pytest
from specimens import at_rest

from knotfem.solver.schemes import Scheme
from knotfem.solver.system import System
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.verify.benchmarks.capstan import MIDDLE, drape


@pytest.mark.parametrize("curved", [True, False])
def test_only_a_naturally_curved_rod_is_free_of_stress_on_the_drum(curved):
    draped = drape(8.0, 2.0, 12, 90.0, naturally_curved=curved)
    x, rod = draped.x.copy(), draped.rod
    arc = rod.sections[4:-4]
    out = x[rod.axis[4:-4]] * [1.0, 0.0, 1.0]
    height = np.linalg.norm(out, axis=1)
    assert height == pytest.approx(MIDDLE + 0.12)
    x[arc] -= (0.12 * out / height[:, None])[:, None]
    system = System(draped.band.terms, Unknowns(len(x)), make_solver("auto"), Scheme())
    system.begin(at_rest(x), 1.0)
    assert (np.abs(system.residual(x)[arc[2:-2]]).max() < 1e-6) == curved
