"""Choices of a scene that trade accuracy for time, and their next finer settings."""

from __future__ import annotations

import math
from collections.abc import Mapping

from knotfem import shipped
from knotfem.scene.model import Scene
from knotfem.study.refinement import BASE, SECTIONS, SIZES, Level, applies, base_level, resized, said

FACTORS = {name: max(size for size in sizes if size <= 0.5) for name, sizes in SIZES.items()}
"""Ratio of the next finer size to the present one: as in a convergence study, but at least a halving, since what a
change says of an error is uncertain by 1 / (1 - factor)."""
FINER_SECTION = 0.8
"""Largest ratio of the sizes of elements in a cross-section and in the next finer one."""

Sizes = Mapping[str, float]
"""Sizes by choice, in units of the scene's own; a choice that is missing has 1."""


def choices_of(scene: Scene) -> list[str]:
    """Names of the choices that a scene and its model have."""
    section = ["section"] if scene.model == "fem" and scene.rods[0].mesh.section is None else []
    return [*section, *(name for name in SIZES if applies(name, scene))]


def finer_size(scene: Scene, name: str, sizes: Sizes) -> float | None:
    """The next finer size of a choice; None where there is no finer one."""
    now = sizes.get(name, 1.0)
    if name != "section":
        return now * FACTORS[name]
    own = scene.rods[0].mesh.section_elements
    known = shipped.section_counts()
    finer = [math.sqrt(own / count) for count in SECTIONS if count in known]
    return max((size for size in finer if size <= FINER_SECTION * now), default=None)


def level_at(scene: Scene, sizes: Sizes) -> Level:
    """The scene with sizes of its choices, as a run; the scene itself where all are 1."""
    changed = {name: sizes[name] for name in choices_of(scene) if sizes.get(name, 1.0) != 1.0}
    if not changed:
        return base_level()
    overrides = {name: resized(name, scene, size) for name, size in changed.items()}
    name = "+".join(f"{name}-x{size:.3g}" for name, size in changed.items())
    setting = ", ".join(f"{name} {said(texts)}" for name, texts in overrides.items())
    return Level(name, BASE, setting, None, tuple(text for texts in overrides.values() for text in texts))


def setting_of(scene: Scene, name: str, size: float) -> str:
    """The value of a choice at a size, for people."""
    return said(resized(name, scene, size))
