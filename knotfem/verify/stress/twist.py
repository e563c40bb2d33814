"""Twist applied at an end: the link of the rod, its twist plus its writhe, is conserved while the knot is pulled."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from knotfem.geometry.frames import material_frames, tangents, twist_of
from knotfem.geometry.writhe import writhe
from knotfem.models.solid.body import SolidRod
from knotfem.models.solid.model import SolidModel
from knotfem.run.simulation import Simulation
from knotfem.scene import Scene
from knotfem.scene.steps import Turned
from knotfem.verify.case import Case, Quantity
from knotfem.verify.stress.runs import Recording, hard_case, hard_scene

FAR = 1e4
"""Length of the straight continuations of the ends over the rod's length; the error of the writhe is its inverse."""
LINK = 0.01
"""Largest error of the link [turns]."""


def cases(*, small: bool = False) -> list[Case]:
    """See `suite.hard_cases`."""
    short = (
        "steps.1.ends.rod.end.turns=0.5", "steps.1.duration=1 s", "steps.2.displacement=1 mm",
        "output.every_displacement=1 mm",
    )  # fmt: skip
    scene = hard_scene("twist", short if small else (), small=small)
    title = "turns of twist applied at an end before the pull"
    return [hard_case("twist", "", title, partial(_twist, scene), scene, small=small)]


def link_of(rod: SolidRod, x: np.ndarray) -> tuple[float, float]:
    """Twist and writhe of a rod [turns].

    Their sum changes by the turns of the ends alone as long as no strand passes through another and the ends keep their
    directions. Both ends are continued straight for `FAR` lengths of the rod.

    Args:
        rod: hexahedra.
        x: positions [mm], shape [nodes, 3].
    """
    centre = x[rod.axis_nodes]
    t = tangents(centre)
    spoke = x[rod.section_nodes[:, rod.mesh.section.ring[0]]] - centre
    twist = float(twist_of(material_frames(t, spoke), centre).sum()) / (2.0 * np.pi)
    far = FAR * rod.mesh.length
    return twist, writhe(np.vstack([centre[0] - far * t[0], centre, centre[-1] + far * t[-1]]))


def _twist(scene: Scene) -> Sequence[Quantity]:
    turn = scene.steps[1]
    end = turn.ends["rod"].end
    assert isinstance(end, Turned)
    model = SolidModel(scene)
    rod = model.body.rods[0]
    recording = Recording(Simulation(scene, model=model))
    links: dict[str, list[tuple[float, float]]] = {step.name: [] for step in scene.steps}
    for step in recording:
        links[step.step.name].append(link_of(rod, step.state.x))
    relaxed, turned, pulled = (np.array(links[step.name]) for step in scene.steps)
    drift = float(np.abs(pulled.sum(axis=1) - turned[-1].sum()).max())
    added = float(turned[-1].sum() - relaxed[-1].sum())
    return [
        *recording.outcome().quantities(before="3_1", after="3_1"),
        Quantity("link applied, turns", added, float(end.turns), LINK, "absolute"),
        Quantity("drift of the link in the pull, turns", drift, LINK, kind="at most"),
        Quantity("twist at the end, turns", float(pulled[-1, 0]), 2.0 * abs(end.turns), kind="at most"),
    ]
