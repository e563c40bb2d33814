"""Small sets of discrete rods and checks of their terms that many tests share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar, cast

import numpy as np

from knotfem.contact.collect import contact_report
from knotfem.contact.curve_pairs import hertz_line_stiffness
from knotfem.contact.friction import Friction
from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.pairs import PairContact
from knotfem.contact.report import ContactReport
from knotfem.contact.rigid import make_cylinder
from knotfem.energy.balance import EnergyBalance, StepFigures
from knotfem.energy.energies import Energies
from knotfem.geometry.finite_rotation import rotate, smallest_rotation
from knotfem.geometry.frames import tangents
from knotfem.models.base import Equations, Model, Obstacle
from knotfem.models.rod.assembly import DiscreteRods
from knotfem.models.rod.initial import EndFrame
from knotfem.models.rod.spec import ContactSpec, RodSpec
from knotfem.solver.constraints import Clamp, Prescribed
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance, Sections
from knotfem.solver.schemes import BackwardEuler, Scheme
from knotfem.solver.state import Motion, State
from knotfem.solver.stepping.continuation import Continuation
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.stepping.integrator import AcceptedStep, integrate
from knotfem.solver.system import System
from knotfem.solver.term import Conditions, Role, Term, TimeStep
from knotfem.sparse.pattern import Matrix, Pattern
from knotfem.terms.load import EndForce, FollowingForce
from knotfem.types import Array, History, VectorHistory

YOUNGS, RADIUS = 1.425, 3.0
BENDING, TWISTING = YOUNGS * np.pi * RADIUS**4 / 4.0, YOUNGS * np.pi * RADIUS**4 / 6.0
MASS = 1.16e-9 * np.pi * RADIUS**2
RUBBER = hertz_line_stiffness(YOUNGS, 0.5)
STICK = RADIUS / 30.0
SIDES = ("start", "end")
Kind = TypeVar("Kind", bound=Term)


def line(segments: int, length: float, axis: int = 0) -> Array:
    """Nodes of a straight rod from the origin along an axis."""
    points = np.zeros((segments + 1, 3))
    points[:, axis] = np.linspace(0.0, length, segments + 1)
    return points


def graded(segments: int, length: float) -> Array:
    """Lengths of segments that change smoothly along a rod, the longest four times the shortest."""
    lengths = 1.0 + 0.6 * np.cos(2.0 * np.pi * (np.arange(segments) + 0.5) / segments + 1.0)
    return lengths * length / lengths.sum()


def graded_line(segments: int, length: float) -> tuple[Array, Array]:
    """Nodes of a straight rod of such segments along x, and their lengths."""
    lengths = graded(segments, length)
    points = np.zeros((segments + 1, 3))
    points[1:, 0] = np.cumsum(lengths)
    return points, lengths


def spec(points: Array, **changed) -> RodSpec:
    """A rubber rod without core, unless changed."""
    values = {"radius": RADIUS, "bending": BENDING, "twisting": TWISTING, "axial": 4e3, "mass_per_length": MASS}
    return RodSpec(points, **{**values, **changed})


def contact(friction: float | Array = 0.0, stiffness: float = RUBBER) -> ContactSpec:
    """Contact by Hertz's law in the default resolution."""
    return ContactSpec(stiffness, friction, ramp=RADIUS / 30.0, stick=STICK, sample_spacing=RADIUS / 4.0)


def peg(place: Sequence[float], axis: Sequence[float], radius: float, friction: float) -> Obstacle:
    """A rigid cylinder."""
    return Obstacle(make_cylinder(np.array(place), np.array(axis), radius), friction)


@dataclass(frozen=True, eq=False)
class End:
    """What happens to an end in a phase."""

    prescribed: Sequence[Prescribed] = ()
    clamps: Sequence[Clamp] = ()
    loads: Sequence[Term] = ()


