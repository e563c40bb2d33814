"""Contact of strands of rigid circular section, by penalty along their smooth centrelines.

Each strand is slave and master (two half passes): the samples of one press with a line force [N/mm] on the closest
points of the other. On a crossing at right angles two straight strands with the line stiffness k then meet with the
force 4/3 k sqrt(2 d) delta^1.5; k = E*/2, E* = E/(2 (1 - nu^2)), makes it Hertz's 4/3 E* sqrt(r) delta^1.5. That is
the default: the sections do not deform, but they give way as rubber's do.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from knotfem.contact import curve_contact_kernels as kernels
from knotfem.contact.curve import Samples, sample_points
from knotfem.contact.curve_search import find_pairs, match_pairs
from knotfem.contact.penalty import Penalty
from knotfem.contact.tube_search import all_pairs
from knotfem.mesh.rod_layout import RodLayout
from knotfem.solver.term import Arrays, StepStart, Term, longest_move
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.rod_pattern import matrix_arguments, stencil_keys

SEARCH_GAP_OVER_RADIUS = 0.6
"""Pairs with a gap below this are kept by the broad phase."""
STALE_MOVE_OVER_RADIUS = 0.15
"""The broad phase is repeated when a node has moved so far."""
PREDICTED_CLOSING_OVER_RADIUS = 1.0 / 6.0
"""The predictor may close no pair by more."""
PATTERN_PAD = 1
"""Nodes by which master stencils are padded in the sparsity, to let contact slide without a new analysis."""


def hertz_line_stiffness(youngs_modulus: float, poissons_ratio: float) -> float:
    """Line stiffness [N/mm^2] with which two crossed strands of one material meet by Hertz's law."""
    return 0.25 * youngs_modulus / (1.0 - poissons_ratio**2)


