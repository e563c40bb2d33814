"""NURBS curves in JSON or TOML files."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.errors import InputError
from knotfem.files import read_text
from knotfem.geometry.nurbs import Nurbs, blender_knots
from knotfem.types import Array

NURBS_KEYS = {"name", "points", "degree", "knots", "order_u", "use_endpoint_u", "use_bezier_u", "use_cyclic_u"}


def read_nurbs(path: str | Path) -> Nurbs:
    """Read a NURBS curve from a JSON or TOML file.

    Keys: `points`, a list of [x, y, z, weight] (a weight of 1 may be omitted); then either `degree` and `knots`, or
    `order_u` with `use_endpoint_u` and `use_bezier_u` as in Blender (both false by default); `name` is ignored.

    Args:
        path: file ending in .json or .toml.

    Raises:
        InputError: the file cannot be read, a key is unknown, missing or wrong, or the curve is cyclic.
    """
    path = Path(path)
    data = _read_keys(path)
    if unknown := sorted(set(data) - NURBS_KEYS):
        raise InputError("unknown key", file=path, key=unknown[0], expected=f"one of {', '.join(sorted(NURBS_KEYS))}")
    if _flag(data, "use_cyclic_u", path):
        raise InputError("the curve is closed; a rod has two ends", file=path, key="use_cyclic_u", expected="false")
    homogeneous = _control_points(data, path)
    degree, knots = _degree_and_knots(data, len(homogeneous), path)
    try:
        return Nurbs(degree, homogeneous[:, :3], homogeneous[:, 3], knots)
    except InputError as error:
        raise InputError(error.problem, file=path, found=error.found, expected=error.expected) from None


def _read_keys(path: Path) -> dict[str, Any]:
    text = read_text(path)
    try:
        data: Any = tomllib.loads(text) if path.suffix.lower() == ".toml" else json.loads(text)
    except (tomllib.TOMLDecodeError, json.JSONDecodeError) as error:
        raise InputError(f"broken {path.suffix[1:].upper()}: {error}", file=path) from None
    if not isinstance(data, dict):
        raise InputError("not a NURBS curve", file=path, found=type(data).__name__, expected="keys and values")
    return data


def _control_points(data: dict[str, Any], path: Path) -> Array:
    """Control points and their weights, shape (n, 4)."""
    expected = "a list of [x, y, z] or [x, y, z, weight]"
    try:
        points = np.array(data["points"], dtype=np.float64)
    except (KeyError, TypeError, ValueError):
        raise InputError("no control points", file=path, key="points", expected=expected) from None
    if points.ndim != 2 or points.shape[1] not in (3, 4):
        raise InputError("control points have the wrong shape", file=path, key="points", expected=expected)
    return np.column_stack([points, np.ones(len(points))])[:, :4]


def _degree_and_knots(data: dict[str, Any], count: int, path: Path) -> tuple[int, Array]:
    """Degree and knots as given, or those of a Blender spline with so many control points."""
    if ("order_u" in data) == ("degree" in data):
        raise InputError("the curve needs either order_u or degree", file=path, expected="one of the two")
    if "order_u" in data:
        order = _integer(data, "order_u", path)
        flags = {"endpoint": _flag(data, "use_endpoint_u", path), "bezier": _flag(data, "use_bezier_u", path)}
        return order - 1, blender_knots(count, order, **flags) if order >= 2 else np.zeros(0)
    degree = _integer(data, "degree", path)
    if "knots" not in data:
        raise InputError("knots are missing", file=path, key="knots", expected="a list of numbers")
    try:
        return degree, np.array(data["knots"], dtype=np.float64).reshape(-1)
    except (TypeError, ValueError):
        raise InputError("not a list of numbers", file=path, key="knots", found=data["knots"]) from None


def _integer(data: dict[str, Any], key: str, path: Path) -> int:
    value = data[key]
    if isinstance(value, bool) or not isinstance(value, int):
        raise InputError("not a whole number", file=path, key=key, found=value)
    return value


def _flag(data: dict[str, Any], key: str, path: Path) -> bool:
    value = data.get(key, False)
    if not isinstance(value, bool):
        raise InputError("not a flag", file=path, key=key, found=value, expected="true or false")
    return value
