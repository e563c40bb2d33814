"""What a run is expected to take, found out without running it."""

from __future__ import annotations

from functools import cache

from knotfem.mesh.make_section import section_from, section_of
from knotfem.run.check import ITERATIONS_A_MM, MEMORY_MB, RELAXING_ITERATIONS, seconds_an_iteration
from knotfem.scene.elements import ORDERS
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod
from knotfem.scene.steps import Pull

OTHER_STEP_ITERATIONS = 200.0
ITERATIONS_A_STEP = 4.0
"""At the least, of a step that the step limit keeps short."""
ROD_UNKNOWNS = 4
START_SECONDS = 8.0
"""Until a process has loaded its kernels."""


def expected_seconds(scene: Scene) -> float:
    """Wall seconds of a run; right within a factor of three, and good for ranking runs of one scene."""
    pulled = sum(step.displacement for step in scene.loading_steps if isinstance(step, Pull))
    others = sum(not isinstance(step, Pull) for step in scene.loading_steps)
    short = ITERATIONS_A_STEP * pulled / (scene.solver.move_over_diameter * scene.diameter)
    iterations = RELAXING_ITERATIONS[scene.model] * bool(scene.tying_steps)
    iterations += max(ITERATIONS_A_MM[scene.model] * pulled, short)
    iterations += OTHER_STEP_ITERATIONS * others
    return START_SECONDS + iterations * seconds_an_iteration(scene.model, unknowns(scene))


def expected_memory(scene: Scene) -> float:
    """Memory of a run [MB]."""
    return MEMORY_MB[0] + MEMORY_MB[1] * unknowns(scene)


def unknowns(scene: Scene) -> int:
    """Unknowns of a scene's mesh."""
    if scene.model == "rod":
        return sum(ROD_UNKNOWNS * (rod.slices + 1) for rod in scene.rods)
    return sum(3 * (rod.slices + 1) * _section_nodes(rod) for rod in scene.rods)


def _section_nodes(rod: Rod) -> int:
    order = ORDERS[rod.mesh.element]
    if rod.mesh.section is not None:
        return len(section_from(rod.mesh.section, order).points)
    return _nodes(rod.mesh.section_elements, order)


@cache
def _nodes(count: int, degree: int) -> int:
    return len(section_of(count, degree).points)
