"""Rods without contact against closed forms: errors, and the order at which they fall with the number of segments.

Elastica (Bisshopp and Drucker 1945), heavy cantilever, roll-up, frequencies, Euler's and Greenhill's buckling, uniform
twist, Michell's ring.

Run with: python benchmarks/rod_statics.py
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from rod_common import DENSITY, YOUNGS, Phase, rubber, table

from knotfem.geometry.finite_rotation import rotate
from knotfem.models.rod.assembly import DiscreteRods
from knotfem.models.rod.spec import RodSpec
from knotfem.scene.stiffness import bending_stiffness, mass_per_length
from knotfem.solver.constraints import Clamp, Prescribed, held
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.reuse import Chord
from knotfem.solver.nonlinear.tolerance import ForceTolerance
from knotfem.solver.state import State
from knotfem.solver.stepping.controller import StepController
from knotfem.terms.load import EndForce
from knotfem.types import History

LENGTH, RADIUS = 100.0, 3.0
BENDING, MASS = bending_stiffness(YOUNGS, RADIUS), mass_per_length(DENSITY, RADIUS)
TWISTING = BENDING / 1.5
X, Y, Z = np.eye(3)
WHOLE_STEPS = Newton(
    tolerance=ForceTolerance.of(2e-8), line_search=Armijo(whole_below=1e3), reuse=Chord(np.inf), max_iterations=60,
    largest_move=1e3,
)  # fmt: skip
"""Steps as they come, to balance so tight that an unstable branch is kept."""


def straight(
    segments: int, length: float = LENGTH, axial: float = 4e3, gravity: np.ndarray | None = None
) -> DiscreteRods:
    """A rod along x, its directors along z."""
    points = np.linspace(0.0, length, segments + 1)[:, None] * X
    spec = rubber(points, RADIUS, axial, directors=np.tile(Z, (segments, 1)))
    return DiscreteRods([spec], gravity=gravity, inertia=False)


def clamp(node: int, axis: np.ndarray = X, angle: History = lambda time: 0.0) -> Clamp:
    """An end that points along x at first and turns about an axis by angle(time) [rad]."""
    return Clamp(node, lambda time: (rotate(X, axis, angle(time)), rotate(Z, axis, angle(time))))


def at_rest(rods: DiscreteRods, *nodes: int) -> list[Prescribed]:
    """Nodes held where they are at first."""
    return [held(np.array(nodes), rods.initial.x[list(nodes), :3])]


def settle(phase: Phase, steps: int = 4) -> Phase:
    """Take one second in equal steps."""
    for _ in phase.steps(StepController(1.0 / steps, 1e-4, 1.0 / steps, 1e3), WHOLE_STEPS, 1.0):
        pass
    return phase


def elastica(a: float) -> Callable[[int], np.ndarray]:
    def find(segments: int) -> np.ndarray:
        rods, push = straight(segments), -a * BENDING / LENGTH**2 * Z
        load = EndForce(np.array([segments]), np.ones(1), lambda time: time * push)
        x = settle(Phase(rods, rods.initial, at_rest(rods, 0), [clamp(0)], [load])).state.x
        last = x[-1] - x[-2]
        return np.array([np.arctan2(-last[2], last[0]), 1.0 - x[-1, 0] / LENGTH, -x[-1, 2] / LENGTH])

    return find


def heavy(gamma: float) -> Callable[[int], np.ndarray]:
    def find(segments: int) -> np.ndarray:
        length = (gamma * BENDING / (MASS * 9810.0)) ** (1 / 3)
        rods = straight(segments, length, 1e5, -9810.0 * Z)
        x = settle(Phase(rods, rods.initial, at_rest(rods, 0), [clamp(0)])).state.x
        return -x[-1, 2:3] / length

    return find


def frequencies(segments: int) -> np.ndarray:
    rods = straight(segments)
    phase = Phase(rods, rods.initial, at_rest(rods, 0), [clamp(0)])
    m = rods.mass.ravel()[~phase.system.fixed.ravel()]
    K = phase.stiffness() / np.sqrt(np.outer(m, m))
    return np.sqrt(np.linalg.eigvalsh(K)[[0, 2, 5]]) * LENGTH**2 / np.sqrt(BENDING / MASS)


def crossing(low: float, high: float, unstable: Callable[[float], bool]) -> float:
    """Where a rod becomes unstable, by bisection to 1e-4."""
    while high - low > 1e-4 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return 0.5 * (low + high)


def euler(clamped: bool, critical: float) -> Callable[[int], np.ndarray]:
    def find(segments: int) -> np.ndarray:
        def unstable(load: float) -> bool:
            rods = straight(segments, axial=1e6)
            x = rods.initial.x * [1.0 - load * BENDING / LENGTH**2 / 1e6, 1.0, 1.0, 1.0]
            history = {**rods.initial.history, "stretch-1": {"force": rods.stretch.tension(x)}}
            state = State(x, rods.initial.v, rods.initial.a, 0.0, history)
            clamps = [clamp(0), clamp(segments)] if clamped else []
            values = np.linalg.eigvalsh(Phase(rods, state, at_rest(rods, 0, segments), clamps).stiffness())
            return bool(values[np.abs(values) > 1e-8][0] < 0.0)

        return np.array([crossing(0.9 * critical, 1.1 * critical, unstable)])

    return find


def twisted(rods: DiscreteRods, twist: float, steps: int) -> Phase:
    """Both ends held, the last one turned."""
    last = rods.layout.nodes - 1
    clamps = [clamp(0), clamp(last, angle=lambda time: twist * time)]
    return settle(Phase(rods, rods.initial, at_rest(rods, 0, last), clamps), steps)


def greenhill(segments: int) -> np.ndarray:
    def unstable(torque: float) -> bool:
        phase = twisted(straight(segments, axial=1e5), torque * BENDING / TWISTING, 6)
        return bool(np.linalg.eigvalsh(phase.stiffness())[0] < 0.0)

    return np.array([crossing(8.0, 10.0, unstable)])


def michell(segments: int) -> np.ndarray:
    """Twist times C/B at which a ring of B = C leaves its plane; the first mode turns the ring as a whole."""
    phi = 2.0 * np.pi * np.arange(segments + 1) / segments
    points = 50.0 * np.stack([np.sin(phi), 1.0 - np.cos(phi), 0.0 * phi], axis=1)
    ring = RodSpec(points, 1.0, 1.0, 1.0, 40.0, MASS, directors=np.tile(Z, (segments, 1)))

    def unstable(twist: float) -> bool:
        phase = twisted(DiscreteRods([ring], inertia=False), twist, 8)
        return bool(np.linalg.eigvalsh(phase.stiffness())[1] < -1e-9)

    return np.array([crossing(10.0, 12.0, unstable)])


def closed_forms() -> None:
    rods = straight(12)
    clamps = [clamp(0), clamp(12, Y, lambda time: -2.0 * np.pi * time)]
    rolled = settle(Phase(rods, rods.initial, at_rest(rods, 0), clamps), 10).state.x
    rods = straight(10)
    torque = rods.torque(twisted(rods, 9.0, 6).state.x) * LENGTH / (9.0 * TWISTING) - 1.0
    print(f"roll-up of 12 segments: end gap {np.abs(rolled[-1, :3]).max() / LENGTH:.1e} L")
    print(f"uniform twist by 9 rad: torque within {np.abs(torque).max():.1e}")


def main() -> None:
    closed_forms()
    cases: list[tuple[str, Callable[[int], np.ndarray], tuple[float, ...]]] = [
        ("elastica a = 1", elastica(1.0), (0.46135, 0.05643, 0.30172)),
        ("elastica a = 5", elastica(5.0), (1.21537, 0.38763, 0.71379)),
        ("heavy, Gamma = 1", heavy(1.0), (0.12347,)),
        ("heavy, Gamma = 5", heavy(5.0), (0.49591,)),
        ("heavy, Gamma = 10", heavy(10.0), (0.70020,)),
        ("frequencies", frequencies, (1.8751**2, 4.6941**2, 7.8548**2)),
        ("Euler, pinned", euler(False, np.pi**2), (np.pi**2,)),
        ("Euler, clamped", euler(True, 4.0 * np.pi**2), (4.0 * np.pi**2,)),
        ("Greenhill, clamped", greenhill, (8.98682,)),
        ("Michell's ring", michell, (2.0 * np.pi * np.sqrt(3.0),)),
    ]
    rows = []
    for name, find, exact in cases:
        fine = {n: find(n) for n in (20, 40, 80)}
        errors = [float(np.abs(fine[n] / exact - 1.0).max()) for n in fine]
        change = [float(np.abs(fine[a] - fine[b]).max()) for a, b in ((20, 40), (40, 80))]
        rows.append((name, *errors, np.log2(change[0] / change[1])))
    table("largest relative errors", ("case", "20 segments", "40", "80", "order"), rows)


if __name__ == "__main__":
    main()
