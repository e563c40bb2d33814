"""Large bending of slender rods against beam theory and against solids computed elsewhere."""

import numpy as np
import pytest
from specimens import WHOLE_STEPS, Rod, agree, beam_clamp, bent_into_arc, make_rod, march, static

from knotfem.effects.gravity import Gravity
from knotfem.effects.load import EndForce, FollowingForce, held
from knotfem.solver.effect import Effect, Motion, StepStart
from knotfem.solver.linear import make_solver
from knotfem.solver.schemes import Scheme
from knotfem.solver.system import Prescribed, System

X_AXIS = np.array([1.0, 0.0, 0.0])


class GrowingWeight(Gravity):
    """Gravity that grows from 0 to its full value in one second."""

    def __init__(self, mass: np.ndarray, acceleration: np.ndarray) -> None:
        super().__init__(mass, acceleration)
        self.full = acceleration

    def begin(self, start: StepStart) -> None:
        self.acceleration = self.full * start.end


def loaded(rod: Rod, loads: list[Effect]) -> np.ndarray:
    """Centreline of a cantilever under loads that grow within one second, shape [sections, 3]."""
    x = rod.mesh.nodes
    system = System([*rod.effects, *loads], len(x), make_solver("auto"), Scheme(), beam_clamp(rod))
    steps = march(
        system, Motion.at_rest(x), rod.section_index, [1.0], first=0.25, largest=0.25, move=1e3, settings=WHOLE_STEPS
    )
    for _ in steps:
        pass
    return steps.progress.motion.x[rod.axis]


@pytest.mark.parametrize(
    ("load", "slope", "shortening", "sag"), [(1.0, 0.46135, 0.05643, 0.30172), (5.0, 1.21537, 0.38763, 0.71379)]
)
def test_elastica(load, slope, shortening, sag):
    rod = make_rod(120.0, 40, radius=1.0, section=20)
    force = load * rod.bending / 120.0**2
    end = EndForce(rod.sections[-1], rod.end_weights, X_AXIS, lambda t: force * t)
    reaction = EndForce(rod.sections[0], rod.end_weights, -X_AXIS, lambda t: force * t)
    line = loaded(rod, [end, reaction])
    t = line[-1] - line[-2]
    agree(f"elastica a = {load}, tip slope", np.arctan2(t[0], t[2]), slope, 0.01)
    agree(f"elastica a = {load}, shortening / L", 1.0 - line[-1, 2] / 120.0, shortening, 0.01)
    agree(f"elastica a = {load}, sag / L", line[-1, 0] / 120.0, sag, 0.01)


def sagging(rod: Rod, g: float) -> float:
    weight = g * rod.mass.sum()
    reaction = EndForce(rod.sections[0], rod.end_weights, -X_AXIS, lambda t: weight * t)
    return float(loaded(rod, [GrowingWeight(rod.mass, g * X_AXIS), reaction])[-1, 0])


@pytest.mark.parametrize(("gamma", "sag"), [(1.0, 0.12347), (5.0, 0.49591), (10.0, 0.70020)])
def test_heavy_cantilever(gamma, sag):
    rod = make_rod(120.0, 40, radius=1.5)
    g = gamma * rod.bending / (rod.density * np.pi * 1.5**2 * 120.0**3)
    agree(f"heavy cantilever Gamma = {gamma}, sag / L", sagging(rod, g) / 120.0, sag, 0.01)


@pytest.mark.parametrize(("length", "sag"), [(80.0, 17.83), (120.0, 68.12)])
def test_paper_rod_sags(length, sag):
    rod = make_rod(length, 40, youngs=89.4 / (np.pi * 3.0**4 / 4.0))
    agree(f"paper rod, {length:.0f} mm, sag [mm]", sagging(rod, 9810.0), sag, 0.01)


def test_roll_up_by_an_end_moment():
    rod = make_rod(120.0, 40, radius=1.0, section=20)
    moment = 2.0 * np.pi * rod.bending / 120.0
    couple = FollowingForce(
        rod.sections[-1], -rod.couple_weights(0), int(rod.axis[-2]), int(rod.axis[-1]), lambda t: moment * t
    )
    x = bent_into_arc(rod, 1.8 * np.pi)
    system = System([*rod.effects, couple], len(x), make_solver("auto"), Scheme(), beam_clamp(rod))
    steps = march(system, Motion.at_rest(x, 0.9), rod.section_index, [1.0], first=0.025, settings=WHOLE_STEPS)
    for _ in steps:
        pass
    line = steps.progress.motion.x[rod.axis]
    gap = float(np.linalg.norm(line[-1] - line[0])) / 120.0
    print(f"\nroll-up: end gap {gap:.4f} L", end="")
    assert gap < 0.005
    radius = 120.0 / (2.0 * np.pi)
    agree("roll-up, diameter / 2R", float(np.ptp(line[:, 0])) / (2.0 * radius), 1.0, 0.005)


@pytest.mark.parametrize(
    ("section", "match_bending", "element", "expected"),
    [(44, False, "hex8", 2.031), pytest.param(104, True, "hex8-reduced", 2.11, marks=pytest.mark.slow)],
    ids=["paper mesh", "true circle"],
)
def test_pure_bending_to_a_right_angle(section, match_bending, element, expected):
    rod = make_rod(60.0, 60, section=section, element=element, poisson=0.49, match_bending=match_bending)
    angle, X = 0.5 * np.pi, rod.mesh.nodes
    near, far = rod.sections[0], rod.sections[-1]
    radius = 60.0 / angle
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    centre = np.array([radius, 0.0, radius])
    plate = centre + (X[far] - [0.0, 0.0, 60.0]) @ turn.T
    ends = [held(near, X[near]), Prescribed(far, lambda time: plate)]
    x, system, _ = static(rod.effects, bent_into_arc(rod, angle), ends, rod.section_index, tolerance=1e-7)
    force = system.residual(x)[far]
    moment = float(np.cross(x[far] - centre, force).sum(axis=0)[1])
    agree(f"pure bending to 90 degrees, {section} hexes a section, M [N mm]", moment, expected, 0.01)
