"""Points of a study: every combination of the axes, each with a name that tells its values."""

from __future__ import annotations

import hashlib
import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.study.sweep.study_file import Axis, Random, Study, Values, number_and_unit

SPACED_DIGITS, RANDOM_DIGITS = 12, 6
"""Significant digits of values that are computed, so that 0.15 is not 0.15000000000000002."""
LONGEST_NAME = 120
ONLY = "base"
"""Name of the point of a study without axes."""


@dataclass(frozen=True)
class Point:
    """A combination of the axes' values.

    Attributes:
        name: of its run directory.
        values: by key, as the study gives them.
    """

    name: str
    values: Mapping[str, Any]


def points_of(study: Study) -> list[Point]:
    """All points; the last axis changes fastest."""
    found = [
        {key: value for along in combination for key, value in along.items()}
        for combination in product(*(_along(axis) for axis in study.axes))
    ]
    labels = _labels(study.keys)
    names = ["_".join(f"{labels[key]}={_text(value)}" for key, value in values.items()) or ONLY for values in found]
    return [
        Point(name if names.count(name) == 1 and len(name) <= LONGEST_NAME else _hashed(name, values), values)
        for name, values in zip(names, found, strict=True)
    ]


def values_of(values: Values, key: str) -> list[Any]:
    """The values themselves.

    Args:
        values: how they are given.
        key: whose; drawn values depend on it, so that two keys with one seed are independent.
    """
    if values.values is not None:
        return list(values.values)
    if values.random is not None:
        return _drawn(values.random, key)
    spaced = values.linspace or values.geomspace
    assert spaced is not None, "validated"
    (first, unit), (last, _) = number_and_unit(spaced[0]), number_and_unit(spaced[1])
    numbers = (np.linspace if values.linspace is not None else np.geomspace)(first, last, spaced[2])
    return [_rounded(number, SPACED_DIGITS, unit) for number in numbers.tolist()]


def _along(axis: Axis) -> list[dict[str, Any]]:
    columns = {key: values_of(values, key) for key, values in axis.by_key.items()}
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _drawn(random: Random, key: str) -> list[Any]:
    (low, unit), (high, _) = number_and_unit(random.low), number_and_unit(random.high)
    generator = np.random.default_rng([random.seed, zlib.crc32(key.encode())])
    parts = generator.random(random.count)
    numbers = low * (high / low) ** parts if random.logarithmic else low + (high - low) * parts
    return [_rounded(number, RANDOM_DIGITS, unit) for number in numbers.tolist()]


def _rounded(number: float, digits: int, unit: str) -> float | str:
    short = float(f"{number:.{digits}g}")
    return f"{short:g} {unit}" if unit and float(f"{short:g}") == short else f"{short!r} {unit}" if unit else short


def _labels(keys: Sequence[str]) -> dict[str, str]:
    """The shortest ends of dotted keys that tell them apart."""
    labels = {}
    for key in keys:
        parts = key.split(".")
        ends = [".".join(parts[-n:]) for n in range(1, len(parts) + 1)]
        labels[key] = next(
            end for end in ends if sum(f".{other}".endswith(f".{end}") for other in keys) == 1 or end == key
        )
    return labels


def _text(value: Any) -> str:
    """A value in the name of a folder."""
    if isinstance(value, str):
        plain = Path(value).stem if value.endswith((".toml", ".csv", ".json")) else value
    elif isinstance(value, bool):
        plain = str(value).lower()
    else:
        plain = repr(value)
    return re.sub(r"[^A-Za-z0-9.+-]+", "", plain.replace(" ", "").replace("/", "-"))


def _hashed(name: str, values: Mapping[str, Any]) -> str:
    """A name that is no other point's: cut, with a hash of the values."""
    return f"{name[: LONGEST_NAME - 9]}-{hashlib.sha256(repr(sorted(values.items())).encode()).hexdigest()[:8]}"
