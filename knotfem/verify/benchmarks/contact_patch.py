"""Two parallel rods of different meshes pressed together between frictionless end plates: uniform along their length.

The line force is compared at more than a diameter from the ends. At an end the spline gives the last section 0.54 times
the weight of a section in the middle, trilinear bricks would need 0.5: within half a diameter of the end the pressure
differs by up to a fifth.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from knotfem.contact.law import Penalty
from knotfem.contact.pairs import PairContact
from knotfem.solver.constraints import Prescribed
from knotfem.verify.benchmarks.rods import Rod, cross_sections, make_rod, static, surfaces
from knotfem.verify.case import Case, Quantity

RADIUS, LENGTH, YOUNGS = 3.0, 30.0, 1.425


def line_force(contact: PairContact, rod: int, length: float) -> np.ndarray:
    """Force per length [N/mm] on the samples of a rod around each of their stations, ends left out."""
    s, pairs = contact.samples, contact.pairs
    own = s.rod == rod
    force = np.bincount(pairs.sample, weights=pairs.force, minlength=s.count)[own]
    stations, where = np.unique(s.u[own], return_inverse=True)
    along = length * stations / stations[-1]
    inner = (along > 2.0 * RADIUS) & (along < length - 2.0 * RADIUS)
    return (np.bincount(where, weights=force) / np.gradient(along))[inner]


def pressed(approach: float, slices: tuple[int, int], sections: tuple[int, int]) -> list[Quantity]:
    """Axes brought together by `approach` [mm], every axis node alike."""
    lower = make_rod(LENGTH, slices[0], section=sections[0], youngs=YOUNGS, element="hex8")
    count = len(lower.mesh.nodes)
    upper = make_rod(LENGTH, slices[1], section=sections[1], youngs=YOUNGS, element="hex8", first=count)
    start = np.array([2.0 * RADIUS, 0.0, 0.0])
    x = np.concatenate([lower.mesh.nodes, upper.mesh.nodes + start])
    goal = x - np.concatenate([np.zeros((count, 3)), np.tile([approach, 0.0, 0.0], (len(upper.mesh.nodes), 1))])
    rods: list[Rod] = [lower, upper]
    axes, plates = (
        np.concatenate([rod.axis for rod in rods]),
        np.concatenate([r.sections[[0, -1]].ravel() for r in rods]),
    )
    supports = [
        Prescribed(axes, lambda time: goal[axes], components=(True, True, False)),
        Prescribed(plates, lambda time: x[plates], components=(False, False, True)),
    ]
    contact = PairContact(*surfaces(rods, 0.25 * RADIUS), Penalty(8.0 * YOUNGS, RADIUS / 15.0))
    static([lower.bulk, upper.bulk, contact], goal, supports, cross_sections(lower, upper), tolerance=1e-8)
    lines = [line_force(contact, rod, LENGTH) for rod in (0, 1)]
    return [
        Quantity(f"q {name} / q mean", float(bound(line)) / float(line.mean()), 1.0, 0.01, condition=f"{rod} rod")
        for rod, line in zip(("lower", "upper"), lines, strict=True)
        for name, bound in (("least", np.min), ("most", np.max))
    ]


CASES = [
    Case(
        "contact-patch",
        partial(pressed, approach, (20, 15), (12, 28)),
        f"parallel rods, axes brought together by {approach:g} mm",
        "uniform along the rods",
        "hex8, 20 x 12 on 15 x 28, default penalty",
        f"{approach:g}mm",
    )
    for approach in (0.1, 0.3)
]