@dataclass
class Contact(Term):
    """Normal contact between all strands.

    Args:
        layout: of the rods.
        samples: where contact is looked for.
        law: penalty law; its stiffness is a line stiffness [N/mm^2].

    Attributes:
        pairs: sample and master rod of each near pair, shape [pairs, 2].
        u: coordinate of the closest point, shape [pairs].
        gap: [mm], shape [pairs].
        share: of the sample's length that a pair carries, settled before it touches, so that contact stores what is
            put into it; shape [pairs].
        force: normal force [N], shape [pairs].
        match: where each pair stood before the last search, or -1, shape [pairs].
        generation: number of searches.
    """

    layout: RodLayout
    samples: Samples
    law: Penalty
    pairs: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64), init=False)
    u: np.ndarray = field(default_factory=lambda: np.zeros(0), init=False)

    def __post_init__(self) -> None:
        self.name = "contact"
        self.generation = 0
        self.gap, self.share, self.force = np.zeros(0), np.zeros(0), np.zeros(0)
        self.match = np.zeros(0, dtype=np.int64)
        smallest = float(self.layout.radius.min())
        self.reach = SEARCH_GAP_OVER_RADIUS * smallest
        self._stale = STALE_MOVE_OVER_RADIUS * smallest
        self._closing = PREDICTED_CLOSING_OVER_RADIUS * smallest
        self._searched = np.zeros((0, 4))
        self.points = np.zeros((self.samples.u.size, 3))
        self.anchor_u: np.ndarray | None = None

    def couplings(self, nodes: int) -> np.ndarray:
        anchors = self.u if self.anchor_u is None else self.anchor_u
        stencils = np.empty((self.pairs.shape[0], 9 + 2 * PATTERN_PAD), dtype=np.int64)
        count = kernels.pattern_stencils(
            self.layout.first, self.samples.base, self.pairs, self.u, self.gap, anchors, self.reach, PATTERN_PAD,
            stencils,
        )  # fmt: skip
        return stencil_keys(np.unique(stencils[:count], axis=0), nodes)

    def update(self, x: np.ndarray) -> None:
        sample_points(x, self.samples.base, self.samples.weights, self.points)
        if self._searched.shape != x.shape or longest_move((x - self._searched)[:, :3]) > self._stale:
            self.search(x)
        self._project(x)

    def search(self, x: np.ndarray) -> None:
        """Find the near pairs anew; shares of known pairs are kept."""
        s, lay = self.samples, self.layout

        def find(pairs: np.ndarray, u: np.ndarray) -> int:
            return find_pairs(x, lay.first, lay.spacing, lay.radius, s.u, s.start, self.points, self.reach, pairs, u)

        found, u = all_pairs(find, s.u.size)
        self.match = match_pairs(self.pairs, self.u, found, u, lay.radius / lay.spacing)
        fresh = self._shares(x, found, u)
        self.share = np.where(self.match >= 0, self.share[self.match], fresh) if self.share.size else fresh
        self.pairs, self.u = found, u
        self.gap, self.force = np.empty(len(found)), np.zeros(len(found))
        self._searched = x.copy()
        self.generation += 1

    def allowed_fraction(self, x: np.ndarray, dx: np.ndarray) -> float:
        if not self.pairs.size:
            return 1.0
        gap = self._gaps(x + dx)
        near = np.isfinite(gap) & np.isfinite(self.gap)
        closing = np.maximum(self.gap[near], 0.0) - gap[near]
        largest = float(closing.max()) if closing.size else 0.0
        return min(1.0, self._closing / largest) if largest > self._closing else 1.0

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        s = self.samples
        return kernels.assemble(
            x, self.layout.first, s.base, s.weights, s.length, self.points, self.pairs, self.u, self.gap, self.share,
            self.law.stiffness, self.law.ramp, residual, *matrix_arguments(matrix), self.force,
        )  # fmt: skip

    def merit(self, x: np.ndarray) -> float:
        return self._stored(self._gaps(x))

    def energy(self, x: np.ndarray) -> float:
        return self._stored(self.gap)

    def begin(self, start: StepStart) -> None:
        apart = self.gap >= 0.5 * self.law.ramp
        self.share[apart] = self._shares(start.motion.x, self.pairs[apart], self.u[apart])

    def history(self) -> Arrays:
        return {
            "pairs": self.pairs.copy(),
            "u": self.u.copy(),
            "gap": self.gap.copy(),
            "share": self.share.copy(),
            "force": self.force.copy(),
            "searched": self._searched.copy(),
        }

    def load(self, history: Arrays) -> None:
        self.pairs, self.u = history["pairs"].copy(), history["u"].copy()
        self.gap, self.share, self.force = history["gap"].copy(), history["share"].copy(), history["force"].copy()
        self._searched = history["searched"].copy()
        self.match = np.arange(self.gap.size)
        self.generation += 1

    @property
    def penetration(self) -> float:
        """Deepest penetration of a rod [mm]; beyond its ends, where contact fades out, there is none of it."""
        last = np.diff(self.layout.first)[self.pairs[:, 1]] - 1.0
        return max(0.0, -float(self.gap[(self.u >= 0.0) & (self.u <= last)].min(initial=0.0)))

    def _project(self, x: np.ndarray) -> None:
        kernels.project_pairs(
            x, self.layout.first, self.layout.radius, self.samples.rod, self.points, self.pairs, self.u, self.gap
        )

    def _gaps(self, x: np.ndarray) -> np.ndarray:
        s = self.samples
        points, u, gap = np.empty_like(self.points), self.u.copy(), np.empty_like(self.gap)
        sample_points(x, s.base, s.weights, points)
        kernels.project_pairs(x, self.layout.first, self.layout.radius, s.rod, points, self.pairs, u, gap)
        return gap

    def _shares(self, x: np.ndarray, pairs: np.ndarray, u: np.ndarray) -> np.ndarray:
        share = np.empty(u.size)
        s = self.samples
        kernels.pair_shares(x, self.layout.first, s.base, s.weights, self.points, pairs, u, share)
        return share

    def _stored(self, gap: np.ndarray) -> float:
        return kernels.energy(self.samples.length, self.pairs, gap, self.share, self.law.stiffness, self.law.ramp)
