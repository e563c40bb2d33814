"""Refinement series: each changes one choice of a scene that trades accuracy for time, level by level."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from knotfem import shipped
from knotfem.errors import InputError
from knotfem.names import suggestion
from knotfem.scene.elements import ORDERS
from knotfem.scene.model import Scene
from knotfem.study.similarity import frictions_of

BASE = "base"
"""Name of the level that is the scene as it is; every series passes through it."""
SECTIONS = (4, 12, 28, 48, 108)
"""Cross-sections of the series; 12, 48 and 108 are each other's refinements."""
QUADRATIC = ((5, 4.0), (5, 2.0), (12, 4.0))
"""Elements of the cross-section and slices, in units of the scene's own, of quadratic elements."""
SIZES = {
    "slice": (2.0, 1.5, 0.75, 0.5),
    "step": (2.0, 0.25, 0.125, 0.0625),
    "penalty": (4.0, 2.0, 0.5, 0.25),
    "ramp": (2.0, 0.5),
    "tolerance": (100.0, 10.0, 0.1),
    "sampling": (2.0, 0.5),
    "stick": (2.0, 0.5),
    "rate": (10.0, 0.1),
    "settling": (5.0, 0.2),
}
"""Refinement levels of the series that change one number, in units of the scene's own; errors fall with them."""
SERIES = ("section", *SIZES, "uniform", "element", "model", "chosen")
"""All refinement series; the levels of the last three have no sizes, and the last combines levels of the others."""
SIZED = SERIES[:-3]
"""Those whose levels have sizes."""


@dataclass(frozen=True)
class Level:
    """A refinement level: one run of a series.

    Attributes:
        name: of its run directory.
        series: one of `SERIES`; BASE for the scene as it is.
        setting: what differs from the scene, for people.
        size: what the error falls with, in units of the scene's own; None where there is no such size.
        overrides: as for `load_scene`.
    """

    name: str
    series: str
    setting: str
    size: float | None
    overrides: tuple[str, ...] = ()


def base_level() -> Level:
    """The scene as it is."""
    return Level(BASE, BASE, "the scene as it is", 1.0)


def make_series(scene: Scene, names: Sequence[str] = ()) -> dict[str, list[Level]]:
    """Levels by series, from coarse to fine, without the base that they share.

    Args:
        scene: as it is.
        names: of the series wanted; all that the scene has by default.

    Raises:
        InputError: no such series, or the scene does not have it.
    """
    every = {name: levels for name in SERIES if (levels := _levels(name, scene)) or name == "chosen"}
    for name in names:
        if name not in SERIES:
            expected = suggestion(name, list(SERIES))
            raise InputError("no such refinement series", key="--series", found=f'"{name}"', expected=expected)
        if name not in every:
            expected = ", ".join(every)
            raise InputError("the scene has no such refinement series", key="--series", found=name, expected=expected)
    return {name: levels for name, levels in every.items() if name in (names or every)}


def refines(fine: Scene, coarse: Scene) -> bool:
    """Whether a scene is at least as fine as another in every choice, element and model being the same."""
    one, other = fine.rods[0].mesh, coarse.rods[0].mesh
    alike = (fine.model, one.element) == (coarse.model, other.element)
    return alike and all(a <= b for a, b in zip(_sizes(fine), _sizes(coarse), strict=True))


def _sizes(scene: Scene) -> tuple[float, ...]:
    mesh, contact, solver = scene.rods[0].mesh, scene.contact, scene.solver
    return (
        1.0 / mesh.section_elements, mesh.element_length, solver.move_over_diameter, solver.force_tolerance,
        1.0 / contact.stiffness_over_modulus, 1.0 / contact.line_stiffness_over_hertz, contact.ramp_over_diameter,
        contact.sample_spacing_over_diameter, contact.stick_over_diameter,
        scene.quasi_static.tolerance, scene.quasi_static.settling_slip_over_diameter,
    )  # fmt: skip


def _levels(name: str, scene: Scene) -> list[Level]:
    """Levels of a series; none where the scene does not have it."""
    if name in SIZES:
        return _scaled(name, scene)
    makers = {"section": _section_levels, "uniform": _uniform, "element": _elements, "model": _models}
    return makers[name](scene) if name in makers else []


def applies(name: str, scene: Scene) -> bool:
    """Whether a choice of `SIZES` is one that a scene has: whether its model computes what the choice concerns."""
    contact, balanced = scene.contact.enabled, any(not step.real for step in scene.steps)
    return {
        "penalty": contact,
        "ramp": contact,
        "sampling": contact,
        "stick": any(frictions_of(scene)),
        "step": bool(scene.steps),
        "rate": balanced,
        "settling": balanced,
    }.get(name, True)


def resized(name: str, scene: Scene, size: float) -> tuple[str, ...]:
    """Overrides that give a choice of a scene a size.

    Args:
        name: of `SIZES`, or "section", whose number of elements becomes the nearest.
        scene: as it is.
        size: in units of the scene's own.
    """
    if name == "section":
        return _section(scene, round(scene.rods[0].mesh.section_elements / size**2)).overrides
    return _CHANGES[name](scene, size)


