"""Time and memory that a run is expected to take, from its scene alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

from knotfem.errors import InputError
from knotfem.mesh.make_section import chosen_section
from knotfem.models.centreline import slices_of
from knotfem.scene.elements import ORDERS
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod
from knotfem.scene.steps import Pull, Release, Step
from knotfem.stability.ends import deciding_steps, loaded_ends

MEMORY_MB = (330.0, 0.021)
"""Memory of a run: in all, and for each unknown; measured on the bowline at 15,000 and 96,000 unknowns."""
SAMPLE_MB = 5.3e-4
"""Of a contact sample on a surface; measured on the bowline with 29,000 and 816,000 samples."""
SAMPLES_PER_AREA = 1.5
"""Samples on a surface over its area divided by the square of their largest distance: they lie at equal distances in
each element."""
ITERATIONS_PER_STEP = 4.0
"""Of Newton's method at the least, where the step limit keeps time steps short."""


@dataclass(frozen=True)
class Cost:
    """What runs of a model were measured to take.

    Attributes:
        factor, power: CPU seconds of a Newton iteration with one thread, factor times unknowns to the power; measured
            on the bowline at 15,000 and 96,000 unknowns and on the figure-eight.
        per_diameter: Newton iterations for each diameter of a pull: 90 in the bowline, 290 in the figure-eight of
            hexahedra.
        settling: Newton iterations of a step that pulls nothing, such as one that relaxes or lets go.
        loading: of one whose forces act on ends.
        lowering: of one with a friction schedule.
        unravelling: those that a knot takes beyond them that unravels under its load.
        width: unknowns of a node.
    """

    factor: float
    power: float
    per_diameter: float
    settling: float
    loading: float
    lowering: float
    unravelling: float
    width: int

    def seconds_per_iteration(self, unknowns: int) -> float:
        """Expected wall time of a Newton iteration [s]."""
        return self.factor * unknowns**self.power


COSTS = {
    "fem": Cost(2.38e-7, 1.381, 150.0, 500.0, 1700.0, 7000.0, 4100.0, 3),
    "rod": Cost(8.3e-6, 1.0, 80.0, 350.0, 1200.0, 5000.0, 2900.0, 4),
}
"""Of rods, the 54 points of the bowline's stability diagram took 1,860 iterations where the knot holds (800 to 2,950)
and 4,760 where it unravels (2,900 to 7,040), and lowering its friction from 0.4 to 0 took 3,800 to 6,700. Those of
hexahedra under loads are in proportion to the settling ones; they were not measured."""


@dataclass(frozen=True)
class Expected:
    """What a run is expected to take.

    Attributes:
        unknowns: of its model.
        seconds: CPU time with one thread [s] once its kernels are loaded; right within a factor of three.
        if_it_unravels: the same where the knot unravels in a step in which it may.
        memory_mb: memory [MB].
    """

    unknowns: int
    seconds: float
    if_it_unravels: float
    memory_mb: float


def expected(scene: Scene, unknowns: int | None = None) -> Expected:
    """What a run of a scene is expected to take.

    Args:
        scene: what is run.
        unknowns: of its model; None to count them, for which curves may have to be read.

    Raises:
        InputError: as `count_unknowns` raises it.
    """
    cost, count = COSTS[scene.model], count_unknowns(scene) if unknowns is None else unknowns
    each = cost.seconds_per_iteration(count)
    held, unravelled = _iterations(scene, cost), cost.unravelling if may_unravel(scene) else 0.0
    return Expected(count, held * each, (held + unravelled) * each, _memory_mb(scene, count))


def may_unravel(scene: Scene) -> bool:
    """Whether a knot that unravels is a result of the scene, which then takes longer; elsewhere it ends the run."""
    return scene.contact.enabled and any(not step.must_hold for step in deciding_steps(scene.steps))


def _iterations(scene: Scene, cost: Cost) -> float:
    """Of all steps, where the knot holds."""
    per_diameter = max(cost.per_diameter, ITERATIONS_PER_STEP / scene.solver.move_over_diameter)
    return sum(
        per_diameter * step.displacement / scene.diameter if isinstance(step, Pull) else _resting_iterations(step, cost)
        for step in scene.steps
    )


def _resting_iterations(step: Step, cost: Cost) -> float:
    """Of a step that pulls nothing."""
    if step.friction_schedule:
        return cost.lowering
    return cost.loading if loaded_ends(step) and not isinstance(step, Release) else cost.settling


def _memory_mb(scene: Scene, unknowns: int) -> float:
    samples = _surface_samples(scene) if scene.contact.enabled and scene.model == "fem" else 0.0
    in_all, each = MEMORY_MB
    return in_all + each * unknowns + SAMPLE_MB * samples


def refuse_too_large(scene: Scene) -> None:
    """Refuse a scene that needs more memory than the machine has, before anything is built.

    Raises:
        InputError: it does.
    """
    unknowns, there = count_unknowns(scene), machine_memory_mb()
    needed = _memory_mb(scene, unknowns)
    if needed > there:
        problem = "needs more memory than this machine has"
        expected = f"at most {there / 1024:.3g} GB; larger elements, fewer rods or samples further apart need less"
        found = f"about {needed / 1024:.3g} GB for {unknowns:,} unknowns and their contact samples"
        raise InputError(problem, key="rods.mesh.element_length", found=found, expected=expected)


def machine_memory_mb() -> float:
    """Memory of this machine [MB]."""
    import psutil

    return psutil.virtual_memory().total / 2**20


def count_unknowns(scene: Scene) -> int:
    """Unknowns of a scene's model, which is not built.

    Raises:
        InputError: a centreline along which no rod can lie.
    """
    width = COSTS[scene.model].width
    section = _section_nodes if scene.model == "fem" else lambda rod: 1
    rods = zip(scene.rods, slices_of(scene), strict=True)
    return sum(width * (slices.count + 1) * section(rod) for rod, slices in rods)


def _surface_samples(scene: Scene) -> float:
    spacing = scene.contact.sample_spacing_over_diameter * scene.diameter
    return SAMPLES_PER_AREA * sum(math.pi * rod.diameter * rod.length for rod in scene.rods) / spacing**2


def _section_nodes(rod: Rod) -> int:
    return _nodes(rod.mesh.section, rod.mesh.section_elements, ORDERS[rod.mesh.element])


@cache
def _nodes(file: str | None, count: int, degree: int) -> int:
    return len(chosen_section(file, count, degree).points)
