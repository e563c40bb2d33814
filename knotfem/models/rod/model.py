"""The reduced model of a set of rods, built from plain numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from knotfem.contact.report import ContactMap, contact_map
from knotfem.energy.ledger import Ledger
from knotfem.errors import InputError
from knotfem.geometry.frames import tangents
from knotfem.mesh.rod_layout import RodLayout, make_layout
from knotfem.models.rod.bend import Bend
from knotfem.models.rod.ends import End, EndFrame, FollowingForce
from knotfem.models.rod.frames import Clamp, Frames
from knotfem.models.rod.spec import ContactSpec, CylinderSpec, RodSpec, twist_free_directors
from knotfem.models.rod.stretch import MERIT_STIFFNESS_OVER_BENDING, Stretch
from knotfem.models.rod.system import RodSystem
from knotfem.models.rod.twist import Twist
from knotfem.solver.constraints import Prescribed
from knotfem.solver.nonlinear.newton import NewtonSettings
from knotfem.solver.schemes import BackwardEuler, Scheme
from knotfem.solver.stepping.integrator import Accepted, March, Progress, StepControl
from knotfem.solver.term import Motion, Term
from knotfem.sparse.linear import make_solver

if TYPE_CHECKING:
    from knotfem.contact.curve import Samples
    from knotfem.contact.curve_contact import Contact
    from knotfem.contact.curve_cylinder import Cylinder, CylinderFriction
    from knotfem.contact.curve_friction import Friction
    from knotfem.models.rod.damping import InternalDamping

Side = tuple[int, str]
"""Number of a rod, and "start" or "end"."""


class RodModel:
    """Rods, their contacts and where they are.

    Args:
        rods: at least one.
        contact: None for strands that pass through each other.
        cylinders: obstacles; they need `contact`.
        gravity: acceleration [mm/s^2], shape [3].
        drag: rate [1/s].
        scheme: time integration; what it is when a phase begins, that phase is integrated by.
        linear_solver: see `knotfem.sparse.linear.make_solver`.
        threads: of the linear solver, 0 for its own choice.

    Attributes:
        layout: numbering.
        effects: those that outlive a phase.
        frames: directors of the edges.
        progress: present motion (positions and spins, shape [nodes, 4]) and step control.
        damping: internal, of stretch, bend and twist; None where no rod has any.
        ledger: energy account.
        system: of the present phase.
    """

    def __init__(
        self,
        rods: Sequence[RodSpec],
        contact: ContactSpec | None = None,
        cylinders: Sequence[CylinderSpec] = (),
        gravity: np.ndarray | None = None,
        drag: float = 0.0,
        scheme: Scheme | None = None,
        linear_solver: str = "auto",
        threads: int = 0,
    ) -> None:
        self.rods = list(rods)
        self.scheme = BackwardEuler() if scheme is None else scheme
        self._solver, self._threads = linear_solver, threads
        chords = [np.linalg.norm(np.diff(rod.points, axis=0), axis=1) for rod in rods]
        spacing = [float(c.mean()) if rod.spacing is None else rod.spacing for rod, c in zip(rods, chords, strict=True)]
        self.layout: RodLayout = make_layout([c.size for c in chords], spacing, [rod.radius for rod in rods])
        x = np.zeros((self.layout.nodes, 4))
        x[:, :3] = np.concatenate([rod.points for rod in rods])
        self.frames = Frames(self.layout, x, np.concatenate([twist_free_directors(rod) for rod in rods]))
        bending = np.array([rod.bending for rod in rods])
        moderate = MERIT_STIFFNESS_OVER_BENDING * bending / self.layout.radius**2
        self.stretch = Stretch(self.layout, np.array([rod.axial for rod in rods]), moderate)
        self.stretch.force = self.stretch.tension(x)
        self.bend = Bend(self.frames, bending)
        self.twist = Twist(self.frames, np.array([rod.twisting for rod in rods]))
        self.effects: list[Term] = [self.frames, self.stretch, self.bend, self.twist]
        self.contact: Contact | None = None
        self.friction: Friction | None = None
        self.cylinders: list[tuple[Cylinder, CylinderFriction | None]] = []
        self.damping: InternalDamping | None = None
        if any(rod.relaxation_time > 0.0 for rod in rods):
            self._add_damping([rod.relaxation_time for rod in rods])
        self._add_masses(drag, gravity)
        if contact is not None:
            self._add_contact(contact, cylinders)
        elif cylinders:
            raise InputError("cylinders need contact", key="rod model")
        self.progress = Progress.at(Motion.at_rest(x))
        self.ledger = Ledger(self.mass if self.scheme.inertial else None)
        self.system: RodSystem | None = None
        self._ends: dict[Side, End] = {}
        self._first_tangents = [tangents(rod.points)[[0, -1]] for rod in rods]
        self._moved = False

    def _add_damping(self, times: Sequence[float]) -> None:
        from knotfem.models.rod.damping import make_damping

        self.damping = make_damping(self.stretch, self.bend, self.twist, self.frames, times)
        self.effects += self.damping

    @cached_property
    def mass(self) -> np.ndarray:
        """That goes with each unknown [tonne], shape [nodes, 4]."""
        from knotfem.models.rod.mass import lumped_mass

        return lumped_mass(self.layout, np.array([rod.mass_per_length for rod in self.rods]))

    def _add_masses(self, drag: float, gravity: np.ndarray | None) -> None:
        if self.scheme.inertial or drag > 0.0:
            from knotfem.terms.inertia import Drag, Inertia

            if self.scheme.inertial:
                self.effects.append(Inertia(self.mass))
            if drag > 0.0:
                self.effects.append(Drag(self.mass, drag))
        if gravity is not None and np.any(gravity):
            from knotfem.terms.gravity import Gravity

            self.effects.append(Gravity(self.mass[:, 0], np.asarray(gravity, dtype=float)))

    def _add_contact(self, spec: ContactSpec, cylinders: Sequence[CylinderSpec]) -> None:
        from knotfem.contact.curve import make_samples
        from knotfem.contact.curve_contact import Contact
        from knotfem.contact.penalty import Penalty

        samples = make_samples(self.layout, spec.sample_spacing)
        law = Penalty(spec.stiffness, spec.ramp, 0.0)
        self.contact = Contact(self.layout, samples, law)
        count = self.layout.rods
        mu = np.broadcast_to(np.asarray(spec.friction, dtype=float), (count, count)).copy()
        self.effects.append(self.contact)
        if mu.max() > 0.0:
            from knotfem.contact.curve_friction import Friction

            self.friction = Friction(self.contact, self.frames, mu, spec.tangential * spec.stiffness, spec.factor)
            self.effects.append(self.friction)
        for cylinder in cylinders:
            self._add_cylinder(cylinder, spec, samples)

    def _add_cylinder(self, cylinder: CylinderSpec, spec: ContactSpec, samples: Samples) -> None:
        from knotfem.contact.curve_cylinder import Cylinder, CylinderFriction
        from knotfem.contact.penalty import Penalty

        stiffness = 2.0 * spec.stiffness if cylinder.stiffness is None else cylinder.stiffness
        law, axis = Penalty(stiffness, spec.ramp, 0.0), np.asarray(cylinder.axis, dtype=float)
        axis = axis / np.linalg.norm(axis)
        touching = Cylinder(self.layout, samples, law, np.asarray(cylinder.origin, float), axis, cylinder.radius)
        self.effects.append(touching)
        mu, friction = np.broadcast_to(np.asarray(cylinder.friction, dtype=float), (self.layout.rods,)).copy(), None
        if mu.max() > 0.0:
            friction = CylinderFriction(touching, self.frames, mu, spec.tangential * stiffness)
            friction.number = len(self.cylinders) + 1
            self.effects.append(friction)
        self.cylinders.append((touching, friction))

    @property
    def x(self) -> np.ndarray:
        """Places and spins (times radius) of all nodes [mm], shape [nodes, 4]."""
        return self.progress.motion.x

    @property
    def time(self) -> float:
        """[s]."""
        return self.progress.motion.time

    def centreline(self, rod: int = 0) -> np.ndarray:
        """Nodes of a rod [mm], shape [n + 1, 3]."""
        return self.x[self.layout.of(rod), :3]

    def tension(self, rod: int = 0) -> np.ndarray:
        """Axial force of each segment [N], internal damping included, shape [n]."""
        axial = self.stretch.tension(self.x)
        if self.damping is not None:
            axial = axial + self.damping.stretch.tension(self.x)
        return axial[self.layout.rod[self.layout.edges] == rod]

    def twists(self, rod: int = 0) -> np.ndarray:
        """Twist per length at each inner node [rad/mm], shape [n - 1]."""
        count = self.layout.inner.size
        twists = self.frames.twists(self.x)[:count] / self.frames.cell[:count]
        return twists[self.layout.rod[self.layout.inner] == rod]

    def contacts(self) -> ContactMap:
        """Where strands press on each other and on cylinders."""
        return contact_map(self.contact, self.friction, self.cylinders)

    @property
    def penetration(self) -> float:
        """Deepest penetration [mm]."""
        touching = ([] if self.contact is None else [self.contact]) + [c for c, _ in self.cylinders]
        return max((c.penetration for c in touching), default=0.0)

    def end_frame(self, rod: int, side: str) -> EndFrame:
        """How an end lies now: as its clamp has it, or as the rod itself does where there is none."""
        nodes = self.layout.of(rod)
        node, edge = (nodes.start, nodes.start) if side == "start" else (nodes.stop - 1, nodes.stop - 2)
        place = self.x[node, :3].copy()
        end = self._ends.get((rod, side))
        if end is not None and end.orientation is not None:
            return EndFrame(place, *end.orientation(self.time))
        t = self.frames.current(self.x)[0][edge]
        director = self.frames.material(self.x)[edge]
        if self._moved:
            return EndFrame(place, t, director)
        goal = self._first_tangents[rod][0 if side == "start" else 1]
        carried = director - (director @ goal) / (1.0 + t @ goal) * (t + goal)
        return EndFrame(place, goal, carried)

    def begin(self, ends: Mapping[Side, End], frozen: np.ndarray | None = None) -> RodSystem:
        """Begin a phase in which this happens to the ends; those not mentioned are free.

        Args:
            ends: by number of the rod and side.
            frozen: unknowns that keep their values, boolean, shape [nodes, 4].
        """
        x, time = self.x, self.time
        prescribed: list[Prescribed] = []
        loads: list[Term] = []
        clamps: list[Clamp] = []
        for (rod, side), end in ends.items():
            if not 0 <= rod < self.layout.rods or side not in ("start", "end"):
                raise InputError("no such end", key="rod model", found=f"{rod}, {side}")
            nodes = self.layout.of(rod)
            node, inner = (nodes.start, nodes.start + 1) if side == "start" else (nodes.stop - 1, nodes.stop - 2)
            if end.place is not None:
                prescribed.append(Prescribed(np.array([node]), _row(end.place), f"{rod}.{side}"))
            if end.orientation is not None:
                clamps.append(Clamp(node, end.orientation))
            if end.force is not None:
                from knotfem.terms.load import EndForce

                loads.append(EndForce(np.array([node]), np.ones(1), end.force))
            if end.following is not None:
                loads.append(FollowingForce(inner, node, end.following))
        self._ends = dict(ends)
        self._moved = True
        self.frames.set_clamps(clamps, x, time)
        for dashpot in self.damping or ():
            dashpot.reset(x)
        if self.system is not None:
            self.system.close()
        self.system = RodSystem(
            [*self.effects, *loads],
            self.layout,
            make_solver(self._solver, self._threads),
            self.scheme,
            prescribed,
            frozen,
        )
        self.system.keep(x)
        self.system.update(x)
        self.ledger.open(self.system, self.frames, x, self.progress.motion.v, time)
        self.progress.dt = self.progress.increment_dt = 0.0
        return self.system

    def march(self, control: StepControl, settings: NewtonSettings, stops: Sequence[float]) -> Iterator[Accepted]:
        """Steps of the present phase, each booked in the ledger, until the last of the times `stops` [s]."""
        assert self.system is not None, "begin a phase before marching"
        march = March(self.system, self.progress, control, settings, self.layout.sections, np.asarray(stops, float))
        for accepted in march:
            self.ledger.book(self.system, self.frames, accepted.start, accepted.motion.x, accepted.motion.v)
            yield accepted

    def reaction(self, rod: int, side: str) -> np.ndarray:
        """Force of a held end's support on the rod [N], shape [3]."""
        assert self.system is not None, "begin a phase first"
        nodes = self.layout.of(rod)
        node = nodes.start if side == "start" else nodes.stop - 1
        return self.system.residual(self.x)[node, :3]

    def settings(self, force_tolerance: float | None = None) -> NewtonSettings:
        """Newton's settings in units of the thinnest rod; the tolerance is 1e-6 B/r^2 unless given [N]."""
        scale = min(rod.bending / rod.radius**2 for rod in self.rods)
        tolerance = 1e-6 * scale if force_tolerance is None else force_tolerance
        d = 2.0 * float(self.layout.radius.min())
        return NewtonSettings(tolerance, 10.0 * tolerance, largest_move=0.25 * d, endgame_move=0.005 * d)

    def history(self) -> dict[str, Any]:
        """All that a new model of the same rods needs to go on with the present phase to the last bit."""
        assert self.system is not None, "begin a phase first"
        state = {key: value for key, value in vars(self.progress).items() if key != "motion"}
        return {
            "progress": {**state, "motion": asdict(self.progress.motion)},
            "effects": self.system.history(),
            "ledger": self.ledger.state(),
        }

    def load(self, history: dict[str, Any]) -> None:
        """Go on from a history, after `begin` with the ends of its phase."""
        assert self.system is not None, "begin a phase first"
        values = dict(history["progress"])
        self.progress = Progress(Motion(**values.pop("motion")), **values)
        self.system.restore(history["effects"])
        self.system.keep(self.x)
        self.ledger.restore(history["ledger"])


def _row(place: Callable[[float], np.ndarray]) -> Callable[[float], np.ndarray]:
    return lambda time: np.asarray(place(time), dtype=float)[None]