class Rods:
    """Discrete rods that go through phases one after the other, and their energy balance.

    Ends that are not mentioned in a phase are free. Before the first phase they are clamped as their curve lies.

    Args:
        rods, contact, obstacles, gravity, drag: see `DiscreteRods`.
        scheme: time integration; backward Euler unless given.

    Attributes:
        discrete: rods and their terms.
        sections: each node is one.
        balance: of energy since the first phase began.
        now: how to go on, with the accepted state.
        system: of the present phase.
        figures: of the last accepted step.
    """

    system: System
    figures: StepFigures

    def __init__(
        self,
        rods: Sequence[RodSpec],
        contact: ContactSpec | None = None,
        obstacles: Sequence[Obstacle] = (),
        *,
        gravity: Array | None = None,
        drag: float | None = None,
        scheme: Scheme | None = None,
    ) -> None:
        self.scheme = BackwardEuler() if scheme is None else scheme
        self.discrete = DiscreteRods(rods, contact, obstacles, gravity, drag, inertia=self.scheme.inertial)
        self.layout, self.terms = self.discrete.layout, self.discrete.terms
        self.sections = Sections(self.layout.sections, self.layout.first[:-1])
        self.balance = EnergyBalance(cast(Model, self))
        self.clamp_couples = self.discrete.clamp_couples
        self.now = Continuation.at(self._initial(rods))
        self._equations: Equations | None = None

    def _initial(self, rods: Sequence[RodSpec]) -> State:
        state, clamps = self.discrete.initial, []
        across = self.discrete.frames.material(state.x)
        for number, rod in enumerate(rods):
            nodes, t = self.layout.of(number), tangents(rod.points)[[0, -1]]
            ends = ((nodes.start, nodes.start, t[0]), (nodes.stop - 1, nodes.stop - 2, t[1]))
            for node, edge, tangent in ends:
                along = state.x[edge + 1, :3] - state.x[edge, :3]
                carried = smallest_rotation(along / np.linalg.norm(along), tangent).apply(across[edge])
                clamps.append(Clamp(node, lambda time, t=tangent, d=carried: (t, d)))
        return self.discrete.clamped(state, clamps)

    @property
    def state(self) -> State:
        """The accepted state."""
        return self.now.state

    @property
    def x(self) -> Array:
        """Its unknowns, shape [nodes, 4]."""
        return self.state.x

    @property
    def time(self) -> float:
        """Its time [s]."""
        return self.state.time

    @property
    def energies(self) -> Energies:
        """The energy balance so far."""
        return self.balance.energies

    def having(self, kind: type[Kind]) -> list[Kind]:
        """Terms of a kind."""
        return [term for term in self.terms if isinstance(term, kind)]

    @property
    def contact(self) -> PairContact:
        """Between rods."""
        (found,) = self.having(PairContact)
        return found

    @property
    def friction(self) -> Friction:
        """Between rods."""
        (found,) = (term for term in self.having(Friction) if isinstance(term.contact, PairContact))
        return found

    @property
    def obstacle(self) -> ObstacleContact:
        """With the only obstacle."""
        (found,) = self.having(ObstacleContact)
        return found

    @property
    def obstacle_friction(self) -> Friction:
        """On the only obstacle."""
        (found,) = (term for term in self.having(Friction) if term.external)
        return found

    def centreline(self, rod: int = 0) -> Array:
        """Nodes of a rod [mm], shape [n + 1, 3]."""
        return self.x[self.layout.of(rod), :3]

    def tension(self, rod: int = 0) -> Array:
        """Axial force of each segment [N], shape [n]."""
        return self.discrete.tension(self.x)[self.layout.rod[self.layout.edges] == rod]

    def contacts(self) -> ContactReport:
        """Where strands press on each other and on obstacles, as last assembled."""
        return contact_report(self.terms)

    @property
    def penetration(self) -> float:
        """Deepest penetration [mm]."""
        touching = [*self.having(PairContact), *self.having(ObstacleContact)]
        return max((term.penetration for term in touching), default=0.0)

    def reaction(self, side: str, rod: int = 0) -> Array:
        """Force of a support on an end at the end of the last accepted step [N], shape [3]."""
        return np.array(self.balance.end_forces[f"{rod}.{side}"])

    def node(self, side: str, rod: int = 0) -> int:
        """Node of an end."""
        nodes = self.layout.of(rod)
        return nodes.start if side == "start" else nodes.stop - 1

    def frame(self, side: str, rod: int = 0) -> EndFrame:
        """Orientation of an end: that of its clamp, or of the rod itself where there is none."""
        node, history = self.node(side, rod), self.state.history["frames-1"]
        held = np.flatnonzero(history["clamped"] == node)
        if held.size:
            row = self.layout.nodes + int(held[0])
            return EndFrame(history["tangent"][row], history["director"][row])
        frames, edge = self.discrete.frames.of(history), node if side == "start" else node - 1
        return EndFrame(frames.current(self.x)[0][edge], frames.material(self.x)[edge])

    def placed(self, side: str, path: VectorHistory, rod: int = 0) -> End:
        """An end that is at path(time) [mm], shape [3], and may turn."""
        return End([Prescribed(np.array([self.node(side, rod)]), lambda time: path(time)[None], f"{rod}.{side}")])

    def pinned(self, side: str, rod: int = 0) -> End:
        """An end that is held and may turn."""
        place = self.x[self.node(side, rod), :3].copy()
        return self.placed(side, lambda time: place, rod)

    def clamped(self, side: str, rod: int = 0) -> End:
        """An end that is held in place and orientation."""
        return self.turned(side, np.array([0.0, 0.0, 1.0]), lambda time: 0.0, rod)

    def driven(self, side: str, direction: Array, path: History, rod: int = 0) -> End:
        """A clamped end that is carried along a unit vector by path(time) [mm]."""
        place = self.x[self.node(side, rod), :3].copy()
        moving = self.placed(side, lambda time: place + path(time) * direction, rod)
        return replace(moving, clamps=self.clamped(side, rod).clamps)

    def turned(self, side: str, axis: Array, angle: History, rod: int = 0, *, held: bool = True) -> End:
        """An end that is turned about an axis through itself by angle(time) [rad]; its place is held or free."""
        frame = self.frame(side, rod)

        def orientation(time: float) -> tuple[Array, Array]:
            turn = angle(time)
            if turn == 0.0:
                return frame.tangent, frame.director
            return rotate(frame.tangent, axis, turn), rotate(frame.director, axis, turn)

        clamps = [Clamp(self.node(side, rod), orientation)]
        return End(self.pinned(side, rod).prescribed if held else (), clamps)

    def loaded(self, side: str, force: VectorHistory, rod: int = 0) -> End:
        """An end that bears a dead force [N], shape [3]."""
        return End(loads=[EndForce(np.array([self.node(side, rod)]), np.ones(1), force)])

    def followed(self, side: str, magnitude: History, rod: int = 0) -> End:
        """An end that bears a force along its tangent [N], positive outwards."""
        outer = self.node(side, rod)
        inner = outer + 1 if side == "start" else outer - 1
        return End(loads=[FollowingForce(np.array([outer]), np.ones(1), inner, outer, magnitude)])

    def put(self, x: Array | None = None, v: Array | None = None, a: Array | None = None) -> None:
        """Move to another state of motion, shape [nodes, 4] each; axial forces follow the positions."""
        old, history = self.state, dict(self.state.history)
        if x is not None:
            history["stretch-1"] = {"force": self.discrete.stretch.tension(x)}
        motion = (old.x if x is None else x, old.v if v is None else v, old.a if a is None else a)
        self.now = Continuation.at(State(*motion, old.time, history))

    def begin(
        self, *ends: End, fixed: Array | None = None, friction: History | None = None, drag: float | None = None
    ) -> None:
        """Begin a phase.

        Args:
            ends: what happens to them.
            fixed: unknowns that keep their values, boolean, shape [nodes, 4].
            friction: see `Conditions`.
            drag: likewise.
        """
        if self._equations is not None:
            self.system.close()
        prescribed, clamps, loads = (
            [one for end in ends for one in part(end)]
            for part in (lambda e: e.prescribed, lambda e: e.clamps, lambda e: e.loads)
        )
        conditions = Conditions(friction, drag, clamps)
        self.system = self.discrete.system(self.scheme, prescribed, loads=loads, conditions=conditions, fixed=fixed)
        self.now = Continuation.at(self.discrete.clamped(self.state, clamps))
        anew, supports = self._equations is None, {motion.label: motion.nodes for motion in prescribed}
        self._equations = Equations(self.system, supports, ())
        self.balance.begin(self._equations, self.state, anew=anew)

    def steps(
        self, controller: StepController, *output_times: float, newton: Newton | None = None
    ) -> Iterator[AcceptedStep]:
        """Yield accepted steps of the present phase up to the last of the output times [s]."""
        assert self._equations is not None, "begin a phase first"
        solver, times = self.newton() if newton is None else newton, np.array(output_times)
        for accepted in integrate(self.system, self.now, controller, solver, self.sections, times):
            self.now = accepted.after
            self.figures = self.balance.update(self._equations, accepted, accepted.start)
            yield accepted

    def run(self, controller: StepController, *output_times: float, newton: Newton | None = None) -> int:
        """Take all these steps; returns the iterations that they took."""
        return sum(step.solution.iterations for step in self.steps(controller, *output_times, newton=newton))

    def newton(self, tolerance: float | None = None) -> Newton:
        """Newton's method in units of the thinnest rod; the tolerance is 1e-6 B/r^2 unless given [N]."""
        scale = min(rod.bending / rod.radius**2 for rod in self.discrete.rods)
        d = 2.0 * float(self.layout.radius.min())
        return Newton(
            tolerance=ForceTolerance.of(1e-6 * scale if tolerance is None else tolerance),
            line_search=Armijo(whole_below=0.005 * d),
            largest_move=0.25 * d,
        )


