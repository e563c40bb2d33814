"""A bulk that is all but incompressible: the same force, and no checkerboard in the pressure."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from knotfem.mesh.section import Section
from knotfem.scene import Scene
from knotfem.verify.rehearsal import Rehearsal
from knotfem.verify.stress.cases import SLIGHT, hard_case, hard_scene
from knotfem.verify.stress.figures import figures_of
from knotfem.verify.verdict import Case, Quantity

ROUGHER = 1.2
"""How many times as rough the pressure of the stiff bulk may be."""


def cases(*, small: bool = False) -> list[Case]:
    """See `hard.hard_cases`."""
    name, short = "overhand-bulk-5000", SLIGHT if small else ()
    scene = hard_scene(name, short, small=small)
    usual = hard_scene(name, ("rods.0.material.bulk_over_shear=500", *short), small=small)
    title = "tight overhand, bulk over shear 5,000 against 500"
    return [hard_case("bulk", "", title, partial(_bulk, scene, usual), scene, small=small)]


def _bulk(scene: Scene, usual: Scene) -> Sequence[Quantity]:
    figures: list[Quantity] = []
    found: list[tuple[float, float, float]] = []
    for ratio, of in (("500", usual), ("5,000", scene)):
        rehearsal = Rehearsal(of)
        force = 0.0
        for passed in rehearsal.run(rehearsal.tied()):
            force = passed.balance.force
        figures += figures_of(rehearsal).quantities(before="3_1", after="3_1", condition=f"bulk over shear {ratio}")
        rod = rehearsal.model.body.rods[0]
        pressure, section = rod.bulk.pressure, rod.mesh.section
        found.append((force, roughness(pressure), roughness_across(pressure, section)))
    (force, along, across), stiff = found
    return [
        *figures,
        Quantity("force, N", stiff[0], force, 0.02),
        Quantity("roughness of the pressure along the rod", stiff[1], ROUGHER * along, kind="at most"),
        Quantity("roughness of the pressure across it", stiff[2], ROUGHER * across, kind="at most"),
    ]


def roughness(pressure: np.ndarray) -> float:
    """Share of an element pressure that alternates along the rod: near 0 if smooth, above 1 for a checkerboard.

    Args:
        pressure: shape [slices, quads, modes]; the first mode is looked at.
    """
    p = pressure[:, :, 0]
    return _size(p[1:-1] - 0.5 * (p[2:] + p[:-2])) / float(np.std(p))


def roughness_across(pressure: np.ndarray, section: Section) -> float:
    """Share of an element pressure by which quads of a section differ from their neighbours.

    What is linear across the section is left out. Near 0 if smooth, 2 where each is the opposite of its neighbours.

    Args:
        pressure: shape [slices, quads, modes]; the first mode is looked at.
        section: whose quads they are.
    """
    p = pressure[:, :, 0]
    corners = section.quads[:, :4]
    linear = np.column_stack([np.ones(len(corners)), section.points[corners].mean(axis=1)])
    rest = p - p @ (linear @ np.linalg.pinv(linear)).T
    has = np.zeros((len(corners), len(section.points)))
    np.put_along_axis(has, corners, 1.0, axis=1)
    beside = (has @ has.T == 2.0).astype(float)
    mean = rest @ (beside / beside.sum(axis=1)[:, None]).T
    return _size(rest - mean) / float(np.std(p))


def _size(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
