"""Units: read exactly, written back without loss, refused with one message."""

import contextlib
import math
from typing import Any, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from knotfem.errors import InputError
from knotfem.scene import quantity as q

VALUES = [
    (q.Length, "6 mm", 6.0),
    (q.Length, "0.6 m", 600.0),
    (q.Length, "-1e2 um", -0.1),
    (q.Length, "2in", 50.8),
    (q.PositivePressure, "1.25 MPa", 1.25),
    (q.PositivePressure, "75.5 GPa", 75500.0),
    (q.PositivePressure, "3 N/mm^2", 3.0),
    (q.PositiveDensity, "1160 kg/m^3", 1.16e-9),
    (q.PositiveDensity, "1160 kg/m³", 1.16e-9),
    (q.PositiveDensity, "1160 kg·m⁻³", 1.16e-9),
    (q.PositiveDensity, "1.16 g/cm**3", 1.16e-9),
    (q.Acceleration, "9.81 m/s^2", 9810.0),
    (q.Rate, "20 1/s", 20.0),
    (q.Rate, "20 Hz", 20.0),
    (q.PositiveSpeed, "0.24 m/min", 4.0),
    (q.Force, "250 mN", 0.25),
    (q.Duration, "0.5 h", 1800.0),
    (q.Angle, "90 deg", math.pi / 2),
    (q.Angle, "-2 rad", -2.0),
]


@pytest.mark.parametrize(("kind", "text", "expected"), VALUES)
def test_reads_exactly(kind: Any, text: str, expected: float) -> None:
    assert TypeAdapter(kind).validate_python(text) == expected


@pytest.mark.parametrize(("kind", "text", "expected"), VALUES)
def test_writes_what_it_reads(kind: Any, text: str, expected: float) -> None:
    adapter = TypeAdapter(kind)
    assert adapter.validate_python(adapter.dump_python(expected, mode="json")) == expected


def test_writes_units_that_people_use() -> None:
    assert TypeAdapter(q.PositiveDensity).dump_python(1.16e-9, mode="json") == "1160 kg/m^3"
    assert TypeAdapter(q.Angle).dump_python(math.pi / 2, mode="json") == "90 deg"
    assert TypeAdapter(q.Acceleration).dump_python(9810.0, mode="json") == "9.81 m/s^2"


@pytest.mark.parametrize("kind", [q.Length, q.Angle])
@given(number=st.floats(allow_nan=False, allow_infinity=False))
def test_any_float_survives(kind: Any, number: float) -> None:
    adapter = TypeAdapter(kind)
    assert adapter.validate_python(adapter.dump_python(number, mode="json")) == number


@given(number=st.floats(min_value=1e-15, max_value=1e-6))
def test_any_density_survives(number: float) -> None:
    adapter = TypeAdapter(q.PositiveDensity)
    assert adapter.validate_python(adapter.dump_python(number, mode="json")) == number


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        (6, "unit is missing"),
        (6.5, "unit is missing"),
        ("6", "unit is missing"),
        ("6 MPa", "measures something else"),
        ("6 mm^2", "measures something else"),
        ("6 degC", "measures something else"),
        ("6 mmm", "no unit is called"),
        ("6 mm)", "no unit is called"),
        ("6 2 mm", "no unit is called"),
        ("6 dB", "measures something else"),
        ("mm", "not a number with a unit"),
        ("", "not a number with a unit"),
        ("nan mm", "not a number with a unit"),
        ("inf mm", "not a number with a unit"),
        ("six mm", "not a number with a unit"),
        (True, "not a number with a unit"),
        (None, "not a number with a unit"),
        (["6 mm"], "not a number with a unit"),
        ("1e400 mm", "too large"),
        ("1e999999999 m", "too large"),
    ],
)
def test_refuses(value: object, problem: str) -> None:
    with pytest.raises(ValidationError, match=problem):
        TypeAdapter(q.Length).validate_python(value)


@pytest.mark.parametrize("text", ["0 mm", "-1 mm"])
def test_positive_means_positive(text: str) -> None:
    assert TypeAdapter(q.Length).validate_python(text) <= 0
    with pytest.raises(ValidationError, match="out of range"):
        TypeAdapter(q.PositiveLength).validate_python(text)


def test_zero_of_what_may_vanish() -> None:
    assert TypeAdapter(q.Force).validate_python("0 N") == 0.0
    with pytest.raises(ValidationError, match="out of range"):
        TypeAdapter(q.Force).validate_python("-1 N")


def test_every_example_is_accepted() -> None:
    kinds = [kind for kind in vars(q).values() if get_args(kind) and isinstance(get_args(kind)[-1], q.Quantity)]
    assert len(kinds) > 10
    for kind in kinds:
        TypeAdapter(kind).validate_python(get_args(kind)[-1].example)


def test_option_values() -> None:
    assert q.parse_quantity("6 cm", q.LENGTH, "--at") == 60.0
    with pytest.raises(InputError, match=r'--at: a bare number.*found "60".*such as "6 mm"'):
        q.parse_quantity("60", q.LENGTH, "--at")


@given(unit=st.text(alphabet="mMPa/^*()[]'\"_.1 -+kgs%°#\\\n\t", max_size=12))
def test_no_text_is_anything_but_read_or_refused(unit: str) -> None:
    with contextlib.suppress(ValidationError):
        assert math.isfinite(TypeAdapter(q.Length).validate_python(f"1 {unit}"))
