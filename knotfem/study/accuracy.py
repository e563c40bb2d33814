"""What `--accuracy` sets: the cheapest stored settings that promise it."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from knotfem.errors import InputError
from knotfem.run.directory import RunDirectory
from knotfem.scene.load import Overrides, changes_of, load_scene
from knotfem.scene.model import Scene
from knotfem.study.records import Record, Setting, stored
from knotfem.study.similarity import class_of, frictions_of, window_of
from knotfem.study.tables import duration

GOVERNED = (
    r"rods\.\d+\.mesh(\.(section_elements|element_length|element))?",
    r"solver(\.(move_over_diameter|force_tolerance))?",
    r"contact(\.(stiffness|line_stiffness|ramp|sample_spacing|stick)_over_\w+)?",
    r"quasi_static(\..*)?",
    r"accuracy(\..*)?",
)
"""Keys of a scene that `--accuracy` sets, and tables that hold them."""


def parse_fraction(text: str) -> float:
    """Read "2 %" or 0.02.

    Raises:
        InputError: no fraction between 0 and 1.
    """
    match = re.fullmatch(r"\s*([0-9.eE+-]+)\s*(%?)\s*", text)
    try:
        value = float(match.group(1)) * (0.01 if match.group(2) else 1.0) if match else float("nan")
    except ValueError:
        value = float("nan")
    if not 0.0 < value < 1.0:
        raise InputError("not an accuracy", key="--accuracy", found=f'"{text}"', expected='a fraction such as "2%"')
    return value


def recommended(scene: Scene, target: float, records: Sequence[Record]) -> tuple[Record, Setting]:
    """The cheapest settings within a target: of the scene itself where it was measured as it is, else of the nearest.

    Errors against the limit of the scene's own model count, and those of its model against hexahedra. A scene that
    names its model keeps it.

    Args:
        scene: to be run.
        target: largest relative error.
        records: measured ones.

    Raises:
        InputError: none is that accurate.
    """
    kind, alike, found = _measured(scene, records)
    good = [(record, setting) for record, setting in found if setting.bound <= target]
    if not good:
        raise _refusal(scene, target, f"scenes of the class {kind}", alike, found)
    nearest = min((record for record, _ in good), key=lambda record: (_distance(scene, record), record.model != "fem"))
    return min((pair for pair in good if pair[0] is nearest), key=lambda pair: pair[1].cpu_s)


def starting_point(scene: Scene, target: float, records: Sequence[Record]) -> tuple[list[str], str]:
    """Overrides from which a search for an accuracy sets out, and a sentence about them.

    They are the recommended settings; where none promise the target the most accurate that were measured for the
    class, and where nothing was measured for it none, so that the scene stays as it is.

    Args:
        scene: to be run, whose model stays.
        target: largest relative error.
        records: measured ones.
    """
    kind, _, found = _measured(scene, records)
    if not found:
        nothing = f"nothing was measured for scenes of the class {kind} and the model {scene.model}"
        return [], f"the scene as it is: {nothing}"
    if any(setting.bound <= target for _, setting in found):
        record, setting = recommended(scene, target, records)
        return _applied(scene, setting), f"the settings that promise {target:.2%}: {_origin(scene, record, setting)}"
    record, setting = min(found, key=lambda pair: pair[1].bound)
    none = f"none promise {target:.2%}"
    best = f"the most accurate settings that were measured for scenes of the class {kind}"
    return _applied(scene, setting), f"{best} ({none}): {_origin(scene, record, setting)}"


def _origin(scene: Scene, record: Record, setting: Setting) -> str:
    figures = ", ".join(_figures(scene, setting))
    return f"{setting.level} of {record.scene} ({figures}), error {setting.bound:.2%} there"


def _measured(scene: Scene, records: Sequence[Record]) -> tuple[str, list[Record], list[tuple[Record, Setting]]]:
    """Class of a scene, the records of this class, and what was measured for the scene, or else for its class."""
    kind = class_of(scene)
    alike = [record for record in records if record.scene_class == kind]
    own = [record for record in alike if not _differences(scene, record)]
    return kind, alike, _promised(scene, own) or _promised(scene, alike)


def _promised(scene: Scene, records: Sequence[Record]) -> list[tuple[Record, Setting]]:
    """Settings whose errors hold for a scene and its model."""
    named = "model" in scene.model_fields_set
    return [
        (record, setting)
        for record in records
        for setting in record.settings
        if (setting.model == scene.model or not named)
        and (record.model == scene.model or (record.model == "fem" and setting.model == scene.model))
    ]


def _distance(scene: Scene, record: Record) -> float:
    """How far a scene is from a measured one of its class: in the window, as a ratio, and in friction."""
    window = abs(math.log((1.0 + window_of(scene)) / (1.0 + record.window)))
    return window + sum(abs(a - b) for a, b in zip(frictions_of(scene), record.frictions, strict=True))


def _refusal(
    scene: Scene, target: float, what: str, alike: Sequence[Record], found: Sequence[tuple[Record, Setting]]
) -> InputError:
    key = "--accuracy"
    if not alike:
        expected = f"a scene of a class that was measured: knotfem cost {scene.name} --store measures this one"
        return InputError(f"no settings were measured for {what}", key=key, expected=expected)
    if not found:
        problem = f"{what} were measured with other models only"
        expected = f"another model, or knotfem cost {scene.name} --model {scene.model} --store"
        return InputError(problem, key=key, found=f"model {scene.model}", expected=expected)
    finest = min(setting.bound for _, setting in found)
    expected = f"{finest:.2%} or more (knotfem cost {scene.name} measures finer settings)"
    problem = f"no settings were measured to be that accurate for {what}"
    return InputError(problem, key=key, found=f"{target:.2%}", expected=expected)


def accurate_overrides(source: str, overrides: Sequence[str], accuracy: str) -> tuple[tuple[str, ...], str]:
    """Overrides that bring a scene to an accuracy, before the user's own, and a sentence about them.

    Args:
        source: a scene, as for `load_scene`.
        overrides: the user's own.
        accuracy: largest relative error, such as "2%".

    Raises:
        InputError: none is that accurate, an override sets what the accuracy decides, or the source is a run.
    """
    target = parse_fraction(accuracy)
    if RunDirectory.is_run(source):
        raise InputError("a run keeps its settings", file=source, key="--accuracy", expected="a scene")
    refuse_governed(overrides)
    scene = load_scene(source, overrides)
    record, setting = recommended(scene, target, stored())
    chosen = [
        *_applied(scene, setting),
        f"accuracy.wanted={target!r}",
        f"accuracy.measured={setting.bound!r}",
        f'accuracy.quantity="{record.quantity}"',
        f'accuracy.scene="{record.scene}"',
        f'accuracy.level="{setting.level}"',
    ]
    return (*chosen, *overrides), _says(scene, target, record, setting)


def refuse_governed(overrides: Overrides) -> None:
    """Refuse overrides of what an accuracy decides.

    Raises:
        InputError: the first of them.
    """
    for key in changes_of(overrides):
        if any(re.fullmatch(pattern, key) for pattern in GOVERNED):
            raise InputError("--accuracy decides this", file="--set", key=key, expected="either of the two")


def _says(scene: Scene, target: float, record: Record, setting: Setting) -> str:
    extrapolated = _differences(scene, record)
    window = f" for a pull of {record.window:.3g} d" if record.window else ""
    return (
        f"{target:.2%} in the {record.quantity}: settings of {setting.level} ({', '.join(_figures(scene, setting))}), "
        f"measured on {record.scene}{_driven(setting)} against the reference of the model {record.model} "
        f"({record.date}, knotfem {record.version}): error {setting.error:.2%} +- {setting.uncertainty:.2%}, "
        f"{duration(setting.wall_s)} there ({record.machine.get('processor', 'another machine')}, "
        f"{record.machine.get('processors', 1)} processors){window}"
        + (f"; an extrapolation: {', '.join(extrapolated)}" if extrapolated else "")
    )


def _driven(setting: Setting) -> str:
    """That no quasi-static steps were measured, where that is so."""
    return " before there were quasi-static steps," if setting.rate is None else ""


def _differences(scene: Scene, record: Record) -> list[str]:
    """What makes a measured scene another one."""
    window, frictions = window_of(scene), frictions_of(scene)
    found = [] if record.scene == scene.name else ["another scene"]
    if not math.isclose(window, record.window, rel_tol=1e-6):
        found.append(f"a pull of {record.window:.3g} d there and {window:.3g} d here")
    if not all(math.isclose(a, b, rel_tol=1e-6) for a, b in zip(frictions, record.frictions, strict=True)):
        there, here = (", ".join(f"{value:g}" for value in values) for values in (record.frictions, frictions))
        found.append(f"friction {there} there and {here} here")
    if any(step.real for step in scene.steps):
        found.append("steps in real time")
    return found


def _figures(scene: Scene, setting: Setting) -> list[str]:
    """The settings that a model reads, for people."""
    solid = setting.model == "fem"

    def named(found: str, own: str) -> str:
        return found if found == own else f"{found} in place of {own}"

    section = [f"element {setting.element}", f"section of {setting.section_elements} elements"] if solid else []
    stiffness = setting.stiffness if solid else setting.line_stiffness
    penalty = [] if stiffness is None or not scene.contact.enabled else [f"penalty {stiffness:g}"]
    return [
        f"model {named(setting.model, scene.model)}",
        *section,
        f"slices of {setting.element_length:.3g} d",
        f"step {setting.move:g} d",
        *penalty,
        f"tolerance {_tolerance(scene, setting):.4g} N",
        *([] if setting.rate is None else [f"at most {setting.rate:.3g} of the load carried by drag"]),
        *([] if setting.settling is None else [f"slip of {setting.settling:.3g} d in a step that settles"]),
    ]


def _tolerance(scene: Scene, setting: Setting) -> float:
    return setting.tolerance * scene.youngs_modulus * scene.diameter**2


def _applied(scene: Scene, setting: Setting) -> list[str]:
    overrides = [
        f"model={setting.model}",
        f"solver.move_over_diameter={setting.move!r}",
        f"solver.force_tolerance={_tolerance(scene, setting)!r} N",
        f"contact.stiffness_over_modulus={setting.stiffness!r}",
        f"contact.sample_spacing_over_diameter={setting.sample_spacing!r}",
        f"contact.stick_over_diameter={setting.stick!r}",
    ]
    later = {
        "quasi_static.tolerance": setting.rate,
        "quasi_static.settling_slip_over_diameter": setting.settling,
        "contact.line_stiffness_over_hertz": setting.line_stiffness,
        "contact.ramp_over_diameter": setting.ramp,
    }
    overrides += [f"{key}={value!r}" for key, value in later.items() if value is not None]
    for i, rod in enumerate(scene.rods):
        overrides += [
            f"rods.{i}.mesh.element={setting.element}",
            f"rods.{i}.mesh.section_elements={setting.section_elements}",
            f"rods.{i}.mesh.element_length={setting.element_length * rod.diameter!r} mm",
        ]
    return overrides
