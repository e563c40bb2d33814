"""Tension profiles of several runs at one displacement."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from knotfem.errors import InputError
from knotfem.run.curves import Curve
from knotfem.run.profile import stored_states

Profiles = dict[str, dict[str, np.ndarray]]
"""Columns s_over_L, tension_over_force, x_mm, y_mm, z_mm by rod."""
TOUCHING = 1.2
"""Distance between axes below which strands count as the knot, in diameters."""


def common_profiles(curves: Sequence[Curve], high: float, at: float | None) -> tuple[list[float], list[Profiles]]:
    """Displacements and profiles of the stored states nearest to `at`, or to the last that all runs have.

    Args:
        curves: of the runs.
        high: largest displacement that all runs have [mm].
        at: displacement [mm], or None.

    Returns:
        One a run; nothing where `at` is None and the runs have no such state.

    Raises:
        InputError: a run has stored nothing near `at`.
    """
    states = [_stored(curve) for curve in curves]
    if at is None:
        held = [d for d in states[0][1] if d <= high * (1.0 + 1e-9)]
        if not held:
            return [], []
        wanted = held[-1]
    else:
        wanted = at
    chosen: list[float] = []
    for curve, (_, stored) in zip(curves, states, strict=True):
        places = np.array(sorted(stored))
        nearest = float(places[np.argmin(np.abs(places - wanted))]) if places.size else np.inf
        spacing = max((b - a for a, b in pairwise(places)), default=0.0)
        if abs(nearest - wanted) > max(0.5 * spacing, 1e-6 * max(1.0, abs(wanted))):
            if at is None:
                return [], []
            found = f"{places.min():g} to {places.max():g} mm" if places.size else "none"
            raise InputError(
                "no tension is stored near this displacement", file=curve.run.path, key="--at", found=found
            )
        chosen.append(nearest)
    return chosen, [_profile(c, d, *s) for c, d, s in zip(curves, chosen, states, strict=True)]


Times = dict[float, float]
"""Time [s] of each state that the pulls have stored, by the displacement over all pulls [mm]."""


def _stored(curve: Curve) -> tuple[dict[str, np.ndarray], Times]:
    """The table of profiles and its states."""
    try:
        states = stored_states(curve.run)
    except InputError:
        return {}, {}
    found: Times = {}
    for time, displacement in zip(states.times, states.displacements, strict=True):
        for start, end, gone in curve.spans:
            if start < time <= end * (1.0 + 1e-12) and displacement > 0.0:
                found[gone + float(displacement)] = float(time)
    return states.table, found


def _profile(curve: Curve, displacement: float, table: dict[str, np.ndarray], times: Times) -> Profiles:
    rows = table["time_s"] == times[displacement]
    names = table.get("rod", np.full(rows.shape, curve.run.scene.rods[0].name))
    scale = float(curve.at(displacement))
    return {
        str(name): {
            "s_over_L": table["s_over_L"][rows & (names == name)],
            "tension_over_force": table["tension_N"][rows & (names == name)] / scale,
            **{axis: table[axis][rows & (names == name)] for axis in ("x_mm", "y_mm", "z_mm") if axis in table},
        }
        for name in dict.fromkeys(names[rows].tolist())
    }


def in_one(profiles: Profiles) -> dict[str, np.ndarray]:
    """All rods in one table, with a gap in the curve between them."""
    gap = np.array([np.nan])
    columns = ("s_over_L", "tension_over_force")
    return {key: np.concatenate([part for p in profiles.values() for part in (p[key], gap)]) for key in columns}


def profiles_apart(profiles: Profiles, first: Profiles) -> float | None:
    """Relative L2 difference of T/F at the arclengths of the first; None where the rods have other names."""
    if profiles.keys() != first.keys():
        return None
    here, there = [], []
    for name, reference in first.items():
        s = reference["s_over_L"]
        there.append(reference["tension_over_force"])
        here.append(np.interp(s, profiles[name]["s_over_L"], profiles[name]["tension_over_force"]))
    return relative_l2(np.concatenate(here), np.concatenate(there))


def knot_length(curve: Curve, profiles: Profiles) -> float | None:
    """Arclength from the first to the last place where one rod runs close to itself [mm]; None for several rods."""
    from knotfem.report.surface import close_strands

    rod, *others = curve.run.scene.rods
    profile = profiles.get(rod.name, {})
    if others or "x_mm" not in profile:
        return None
    points = np.stack([profile[axis] for axis in ("x_mm", "y_mm", "z_mm")], axis=1)
    near = np.flatnonzero(close_strands(points, rod.diameter, reach=TOUCHING))
    if not near.size:
        return None
    return float(np.ptp(profile["s_over_L"][near])) * rod.length


def relative_l2(values: np.ndarray, first: np.ndarray) -> float | None:
    """Size of a difference over that of the first, or None where that is nothing."""
    size = float(np.linalg.norm(first))
    return float(np.linalg.norm(values - first)) / size if size > 0.0 else None
