"""Ladders: the choices of a scene that trade accuracy for time, each with rungs from coarse to fine."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from knotfem import shipped
from knotfem.errors import InputError
from knotfem.names import suggestion
from knotfem.scene.elements import ORDERS
from knotfem.scene.model import Scene
from knotfem.study.likeness import frictions_of

BASE = "base"
"""Name of the rung that is the scene as it is; every ladder passes through it."""
SECTIONS = (4, 12, 28, 48, 108)
"""Cross-sections of the ladders; 12, 48 and 108 are each other's refinements."""
QUADRATIC = ((5, 4.0), (5, 2.0), (12, 4.0))
"""Elements of the cross-section and slices, in units of the scene's own, of quadratic elements."""
SIZES = {
    "slice": (2.0, 1.5, 0.75, 0.5),
    "step": (2.0, 0.25, 0.125, 0.0625),
    "penalty": (4.0, 2.0, 0.5, 0.25),
    "tolerance": (100.0, 10.0, 0.1),
    "sampling": (2.0, 0.5),
    "stick": (2.0, 0.5),
}
"""Rungs of the ladders of one number, in units of the scene's own; errors fall with them."""
LADDERS = ("section", *SIZES, "uniform", "element", "model", "chosen")
"""All ladders; the sizes of the last three say nothing, and the last follows from what the others come to."""
SIZED = LADDERS[:-3]


@dataclass(frozen=True)
class Rung:
    """One run of a ladder.

    Attributes:
        name: of its run directory.
        ladder: one of `LADDERS`; BASE for the scene as it is.
        setting: what differs from the scene, for people.
        size: what the error falls with, in units of the scene's own; None where sizes say nothing.
        overrides: as for `load_scene`.
    """

    name: str
    ladder: str
    setting: str
    size: float | None
    overrides: tuple[str, ...] = ()


def base_rung() -> Rung:
    """The scene as it is."""
    return Rung(BASE, BASE, "the scene as it is", 1.0)


def make_ladders(scene: Scene, names: Sequence[str] = ()) -> dict[str, list[Rung]]:
    """Rungs by ladder, from coarse to fine, without the base that they share.

    Args:
        scene: as it is.
        names: of the ladders wanted; all that the scene has by default.

    Raises:
        InputError: no such ladder, or the scene does not have it.
    """
    every = {name: rungs for name in LADDERS if (rungs := _ladder(name, scene)) or name == "chosen"}
    for name in names:
        if name not in LADDERS:
            raise InputError(
                "no such ladder", key="--ladder", found=f'"{name}"', expected=suggestion(name, list(LADDERS))
            )
        if name not in every:
            raise InputError("the scene has no such ladder", key="--ladder", found=name, expected=", ".join(every))
    return {name: rungs for name, rungs in every.items() if name in (names or every)}


def refines(fine: Scene, coarse: Scene) -> bool:
    """Whether a scene is at least as fine as another in every choice, element and model being the same."""
    one, other = fine.rods[0].mesh, coarse.rods[0].mesh
    alike = (fine.model, one.element) == (coarse.model, other.element)
    return alike and all(a <= b for a, b in zip(_sizes(fine), _sizes(coarse), strict=True))


def _sizes(scene: Scene) -> tuple[float, ...]:
    mesh, contact, solver = scene.rods[0].mesh, scene.contact, scene.solver
    return (
        1.0 / mesh.section_elements, mesh.element_length, solver.move_over_diameter, solver.force_tolerance,
        1.0 / contact.stiffness_over_modulus, contact.sample_spacing_over_diameter, contact.stick_over_diameter,
    )  # fmt: skip


def _ladder(name: str, scene: Scene) -> list[Rung]:
    solid, contact = scene.model == "fem", scene.contact.enabled
    if name == "section":
        return [_section(scene, n) for n in _sections(scene)] if solid else []
    if name == "uniform":
        return _uniform(scene)
    if name == "element":
        return _elements(scene) if solid else []
    if name == "model":
        other = "rod" if solid else "fem"
        return [Rung(f"model-{other}", name, f"model {other}", None, (f"model={other}",))]
    has = {
        "penalty": contact and solid,
        "sampling": contact,
        "stick": solid and any(frictions_of(scene)),
        "step": bool(scene.steps),
    }
    if name not in SIZES or not has.get(name, True):
        return []
    change = _CHANGES[name]
    return [
        Rung(f"{name}-x{size:g}", name, _says(change(scene, size)), size, change(scene, size)) for size in SIZES[name]
    ]


