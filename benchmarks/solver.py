"""Assembly, factorisation and solve on a scene's mesh, contact off: best of several, in seconds.

Usage: python benchmarks/solver.py [SCENE [REPEATS]]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

from knotfem.models.solid.solid import Solid
from knotfem.run.machine import usable_threads
from knotfem.scene import load_scene
from knotfem.solver.constraints import Prescribed
from knotfem.solver.schemes import Scheme
from knotfem.solver.system import System
from knotfem.solver.term import Motion, StepStart
from knotfem.sparse.linear import make_solver


def best(function: Callable[[], object], repeats: int) -> float:
    """Shortest wall time of a call [s]."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        function()
        times.append(time.perf_counter() - began)
    return min(times)


def main(name: str = "bowline-paper", repeats: int = 5) -> None:
    """Time the swept and balanced knot of a scene."""
    model, threads = Solid(load_scene(name, ["tie.path=direct"])), usable_threads()
    body = model.body
    began = time.perf_counter()
    (knot,) = model.mapping(model.paths(), "auto")
    hexes = sum(rod.bulk.pressure.size for rod in body.rods)
    print(f"{name}: {hexes} hexahedra, {3 * body.nodes} unknowns, {threads} threads")
    print(f"direct tie           {time.perf_counter() - began:8.3f} s, {knot.iterations} iterations")
    nodes = np.concatenate([rod.axis_nodes for rod in body.rods])
    held = Prescribed(nodes, lambda _: knot.x[nodes])
    system = System(body.elastic, body.nodes, make_solver("auto", threads), Scheme(), [held], body.shift_weights)
    system.begin(StepStart(Motion.at_rest(knot.x), 1.0))
    system.update(knot.x)
    _, matrix = system.tangent(knot.x)
    print(f"residual             {best(lambda: system.residual(knot.x), repeats):8.3f} s")
    print(f"residual and tangent {best(lambda: system.tangent(knot.x), repeats):8.3f} s")
    matrix.constrain(system.fixed.ravel())
    system.solver.analyse(matrix.pattern)
    print(f"factorisation        {best(lambda: system.solver.factorise(matrix), repeats):8.3f} s")
    rhs = np.random.default_rng(0).normal(size=3 * body.nodes)
    print(f"solve                {best(lambda: system.solver.solve(rhs), repeats):8.3f} s")


if __name__ == "__main__":
    main(*sys.argv[1:2], *map(int, sys.argv[2:3]))
