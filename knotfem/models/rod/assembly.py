"""The terms of a set of discrete rods, built from plain numbers."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from knotfem.mesh.rod_layout import RodLayout, make_layout
from knotfem.models.base import Obstacle
from knotfem.models.rod.bend import Bend
from knotfem.models.rod.frames import Frames
from knotfem.models.rod.spec import ContactSpec, RodSpec, directors_of
from knotfem.models.rod.twist import Twist
from knotfem.models.shared_terms import ContactParts, contact_terms, mass_terms
from knotfem.solver.constraints import Clamp, Prescribed
from knotfem.solver.schemes import Scheme
from knotfem.solver.state import Motion, State
from knotfem.solver.system import System, labelled
from knotfem.solver.term import Conditions, Term
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.axial import AxialStiffness

if TYPE_CHECKING:
    from knotfem.models.rod.damping import Damping  # with compiled loops, for rods with internal damping only

MERIT_STIFFNESS_OVER_BENDING = 5.0
"""Axial stiffness of the line search's merit, in units of B/r^2; the true one rejects every rotation."""


class DiscreteRods:
    """Discrete elastic rods, their contacts and what acts on them. It never changes; states do.

    Args:
        rods: at least one.
        contact: None for strands that pass through each other.
        obstacles: rigid bodies; they need `contact`.
        gravity: acceleration [mm/s^2], shape [3].
        drag: rate in real time [1/s]; None without drag.
        numerical_drag: rate in quasi-static steps [1/s]; None where there is none.
        inertia: whether there is any.

    Raises:
        InputError: obstacles without contact.

    Attributes:
        layout: numbering.
        terms: in the order in which they are assembled.
        frames: directors of the edges.
        stretch, bend, twist: elasticity.
        damping: internal, of stretch, bend and twist; empty where no rod has any.
        initial: state in which the rods are given, without clamps.
    """

    def __init__(
        self,
        rods: Sequence[RodSpec],
        contact: ContactSpec | None = None,
        obstacles: Sequence[Obstacle] = (),
        gravity: np.ndarray | None = None,
        drag: float | None = None,
        *,
        inertia: bool = True,
        numerical_drag: float | None = None,
    ) -> None:
        self.rods = list(rods)
        self.layout = _layout_of(rods)
        x = np.zeros((self.layout.nodes, 4))
        x[:, :3] = np.concatenate([rod.points for rod in rods])
        self.frames = Frames(self.layout, x, np.concatenate([directors_of(rod) for rod in rods]))
        self.stretch = self._stretch()
        self.stretch.view.force[:] = self.stretch.tension(x)
        self.bend = Bend(self.frames, np.array([rod.bending for rod in rods]))
        self.twist = Twist(self.frames, np.array([rod.twisting for rod in rods]))
        self.damping = self._damping()
        self.terms: tuple[Term, ...] = (
            self.frames,
            self.stretch,
            self.bend,
            self.twist,
            *(self.damping or ()),
            *mass_terms(lambda: self.mass, inertia=inertia, drag=drag, numerical_drag=numerical_drag, gravity=gravity),
            *contact_terms(None if contact is None else self._contact_parts(contact), obstacles),
        )
        own = {label: term.history() for label, term in labelled([self.frames, self.stretch])}
        self.initial = self.clamped(State.of(Motion.at_rest(x), own), ())

    @cached_property
    def mass(self) -> np.ndarray:
        """Mass of each unknown [tonne], shape [nodes, 4]; made when a term first asks for it."""
        from knotfem.models.rod.mass import lumped_mass

        return lumped_mass(self.layout, np.array([rod.mass_per_length for rod in self.rods]))

    @property
    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Nodes of each edge, shape [edges, 2], and its length when free of stress [mm], shape [edges]."""
        edges = self.layout.edges
        return np.stack([edges, edges + 1], axis=1), self.layout.spacing[edges]

    def _stretch(self) -> AxialStiffness:
        rod = self.layout.rod[self.layout.edges]
        axial = np.array([spec.axial for spec in self.rods])
        bending = np.array([spec.bending for spec in self.rods])
        moderate = MERIT_STIFFNESS_OVER_BENDING * bending / np.asarray(self.layout.radius) ** 2
        return AxialStiffness("stretch", *self.edges, axial[rod], moderate[rod])

    def _damping(self) -> Damping | None:
        times = [rod.relaxation_time for rod in self.rods]
        if max(times) == 0.0:
            return None
        from knotfem.models.rod.damping import make_damping

        return make_damping(self.stretch, self.bend, self.twist, self.frames, times)

    def _contact_parts(self, spec: ContactSpec) -> ContactParts:
        from knotfem.contact.curve import make_samples
        from knotfem.contact.curve_pairs import CurveSurface
        from knotfem.contact.law import Penalty

        law = Penalty(spec.stiffness, spec.ramp, spec.onset_over_ramp)
        obstacle_law = law._replace(stiffness=2.0 * spec.stiffness)

        def friction():
            from knotfem.contact.curve_friction import CurveFriction

            return CurveFriction(self.frames, spec.stick)

        def obstacle_friction():
            from knotfem.contact.curve_obstacle_friction import CurveObstacleFriction

            return CurveObstacleFriction(self.frames, spec.stick)

        mu = np.broadcast_to(np.asarray(spec.friction, dtype=float), (self.layout.rods, self.layout.rods)).copy()
        samples = make_samples(self.layout, spec.sample_spacing)
        return ContactParts(CurveSurface(self.layout), samples, law, obstacle_law, mu, friction, obstacle_friction)

    def load(self, state: State) -> None:
        """Let the terms take the history variables of a state; those that are not in it begin anew."""
        for label, term in labelled(self.terms):
            term.load(state.history.get(label, {}))

    def clamped(self, state: State, clamps: Sequence[Clamp]) -> State:
        """A state with other clamps, from which a step sets out; internal damping begins at no rate."""
        labels = {id(term): label for label, term in labelled(self.terms)}
        history = dict(state.history)
        label = labels[id(self.frames)]
        frames = self.frames.of(history.get(label, {}))
        history[label] = frames.clamped_at(clamps, state.x, state.time)
        for dashpot in self.damping or ():
            label = labels[id(dashpot)]
            history[label] = dashpot.at_rest(state.x, frames, history.get(label, {}))
        return State.of(state, history)

    def system(
        self,
        scheme: Scheme,
        prescribed: Sequence[Prescribed] = (),
        *,
        loads: Sequence[Term] = (),
        conditions: Conditions | None = None,
        fixed: np.ndarray | None = None,
        linear_solver: str = "auto",
        threads: int = 1,
    ) -> System:
        """The equations of a step.

        Args:
            scheme: time integration.
            prescribed: nodes whose places are given.
            loads: forces besides.
            conditions: clamps, friction and drag.
            fixed: unknowns that keep their values, boolean, shape [nodes, 4].
            linear_solver: its name.
            threads: of it.
        """
        kept = np.zeros((self.layout.nodes, 4), dtype=bool) if fixed is None else fixed.copy()
        kept[self.layout.last, 3] = True
        unknowns = Unknowns(self.layout.nodes, 4, kept, unsymmetric=True)
        solver = make_solver(linear_solver, threads)
        return System([*self.terms, *loads], unknowns, solver, scheme, prescribed, conditions=conditions)

    @property
    def _resisting(self) -> Damping | None:
        """Internal damping where anything moves in real time."""
        return None if self.damping is None or self.damping.stretch.rate == 0.0 else self.damping

    def tension(self, x: np.ndarray) -> np.ndarray:
        """Axial force of each segment [N], internal damping included, shape [segments]."""
        elastic = self.stretch.tension(x)
        return elastic if self._resisting is None else elastic + self._resisting.stretch.tension(x)

    def torque(self, x: np.ndarray) -> np.ndarray:
        """Twisting moment of each vertex [N mm], internal damping included, shape [vertices]."""
        elastic = self.twist.torque(x)
        return elastic if self._resisting is None else elastic + self._resisting.twist.torque(x)

    def clamp_couples(self, x: np.ndarray) -> np.ndarray:
        """Couple of each clamp on its rod [N mm], shape [clamps, 3]."""
        none = np.zeros((self.frames.clamped.size, 3))
        damping = () if self._resisting is None else (self._resisting.bend, self._resisting.twist)
        return sum((term.clamp_couples(x) for term in (self.bend, self.twist, *damping)), none)


def _layout_of(rods: Sequence[RodSpec]) -> RodLayout:
    chords = [np.linalg.norm(np.diff(rod.points, axis=0), axis=1) for rod in rods]
    spacing = [float(c.mean()) if rod.spacing is None else rod.spacing for rod, c in zip(rods, chords, strict=True)]
    return make_layout([c.size for c in chords], spacing, [rod.radius for rod in rods])
