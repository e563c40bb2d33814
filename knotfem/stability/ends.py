"""Which ends of a step are loaded, and which are free to run."""

from __future__ import annotations

from collections.abc import Sequence

from knotfem.scene.steps import Driven, Free, Loaded, Step

FREE_FRACTION = 0.5
"""An end that bears at most this fraction of the largest load is free to run."""

Place = tuple[str, str]
"""Rod and side of an end."""


def loaded_ends(step: Step) -> list[Place]:
    """Ends that are driven; where there are none, those that bear more than `FREE_FRACTION` of the largest load."""
    driven = step.having(Driven)
    if driven:
        return driven
    loads = _loads(step)
    largest = max(loads.values(), default=0.0)
    return [place for place, load in loads.items() if largest > 0.0 and load > FREE_FRACTION * largest]


def free_ends(step: Step) -> list[Place]:
    """Ends on which nothing acts, or a load so small that they are no loaded ends; empty without a loaded end."""
    loaded = loaded_ends(step)
    if not loaded:
        return []
    return [place for place in (*step.having(Free), *_loads(step)) if place not in loaded]


def deciding_steps(steps: Sequence[Step]) -> list[Step]:
    """Steps with a loaded and a free end, which show whether the knot holds."""
    return [step for step in steps if free_ends(step)]


def _loads(step: Step) -> dict[Place, float]:
    return {place: end.force for place, end in step.all_ends().items() if isinstance(end, Loaded)}
