"""A nearly incompressible bulk: the same force, and no checkerboard in the pressure."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from knotfem.mesh.section import Section
from knotfem.models.solid.model import SolidModel
from knotfem.run.simulation import Simulation
from knotfem.scene import Scene
from knotfem.verify.case import Case, Quantity
from knotfem.verify.stress.runs import SLIGHT, Recording, hard_case, hard_scene

ROUGHER = 1.2
"""Largest roughness of the pressure in the stiff bulk over that in the usual one."""


def cases(*, small: bool = False) -> list[Case]:
    """See `suite.hard_cases`."""
    name, short = "overhand-bulk-5000", SLIGHT if small else ()
    scene = hard_scene(name, short, small=small)
    usual = hard_scene(name, ("rods.0.material.bulk_over_shear=500", *short), small=small)
    title = "tight overhand, bulk over shear 5,000 against 500"
    return [hard_case("bulk", "", title, partial(_bulk, scene, usual), scene, small=small)]


def _bulk(scene: Scene, usual: Scene) -> Sequence[Quantity]:
    figures: list[Quantity] = []
    found: list[tuple[float, float, float]] = []
    for ratio, of in (("500", usual), ("5,000", scene)):
        model = SolidModel(of)
        recording = Recording(Simulation(of, model=model))
        force = 0.0
        for step in recording:
            force = step.force
        figures += recording.outcome().quantities(before="3_1", after="3_1", condition=f"bulk over shear {ratio}")
        pressure = recording.simulation.state.history["elasticity-1"]["pressure"]
        section = model.body.rods[0].mesh.section
        found.append((force, roughness(pressure), roughness_across(pressure, section)))
    (force, along, across), stiff = found
    return [
        *figures,
        Quantity("force, N", stiff[0], force, 0.02),
        Quantity("roughness of the pressure along the rod", stiff[1], ROUGHER * along, kind="at most"),
        Quantity("roughness of the pressure across it", stiff[2], ROUGHER * across, kind="at most"),
    ]


def roughness(pressure: np.ndarray) -> float:
    """Fraction of the element pressures that alternates along the rod: near 0 if smooth, above 1 for a checkerboard.

    Args:
        pressure: shape [slices, quads, modes]; the first mode is used.
    """
    p = pressure[:, :, 0]
    return _size(p[1:-1] - 0.5 * (p[2:] + p[:-2])) / float(np.std(p))


def roughness_across(pressure: np.ndarray, section: Section) -> float:
    """Fraction of the element pressures by which quadrilaterals of a section differ from their neighbours.

    A linear distribution over the section is subtracted first. Near 0 if smooth, 2 where each is the opposite of its
    neighbours.

    Args:
        pressure: shape [slices, quads, modes]; the first mode is used.
        section: of the rod.
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
