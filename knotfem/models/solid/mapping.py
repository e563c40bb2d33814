"""The tying phase: bulk and core follow the mapped centreline, contact off."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from knotfem.errors import InputError, NotConverged
from knotfem.geometry.finite_rotation import rotate, smallest_rotation
from knotfem.geometry.frames import rotation_minimising_frame, tangents
from knotfem.models.base import Increment
from knotfem.models.solid.body import Body, SolidRod
from knotfem.solver.constraints import Prescribed
from knotfem.solver.nonlinear.newton import Newton, Solution, StepFailed
from knotfem.solver.schemes import Scheme
from knotfem.solver.state import Motion, State
from knotfem.solver.system import System
from knotfem.sparse.linear import make_solver
from knotfem.tie import CentrelinePath, swept_state

LOOSE = 0.1
"""Tolerance [N] of increments on the way, which only show that the solid can follow; the last is solved to the scene's
own."""
PATIENCE = 3
"""Times the iterations of a step: an increment cannot be retried with a shorter one."""


def mapping(
    body: Body,
    paths: list[CentrelinePath],
    times: Sequence[float],
    newton: Newton,
    threads: int,
    solver_name: str,
) -> Iterator[Increment]:
    """Carry the straight rods along their paths.

    Each increment is swept onto its centreline and solved from there, so that one on the way that no solid can follow
    (the linear path crushes the rod) is reported and skipped; the last is the same for every path.

    Args:
        body: straight rods.
        paths: of all rods.
        times: mapping times of the increments, the last being 1.
        newton: of a step.
        threads: of the linear solver.
        solver_name: its name.

    Raises:
        NotConverged: the last increment was not solved.
    """
    exact = newton.patient(PATIENCE)
    loose = replace(exact, tolerance=exact.tolerance.loosened(LOOSE))
    frames = [_carried_frames(path, times) for path in paths]
    nodes = np.concatenate([_held_nodes(rod) for rod in body.rods])
    x = np.empty((body.nodes, 3))
    follow = Prescribed(nodes, lambda _: x[nodes])
    system = System(body.elastic, body.unknowns, make_solver(solver_name, threads), Scheme(), [follow])
    for number, mapping_time in enumerate(times):
        began = time.perf_counter()
        last = number == len(times) - 1
        stretch = [path.stretch(mapping_time) for path in paths]
        iterations, solved = 0, True
        try:
            for rod, path, frame, stretched in zip(body.rods, paths, frames, stretch, strict=True):
                _sweep(x, rod, path.at(mapping_time), frame[number], stretched, mapping_time)
            solution = _balance(body, system, x, exact if last else loose)
            x, iterations = solution.x, solution.iterations
        except (InputError, StepFailed) as error:
            if last:
                raise NotConverged(f"mapping: the last increment was not solved: {error}") from error
            solved = False
        smallest = min(rod.bulk.smallest_j for rod in body.rods)
        state = system.state(Motion.at_rest(x))
        wall = time.perf_counter() - began
        yield Increment(mapping_time, np.concatenate(stretch), iterations, solved, wall, state, smallest, system)
    system.close()


def _held_nodes(rod: SolidRod) -> np.ndarray:
    return np.unique(np.concatenate([rod.axis_nodes, rod.section_nodes[0], rod.section_nodes[-1]]))


def _balance(body: Body, system: System, x: np.ndarray, newton: Newton) -> Solution:
    """Solve from a swept state, whose pressures and core forces are none."""
    step = system.begin(State.of(Motion.at_rest(x), {}), 1.0)
    return newton.solve(system, x, step, body.sections)


def _sweep(
    x: np.ndarray, rod: SolidRod, points: np.ndarray, start: np.ndarray, stretch: np.ndarray, mapping_time: float
) -> None:
    """Put a rod's sections onto a centreline, twisted evenly in proportion to the mapping time."""
    frames = rotation_minimising_frame(points, start)
    if rod.scene.twist != 0.0:
        angle = mapping_time * rod.scene.twist * rod.target.slices.fractions
        for director in (0, 1):
            frames[:, director] = rotate(frames[:, director], frames[:, 2], angle)
    x[rod.section_nodes] = swept_state(
        points, frames, rod.section_points, rod.scene.material.poissons_ratio, stretch=stretch
    )


def _carried_frames(path: CentrelinePath, times: Sequence[float]) -> np.ndarray:
    """First section's d1 at each time, carried without rotation about the tangent, shape [times, 3].

    All are turned by one angle so that the last is the same for every path.
    """
    first = [tangents(path.at(t))[0] for t in (0.0, *times)]
    carried = [rotation_minimising_frame(path.at(0.0))[0, 0]]
    for before, after in pairwise(first):
        carried.append(smallest_rotation(before, after).apply(carried[-1]))
    goal = rotation_minimising_frame(path.at(1.0))[0, 0]
    across = np.cross(first[-1], carried[-1])
    angle = np.arctan2(goal @ across, goal @ carried[-1])
    return rotate(np.array(carried[1:]), np.array(first[1:]), np.full(len(times), angle))
