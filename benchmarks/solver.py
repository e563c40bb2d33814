"""Assembly, factorisation and solve on a scene's mesh, contact off: best of several, in seconds.

Usage: python benchmarks/solver.py [SCENE [REPEATS]]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

import knotfem as kf
from knotfem.models.solid.model import SolidModel
from knotfem.threads import threads_of


def best(function: Callable[[], object], repeats: int) -> float:
    """Shortest wall time of a call [s]."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        function()
        times.append(time.perf_counter() - began)
    return min(times)


def main(name: str, repeats: int) -> None:
    """Time the swept and balanced knot of a scene."""
    model = SolidModel(kf.load_scene(name, {"tie.path": "direct"}))
    began = time.perf_counter()
    knot = next(model.mapping(model.paths(), "auto"))
    x, system = knot.state.x, knot.system
    assert system is not None
    print(f"{name}: {model.hexes} hexahedra, {model.dofs} unknowns, {threads_of(model.scene)} threads")
    print(f"direct tie           {time.perf_counter() - began:8.3f} s, {knot.iterations} iterations")
    system.begin(knot.state, 1.0)
    _, matrix = system.tangent(x)
    print(f"residual             {best(lambda: system.residual(x), repeats):8.3f} s")
    print(f"residual and tangent {best(lambda: system.tangent(x), repeats):8.3f} s")
    matrix.constrain(system.fixed.ravel())
    system.solver.analyse(matrix.pattern)
    print(f"factorisation        {best(lambda: system.solver.factorise(matrix), repeats):8.3f} s")
    rhs = np.random.default_rng(0).normal(size=model.dofs)
    print(f"solve                {best(lambda: system.solver.solve(rhs), repeats):8.3f} s")


if __name__ == "__main__":
    scene, *times = sys.argv[1:] or ["bowline-paper"]
    main(scene, int(times[0]) if times else 5)
