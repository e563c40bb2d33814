"""A rigid cylinder, touched by rods, with friction of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.contact import curve_cylinder_kernels as kernels
from knotfem.contact.curve import Samples, sample_points
from knotfem.contact.curve_contact import PREDICTED_CLOSING_OVER_RADIUS, SEARCH_GAP_OVER_RADIUS
from knotfem.contact.penalty import Penalty
from knotfem.mesh.rod_layout import RodLayout
from knotfem.models.rod.frames import Frames
from knotfem.solver.term import Arrays, Term
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.rod_pattern import matrix_arguments, stencil_keys


@dataclass
class Cylinder(Term):
    """Normal contact of all rods with a rigid cylinder.

    Only the rod gives way, so that a line stiffness of twice the one between two rods goes with Hertz's law.

    Args:
        layout: of the rods.
        samples: of their centrelines.
        law: penalty law; its stiffness is a line stiffness [N/mm^2].
        origin: a point on the axis [mm], shape [3].
        axis: unit vector, shape [3].
        radius: [mm].

    Attributes:
        gap: of each sample [mm], shape [samples].
        force: normal force of each sample [N], shape [samples].
    """

    layout: RodLayout
    samples: Samples
    law: Penalty
    origin: np.ndarray
    axis: np.ndarray
    radius: float

    def __post_init__(self) -> None:
        self.name = "cylinder"
        count = self.samples.u.size
        self.points = np.zeros((count, 3))
        self.force, self.gap = np.zeros(count), np.full(count, np.inf)
        self.sample_radius = self.layout.radius[self.samples.rod]
        self.reach = SEARCH_GAP_OVER_RADIUS * float(self.layout.radius.min())

    def couplings(self, nodes: int) -> np.ndarray:
        base = np.arange(nodes - 2)[:, None] + np.arange(3)
        return stencil_keys(base[self.layout.rod[base[:, 0]] == self.layout.rod[base[:, 2]]], nodes)

    def update(self, x: np.ndarray) -> None:
        self.gap = self._gaps(x, self.points)

    def allowed_fraction(self, x: np.ndarray, dx: np.ndarray) -> float:
        closing = float((np.maximum(self.gap, 0.0) - self._gaps(x + dx, np.empty_like(self.points))).max())
        limit = PREDICTED_CLOSING_OVER_RADIUS * float(self.layout.radius.min())
        return min(1.0, limit / closing) if closing > limit else 1.0

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        s = self.samples
        return kernels.assemble(
            s.base, s.weights, s.length, self.points, self.origin, self.axis, self.gap, self.law.stiffness,
            self.law.ramp, residual, *matrix_arguments(matrix), self.force,
        )  # fmt: skip

    def merit(self, x: np.ndarray) -> float:
        gap = self._gaps(x, np.empty_like(self.points))
        return kernels.energy(self.samples.length, gap, self.law.stiffness, self.law.ramp)

    def energy(self, x: np.ndarray) -> float:
        return kernels.energy(self.samples.length, self.gap, self.law.stiffness, self.law.ramp)

    @property
    def penetration(self) -> float:
        """Deepest penetration [mm]."""
        return float(max(0.0, -self.gap.min()))

    def _gaps(self, x: np.ndarray, points: np.ndarray) -> np.ndarray:
        gap = np.empty(self.samples.u.size)
        sample_points(x, self.samples.base, self.samples.weights, points)
        kernels.gaps(points, self.sample_radius, self.origin, self.axis, self.radius, gap)
        return gap


@dataclass
class CylinderFriction(Term):
    """Coulomb friction on a cylinder, which must come before it in the list of effects, as must the frames.

    Args:
        cylinder: whose samples rub.
        frames: of the rods.
        coefficients: mu of each rod, shape [rods].
        spring: tangential line stiffness [N/mm^2].

    Attributes:
        stored: elastic slip of each sample along the rod and across it [mm], shape [samples, 2].
        traction: force of each sample on the cylinder [N], shape [samples, 3].
        dissipated, kept: see `knotfem.contact.curve_friction.Friction`.
    """

    cylinder: Cylinder
    frames: Frames
    coefficients: np.ndarray
    spring: float

    def __post_init__(self) -> None:
        self.name = "cylinder friction"
        self.symmetric = False
        self.dissipated = self.kept = 0.0
        count = self.cylinder.samples.u.size
        self.own, self.anchor, self.stored = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 2))
        self.slip, self.traction = np.zeros(count), np.zeros((count, 3))
        self.mu = np.asarray(self.coefficients, dtype=float)[self.cylinder.samples.rod]
        self._anchored = False

    def update(self, x: np.ndarray) -> None:
        if not self._anchored:
            self._anchor(x)
            self._anchored = True

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        c, s = self.cylinder, self.cylinder.samples
        return kernels.assemble_friction(
            x, self.frames.material_arrays, s.base, s.weights, s.share, s.length, c.points, c.origin, c.axis, c.gap,
            c.law.stiffness, c.law.ramp, self.spring, self.mu, self.own, self.anchor, self.stored, residual,
            *matrix_arguments(matrix), self.slip, self.traction,
        )  # fmt: skip

    def merit(self, x: np.ndarray) -> float:
        c, s = self.cylinder, self.cylinder.samples
        points = np.empty_like(c.points)
        sample_points(x, s.base, s.weights, points)
        return kernels.potential(
            x, self.frames.material_arrays, s.base, s.weights, s.share, s.length, points, c.origin, c.axis,
            self.spring, self.mu, c.force, self.own, self.anchor, self.stored,
        )  # fmt: skip

    def commit(self, x: np.ndarray) -> None:
        c, s = self.cylinder, self.cylinder.samples
        self.dissipated, self.kept = kernels.commit(
            x, self.frames.material_arrays, s.base, s.weights, s.share, s.length, c.points, c.origin, c.axis,
            self.spring, self.mu, c.force, self.own, self.anchor, self.stored,
        )  # fmt: skip
        self._anchor(x)

    def history(self) -> Arrays:
        return {
            "own": self.own.copy(),
            "anchor": self.anchor.copy(),
            "stored": self.stored.copy(),
            "anchored": np.array(self._anchored),
            "kept": np.array(self.kept),
        }

    def load(self, history: Arrays) -> None:
        self.own[:], self.anchor[:], self.stored[:] = history["own"], history["anchor"], history["stored"]
        self._anchored, self.kept = bool(history["anchored"]), float(history["kept"])

    @property
    def slides(self) -> np.ndarray:
        """Whether each sample slides, shape [samples]."""
        c = self.cylinder
        limit = (1.0 - 1e-9) * self.mu * c.force
        return (c.force > 0.0) & (self.spring * c.samples.length * self.slip > limit)

    @property
    def sliding(self) -> int:
        """Number of sliding samples."""
        return int(np.count_nonzero(self.slides))

    def _anchor(self, x: np.ndarray) -> None:
        c, s = self.cylinder, self.cylinder.samples
        kernels.anchor_samples(
            x, self.frames.material_arrays, s.base, s.weights, s.share, c.points, c.origin, c.axis, c.radius, c.gap,
            np.inf, self.own, self.anchor,
        )  # fmt: skip
