"""The assembled equations: terms, constraints, one matrix and its factorisation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from knotfem.errors import InputError
from knotfem.solver.clock import Clock
from knotfem.solver.constraints import Prescribed
from knotfem.solver.schemes import Scheme
from knotfem.solver.state import Motion, State
from knotfem.solver.term import RATES, Conditions, Role, Term, TimeStep
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.base import LinearSolver
from knotfem.sparse.pattern import Matrix, Pattern, merge_keys
from knotfem.types import Arrays


class System:
    """Residual and tangent of all terms under constraints.

    Args:
        terms: in the order in which they are assembled; a term stands behind those that it builds on. Inertia is left
            out where the scheme has none, and what the conditions leave no room for: in real time numerical drag,
            otherwise viscous terms and inertia, and friction where they say so.
        unknowns: of all nodes.
        solver: linear solver.
        scheme: time integration scheme.
        prescribed: nodes whose places are given.
        conditions: of the scene's step.

    Attributes:
        fixed: unknowns that are prescribed or fixed, shape [nodes, width].
        clock: time taken so far.
        analyses, factorisations: so far.
        keys: adjacency keys of the pattern in force, None before the first.
    """

    def __init__(
        self,
        terms: Sequence[Term],
        unknowns: Unknowns,
        solver: LinearSolver,
        scheme: Scheme,
        prescribed: Sequence[Prescribed] = (),
        *,
        conditions: Conditions | None = None,
    ) -> None:
        self.conditions = Conditions() if conditions is None else conditions
        absent = {Role.NUMERICAL} if self.conditions.real else {Role.RESISTANCE, Role.INERTIA}
        if self.conditions.frictionless:
            absent.add(Role.FRICTION)
        self.terms = [t for t in terms if t.role not in absent and (scheme.inertial or t.role is not Role.INERTIA)]
        self._left_out = [term for term in terms if term not in self.terms]
        self.nodes, self.width = unknowns.nodes, unknowns.width
        self.solver, self.scheme = solver, scheme
        self.prescribed = list(prescribed)
        weights = unknowns.damping_weights
        self.damping_weights = np.full(self.nodes, 1.0 / self.nodes) if weights is None else weights
        self.symmetric = not unknowns.unsymmetric and all(term.symmetric for term in self.terms)
        shape = self.nodes, self.width
        self.fixed = np.zeros(shape, dtype=bool) if unknowns.fixed is None else unknowns.fixed.copy()
        for motion in self.prescribed:
            self.fixed[motion.nodes, :3] |= np.array(motion.components)
        self.clock = Clock()
        self.analyses = 0
        self.factorisations = 0
        self.keys: np.ndarray | None = None
        self._matrix: Matrix | None = None
        self._analysed: Pattern | None = None
        self._start_residual: np.ndarray | None = None
        self._start: np.ndarray | None = None
        self._loaded: State | None = None
        self._labelled = labelled(self.terms)

    def load(self, state: State) -> None:
        """Take the history variables of an accepted state; terms that are not in it begin anew."""
        if state is self._loaded:
            return
        for label, term in self._labelled:
            term.load(state.history.get(label, {}))
        for term in self._left_out:
            term.load({})
        self._loaded = state

    def begin(self, state: State, dt: float, advance: float | None = None) -> TimeStep:
        """A step sets out from an accepted state.

        Args:
            state: accepted.
            dt: time over which rates are taken [s].
            advance: of loads [s]; None for `dt`, which is real time. Without real time there is no velocity: the step
                ends at rest.

        Where the scheme weighs in the residual it sets out with, that is of a step of no length: loads and velocities
        are then those of the accepted state, whatever was tried since.
        """
        self.load(state)
        self._loaded = None
        self.update(state.x)
        self._start = state.x
        step = TimeStep(state, dt, self.scheme, self.conditions, advance)
        if self.scheme.alpha_f > 0.0:
            here = TimeStep(state, 0.0, self.scheme, self.conditions)
            for term in self.terms:
                self.clock.run(term.name, term.begin, here)
            self._start_residual = self._static(state.x, None)[0]
        for term in self.terms:
            self.clock.run(term.name, term.begin, step)
        return step

    def update(self, x: np.ndarray) -> None:
        """Let the terms follow new positions."""
        for term in self.terms:
            self.clock.run(term.name, term.update, x)

    def drop_pattern(self) -> None:
        """Forget pattern and analysis; they are built anew when next needed."""
        self._matrix = None

    def restore_pattern(self, keys: np.ndarray) -> None:
        """Take the pattern of an earlier system, so that factorisations go on to the same bits."""
        self._matrix = self._fill(keys)

    def residual(self, x: np.ndarray) -> np.ndarray:
        """Out-of-balance force [N] of all nodes, reactions at prescribed ones included, shape [nodes, width]."""
        return self._total(x, None)[0]

    def tangent(self, x: np.ndarray) -> tuple[np.ndarray, Matrix]:
        """Residual and unconstrained tangent."""
        matrix = self._matrix or self._build()
        matrix.clear()
        residual, complete = self._total(x, matrix)
        if not complete:
            matrix = self._build()
            residual, complete = self._total(x, matrix)
            assert complete, "a term's couplings do not cover its tangent"
        self._matrix = matrix
        return residual, matrix

    def targets(self, time: float) -> np.ndarray:
        """Values of the prescribed unknowns at a time, shape [nodes, width]; fixed ones keep those of the start."""
        goal = np.zeros((self.nodes, self.width)) if self._start is None else np.where(self.fixed, self._start, 0.0)
        for motion in self.prescribed:
            place = goal[motion.nodes, :3]
            goal[motion.nodes, :3] = np.where(motion.components, motion.positions(time), place)
        return goal

    def solve(self, matrix: Matrix, damping: float, rhs: np.ndarray) -> np.ndarray:
        """Solve with zero at prescribed unknowns.

        Args:
            matrix: tangent; it is constrained and damped in place.
            damping: Levenberg-Marquardt damping of all nodes together [N/mm], weighted by `damping_weights`.
            rhs: shape [nodes, width].

        Returns:
            Shape [nodes, width].
        """
        if damping > 0.0:
            matrix.add_diagonal(np.repeat(damping * self.damping_weights, self.width))
        self.clock.run("constrain", matrix.constrain, self.fixed.ravel())
        self._factorise(matrix)
        return self.resolve(rhs)

    def resolve(self, rhs: np.ndarray) -> np.ndarray:
        """Solve with the last factorisation, zero at prescribed unknowns; shapes as in `solve`."""
        masked = np.where(self.fixed, 0.0, rhs)
        return self.clock.run("solve", self.solver.solve, masked.ravel()).reshape(rhs.shape)

    def increment(self, du: np.ndarray) -> None:
        """Let the terms find the change of their own unknowns in a full step `du`, shape [nodes, width]."""
        for term in self.terms:
            self.clock.run(term.name, term.increment, du)

    def advance(self, fraction: float) -> None:
        """Let the terms take a fraction of that change."""
        for term in self.terms:
            self.clock.run(term.name, term.advance, fraction)

    def allowed_fraction(self, x: np.ndarray, dx: np.ndarray) -> float:
        """Fraction of a predicted move `dx` from x, shape [nodes, width], that all terms let through."""
        return min((self.clock.run(t.name, t.allowed_fraction, x, dx) for t in self.terms), default=1.0)

    @property
    def admissible(self) -> bool:
        """Whether the state last assembled can be one of equilibrium."""
        return all(term.admissible for term in self.terms)

    def merit(self, x: np.ndarray) -> float:
        """Merit of the line search at x, with the terms' own unknowns at their full increment.

        Its slope is the residual, so terms weigh in it as the scheme has them.
        """
        weight, merit = self.scheme.alpha_f, 0.0
        for term in self.terms:
            part = self.clock.run(term.name, term.merit, x)
            merit += part if term.role is Role.INERTIA else (1.0 - weight) * part
        if self._start_residual is not None:
            merit += weight * float(np.sum(self._start_residual * x))
        return merit

    def commit(self, x: np.ndarray, step: TimeStep) -> State:
        """The state in which an accepted step ends at x."""
        real = step.advance is None
        motion = self.scheme.motion(x, step.start, step.dt) if real else Motion.at_rest(x, step.end)
        for term in self.terms:
            self.clock.run(term.name, term.commit, x)
        self._loaded = self.state(motion)
        return self._loaded

    def state(self, motion: Motion) -> State:
        """A motion with the present history variables of all terms."""
        return State.of(motion, self.history())

    def history(self) -> dict[str, Arrays]:
        """Present history variables of all terms by label."""
        return {label: history for label, term in self._labelled if (history := term.history())}

    def having(self, *roles: Role) -> list[Term]:
        """Terms of some roles, in order."""
        return [term for term in self.terms if term.role in roles]

    def forces(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """Residual of each term by itself, by label, shape [nodes, width]."""
        result: dict[str, np.ndarray] = {}
        for label, term in self._labelled:
            result[label] = np.zeros((self.nodes, self.width))
            self.clock.run(term.name, term.assemble, x, result[label], None)
        return result

    def rate_forces(self, x: np.ndarray) -> np.ndarray:
        """Residual at x of all that rests in equilibrium, shape [nodes, width]."""
        result = np.zeros((self.nodes, self.width))
        for term in self.having(*RATES):
            self.clock.run(term.name, term.assemble, x, result, None)
        return result

    def slip(self) -> float:
        """Longest slip of a contact in the last accepted step, beyond the stick distance [mm]."""
        return max((term.slip() for term in self.having(Role.FRICTION)), default=0.0)

    def largest_load(self, x: np.ndarray, residual: np.ndarray) -> float:
        """Size of the largest force on an end of a rod [N], a reaction or a load.

        Args:
            x: unknowns in balance, shape [nodes, width].
            residual: there, reactions included, shape of x.
        """
        forces = [residual[motion.nodes, :3].sum(axis=0) for motion in self.prescribed]
        for term in self.having(Role.LOAD):
            force = np.zeros_like(x)
            self.clock.run(term.name, term.assemble, x, force, None)
            forces.append(force[:, :3].sum(axis=0))
        return max((float(np.linalg.norm(force)) for force in forces), default=0.0)

    @property
    def labels(self) -> Mapping[str, Term]:
        """Terms by label."""
        return dict(self._labelled)

    def close(self) -> None:
        """Release the linear solver's memory."""
        self.solver.close()
        self._analysed = None

    def _factorise(self, matrix: Matrix) -> None:
        if self._analysed is not matrix.pattern:
            self.clock.run("analysis", self.solver.analyse, matrix.pattern)
            self._analysed = matrix.pattern
            self.analyses += 1
        self.clock.run("factorisation", self.solver.factorise, matrix)
        self.factorisations += 1

    def _build(self) -> Matrix:
        diagonal = np.arange(self.nodes, dtype=np.int64) * (self.nodes + 1)
        found = (self.clock.run(term.name, term.couplings, self.nodes) for term in self.terms)
        keys = self.clock.run("pattern", merge_keys, diagonal, *(part for part in found if part is not None))
        return self._fill(keys)

    def _fill(self, keys: np.ndarray) -> Matrix:
        self.keys = keys
        pattern = self.clock.run("pattern", Pattern.from_keys, keys, self.nodes, self.symmetric, self.width)
        for term in self.terms:
            self.clock.run("pattern", term.allocate, pattern)
        return Matrix(pattern)

    def _static(self, x: np.ndarray, matrix: Matrix | None) -> tuple[np.ndarray, bool]:
        residual, complete = np.zeros((self.nodes, self.width)), True
        for term in self.terms:
            if term.role is not Role.INERTIA:
                answer = self.clock.run(term.name, term.assemble, x, residual, matrix)
                if answer is None:
                    expected = "True, or False where the pattern of the matrix must be built anew"
                    raise InputError("assemble returns nothing", key="terms", found=term.name, expected=expected)
                complete &= answer
        return residual, complete

    def _total(self, x: np.ndarray, matrix: Matrix | None) -> tuple[np.ndarray, bool]:
        residual, complete = self._static(x, matrix)
        weight = self.scheme.alpha_f
        if weight > 0.0:
            assert self._start_residual is not None, "begin before assembling"
            residual = (1.0 - weight) * residual + weight * self._start_residual
            if matrix is not None:
                matrix.data *= 1.0 - weight
        for term in self.having(Role.INERTIA):
            self.clock.run(term.name, term.assemble, x, residual, matrix)
        return residual, complete


def labelled(terms: Sequence[Term]) -> list[tuple[str, Term]]:
    """Terms with labels of their own: name and number, or else place among those of the same name."""
    seen: dict[str, int] = {}
    result = []
    for term in terms:
        seen[term.name] = seen.get(term.name, 0) + 1
        result.append((f"{term.name}-{term.number or seen[term.name]}", term))
    return result
