"""Tension profiles of several runs: at one displacement, or at the end of one step."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.clearance import close_strands
from knotfem.results.force import ForceCurve, force_at
from knotfem.results.moment import Moment
from knotfem.results.profile import StoredStates, stored_states
from knotfem.types import Arrays

Profiles = dict[str, dict[str, np.ndarray]]
"""Columns s_over_L, tension, x_mm, y_mm, z_mm by rod."""
TOUCHING = 1.2
"""Distance between axes below which strands count as the knot, in diameters."""


@dataclass(frozen=True, eq=False)
class CommonState:
    """One state of each of several runs.

    Attributes:
        step: at whose end the runs are, or None where they are compared at one displacement.
        displacements: over all steps [mm], one a run; None at the end of a step.
        forces: F at the reported end [N], one a run.
        profiles: one a run.
        over_force: whether their tension is T/F; it is T [N] where F does not pull in one of them.
    """

    step: str | None
    displacements: list[float] | None
    forces: list[float]
    profiles: list[Profiles]
    over_force: bool


def common_state(curves: Sequence[ForceCurve], at: float | None, step: str | None) -> CommonState | None:
    """The stored states in which runs can be compared.

    Args:
        curves: of the runs.
        at: displacement over all steps [mm], or None.
        step: name of the step at whose end, or None; with neither of both, the last of which all runs have stored
            something. Pulls are compared at the last displacement that all runs have in them.

    Returns:
        None where neither is given and the runs have stored no such state.

    Raises:
        InputError: both are given, a run has no such step, or has stored nothing near `at` or in the step.
    """
    if at is not None and step is not None:
        raise InputError("two states are asked for", key="--at, --step", expected="one of them")
    states = [_stored(curve) for curve in curves]
    if at is not None:
        return _at_displacement(curves, states, at)
    if step is not None:
        return _in_step(curves, states, step)
    for name in reversed(curves[0].steps):
        with suppress(InputError):
            return _in_step(curves, states, name)
    return None


def _stored(curve: ForceCurve) -> StoredStates:
    """Stored states of a run; none where it has no table that says something."""
    try:
        return stored_states(curve.run)
    except InputError:
        return StoredStates.of(curve.run.path, {})


def _in_step(curves: Sequence[ForceCurve], states: Sequence[StoredStates], name: str) -> CommonState:
    for curve in curves:
        if name not in curve.steps:
            known = ", ".join(curve.steps)
            raise InputError(
                "no such step is stored", file=curve.run.path, key="--step", found=f'"{name}"', expected=known
            )
    if not all(name in curve.spans for curve in curves):
        return _at_end(curves, states, name)
    places = [list(_pulled(stored, [curve.spans[name]])) for curve, stored in zip(curves, states, strict=True)]
    for curve, found in zip(curves, places, strict=True):
        if not found:
            raise _nothing_in(curve, name)
    high = min(found[-1] for found in places) * (1.0 + 1e-9)
    return _at_displacement(curves, states, max((d for d in places[0] if d <= high), default=high))


def _nothing_in(curve: ForceCurve, name: str) -> InputError:
    return InputError("no tension is stored in this step", file=curve.run.path, key="--step", found=f'"{name}"')


def _pulled(stored: StoredStates, spans: Iterable[tuple[float, float, float]]) -> dict[float, Moment]:
    """States stored in pulls, by the displacement over all steps [mm], ascending."""
    found: dict[float, Moment] = {}
    for moment in stored.moments:
        for start, end, _ in spans:
            if start < moment.time <= end * (1.0 + 1e-12) and moment.step_displacement > 0.0:
                found[moment.displacement] = moment
    return dict(sorted(found.items()))


def _at_displacement(curves: Sequence[ForceCurve], states: Sequence[StoredStates], wanted: float) -> CommonState:
    displacements, times, forces = [], [], []
    for curve, stored in zip(curves, states, strict=True):
        pulled = _pulled(stored, curve.spans.values())
        places = np.array(list(pulled))
        nearest = float(places[np.argmin(np.abs(places - wanted))]) if places.size else np.inf
        spacing = max((b - a for a, b in pairwise(places)), default=0.0)
        if abs(nearest - wanted) > max(0.5 * spacing, 1e-6 * max(1.0, abs(wanted))):
            expected = f"{places.min():g} to {places.max():g} mm" if places.size else "a run with a pull"
            problem = "no tension is stored near this displacement"
            raise InputError(problem, file=curve.run.path, key="at", found=f"{wanted:g} mm", expected=expected)
        displacements.append(nearest)
        times.append(pulled[nearest].time)
        forces.append(force_at(curve.run, pulled[nearest]))
    return _state(curves, states, times, forces, displacements=displacements)


def _at_end(curves: Sequence[ForceCurve], states: Sequence[StoredStates], name: str) -> CommonState:
    times, forces = [], []
    for curve, stored in zip(curves, states, strict=True):
        taken, force = curve.steps[name]
        inside = (stored.times >= taken[0] * (1.0 - 1e-12)) & (stored.times <= taken[-1] * (1.0 + 1e-12))
        if not inside.any():
            raise _nothing_in(curve, name)
        times.append(float(stored.times[inside].max()))
        forces.append(float(np.interp(times[-1], taken, force)))
    return _state(curves, states, times, forces, step=name)


def _state(
    curves: Sequence[ForceCurve],
    states: Sequence[StoredStates],
    times: Sequence[float],
    forces: list[float],
    *,
    step: str | None = None,
    displacements: list[float] | None = None,
) -> CommonState:
    loaded = all(force > 0.0 for force in forces)
    scales = forces if loaded else [1.0] * len(forces)
    parts = zip(curves, states, times, scales, strict=True)
    profiles = [_profile(curve, stored.at_time(time), scale) for curve, stored, time, scale in parts]
    return CommonState(step, displacements, forces, profiles, loaded)


def _profile(curve: ForceCurve, table: Arrays, scale: float) -> Profiles:
    """Profiles by rod of one state's rows."""
    names = table.get("rod", np.full(table["time_s"].shape, curve.run.scene.rods[0].name))
    return {
        str(name): {
            "s_over_L": table["s_over_L"][names == name],
            "tension": table["tension_N"][names == name] / scale,
            **{axis: table[axis][names == name] for axis in ("x_mm", "y_mm", "z_mm") if axis in table},
        }
        for name in dict.fromkeys(names.tolist())
    }


def profiles_apart(profiles: Profiles, first: Profiles) -> float | None:
    """Relative L2 difference of tension at the arclengths of the first; None where the rods have other names."""
    if profiles.keys() != first.keys():
        return None
    here, there = [], []
    for name, reference in first.items():
        s = reference["s_over_L"]
        there.append(reference["tension"])
        here.append(np.interp(s, profiles[name]["s_over_L"], profiles[name]["tension"]))
    return relative_l2(np.concatenate(here), np.concatenate(there))


def knot_length(curve: ForceCurve, profiles: Profiles) -> float | None:
    """Arclength from the first to the last place where one rod runs close to itself [mm]; None for several rods."""
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
