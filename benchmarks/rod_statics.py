"""Rods without contact against closed forms: errors, and the order at which they fall with the number of segments.

Elastica (Bisshopp and Drucker 1945), heavy cantilever, roll-up, frequencies, Euler's and Greenhill's buckling, uniform
twist, Michell's ring.

Run with: python benchmarks/rod_statics.py
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from rod_common import DENSITY, GRAVITY, YOUNGS, table

from knotfem.models.rod.ends import End, clamped, pinned, turned
from knotfem.models.rod.model import RodModel, Side
from knotfem.models.rod.spec import RodSpec
from knotfem.solver.nonlinear.newton import NewtonSettings
from knotfem.solver.schemes import Scheme
from knotfem.solver.stepping.integrator import StepControl
from knotfem.solver.term import StepStart

LENGTH, RADIUS = 100.0, 3.0
BENDING, MASS = YOUNGS * np.pi * RADIUS**4 / 4.0, DENSITY * np.pi * RADIUS**2
TWISTING = BENDING / 1.5
X, Y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])


def straight(segments: int, length: float = LENGTH, axial: float = 4e3, gravity: np.ndarray | None = None) -> RodModel:
    points = np.linspace(0.0, length, segments + 1)[:, None] * X
    return RodModel([RodSpec(points, RADIUS, BENDING, TWISTING, axial, MASS)], gravity=gravity, scheme=Scheme())


def settle(model: RodModel, ends: Mapping[Side, End], steps: int = 4) -> RodModel:
    """March through one second in equal steps to balance so tight that an unstable branch is kept."""
    model.begin(ends)
    control = StepControl(1.0 / steps, 1e-4, 1.0 / steps, 1e3)
    for _ in model.march(control, NewtonSettings(2e-8, 2e-7, 60, 1e3, 1e3, chord_safety=np.inf), [model.time + 1.0]):
        pass
    return model


def stiffness(model: RodModel) -> tuple[np.ndarray, np.ndarray]:
    """Dense tangent and mass of the free unknowns."""
    system = model.system
    assert system is not None
    system.begin(StepStart(model.progress.motion, 1e-9))
    free = ~system.fixed.ravel()
    return system.tangent(model.x)[1].to_scipy().toarray()[np.ix_(free, free)], model.mass.ravel()[free]


def elastica(a: float) -> Callable[[int], np.ndarray]:
    def find(segments: int) -> np.ndarray:
        model = straight(segments)
        push = np.array([0.0, 0.0, -a * BENDING / LENGTH**2])
        settle(model, {(0, "start"): clamped(model.end_frame(0, "start")), (0, "end"): End(force=lambda t: t * push)})
        last = model.x[-1] - model.x[-2]
        return np.array([np.arctan2(-last[2], last[0]), 1.0 - model.x[-1, 0] / LENGTH, -model.x[-1, 2] / LENGTH])

    return find


def heavy(gamma: float) -> Callable[[int], np.ndarray]:
    def find(segments: int) -> np.ndarray:
        length = (gamma * BENDING / (MASS * 9810.0)) ** (1 / 3)
        model = straight(segments, length, 1e5, GRAVITY)
        settle(model, {(0, "start"): clamped(model.end_frame(0, "start"))})
        return -model.x[-1, 2:3] / length

    return find


def frequencies(segments: int) -> np.ndarray:
    model = straight(segments)
    model.begin({(0, "start"): clamped(model.end_frame(0, "start"))})
    K, m = stiffness(model)
    return np.sqrt(np.linalg.eigvalsh(K / np.sqrt(np.outer(m, m)))[[0, 2, 5]]) * LENGTH**2 / np.sqrt(BENDING / MASS)


def crossing(low: float, high: float, unstable: Callable[[float], bool]) -> float:
    """Where a rod becomes unstable, by bisection to 1e-4."""
    while high - low > 1e-4 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return 0.5 * (low + high)


def euler(hold: Callable, critical: float) -> Callable[[int], np.ndarray]:
    def find(segments: int) -> np.ndarray:
        def unstable(load: float) -> bool:
            model = straight(segments, axial=1e6)
            model.x[:, 0] *= 1.0 - load * BENDING / LENGTH**2 / 1e6
            model.begin({(0, side): hold(model.end_frame(0, side)) for side in ("start", "end")})
            model.stretch.force = model.stretch.tension(model.x)
            values = np.linalg.eigvalsh(stiffness(model)[0])
            return bool(values[np.abs(values) > 1e-8][0] < 0.0)

        return np.array([crossing(0.9 * critical, 1.1 * critical, unstable)])

    return find


def greenhill(segments: int) -> np.ndarray:
    def unstable(torque: float) -> bool:
        model, twist = straight(segments, axial=1e5), torque * BENDING / TWISTING
        turn = turned(model.end_frame(0, "end"), X, lambda t: twist * t)
        settle(model, {(0, "start"): clamped(model.end_frame(0, "start")), (0, "end"): turn}, 6)
        return bool(np.linalg.eigvalsh(stiffness(model)[0])[0] < 0.0)

    return np.array([crossing(8.0, 10.0, unstable)])


def michell(segments: int) -> np.ndarray:
    """Twist times C/B at which a ring of B = C leaves its plane; the first mode turns the ring as a whole."""
    phi = 2.0 * np.pi * np.arange(segments + 1) / segments
    points = 50.0 * np.stack([np.sin(phi), 1.0 - np.cos(phi), 0.0 * phi], axis=1)

    def unstable(twist: float) -> bool:
        model = RodModel([RodSpec(points, 1.0, 1.0, 1.0, 40.0, MASS)], scheme=Scheme())
        joint = turned(model.end_frame(0, "end"), X, lambda t: twist * t)
        settle(model, {(0, "start"): clamped(model.end_frame(0, "start")), (0, "end"): joint}, 8)
        return bool(np.linalg.eigvalsh(stiffness(model)[0])[1] < -1e-9)

    return np.array([crossing(10.0, 12.0, unstable)])


def closed_forms() -> None:
    roll = straight(12)
    turn = turned(roll.end_frame(0, "end"), Y, lambda t: -2.0 * np.pi * t, held=False)
    settle(roll, {(0, "start"): clamped(roll.end_frame(0, "start")), (0, "end"): turn}, 10)
    twisted = straight(10)
    spin = turned(twisted.end_frame(0, "end"), X, lambda t: 9.0 * t)
    settle(twisted, {(0, "start"): clamped(twisted.end_frame(0, "start")), (0, "end"): spin}, 6)
    torque = twisted.twist.torque(twisted.x) * LENGTH / (9.0 * TWISTING) - 1.0
    print(f"roll-up of 12 segments: end gap {np.abs(roll.x[-1, :3]).max() / LENGTH:.1e} L")
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
        ("Euler, pinned", euler(pinned, np.pi**2), (np.pi**2,)),
        ("Euler, clamped", euler(clamped, 4.0 * np.pi**2), (4.0 * np.pi**2,)),
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