def still(points: Array, **changed) -> Rods:
    """One rod without inertia, drag and contact."""
    return Rods([spec(points, **changed)], scheme=Scheme())


def crossing(
    depth: float,
    *,
    angle: float = np.pi / 2,
    shift: tuple[float, float] = (0.0, 0.0),
    segments: int = 20,
    h: float = 2.0,
    turn: Array | None = None,
    **changed,
) -> Rods:
    """Two straight rods that cross, the second on top and pressed in by `depth`."""
    s = (np.arange(segments + 1) - segments / 2) * h
    lower = np.stack([s + shift[0], 0 * s, 0 * s], axis=1)
    upper = np.stack(
        [np.cos(angle) * (s + shift[1]), np.sin(angle) * (s + shift[1]), 0 * s + 2 * RADIUS - depth], axis=1
    )
    Q = np.eye(3) if turn is None else turn
    return begun(Rods([spec(lower @ Q.T), spec(upper @ Q.T)], contact(**changed)))


def begun(model: Rods, *ends: End) -> Rods:
    """Rods with a first phase begun, so that their terms are those of the state."""
    model.begin(*ends)
    return model


def settle(
    model: Rods,
    *ends: End,
    duration: float = 1.0,
    steps: int = 4,
    tolerance: float = 2e-8,
    move: float = 1e3,
    **phase,
) -> int:
    """Go through one phase in equal steps, see `Rods.begin`; returns the iterations that they took."""
    model.begin(*ends, **phase)
    dt = duration / steps
    newton = Newton(
        tolerance=ForceTolerance.of(tolerance),
        line_search=Armijo(whole_below=0.03 if move < 1e3 else 1e3),
        max_iterations=60,
        largest_move=move,
    )
    return model.run(StepController(dt, 1e-4 * dt, dt, move), model.time + duration, newton=newton)


