"""Cycles of load and long holds: friction dissipates in each cycle, the loop closes, nothing creeps."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from knotfem.models.solid.model import SolidModel
from knotfem.run.simulation import Simulation
from knotfem.scene import Scene
from knotfem.verify.case import Case, Quantity
from knotfem.verify.stress.runs import Recording, hard_case, hard_scene, run

CYCLES = 3
HELD = 0.9
"""Fraction of the slip load that is held."""
STEP = 1e-3
"""Time between outputs [s], so that no step of the hold is longer."""


def cases(*, small: bool = False) -> list[Case]:
    """See `suite.hard_cases`."""
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
    common = found.quantities(before="3_1", after="3_1")
    if not found.finished:
        return common
    friction, force, step = (found.force[name] for name in ("friction_Nmm", "force_N", "step"))
    last = {name: int(np.flatnonzero(step == name)[-1]) for name in names}
    ends = [last["load"], *(last[f"reload-{i}"] for i in range(1, CYCLES + 1))]
    dissipated = np.diff(friction[ends])
    peaks = force[ends[-2:]]
    valleys = force[[last[f"unload-{i}"] for i in (CYCLES - 1, CYCLES)]]
    scale = float(peaks[-1])
    return [
        *common,
        *(
            Quantity("dissipation, N mm", float(work), 0.0, kind="above", condition=f"cycle {i}")
            for i, work in enumerate(dissipated, start=1)
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
        return pulled.quantities(before="unknot", after="unknot", condition="pulled until it slips")
    slip = float(pulled.force["force_N"].max())
    count = 100 if small else 10_000
    scene = hard_scene(
        "hold",
        (f"steps.1.ends.rod.start.force={HELD * slip:.6f} N", f"steps.2.ends.rod.start.force={HELD * slip:.6f} N",
         f"steps.2.duration={STEP * count} s"),
        small=small,
    )  # fmt: skip
    model = SolidModel(scene)
    axis = model.axis_nodes(0)
    recording = Recording(Simulation(scene, model=model))
    held: list[np.ndarray] = []
    for step in recording:
        if step.step is scene.steps[-1]:
            held.append(step.state.x[axis])
        if len(held) == count:
            break
    elastic = scene.contact.stick_over_diameter * scene.rods[0].diameter
    return [
        *recording.outcome().quantities(before="unknot", after="unknot"),
        Quantity("steps held", float(len(held)), float(count), kind="at least"),
        Quantity("drift, mm", farthest(held), elastic, kind="at most"),
        Quantity("drift in the second half, mm", farthest(held[len(held) // 2 :]), 0.01 * elastic, kind="at most"),
        Quantity("force at slip, N", slip, 0.0, kind="above"),
    ]


def farthest(states: Sequence[np.ndarray]) -> float:
    """Largest distance of a vertex between the first and the last state [mm]; states of shape [vertices, 3]."""
    return float(np.linalg.norm(states[-1] - states[0], axis=1).max())
