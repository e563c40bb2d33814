"""What `--accuracy` sets: the cheapest stored settings that promise it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from knotfem.cost.records import Record, Setting, class_of, softest, stored, thinnest
from knotfem.errors import InputError
from knotfem.scene.load import load_scene
from knotfem.scene.model import Scene

GOVERNED = (
    r"rods\.\d+\.mesh(\.(section_elements|element_length|element))?",
    r"solver(\.(move_over_diameter|force_tolerance))?",
    r"contact(\.(stiffness|sample_spacing|stick)_over_\w+)?",
    r"accuracy(\..*)?",
)
"""Keys of a scene that `--accuracy` sets, and tables that hold them."""


def parse_share(text: str) -> float:
    """Read "2 %" or 0.02.

    Raises:
        InputError: no share between 0 and 1.
    """
    match = re.fullmatch(r"\s*([0-9.eE+-]+)\s*(%?)\s*", text)
    try:
        value = float(match.group(1)) * (0.01 if match.group(2) else 1.0) if match else float("nan")
    except ValueError:
        value = float("nan")
    if not 0.0 < value < 1.0:
        raise InputError("not an accuracy", key="--accuracy", found=f'"{text}"', expected='a share such as "2%"')
    return value


def recommended(
    scene: Scene, target: float, records: Sequence[Record], model: str | None = None
) -> tuple[Record, Setting]:
    """The cheapest settings within a target: of the scene itself where it was measured, else of its class.

    Args:
        scene: to be run.
        target: largest relative error.
        records: measured ones.
        model: that must be kept, or none.

    Raises:
        InputError: none is that accurate.
    """
    kind = class_of(scene)
    alike = [record for record in records if record.scene_class == kind]
    own = [record for record in alike if record.scene == scene.name]
    found = [(record, s) for record in own or alike for s in record.settings if model in (None, s.model)]
    good = [(record, s) for record, s in found if s.bound <= target]
    if good:
        return min(good, key=lambda pair: pair[1].cpu_s)
    known = (
        f"{min(s.bound for _, s in found):.2%} or more (knotfem cost {scene.name} measures finer settings)"
        if found
        else f"a scene of a class that was measured: knotfem cost {scene.name} --store measures this one"
    )
    problem = f"no settings were measured to be that accurate for scenes of the class {kind}"
    raise InputError(problem, key="--accuracy", found=f"{target:.2%}", expected=known)


def accurate_overrides(source: str, overrides: Sequence[str], accuracy: str) -> tuple[tuple[str, ...], str]:
    """Overrides that bring a scene to an accuracy, before the user's own, and a sentence about them.

    Args:
        source: a scene, as for `load_scene`.
        overrides: the user's own.
        accuracy: largest relative error, such as "2%".

    Raises:
        InputError: none is that accurate, an override sets what the accuracy decides, or the source is a run.
    """
    target = parse_share(accuracy)
    if Path(source).is_dir():
        raise InputError("a run keeps its settings", file=source, key="--accuracy", expected="a scene")
    for override in overrides:
        key = override.partition("=")[0].strip()
        if any(re.fullmatch(pattern, key) for pattern in GOVERNED):
            raise InputError("--accuracy decides this", file="--set", key=key, expected="either of the two")
    scene = load_scene(source, overrides)
    asked = [override.partition("=")[2] for override in overrides if override.partition("=")[0].strip() == "model"]
    record, setting = recommended(scene, target, stored(), asked[-1].strip() if asked else None)
    chosen = [
        *_applied(scene, setting),
        f"accuracy.wanted={target!r}",
        f"accuracy.measured={setting.bound!r}",
        f'accuracy.quantity="{record.quantity}"',
        f'accuracy.scene="{record.scene}"',
        f'accuracy.rung="{setting.rung}"',
    ]
    says = (
        f"{target:.2%} in the {record.quantity}: settings of {setting.rung}, measured on {record.scene} "
        f"({record.date}, knotfem {record.version}): error {setting.error:.2%} +- {setting.uncertainty:.2%}, "
        f"{setting.wall_s / 60.0:.1f} min there for a pull of {record.window:.3g} d"
    )
    return (*chosen, *overrides), says


def _applied(scene: Scene, setting: Setting) -> list[str]:
    overrides = [
        f"model={setting.model}",
        f"solver.move_over_diameter={setting.move!r}",
        f"solver.force_tolerance={setting.tolerance * softest(scene) * thinnest(scene) ** 2!r} N",
        f"contact.stiffness_over_modulus={setting.stiffness!r}",
        f"contact.sample_spacing_over_diameter={setting.sample_spacing!r}",
        f"contact.stick_over_diameter={setting.stick!r}",
    ]
    for i, rod in enumerate(scene.rods):
        overrides += [
            f"rods.{i}.mesh.element={setting.element}",
            f"rods.{i}.mesh.section_elements={setting.section_elements}",
            f"rods.{i}.mesh.element_length={setting.element_length * rod.diameter!r} mm",
        ]
    return overrides
