"""Force of every shipped knot over a short pull on a coarse mesh, sag of the cantilever, with either model.

Tables and the tool that writes them: `pinned.py`, `write.py`. Strands rub on each other or on the cylinder in all pins
but that of the cantilever.
"""

from __future__ import annotations

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
    """Each on its table, and within 2 % (1.6 % measured) of each other once the knot slides as a whole."""
    rod, solid = (held(name) for name in BOTH)
    assert PINS["overhand-rod"].overrides[1:] == PINS["overhand-fem"].overrides[1:]
    slides = rod[0] > 3.5, solid[0] > 3.5
    rod, solid = ((x[rows], y[rows]) for (x, y), rows in zip((rod, solid), slides, strict=True))
    assert deviation(rod, solid) < 0.02


@pytest.mark.parametrize("change", ["contact.friction=0.3465", "rods.0.material.youngs_modulus=1.46775 MPa"])
def test_change_of_a_few_percent_fails_what_is_pinned(change):
    pin = PINS["overhand-rod"]
    assert pin.deviation(pin.run([change])) > 2.0 * pin.tolerance
