"""Force of every shipped knot over a short pull on a coarse mesh, sag of the cantilever, with either model.

Tables and the tool that writes them: `pinned.py`, `write.py`. Strands rub on each other or on the cylinder in all pins
but that of the cantilever.
"""

from __future__ import annotations

import numpy as np
import pytest
from curves import Curve
from pinned import SHORT, deviation

PINS = {pin.name: pin for pin in SHORT}
BOTH = ("overhand-rod", "overhand-fem")


def held(name: str) -> Curve:
    """The curve of a pin, as near to its table as it must be."""
    pin = PINS[name]
    assert pin.path.read_text().startswith(pin.head), "the table is of other settings"
    curve = pin.run()
    assert pin.deviation(curve) < pin.tolerance
    return curve


@pytest.mark.parametrize("name", [name for name in PINS if name not in BOTH])
def test_short_curve_pinned(name):
    held(name)


def test_short_overhand_of_rod_and_solid_pinned():
    """Each on its table, and within 1.5 % (1.1 % measured) of each other once the knot slides as a whole."""
    rod, solid = (held(name) for name in BOTH)
    assert PINS["overhand-rod"].overrides[1:] == PINS["overhand-fem"].overrides[1:]
    places = np.arange(5.0, 11.0)
    assert deviation(rod, (places, np.interp(places, *solid))) < 0.015


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("cantilever-fem", "rods.0.material.youngs_modulus=1.46775 MPa"),
        ("capstan-fem", "obstacles.0.friction=0.3465"),
        ("overhand-rod", "rods.0.material.youngs_modulus=1.46775 MPa"),
        ("overhand-rod", "contact.friction=0.3465"),
        ("bowline-rod", "rods.0.material.bulk_over_shear=10.87"),
    ],
)
def test_what_is_a_few_percent_off_fails_to_be_pinned(name, change):
    """Young's modulus by 3 %, friction by 5 %, the shear modulus alone by 3 %."""
    pin = PINS[name]
    assert pin.deviation(pin.run([change])) > pin.tolerance
