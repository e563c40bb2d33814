"""Numbers and arrays given to closed forms, checked in one place."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.types import Array


def finite(name: str, values: ArrayLike) -> Array:
    """The values as an array of floats.

    Args:
        name: of the argument, for the message.
        values: any shape.

    Raises:
        InputError: something that is no number, or not finite; the same holds for the other functions of this module.
    """
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("not a number or an array of numbers", key=name, found=repr(values)) from None
    return _only(name, array, np.isfinite(array), "finite numbers")


def positive(name: str, values: ArrayLike) -> Array:
    """The same for values that must be above 0."""
    array = finite(name, values)
    return _only(name, array, array > 0.0, "numbers above 0")


def not_negative(name: str, values: ArrayLike) -> Array:
    """The same for values that must be 0 or above."""
    array = finite(name, values)
    return _only(name, array, array >= 0.0, "numbers from 0 on")


def fraction(name: str, values: ArrayLike) -> Array:
    """The same for values from 0 on and below 1."""
    array = not_negative(name, values)
    return _only(name, array, array < 1.0, "numbers from 0 on and below 1")


def scalar_or_array(values: ArrayLike) -> Any:
    """A result as it is returned: a Python scalar where it has no dimension."""
    array = np.asarray(values)
    return array.item() if array.ndim == 0 else array


def _only(name: str, array: Array, accepted: Array, expected: str) -> Array:
    if not np.all(accepted):
        raise InputError("out of range", key=name, found=float(array[~accepted].flat[0]), expected=expected)
    return array
