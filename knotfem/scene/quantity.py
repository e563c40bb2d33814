"""Physical quantities of a scene: text with a unit outside, a float in mm, N, MPa, s, tonne inside."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from decimal import Decimal
from decimal import Overflow as DecimalOverflow
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, cast

from pydantic import GetCoreSchemaHandler
from pydantic_core import PydanticCustomError, core_schema

from knotfem.errors import InputError

if TYPE_CHECKING:
    from pint import UnitRegistry

_PATTERN = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\D.*)?", re.DOTALL)
_FACTOR = r"(?:1|[A-Za-zµ°%_]+(?:\s?(?:\^|\*\*)\s?-?\d)?)"
_UNIT = re.compile(rf"{_FACTOR}(?:(?:\s?[*/]\s?|\s){_FACTOR})*")

_TYPESET = {"⁻": "^-", "^-¹": "^-1", "^-²": "^-2", "^-³": "^-3", "²": "^2", "³": "^3", "·": "*"}
"""Signs in typeset units such as kg/m³, in this order."""


@dataclass(frozen=True)
class Quantity:
    """What a number measures; as pydantic metadata it reads text with a unit and writes it back without loss.

    Attributes:
        what: name for messages, with its article.
        unit: unit of the float inside.
        display: unit that people write, used where it gives the same float back.
        example: for messages.
        minimum: smallest allowed float, or none.
        open_minimum: whether the minimum itself is refused.
        maximum: largest allowed float, or none.
        reason: of the bounds, for messages.
    """

    what: str
    unit: str
    display: str
    example: str
    minimum: float | None = None
    open_minimum: bool = False
    maximum: float | None = None
    reason: str = ""

    @property
    def expected(self) -> str:
        """What a message asks for."""
        bound = "" if self.minimum is None else f" {'above' if self.open_minimum else 'of at least'} {self.minimum:g}"
        if self.maximum is not None:
            bound += f" and at most {self.maximum:g} {self.unit}"
        reason = f" ({self.reason})" if self.reason else ""
        return f'{self.what}{bound}{reason} with a unit, such as "{self.example}"'

    def parse(self, value: object) -> float:
        """Read text such as "6 mm".

        Raises:
            PydanticCustomError: a bare number, an unknown unit, the wrong dimension or a value out of bounds.
        """
        if isinstance(value, int | float) and not isinstance(value, bool):
            raise self._error("a bare number, its unit is missing")
        match = _PATTERN.fullmatch(value) if isinstance(value, str) else None
        if match is None:
            raise self._error("not a number with a unit")
        digits, unit = match.groups()
        if not unit:
            raise self._error("a bare number, its unit is missing")
        factor = _factor(unit.strip(), self.unit)
        if isinstance(factor, str):
            raise self._error(factor)
        try:
            number = float(Decimal(digits) * factor)
        except DecimalOverflow:
            number = math.inf
        if math.isinf(number):
            raise self._error("too large a number")
        if not self._within(number):
            raise self._error("out of range", self._meant(digits, unit.strip()))
        return number

    def _within(self, number: float) -> bool:
        low = self.minimum is None or number > self.minimum or (number == self.minimum and not self.open_minimum)
        return low and (self.maximum is None or number <= self.maximum)

    def _meant(self, digits: str, unit: str) -> str:
        """A question, where milli stands for mega or the other way round."""
        other = unit[:1].swapcase() + unit[1:]
        factor = _factor(other, self.unit) if unit[:1] in "mM" else ""
        meant = not isinstance(factor, str) and self._within(float(Decimal(digits) * factor))
        return f'; did you mean "{digits} {other}"?' if meant else ""

    def format(self, number: float) -> str:
        """Text with a unit that `parse` reads as the identical float."""
        if self.display != self.unit:
            factor = Decimal(_factor(self.display, self.unit))
            shown = repr(float(Decimal(repr(number)) / factor))
            if float(Decimal(shown) * factor) == number:
                return f"{_short(shown)} {self.display}"
        return f"{_short(repr(number))} {self.unit}"

    def _error(self, problem: str, question: str = "") -> PydanticCustomError:
        expected = self.expected + question
        return PydanticCustomError("quantity", "{problem}", {"problem": problem, "expected": expected})

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(
            self.parse, serialization=core_schema.plain_serializer_function_ser_schema(self.format, when_used="json")
        )


def parse_quantity(text: str, quantity: Quantity, key: str) -> float:
    """Read a quantity outside a scene, such as the value of a command-line option.

    Args:
        text: such as "60 mm".
        quantity: what it measures.
        key: name of the option for the message.

    Raises:
        InputError: no such quantity.
    """
    try:
        return quantity.parse(text)
    except PydanticCustomError as error:
        raise InputError(error.message(), key=key, found=f'"{text}"', expected=quantity.expected) from None


def _short(digits: str) -> str:
    return digits.removesuffix(".0")


@cache
def _registry() -> UnitRegistry:
    import pint  # half a second: only for who reads a scene

    return pint.UnitRegistry(non_int_type=cast(Any, Decimal))


@cache
def _factor(unit: str, into: str) -> Decimal | str:
    """The exact factor between two units, or what is wrong with the first."""
    import pint

    registry = _registry()
    for raised, plain in _TYPESET.items():
        unit = unit.replace(raised, plain)
    if not _UNIT.fullmatch(unit):
        return f'no unit is called "{unit}"'
    try:
        return registry.Quantity(Decimal(1), registry.parse_units(unit)).to(into).magnitude
    except pint.errors.DimensionalityError:
        return f'"{unit}" measures something else'
    except (pint.errors.PintError, ValueError, TypeError):  # a TypeError: logarithmic units take no exact numbers
        return f'no unit is called "{unit}"'


_LENGTH = ("a length", "mm", "mm", "6 mm")
_PRESSURE = ("a pressure", "MPa", "MPa", "1.25 MPa")
_FORCE = ("a force", "N", "N", "0.5 N")
_SPEED = ("a speed", "mm/s", "mm/s", "4 mm/s")
_DENSITY = ("a density", "tonne/mm^3", "kg/m^3", "1160 kg/m^3")
_TIME = ("a time", "s", "s", "10 s")
_RATE = ("a rate", "1/s", "1/s", "20 1/s")
_ACCELERATION = ("an acceleration", "mm/s^2", "m/s^2", "9.81 m/s^2")
_RESISTANCE = ("a coefficient of resistance", "MPa s", "Pa s", "2 Pa s")
_ANGLE = ("an angle", "rad", "deg", "90 deg")

LENGTH = Quantity(*_LENGTH)
FORCE = Quantity(*_FORCE)
PRESSURE = Quantity(*_PRESSURE)
DURATION = Quantity(*_TIME, minimum=0.0, open_minimum=True)

Length = Annotated[float, LENGTH]
Angle = Annotated[float, Quantity(*_ANGLE)]
Duration = Annotated[float, Quantity(*_TIME, minimum=0.0)]
Force = Annotated[float, Quantity(*_FORCE, minimum=0.0)]
Rate = Annotated[
    float, Quantity(*_RATE, minimum=0.0, maximum=1e6, reason="rods that are slowed down faster stand still")
]
Resistance = Annotated[float, Quantity(*_RESISTANCE, minimum=0.0)]
Acceleration = Annotated[float, Quantity(*_ACCELERATION, minimum=0.0, maximum=1e8, reason="the Earth has 9810")]
PositiveLength = Annotated[float, Quantity(*_LENGTH, minimum=0.0, open_minimum=True)]
PositiveDuration = Annotated[float, DURATION]
PositiveForce = Annotated[float, Quantity(*_FORCE, minimum=0.0, open_minimum=True)]
PositivePressure = Annotated[
    float, Quantity(*_PRESSURE, minimum=1e-6, maximum=1e7, reason="soft gels have 1e-3 MPa, diamond 1e6 MPa")
]
PositiveSpeed = Annotated[
    float, Quantity(*_SPEED, minimum=0.0, open_minimum=True, maximum=1e6, reason="1 km/s; knots are pulled slowly")
]
PositiveDensity = Annotated[float, Quantity(*_DENSITY, minimum=1e-15, maximum=1e-6, reason="water has 1e-9 tonne/mm^3")]
