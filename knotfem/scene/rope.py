"""A scene for another rope: its lengths, stresses and forces in proportion to the rope's diameter and modulus."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from typing import Annotated, Any, Self, get_args, get_origin

from pydantic import Field, ValidationError, model_validator

from knotfem.errors import ROPE, InputError
from knotfem.names import suggestion
from knotfem.scene.quantity import LENGTH, PRESSURE, PositiveLength, PositivePressure, Quantity
from knotfem.scene.table import Flag, Friction, Number, Table, input_errors, one_error, refusal

POWERS = {"mm": (1, 0), "mm/s": (1, 0), "MPa": (0, 1), "N": (2, 1)}
"""Powers of the ratios of diameters and of moduli by which quantities of these units are scaled; others stay."""
THICKEST_CORE = 0.9
"""Of a scaled core, over the thickness of its rod; a core that is to be thicker has another modulus instead."""
DIGITS = 12
"""Of scaled numbers, so that 600 mm are 1000 mm and not 1000.0000000000001 mm."""

Ratio = Annotated[Number, Field(gt=0.0)]


class Rope(Table):
    """The rope that a user has.

    Attributes:
        diameter: of the thinnest rod; None for that of the scene [mm].
        youngs_modulus: of the softest rod; None likewise [MPa].
        friction: rope on rope; None likewise.
        obstacle_friction: rope on all obstacles; None likewise.
    """

    diameter: PositiveLength | None = None
    youngs_modulus: PositivePressure | None = None
    friction: Friction | None = None
    obstacle_friction: Friction | None = None

    @model_validator(mode="after")
    def _check_something(self) -> Self:
        if all(getattr(self, key) is None for key in type(self).model_fields):
            raise refusal("nothing of the rope is given", expected=f"one of {', '.join(type(self).model_fields)}")
        return self


class Scaled(Table):
    """How a scene was made for another rope: a record, which only curves with a unit of their own heed.

    Attributes:
        scene: that was scaled.
        diameter: of its thinnest rod [mm].
        youngs_modulus: of its softest rod [MPa].
        friction: of it, rope on rope.
        obstacles_kept: whether rope on rope rubs otherwise, and rope on obstacles as before.
        lengths: by which all lengths were multiplied, with them displacements and speeds, and curves whose files have a
            unit.
        stresses: likewise moduli.
        forces: likewise forces and their tolerance.
    """

    scene: str
    diameter: PositiveLength
    youngs_modulus: PositivePressure
    friction: Friction
    obstacles_kept: Flag = False
    lengths: Ratio = 1.0
    stresses: Ratio = 1.0
    forces: Ratio = 1.0

    @property
    def weight(self) -> float:
        """Ratio of weight to stiffness, rho g d / E, over that of the scene that was scaled."""
        return self.lengths / self.stresses

    @property
    def inertia(self) -> float:
        """Ratio of inertia to stiffness, rho v^2 / E, over that of the scene that was scaled."""
        return self.lengths**2 / self.stresses

    def __str__(self) -> str:
        kinds = {"lengths and speeds": self.lengths, "stresses": self.stresses, "forces": self.forces}
        changed = [f"{kind} x {ratio:.4g}" for kind, ratio in kinds.items() if ratio != 1.0]
        what = ", ".join(changed) if changed else "friction only"
        kept = "; friction on obstacles as it was (obstacle_friction changes it)" if self.obstacles_kept else ""
        of = f"{self.scene} of {self.diameter:g} mm and {self.youngs_modulus:g} MPa"
        return f"{of} scaled: {what}; times as they were{kept}"


@dataclass(frozen=True)
class Ratios:
    """By what a scene is multiplied.

    Attributes:
        diameter: new over old.
        modulus: likewise.
    """

    diameter: float
    modulus: float

    def of(self, unit: str) -> float:
        """Of quantities with a unit."""
        length, stress = POWERS.get(unit, (0, 0))
        return self.diameter**length * self.modulus**stress


def read_rope(given: Mapping[str, Any]) -> Rope:
    """The rope that is given by texts with units.

    Raises:
        InputError: what is wrong with it.
    """
    try:
        return Rope.model_validate(dict(given))
    except ValidationError as error:
        raise one_error(input_errors(error, given, file=ROPE)) from None


def tables_for(rope: Rope, scene: Any) -> dict[str, Any]:
    """Tables of a scene for another rope; see `knotfem.scene.model.Scene.with_rope`.

    Args:
        rope: wanted.
        scene: validated.
    """
    before = scene.contact.friction
    ratios = Ratios(
        1.0 if rope.diameter is None else rope.diameter / scene.diameter,
        1.0 if rope.youngs_modulus is None else rope.youngs_modulus / scene.youngs_modulus,
    )
    tables = multiplied(scene, ratios)
    for rod, made in zip(scene.rods, tables["rods"], strict=True):
        if isinstance(rod.scale, float):
            made["scale"] = rod.scale * ratios.diameter
        if rod.core is not None:
            made["core"] = _core(rod, ratios)
    if rope.friction is not None:
        _rub(tables, rope.friction, rope.friction / before if before > 0.0 else 1.0)
    for obstacle in tables["obstacles"] if rope.obstacle_friction is not None else ():
        obstacle["friction"] = rope.obstacle_friction
    earlier = scene.rope
    record = earlier.model_dump(mode="json") if earlier is not None else {
        "scene": scene.name,
        "diameter": f"{scene.diameter!r} mm",
        "youngs_modulus": f"{scene.youngs_modulus!r} MPa",
        "friction": before,
    }  # fmt: skip
    for kind, unit in (("lengths", "mm"), ("stresses", "MPa"), ("forces", "N")):
        record[kind] = float(f"{(1.0 if earlier is None else getattr(earlier, kind)) * ratios.of(unit):.{DIGITS}g}")
    if rope.friction is not None or rope.obstacle_friction is not None:
        record["obstacles_kept"] = bool(scene.obstacles) and rope.obstacle_friction is None
    return {**tables, "rope": record}


def _core(rod: Any, ratios: Ratios) -> dict[str, Any]:
    """The core of another rope: its axial stiffness in proportion, by its radius as long as there is room for it."""
    core = rod.core
    wanted = core.radius * ratios.diameter * sqrt(ratios.modulus)
    radius = min(wanted, THICKEST_CORE * 0.5 * rod.diameter * ratios.diameter)
    return {
        "youngs_modulus": PRESSURE.format(_rounded(core.youngs_modulus * (wanted / radius) ** 2)),
        "radius": LENGTH.format(_rounded(radius)),
    }


def _rounded(number: float) -> float:
    return float(f"{number:.{DIGITS}g}")


def _rub(tables: dict[str, Any], friction: float, ratio: float) -> None:
    """Give the rods of a scene another friction on each other, pairs and schedules in proportion."""
    rods = {rod["name"] for rod in tables["rods"]}
    tables["contact"]["friction"] = friction
    for pair in tables["contact"]["pairs"]:
        if set(pair["between"]) <= rods:
            pair["friction"] *= ratio
    for step in tables["steps"]:
        for point in step["friction_schedule"]:
            point["friction"] *= ratio


def rope_of(texts: tuple[str, ...]) -> dict[str, Any]:
    """Keys and values of texts such as "diameter=10 mm".

    Raises:
        InputError: a text that is not of this kind.
    """
    found: dict[str, Any] = {}
    for text in texts:
        key, equals, value = (part.strip() for part in text.partition("="))
        if key not in Rope.model_fields or not equals:
            expected = suggestion(key, Rope.model_fields) + ', such as diameter="10 mm"'
            raise InputError("not a property of a rope", file=ROPE, found=f'"{text}"', expected=expected)
        try:
            found[key] = float(value) if key.endswith("friction") else value
        except ValueError:
            raise InputError("not a number", file=ROPE, key=key, found=f'"{value}"', expected="such as 0.25") from None
    return found


def multiplied(table: Table, ratios: Ratios) -> dict[str, Any]:
    """Values of a table of a scene, those with the unit of a length, speed, stress or force multiplied.

    Gravity, densities, fluids and times stay.

    Args:
        table: validated.
        ratios: by what.
    """
    fields = type(table).model_fields
    return {
        name: _multiplied(getattr(table, name), _annotation(fields[name].annotation, fields[name].metadata), ratios)
        for name in table.model_dump(exclude_none=True)
    }


def _annotation(annotation: Any, metadata: list[Any]) -> Any:
    quantities = tuple(entry for entry in metadata if isinstance(entry, Quantity))
    return Annotated[annotation, *quantities] if quantities else annotation


def _multiplied(value: Any, annotation: Any, ratios: Ratios) -> Any:
    """A value multiplied as the annotation of its field says."""
    if isinstance(value, Table):
        return multiplied(value, ratios)
    if isinstance(value, Mapping):
        return {key: _multiplied(entry, None, ratios) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        kinds = get_args(annotation) if get_origin(annotation) is tuple else ()
        return [_multiplied(entry, kinds[i] if i < len(kinds) else None, ratios) for i, entry in enumerate(value)]
    quantity = quantity_of(annotation)
    if quantity is None or value is None:
        return value
    return quantity.format(_rounded(value * ratios.of(quantity.unit)))


def quantity_of(annotation: Any) -> Quantity | None:
    """What a value of an annotation measures; None for plain numbers and texts."""
    if get_origin(annotation) is Annotated:
        kind, *metadata = get_args(annotation)
        found = next((entry for entry in metadata if isinstance(entry, Quantity)), None)
        return found or quantity_of(kind)
    if get_origin(annotation) in (tuple, list, dict):
        return None
    return next((found for kind in get_args(annotation) if (found := quantity_of(kind)) is not None), None)