def _scaled(name: str, scene: Scene) -> list[Level]:
    """Levels of a series that changes one number."""
    if not applies(name, scene):
        return []
    changes = [(size, resized(name, scene, size)) for size in SIZES[name]]
    return [Level(f"{name}-x{size:g}", name, said(overrides), size, overrides) for size, overrides in changes]


def _models(scene: Scene) -> list[Level]:
    other = "rod" if scene.model == "fem" else "fem"
    return [Level(f"model-{other}", "model", f"model {other}", None, (f"model={other}",))]


def _section_levels(scene: Scene) -> list[Level]:
    return [_section(scene, n) for n in _sections(scene)] if scene.model == "fem" else []


def _sections(scene: Scene) -> list[int]:
    own = scene.rods[0].mesh.section_elements
    known = shipped.section_counts()
    return [n for n in SECTIONS if n in known and not 0.8 < math.sqrt(own / n) < 1.2]


def _section(scene: Scene, count: int) -> Level:
    size = math.sqrt(scene.rods[0].mesh.section_elements / count)
    overrides = tuple(f"rods.{i}.mesh.section_elements={count}" for i in range(len(scene.rods)))
    return Level(f"section-{count}", "section", f"{count} elements", size, overrides)


def _slice(scene: Scene, size: float) -> tuple[str, ...]:
    overrides = [
        f"rods.{i}.mesh.element_length={size * rod.mesh.element_length!r} mm" for i, rod in enumerate(scene.rods)
    ]
    for i, rod in enumerate(scene.rods):
        if rod.mesh.turning_angle is not None:
            overrides.append(f"rods.{i}.mesh.turning_angle={size * rod.mesh.turning_angle!r}")
    return tuple(overrides)


def _penalty(scene: Scene, size: float) -> tuple[str, ...]:
    if scene.model == "rod":
        return (f"contact.line_stiffness_over_hertz={scene.contact.line_stiffness_over_hertz / size!r}",)
    return (f"contact.stiffness_over_modulus={scene.contact.stiffness_over_modulus / size!r}",)


_CHANGES: dict[str, Callable[[Scene, float], tuple[str, ...]]] = {
    "slice": _slice,
    "step": lambda scene, size: (f"solver.move_over_diameter={size * scene.solver.move_over_diameter!r}",),
    "penalty": _penalty,
    "ramp": lambda scene, size: (f"contact.ramp_over_diameter={size * scene.contact.ramp_over_diameter!r}",),
    "tolerance": lambda scene, size: (f"solver.force_tolerance={size * scene.solver.force_tolerance!r} N",),
    "sampling": lambda scene, size: (
        f"contact.sample_spacing_over_diameter={size * scene.contact.sample_spacing_over_diameter!r}",
    ),
    "stick": lambda scene, size: (f"contact.stick_over_diameter={size * scene.contact.stick_over_diameter!r}",),
    "rate": lambda scene, size: (f"quasi_static.tolerance={size * scene.quasi_static.tolerance!r}",),
    "settling": lambda scene, size: (
        f"quasi_static.settling_slip_over_diameter={size * scene.quasi_static.settling_slip_over_diameter!r}",
    ),
}


def _uniform(scene: Scene) -> list[Level]:
    """Everything refined at once: sizes and steps with t, the penalty with 1/t, the tolerance with t^2."""
    if scene.model == "fem":
        own = scene.rods[0].mesh.section_elements
        sizes = [(f"uniform-{n}", math.sqrt(own / n), _section(scene, n).overrides) for n in _sections(scene)]
    else:
        sizes = [(f"uniform-x{t:g}", t, ()) for t in (4.0, 2.0, 0.5, 0.25)]
    levels = []
    for name, t, overrides in sizes:
        for series, change in _CHANGES.items():
            if _levels(series, scene):
                overrides = (*overrides, *change(scene, t**2 if series == "tolerance" else t))
        levels.append(Level(name, "uniform", f"all sizes x {t:.3g}", t, overrides))
    return levels


def _elements(scene: Scene) -> list[Level]:
    """Every other element on the scene's mesh and all on a coarser one; quadratic ones on meshes of far fewer."""
    if scene.model != "fem":
        return []
    own = scene.rods[0].mesh
    coarser = [n for n in SECTIONS if n < own.section_elements]
    levels = []
    for name in ORDERS:
        chosen = tuple(f"rods.{i}.mesh.element={name}" for i in range(len(scene.rods)))
        if name != own.element:
            levels.append(Level(f"element-{name}", "element", name, None, chosen))
        for count, size in QUADRATIC if ORDERS[name] == 2 else [(n, 2.0) for n in coarser[-1:]]:
            overrides = (*chosen, *_section(scene, count).overrides, *_slice(scene, size))
            setting = f"{name}, {count} elements, slices x {size:g}"
            levels.append(Level(f"element-{name}-{count}-x{size:g}", "element", setting, None, overrides))
    return levels


def said(overrides: Sequence[str]) -> str:
    """The value of the first override, shortened, for people."""
    number, _, unit = overrides[0].partition("=")[2].partition(" ")
    return f"{float(number):g} {unit}".strip()
