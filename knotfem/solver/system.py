"""The assembled equations: effects, constraints, one matrix and its factorisation."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from knotfem.solver.constraints import Prescribed
from knotfem.solver.schemes import Scheme
from knotfem.solver.term import Arrays, Motion, StepStart, Term
from knotfem.sparse.linear import LinearSolver
from knotfem.sparse.pattern import Matrix, Pattern, merge_keys


@dataclass
class Clock:
    """CPU and wall seconds by name."""

    cpu: dict[str, float] = field(default_factory=dict)
    wall: dict[str, float] = field(default_factory=dict)
    calls: dict[str, int] = field(default_factory=dict)

    def run(self, name: str, function: Callable, *args):
        """Call a function and book its time under a name."""
        wall, cpu = time.perf_counter(), time.process_time()
        try:
            return function(*args)
        finally:
            self.wall[name] = self.wall.get(name, 0.0) + time.perf_counter() - wall
            self.cpu[name] = self.cpu.get(name, 0.0) + time.process_time() - cpu
            self.calls[name] = self.calls.get(name, 0) + 1


class System:
    """Residual and tangent of all effects under prescribed motions.

    The first three unknowns of a node are its place; a model of more (`knotfem.rod`) sets `width` and `_pattern`.

    Args:
        effects: in the order in which they are assembled.
        nodes: number of nodes.
        solver: linear solver.
        scheme: time integration scheme.
        prescribed: prescribed motions.
        shift_weights: share of each node in the Levenberg-Marquardt shift, shape [nodes], summing to one.

    Attributes:
        width: unknowns a node.
    """

    width: ClassVar[int] = 3

    def __init__(
        self,
        effects: Sequence[Term],
        nodes: int,
        solver: LinearSolver,
        scheme: Scheme,
        prescribed: Sequence[Prescribed] = (),
        shift_weights: np.ndarray | None = None,
    ) -> None:
        self.effects = list(effects)
        self.nodes = nodes
        self.solver = solver
        self.scheme = scheme
        self.prescribed = list(prescribed)
        self.shift_weights = np.full(nodes, 1.0 / nodes) if shift_weights is None else shift_weights
        self.symmetric = all(effect.symmetric for effect in self.effects)
        self.fixed = np.zeros((nodes, self.width), dtype=bool)
        for motion in self.prescribed:
            self.fixed[motion.nodes, :3] |= np.array(motion.components)
        for effect in self.effects:
            effect.integrate(scheme)
        self.clock = Clock()
        self.analyses = 0
        self.factorisations = 0
        self._keys: np.ndarray | None = None
        self._matrix: Matrix | None = None
        self._analysed: Pattern | None = None
        self._start_residual: np.ndarray | None = None

    def begin(self, start: StepStart) -> None:
        """A step sets out.

        Where the scheme weighs in the residual it sets out with, that is of a step of no length: loads and speeds are
        then those of the accepted state, whatever was tried since.
        """
        if self.scheme.alpha_f > 0.0:
            here = StepStart(start.motion, 0.0)
            for effect in self.effects:
                self.clock.run(effect.name, effect.begin, here)
            self._start_residual = self._static(start.motion.x, None)[0]
        for effect in self.effects:
            self.clock.run(effect.name, effect.begin, start)

    def update(self, x: np.ndarray) -> None:
        """Let the effects follow new positions."""
        for effect in self.effects:
            self.clock.run(effect.name, effect.update, x)

    def drop_pattern(self) -> None:
        """Forget pattern and analysis; they are built anew when next needed."""
        self._matrix = None

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
            assert complete, "an effect's keys do not cover its tangent"
        self._matrix = matrix
        return residual, matrix

    def targets(self, time: float) -> np.ndarray:
        """Prescribed positions at a time, shape [nodes, width]; zero where nothing is prescribed."""
        goal = np.zeros((self.nodes, self.width))
        for motion in self.prescribed:
            place = goal[motion.nodes, :3]
            goal[motion.nodes, :3] = np.where(motion.components, motion.positions(time), place)
        return goal

    def solve(self, matrix: Matrix, shift: float, rhs: np.ndarray) -> np.ndarray:
        """Solve with zero at prescribed unknowns.

        Args:
            matrix: tangent; it is constrained and shifted in place.
            shift: Levenberg-Marquardt shift [N/mm] of the whole, shared by `shift_weights`.
            rhs: shape [nodes, width].

        Returns:
            Shape [nodes, width].
        """
        if shift > 0.0:
            matrix.add_diagonal(np.repeat(shift * self.shift_weights, self.width))
        self.clock.run("constrain", matrix.constrain, self.fixed.ravel())
        self._factorise(matrix)
        return self.resolve(rhs)

    def resolve(self, rhs: np.ndarray) -> np.ndarray:
        """Solve with the last factorisation, zero at prescribed unknowns; shapes as in `solve`."""
        masked = np.where(self.fixed, 0.0, rhs)
        return self.clock.run("solve", self.solver.solve, masked.ravel()).reshape(rhs.shape)

    def _factorise(self, matrix: Matrix) -> None:
        if self._analysed is not matrix.pattern:
            self.clock.run("analysis", self.solver.analyse, matrix.pattern)
            self._analysed = matrix.pattern
            self.analyses += 1
        self.clock.run("factorisation", self.solver.factorise, matrix)
        self.factorisations += 1

    def increment(self, du: np.ndarray) -> None:
        for effect in self.effects:
            self.clock.run(effect.name, effect.increment, du)

    def advance(self, fraction: float) -> None:
        for effect in self.effects:
            self.clock.run(effect.name, effect.advance, fraction)

    def allowed_fraction(self, x: np.ndarray, dx: np.ndarray) -> float:
        """Fraction of a predicted move `dx` from x, shape [nodes, width], that all effects let through."""
        return min((self.clock.run(e.name, e.allowed_fraction, x, dx) for e in self.effects), default=1.0)

    @property
    def admissible(self) -> bool:
        """Whether the state last assembled can be one of equilibrium."""
        return all(effect.admissible for effect in self.effects)

    def merit(self, x: np.ndarray) -> float:
        """Merit of the line search at x, with the effects' own unknowns at their full increment.

        Its slope is the residual, so effects weigh in it as the scheme has them.
        """
        weight, merit = self.scheme.alpha_f, 0.0
        for effect in self.effects:
            part = self.clock.run(effect.name, effect.merit, x)
            merit += part if effect.name == "inertia" else (1.0 - weight) * part
        if self._start_residual is not None:
            merit += weight * float(np.sum(self._start_residual * x))
        return merit

    def commit(self, x: np.ndarray, start: StepStart) -> Motion:
        """Commit the step that ended at x."""
        motion = self.scheme.finish(x, start)
        for effect in self.effects:
            self.clock.run(effect.name, effect.commit, x)
        return motion

    def history(self) -> dict[str, Arrays]:
        """Copies of what the effects remember, by place and name, and the pattern in force."""
        history = {label: effect.history() for label, effect in labelled(self.effects)}
        return {**history, "pattern": {} if self._keys is None else {"keys": self._keys}}

    def load(self, history: dict[str, Arrays]) -> None:
        """Go back to a memory; the pattern, which only ever grows too large, stays."""
        for label, effect in labelled(self.effects):
            effect.load(history[label])

    def restore(self, history: dict[str, Arrays]) -> None:
        """Go on from a memory in a new system, with the pattern of that time and so to the same bits."""
        self.load(history)
        keys = history["pattern"].get("keys")
        self._keys, self._matrix = None, None
        if keys is not None:
            self._matrix = self._fill(keys)

    def effect(self, name: str) -> list[Term]:
        """All effects of a name."""
        return [effect for effect in self.effects if effect.name == name]

    def forces(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """Residual of each effect by itself, by name; effects of one name are summed."""
        result: dict[str, np.ndarray] = {}
        for effect in self.effects:
            part = result.setdefault(effect.name, np.zeros((self.nodes, self.width)))
            self.clock.run(effect.name, effect.assemble, x, part, None)
        return result

    def close(self) -> None:
        self.solver.close()
        self._analysed = None

    def _build(self) -> Matrix:
        diagonal = np.arange(self.nodes, dtype=np.int64) * (self.nodes + 1)
        found = (self.clock.run(effect.name, effect.couplings, self.nodes) for effect in self.effects)
        keys = self.clock.run("pattern", merge_keys, diagonal, *(part for part in found if part is not None))
        return self._fill(keys)

    def _fill(self, keys: np.ndarray) -> Matrix:
        self._keys = keys
        pattern = self.clock.run("pattern", self._pattern, keys)
        for effect in self.effects:
            self.clock.run("pattern", effect.allocate, pattern)
        return Matrix(pattern)

    def _pattern(self, keys: np.ndarray) -> Pattern:
        return Pattern.from_keys(keys, self.nodes, self.symmetric)

    def _static(self, x: np.ndarray, matrix: Matrix | None) -> tuple[np.ndarray, bool]:
        residual, complete = np.zeros((self.nodes, self.width)), True
        for effect in self.effects:
            if effect.name != "inertia":
                complete &= self.clock.run(effect.name, effect.assemble, x, residual, matrix)
        return residual, complete

    def _total(self, x: np.ndarray, matrix: Matrix | None) -> tuple[np.ndarray, bool]:
        residual, complete = self._static(x, matrix)
        weight = self.scheme.alpha_f
        if weight > 0.0:
            assert self._start_residual is not None, "begin before assembling"
            residual = (1.0 - weight) * residual + weight * self._start_residual
            if matrix is not None:
                matrix.data *= 1.0 - weight
        for effect in self.effects:
            if effect.name == "inertia":
                self.clock.run(effect.name, effect.assemble, x, residual, matrix)
        return residual, complete


def labelled(effects: Sequence[Term]) -> list[tuple[str, Term]]:
    """Effects with labels of their own: name and number, or else place among those of the same name."""
    seen: dict[str, int] = {}
    result = []
    for effect in effects:
        seen[effect.name] = seen.get(effect.name, 0) + 1
        result.append((f"{effect.name}-{effect.number or seen[effect.name]}", effect))
    return result
