"""Units of length in which curves are drawn."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LengthUnit:
    """A unit of length.

    Attributes:
        symbol: as people write it.
        millimetres: in one of it.
        plural: its name.
        others: further ways of writing it, in small letters.
    """

    symbol: str
    millimetres: float
    plural: str
    others: tuple[str, ...] = ()


UNITS = (
    LengthUnit("mm", 1.0, "millimetres", ("millimetre", "millimeter", "millimeters")),
    LengthUnit("cm", 10.0, "centimetres", ("centimetre", "centimeter", "centimeters")),
    LengthUnit("dm", 100.0, "decimetres", ("decimetre", "decimeter", "decimeters")),
    LengthUnit("m", 1000.0, "metres", ("metre", "meter", "meters")),
    LengthUnit("um", 1e-3, "micrometres", ("\u00b5m", "\u03bcm", "micrometre", "micrometer", "micrometers", "micron")),
    LengthUnit("nm", 1e-6, "nanometres", ("nanometre", "nanometer", "nanometers")),
    LengthUnit("in", 25.4, "inches", ("inch",)),
    LengthUnit("ft", 304.8, "feet", ("foot",)),
)


def length_unit(text: str) -> LengthUnit | None:
    """The unit that a text means, in small letters or capitals; None for none that is known."""
    wanted = text.strip().lower()
    return next((unit for unit in UNITS if wanted in (unit.symbol, unit.plural, *unit.others)), None)