def stiffness(model: Rods) -> Array:
    """Dense tangent of the free unknowns in the accepted state."""
    system = model.system
    system.begin(model.state, 1e-9)
    free = ~system.fixed.ravel()
    return system.tangent(model.x)[1].to_scipy().toarray()[np.ix_(free, free)]


def free_mass(model: Rods) -> Array:
    """Mass of the free unknowns."""
    return model.discrete.mass.ravel()[~model.system.fixed.ravel()]


def static_forces(model: Rods) -> Array:
    """Residual of all terms but inertia and resistances in the accepted state, shape [nodes, 4]."""
    left_out = {label for label, term in model.system.labels.items() if term.role in (Role.INERTIA, Role.RESISTANCE)}
    model.system.load(model.state)
    model.system.update(model.x)
    forces = model.system.forces(model.x)
    return sum((force for label, force in forces.items() if label not in left_out), np.zeros_like(model.x))


def begin(terms: Sequence[Term], x: Array, clamps: Sequence[Clamp] = ()) -> None:
    """Let terms begin a step of one second from rest at x."""
    for term in terms:
        term.update(x)
    for term in terms:
        term.begin(TimeStep(Motion.at_rest(x), 1.0, conditions=Conditions(clamps=clamps)))


def residual(terms: Sequence[Term], x: Array) -> Array:
    """Residual of the last term; all are updated in order."""
    for term in terms:
        term.update(x)
    result = np.zeros_like(x)
    assert terms[-1].assemble(x, result, None)
    return result


def tangent(terms: Sequence[Term], x: Array) -> Array:
    """Dense tangent of the last term through the sparsity of all."""
    for term in terms:
        term.update(x)
    count = len(x)
    keys = [np.arange(count) * (count + 1)] + [k for t in terms if (k := t.couplings(count)) is not None]
    matrix = Matrix(Pattern.from_keys(np.unique(np.concatenate(keys)), count, False, 4))
    assert terms[-1].assemble(x, np.zeros_like(x), matrix), "the couplings do not cover the tangent"
    return matrix.to_scipy().toarray()


def differences(terms: Sequence[Term], x: Array, step: float = 1e-6) -> Array:
    """Central differences of the residual, column by column."""
    return _differences(lambda y: residual(terms, y).ravel(), x, step)


def tangent_error(terms: Sequence[Term], x: Array) -> float:
    """Largest deviation of the tangent from central differences, over its largest entry."""
    expected = differences(terms, x)
    return float(np.abs(tangent(terms, x) - expected).max() / np.abs(expected).max())


def gradient_error(terms: Sequence[Term], x: Array, step: float = 1e-6) -> float:
    """Largest deviation of the last term's residual from central differences of its energy, relative."""

    def energy(y: Array) -> Array:
        for term in terms:
            term.update(y)
        return np.array(terms[-1].energy(y))

    force = residual(terms, x).ravel()
    return float(np.abs(force - _differences(energy, x, step)).max() / np.abs(force).max())


def _differences(function: Callable[[Array], Array], x: Array, step: float) -> Array:
    columns = []
    for k in range(x.size):
        move = np.zeros(x.size)
        move[k] = step
        ahead, behind = (function(x + sign * move.reshape(x.shape)) for sign in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * step))
    return np.stack(columns, axis=-1)


def order(errors: Sequence[float]) -> float:
    """Measured order of convergence of errors under halving."""
    return float(np.log2(errors[0] / errors[-1]) / (len(errors) - 1))
