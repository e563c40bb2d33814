"""Cycles of load and long holds: friction dissipates in each cycle, the loop closes, nothing creeps."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from knotfem.scene import Scene
from knotfem.verify.rehearsal import Rehearsal
from knotfem.verify.stress.cases import hard_case, hard_scene, run
from knotfem.verify.stress.figures import figures_of
from knotfem.verify.verdict import Case, Quantity

CYCLES = 3
HELD = 0.9
"""Share of the slip load that is held."""
STEP = 1e-3
"""Between outputs, so that no step of the hold is longer [s]."""


def cases(*, small: bool = False) -> list[Case]:
    """See `hard.hard_cases`."""
    cycles = hard_scene("cycles", ("steps.1.displacement=4 mm",) if small else (), small=small)
    hold = hard_scene("hold", small=small)
    cycle, slip = (
        "overhand loaded, unloaded and loaded again, three times",
        "capstan held at 90 % of slip, 10,000 steps",
    )
    return [
        hard_case("cycles", "", cycle, partial(_cycles, cycles), cycles, small=small),
        hard_case("hold", "", slip, partial(_hold, small), hold, small=small),
    ]


def _cycles(scene: Scene) -> Sequence[Quantity]:
    names = ["load", *(f"{kind}-{i}" for i in range(1, CYCLES + 1) for kind in ("unload", "reload"))]
    found = run(scene)
    if not found.finished:
        return found.quantities()
    friction, force, step = (found.force[name] for name in ("friction_Nmm", "force_N", "step"))
    last = {name: int(np.flatnonzero(step == name)[-1]) for name in names}
    ends = [last["load"], *(last[f"reload-{i}"] for i in range(1, CYCLES + 1))]
    taken = np.diff(friction[ends])
    peaks = force[ends[-2:]]
    valleys = force[[last[f"unload-{i}"] for i in (CYCLES - 1, CYCLES)]]
    scale = float(peaks[-1])
    return [
        *found.quantities(before="3_1", after="3_1"),
        *(
            Quantity("dissipation, N mm", float(work), 0.0, kind="above", condition=f"cycle {i}")
            for i, work in enumerate(taken, start=1)
        ),
        *(
            Quantity(
                f"{which} force of the last two cycles, N", float(pair[1]), float(pair[0]), 0.02 * scale, "absolute"
            )
            for which, pair in (("largest", peaks), ("least", valleys))
        ),
    ]


def _hold(small: bool) -> Sequence[Quantity]:
    pulled = run(hard_scene("slip-capstan", small=small))
    if not pulled.finished:
        return pulled.quantities(condition="pulled until it slips")
    slip = float(pulled.force["force_N"].max())
    count = 100 if small else 10_000
    scene = hard_scene(
        "hold",
        (f"steps.1.ends.rod.start.force={HELD * slip:.6f} N", f"steps.2.ends.rod.start.force={HELD * slip:.6f} N",
         f"steps.2.duration={STEP * count} s"),
        small=small,
    )  # fmt: skip
    rehearsal = Rehearsal(scene)
    axis = rehearsal.model.body.rods[0].axis_nodes
    held: list[np.ndarray] = []
    for passed in rehearsal.run(rehearsal.tied()):
        if passed.step is scene.steps[-1]:
            held.append(passed.x[axis])
        if len(held) == count:
            break
    elastic = scene.contact.stick_over_diameter * scene.rods[0].diameter
    return [
        *figures_of(rehearsal).quantities(before="unknot", after="unknot"),
        Quantity("steps held", float(len(held)), float(count), kind="at least"),
        Quantity("drift, mm", farthest(held), elastic, kind="at most"),
        Quantity("drift in the second half, mm", farthest(held[len(held) // 2 :]), 0.01 * elastic, kind="at most"),
        Quantity("force at slip, N", slip, 0.0, kind="above"),
    ]


def farthest(states: Sequence[np.ndarray]) -> float:
    """How far any vertex ended from where it set out [mm]; states of shape [vertices, 3]."""
    return float(np.linalg.norm(states[-1] - states[0], axis=1).max())
