"""Coulomb friction between strands: a tangential spring a pair, cut at mu N (Cundall and Strack 1979).

The spring's stiffness is constant, so that no elastic energy comes from a change of the normal force, and what is
dissipated is never negative. See `knotfem.contact.curve_friction_kernels` for what is remembered.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from knotfem.contact import curve_friction_kernels as kernels
from knotfem.contact.curve import sample_points
from knotfem.contact.curve_contact import Contact
from knotfem.models.rod.frames import Frames
from knotfem.solver.term import Arrays, StepStart, Term
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.rod_pattern import matrix_arguments


@dataclass
class Friction(Term):
    """Friction of all pairs of a contact, which must come before it in the list of effects.

    Args:
        contact: whose pairs rub.
        frames: which must come before it too.
        coefficients: mu of each pair of rods, shape [rods, rods].
        spring: tangential line stiffness [N/mm^2].
        factor: multiplies all coefficients, as a function of time [s]; None for 1.

    Attributes:
        stored: elastic slip of each pair along the slave and across it [mm], shape [pairs, 2].
        slip: size of the trial slip [mm], shape [pairs].
        traction: force on the master of each pair [N], shape [pairs, 3].
        dissipated: work of sliding in the last accepted step [N mm].
        kept: elastic energy of the springs after it [N mm].
    """

    contact: Contact
    frames: Frames
    coefficients: np.ndarray
    spring: float
    factor: Callable[[float], float] | None = None

    def __post_init__(self) -> None:
        self.name = "friction"
        self.symmetric = False
        self.dissipated = self.kept = 0.0
        self._generation = -1
        self._now = 1.0
        self.own, self.anchor, self.stored = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 2))
        self.anchor_u = np.zeros(0)
        self._size()

    def begin(self, start: StepStart) -> None:
        self._now = 1.0 if self.factor is None else self.factor(start.end)
        self._size()

    def update(self, x: np.ndarray) -> None:
        c = self.contact
        if self._generation == c.generation:
            return
        count, match = c.u.size, c.match
        known = (match >= 0) if self.anchor_u.size else np.zeros(count, dtype=bool)
        own, anchor, stored, u = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 2)), np.zeros(count)
        for new, old in ((own, self.own), (anchor, self.anchor), (stored, self.stored), (u, self.anchor_u)):
            new[known] = old[match[known]]
        self.own, self.anchor, self.stored, self.anchor_u = own, anchor, stored, u
        self._generation = c.generation
        self._anchor(x, ~known)
        self._size()

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        c, s = self.contact, self.contact.samples
        return kernels.assemble(
            x, self.frames.material_arrays, c.layout.first, s.base, s.weights, s.share, s.length, c.points, c.pairs,
            c.u, c.gap, c.share, c.law.stiffness, c.law.ramp, self.spring, self.mu, self.own, self.anchor_u,
            self.anchor, self.stored, residual, *matrix_arguments(matrix), self.slip, self.traction,
        )  # fmt: skip

    def merit(self, x: np.ndarray) -> float:
        c, s = self.contact, self.contact.samples
        points = np.empty_like(c.points)
        sample_points(x, s.base, s.weights, points)
        return kernels.potential(
            x, self.frames.material_arrays, c.layout.first, s.base, s.weights, s.share, s.length, points, c.pairs,
            c.u, c.share, self.spring, self.mu, c.force, self.own, self.anchor_u, self.anchor, self.stored,
        )  # fmt: skip

    def commit(self, x: np.ndarray) -> None:
        c, s = self.contact, self.contact.samples
        self.dissipated, self.kept = kernels.commit(
            x, self.frames.material_arrays, c.layout.first, s.base, s.weights, s.share, s.length, c.points, c.pairs,
            c.u, c.share, self.spring, self.mu, c.force, self.own, self.anchor_u, self.anchor, self.stored,
        )  # fmt: skip
        self._anchor(x, np.isfinite(c.gap))

    def history(self) -> Arrays:
        return {
            "own": self.own.copy(),
            "anchor_u": self.anchor_u.copy(),
            "anchor": self.anchor.copy(),
            "stored": self.stored.copy(),
            "kept": np.array(self.kept),
        }

    def load(self, history: Arrays) -> None:
        self.own, self.anchor_u = history["own"].copy(), history["anchor_u"].copy()
        self.anchor, self.stored = history["anchor"].copy(), history["stored"].copy()
        self.kept = float(history["kept"])
        self.contact.anchor_u = self.anchor_u
        self._size()
        self._generation = self.contact.generation

    @property
    def slides(self) -> np.ndarray:
        """Whether each pair slides, shape [pairs]."""
        c = self.contact
        stiffness = self.spring * c.samples.length[c.pairs[:, 0]] * c.share
        return (c.force > 0.0) & (stiffness * self.slip > (1.0 - 1e-9) * self.mu * c.force)

    @property
    def sliding(self) -> int:
        """Number of sliding pairs."""
        return int(np.count_nonzero(self.slides))

    def _anchor(self, x: np.ndarray, chosen: np.ndarray) -> None:
        c, s = self.contact, self.contact.samples
        kernels.anchor_pairs(
            x, self.frames.material_arrays, c.layout.first, c.layout.radius, s.rod, s.base, s.weights, s.share,
            c.points, c.pairs, c.u, chosen, self.own, self.anchor_u, self.anchor,
        )  # fmt: skip
        c.anchor_u = self.anchor_u

    def _size(self) -> None:
        c = self.contact
        self.slip, self.traction = np.zeros(c.u.size), np.zeros((c.u.size, 3))
        self.mu = self._now * np.asarray(self.coefficients, dtype=float)[c.samples.rod[c.pairs[:, 0]], c.pairs[:, 1]]
