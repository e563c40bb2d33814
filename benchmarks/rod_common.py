"""What the benchmarks of the reduced model share: rods of the paper's rubber, knots, rest, tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from knotfem.contact.curve_contact import hertz_line_stiffness
from knotfem.geometry.curve import interpolate
from knotfem.geometry.readers import read_centreline
from knotfem.geometry.resample import equal_chords
from knotfem.models.rod.ends import clamped
from knotfem.models.rod.model import RodModel
from knotfem.models.rod.spec import ContactSpec, CylinderSpec, RodSpec
from knotfem.shipped import centreline_path
from knotfem.solver.stepping.integrator import StepControl

YOUNGS, DENSITY = 1.425, 1.16e-9
CORE = 3826.0
"""Axial stiffness of the wire [N]."""
UP = np.array([0.0, 0.0, 1.0])
GRAVITY = -9810.0 * UP


def rubber(points: np.ndarray, radius: float = 3.0, core: float = CORE) -> RodSpec:
    """A rod of the paper's rubber through these nodes [mm], its wire of axial stiffness `core` [N]."""
    bending = YOUNGS * np.pi * radius**4 / 4.0
    axial = core + YOUNGS * np.pi * radius**2
    return RodSpec(points, radius, bending, bending / 1.5, axial, DENSITY * np.pi * radius**2)


def touching(friction: float, radius: float = 3.0, stiffer: float = 1.0, **changed) -> ContactSpec:
    """Contact by Hertz's stiffness, or so many times that."""
    stiffness = stiffer * hertz_line_stiffness(YOUNGS, 0.5)
    return ContactSpec(stiffness, friction, ramp=radius / 30.0, sample_spacing=radius / 4.0, **changed)


def bowline(
    friction: float,
    segments: int = 300,
    cylinder: float = 0.39,
    drag: float = 10.0,
    stiffer: float = 1.0,
    gravity: np.ndarray = GRAVITY,
    **changed,
) -> RodModel:
    """The scene `bowline`: 600 mm of rod round a cylinder of 20 mm."""
    points = equal_chords(read_centreline(centreline_path("bowline")), segments, 600.0).points
    peg = CylinderSpec(np.zeros(3), np.array([0.0, 1.0, 0.0]), 10.0, cylinder)
    contact = touching(friction, stiffer=stiffer, **changed)
    return RodModel([rubber(points)], contact, [peg], gravity=gravity, drag=drag)


def torus_knot(n: int, radius: float, loop: float, segments: int, length: float) -> np.ndarray:
    """Nodes of an open (2, 2n + 1) torus knot along x: 2n + 1 half turns of two strands, a loop, straight tails."""
    offset, turns = 1.3 * radius, 2 * n + 1
    half = 0.8 * turns * np.sqrt(radius * loop)
    s = np.linspace(-1.0, 1.0, 40 * turns)
    angle = 0.5 * np.pi * (turns * (1.0 + s) - 1.0)
    first = np.stack([half * s, offset * np.sin(angle), offset * np.cos(angle)], axis=1)
    second = first * [1.0, -1.0, -1.0]
    size = max(loop, 1.5 * half)
    phi = np.linspace(0.0, 2.0 * np.pi, 60) - 0.5 * np.pi
    circle = np.stack([size * np.cos(phi), size * (1.0 + np.sin(phi)) + offset, 0.0 * phi], axis=1)
    circle = circle[np.hypot(circle[:, 0], circle[:, 1] - offset) > 1.2 * half]
    tail = np.stack([np.linspace(-0.5 * length, -1.3 * half, 30), np.full(30, -offset), np.zeros(30)], axis=1)
    curve = interpolate(np.concatenate([tail, first, circle, second, tail[::-1] * [-1.0, 1.0, 1.0]]))
    fine = equal_chords(curve, 8 * segments).points
    spare = int(0.5 * (len(fine) - 1 - length / np.linalg.norm(fine[1] - fine[0])))
    return equal_chords(interpolate(fine[spare : len(fine) - spare]), segments, length).points


def unrest(model: RodModel) -> float:
    """Largest running sum of inertia and drag along the rods [N]."""
    forces = model.ledger.forces
    moving = sum((f for name, f in forces.items() if name in ("inertia", "drag")), np.zeros_like(model.x))
    return float(np.linalg.norm(np.cumsum(moving[:, :3], axis=0), axis=1).max())


def hold_ends(model: RodModel) -> None:
    """Begin a phase in which all ends are clamped as they lie."""
    sides = ("start", "end")
    model.begin(
        {(rod, side): clamped(model.end_frame(rod, side)) for rod in range(model.layout.rods) for side in sides}
    )


def rest(model: RodModel, longest: float = 100.0, share: float = 2e-5) -> int:
    """March the present phase until inertia and drag carry less than `share` B/r^2; returns the steps taken."""
    rod = model.rods[0]
    limit = share * rod.bending / rod.radius**2
    control = StepControl(0.01, 1e-8, longest, rod.radius)
    for count, _ in enumerate(model.march(control, model.settings(), [model.time + longest]), start=1):
        e = model.ledger.energies
        if unrest(model) < limit and e.kinetic < 1e-6 * e.elastic:
            return count
    return model.progress.steps


def table(title: str, header: Sequence[str], rows: Sequence[Sequence[float | str]]) -> None:
    """Print rows under a header."""
    print(f"\n{title}")
    cells = [list(header)] + [[c if isinstance(c, str) else f"{c:.4g}" for c in row] for row in rows]
    widths = [max(len(row[k]) for row in cells) for k in range(len(header))]
    for row in cells:
        print("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)), flush=True)
