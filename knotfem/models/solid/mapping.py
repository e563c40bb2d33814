"""The tying phase: bulk and core follow the mapped centreline, contact off."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from knotfem.errors import InputError, NotConverged
from knotfem.geometry.frames import rotation_minimising_frame, tangents
from knotfem.solver.constraints import Prescribed
from knotfem.solver.nonlinear.newton import Iterations, NewtonSettings, StepFailed, solve
from knotfem.solver.schemes import Scheme
from knotfem.solver.system import System
from knotfem.solver.term import Motion, StepStart
from knotfem.sparse.linear import make_solver
from knotfem.tie import CentrelinePath, swept_state

if TYPE_CHECKING:
    from knotfem.models.solid.body import Body, RodBody

LOOSE = 0.1
"""Tolerance [N] of increments on the way, which only show that the solid can follow; the last is solved to the scene's
own."""
PATIENCE = 3
"""Times the iterations of a step: an increment cannot be tried again with a shorter one."""


@dataclass(frozen=True)
class Increment:
    """One increment of the mapping.

    Attributes:
        mapping_time: 0 to 1.
        stretch: of every edge of every rod, shape [edges].
        iterations: of Newton's method.
        solved: whether the solid could follow; only the last increment must.
        wall: [s].
        x: positions [mm], shape [nodes, 3].
        smallest_j: smallest determinant of the deformation gradient.
        system: what was solved, with its clock; None where nothing was.
    """

    mapping_time: float
    stretch: np.ndarray
    iterations: int
    solved: bool
    wall: float
    x: np.ndarray
    smallest_j: float
    system: System | None = None


def mapping(
    body: Body,
    paths: list[CentrelinePath],
    times: Sequence[float],
    settings: NewtonSettings,
    threads: int,
    solver_name: str,
) -> Iterator[Increment]:
    """Carry the straight rods along their paths.

    Each increment is swept onto its centreline and solved from there, so that one on the way that no solid can follow
    (the linear path crushes the rod) is reported and passed over; the last is the same for every path.

    Args:
        body: straight rods.
        paths: of all rods.
        times: mapping times of the increments, the last being 1.
        settings: of a step.
        threads: of the linear solver.
        solver_name: its name.

    Raises:
        NotConverged: the last increment was not solved.
    """
    exact = replace(settings, max_iterations=PATIENCE * settings.max_iterations)
    loose = _loosened(exact)
    frames = [_carried_frames(path, times) for path in paths]
    solver = make_solver(solver_name, threads)
    nodes = np.concatenate([_held_nodes(rod) for rod in body.rods])
    x = np.empty((body.nodes, 3))
    follow = Prescribed(nodes, lambda _: x[nodes])
    system = System(body.elastic, body.nodes, solver, Scheme(), [follow], body.shift_weights)
    for number, mapping_time in enumerate(times):
        began = time.perf_counter()
        last = number == len(times) - 1
        stretch = [path.stretch(mapping_time) for path in paths]
        took, solved = Iterations(), True
        try:
            for rod, path, frame, stretched in zip(body.rods, paths, frames, stretch, strict=True):
                _sweep(x, rod, path.at(mapping_time), frame[number], stretched)
            x, took = _balance(body, system, x, exact if last else loose)
        except (InputError, StepFailed) as error:
            if last:
                raise NotConverged(f"mapping: the last increment was not solved: {error}") from error
            solved = False
        smallest = min(rod.bulk.smallest_j for rod in body.rods)
        wall = time.perf_counter() - began
        yield Increment(mapping_time, np.concatenate(stretch), took.count, solved, wall, x, smallest, system)
    system.close()


def _held_nodes(rod: RodBody) -> np.ndarray:
    return np.unique(np.concatenate([rod.axis_nodes, rod.section_nodes[0], rod.section_nodes[-1]]))


def _loosened(settings: NewtonSettings) -> NewtonSettings:
    factor = max(1.0, LOOSE / settings.force_tolerance)
    return replace(
        settings,
        force_tolerance=factor * settings.force_tolerance,
        resultant_tolerance=factor * settings.resultant_tolerance,
    )


def _balance(body: Body, system: System, x: np.ndarray, settings: NewtonSettings) -> tuple[np.ndarray, Iterations]:
    start = StepStart(Motion.at_rest(x), 1.0)
    system.begin(start)
    return solve(system, x, start, settings, body.sections)


def _sweep(x: np.ndarray, rod: RodBody, points: np.ndarray, start: np.ndarray, stretch: np.ndarray) -> None:
    """Put a rod's sections onto a centreline, free of stress history."""
    frames = rotation_minimising_frame(points, start)
    x[rod.section_nodes] = swept_state(
        points, frames, rod.section_points, rod.scene.material.poissons_ratio, stretch=stretch
    )
    rod.bulk.forget()
    if rod.core is not None:
        rod.core.force[:] = 0.0


def _carried_frames(path: CentrelinePath, times: Sequence[float]) -> list[np.ndarray]:
    """First section's d1 at each time, carried without spin, rolled so that it ends the same for every path."""
    first = [tangents(path.at(t))[0] for t in (0.0, *times)]
    carried = [rotation_minimising_frame(path.at(0.0))[0, 0]]
    for before, after in pairwise(first):
        carried.append(_turned(carried[-1], before, after))
    goal = rotation_minimising_frame(path.at(1.0))[0, 0]
    across = np.cross(first[-1], carried[-1])
    angle = np.arctan2(goal @ across, goal @ carried[-1])
    return [np.cos(angle) * d1 + np.sin(angle) * np.cross(t, d1) for t, d1 in zip(first[1:], carried[1:], strict=True)]


def _turned(d1: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """d1 turned by the smallest rotation that takes the tangent `before` to `after`."""
    axis = np.cross(before, after)
    return d1 + np.cross(axis, d1) + np.cross(axis, np.cross(axis, d1)) / (1.0 + before @ after)