def _sections(scene: Scene) -> list[int]:
    own = scene.rods[0].mesh.section_elements
    known = shipped.section_counts()
    return [n for n in SECTIONS if n in known and not 0.8 < math.sqrt(own / n) < 1.2]


def _section(scene: Scene, count: int) -> Rung:
    size = math.sqrt(scene.rods[0].mesh.section_elements / count)
    overrides = tuple(f"rods.{i}.mesh.section_elements={count}" for i in range(len(scene.rods)))
    return Rung(f"section-{count}", "section", f"{count} elements", size, overrides)


def _slice(scene: Scene, size: float) -> tuple[str, ...]:
    return tuple(f"rods.{i}.mesh.element_length={size * rod.mesh.element_length!r} mm" for i, rod in _numbered(scene))


def _numbered(scene: Scene):
    return enumerate(scene.rods)


_CHANGES: dict[str, Callable[[Scene, float], tuple[str, ...]]] = {
    "slice": _slice,
    "step": lambda scene, size: (f"solver.move_over_diameter={size * scene.solver.move_over_diameter!r}",),
    "penalty": lambda scene, size: (f"contact.stiffness_over_modulus={scene.contact.stiffness_over_modulus / size!r}",),
    "tolerance": lambda scene, size: (f"solver.force_tolerance={size * scene.solver.force_tolerance!r} N",),
    "sampling": lambda scene, size: (
        f"contact.sample_spacing_over_diameter={size * scene.contact.sample_spacing_over_diameter!r}",
    ),
    "stick": lambda scene, size: (f"contact.stick_over_diameter={size * scene.contact.stick_over_diameter!r}",),
}


def _uniform(scene: Scene) -> list[Rung]:
    """Everything refined at once: sizes and steps with t, the penalty with 1/t, the tolerance with t^2."""
    if scene.model == "fem":
        own = scene.rods[0].mesh.section_elements
        levels = [(f"uniform-{n}", math.sqrt(own / n), _section(scene, n).overrides) for n in _sections(scene)]
    else:
        levels = [(f"uniform-x{t:g}", t, ()) for t in (4.0, 2.0, 0.5, 0.25)]
    rungs = []
    for name, t, overrides in levels:
        for ladder, change in _CHANGES.items():
            if _ladder(ladder, scene):
                overrides = (*overrides, *change(scene, t**2 if ladder == "tolerance" else t))
        rungs.append(Rung(name, "uniform", f"all sizes x {t:.3g}", t, overrides))
    return rungs


def _elements(scene: Scene) -> list[Rung]:
    """Every other element on the scene's mesh and all on a coarser one; quadratic ones on meshes of far fewer."""
    own = scene.rods[0].mesh
    coarser = [n for n in SECTIONS if n < own.section_elements]
    rungs = []
    for name in ORDERS:
        chosen = tuple(f"rods.{i}.mesh.element={name}" for i, _ in _numbered(scene))
        if name != own.element:
            rungs.append(Rung(f"element-{name}", "element", name, None, chosen))
        for count, size in QUADRATIC if ORDERS[name] == 2 else [(n, 2.0) for n in coarser[-1:]]:
            overrides = (*chosen, *_section(scene, count).overrides, *_slice(scene, size))
            setting = f"{name}, {count} elements, slices x {size:g}"
            rungs.append(Rung(f"element-{name}-{count}-x{size:g}", "element", setting, None, overrides))
    return rungs


def _says(overrides: Sequence[str]) -> str:
    """The value of the first override, shortened."""
    number, _, unit = overrides[0].partition("=")[2].partition(" ")
    return f"{float(number):g} {unit}".strip()
