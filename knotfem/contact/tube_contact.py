"""Contact of all strands of all rods, by penalty on their smooth surfaces.

Each strand is slave and master (two half passes); samples are fixed material points, so that pressure is an integral
over the reference surface.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from knotfem.contact import tube_contact_kernels as kernels
from knotfem.contact.penalty import Penalty
from knotfem.contact.tube import Samples, Tubes, sample_points
from knotfem.contact.tube_search import all_pairs, find_pairs, match_pairs
from knotfem.solver.term import Arrays, Term, longest_move
from knotfem.sparse.pattern import Matrix

SEARCH_GAP_OVER_RADIUS = 0.3
"""Pairs with a gap below this are kept by the broad phase."""
STALE_MOVE_OVER_RADIUS = 0.117
"""The broad phase is repeated when a node has moved so far (0.35 mm at r = 3 mm)."""
PREDICTED_CLOSING_OVER_RADIUS = 1.0 / 6.0
"""The predictor may close no pair by more (0.5 mm at r = 3 mm)."""
PATTERN_PAD = 1
"""Nodes by which master patches are padded in the sparsity, to let contact slide without a new analysis."""


@dataclass
class Contact(Term):
    """Normal contact between tubes.

    Args:
        tubes: surfaces of all rods.
        samples: where contact is looked for.
        law: penalty law.

    Attributes:
        pairs: sample and master rod of each near pair, shape [pairs, 2].
        uv: closest point of each, shape [pairs, 2].
        gap: [mm], shape [pairs].
        share: factor on the sample's area, fading where the closest point leaves the master's end, shape [pairs].
        force: normal force [N], shape [pairs].
        area: half the reference area of each sample, shape [samples]: the other half is the other strand's pass.
        match: where each pair stood before the last search, or -1, shape [pairs].
        generation: number of searches.
    """

    tubes: Tubes
    samples: Samples
    law: Penalty
    pairs: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64), init=False)
    uv: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)), init=False)

    def __post_init__(self) -> None:
        self.name = "contact"
        self.generation = 0
        self.gap = np.zeros(0)
        self.share = np.zeros(0)
        self.force = np.zeros(0)
        self.match = np.zeros(0, dtype=np.int64)
        self.reach = SEARCH_GAP_OVER_RADIUS * float(self.tubes.radius.min())
        self._stale_move = STALE_MOVE_OVER_RADIUS * float(self.tubes.radius.min())
        self.closing = PREDICTED_CLOSING_OVER_RADIUS * float(self.tubes.radius.min())
        self._searched = np.zeros((0, 3))
        self.points = np.zeros((self.samples.u.size, 3))
        self.area = 0.5 * self.samples.area

    def couplings(self, nodes: int) -> np.ndarray | None:
        s, tubes = self.samples, self.tubes.arrays
        patch = np.zeros((self.pairs.shape[0], 6), dtype=np.int64)
        count = kernels.patches(tubes, self.pairs, self.uv, self.gap, self.reach, s.u, s.v, s.rod, patch)
        patch = np.unique(patch[:count], axis=0)
        wide = 3 + 2 * PATTERN_PAD
        keys = np.empty(patch.shape[0] * (12 + wide * (wide + 1)) ** 2, dtype=np.int64)
        return np.unique(keys[: kernels.patch_keys(tubes, patch, PATTERN_PAD, nodes, keys)])

    def update(self, x: np.ndarray) -> None:
        sample_points(x, self.samples.nodes, self.samples.weights, self.points)
        if self._searched.shape != x.shape or longest_move(x - self._searched) > self._stale_move:
            self.search(x)
        self.project(x)

    def search(self, x: np.ndarray) -> None:
        """Find the near pairs anew; shares of known pairs are kept."""
        s, t = self.samples, self.tubes

        def find(pairs: np.ndarray, uv: np.ndarray) -> int:
            return find_pairs(
                x, t.arrays, t.axis, t.axis_start, t.spacing, t.radius, s.rod, s.u, s.section_start, self.points,
                self.reach, pairs, uv,
            )  # fmt: skip

        found, uv = all_pairs(find, s.u.size, 2)
        count = len(found)
        order = np.lexsort((uv[:, 0], found[:, 1], found[:, 0]))
        found, uv = found[order], uv[order]
        self.match = np.empty(count, dtype=np.int64)
        match_pairs(self.pairs, self.uv, found, uv, s.u.size, t.radius / t.spacing, self.match)
        fresh = _end_share(uv[:, 0], t.sections[found[:, 1]])
        self.share = np.where(self.match >= 0, self.share[self.match], fresh) if self.share.size else fresh
        self.pairs, self.uv = found, uv
        self.gap, self.force = np.empty(count), np.zeros(count)
        self._searched = x.copy()
        self.generation += 1

    def project(self, x: np.ndarray) -> None:
        """Closest points and gaps of the known pairs."""
        kernels.project_pairs(x, self.tubes.arrays, self.points, self.pairs, self.uv, self.gap)

    def allowed_fraction(self, x: np.ndarray, dx: np.ndarray) -> float:
        if not self.pairs.size:
            return 1.0
        points, uv, gap = np.empty_like(self.points), self.uv.copy(), np.empty_like(self.gap)
        sample_points(x + dx, self.samples.nodes, self.samples.weights, points)
        kernels.project_pairs(x + dx, self.tubes.arrays, points, self.pairs, uv, gap)
        near = np.isfinite(gap) & np.isfinite(self.gap)
        closing = np.maximum(self.gap[near], 0.0) - gap[near]
        most = float(closing.max(initial=0.0))
        return min(1.0, self.closing / most) if most > 0.0 else 1.0

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        s, t, none = self.samples, self.tubes, np.zeros(0, dtype=np.int64)
        return kernels.assemble(
            x, t.arrays, s.nodes, s.weights, self.area, self.points, self.pairs, self.uv, self.gap,
            self.share, self.law.stiffness, self.law.ramp, residual, matrix is not None,
            np.zeros(0) if matrix is None else matrix.data,
            none if matrix is None else matrix.pattern.node_ptr,
            none if matrix is None else matrix.pattern.node_adj,
            matrix is not None and matrix.pattern.upper, self.force,
        )  # fmt: skip

    def merit(self, x: np.ndarray) -> float:
        points, uv, gap = np.empty_like(self.points), self.uv.copy(), np.empty_like(self.gap)
        sample_points(x, self.samples.nodes, self.samples.weights, points)
        kernels.project_pairs(x, self.tubes.arrays, points, self.pairs, uv, gap)
        return self._stored(gap)

    def energy(self, x: np.ndarray) -> float:
        return self._stored(self.gap)

    def commit(self, x: np.ndarray) -> None:
        self.share = _end_share(self.uv[:, 0], self.tubes.sections[self.pairs[:, 1]])

    def history(self) -> Arrays:
        return {
            "pairs": self.pairs.copy(),
            "uv": self.uv.copy(),
            "gap": self.gap.copy(),
            "share": self.share.copy(),
            "searched": self._searched.copy(),
        }

    def load(self, history: Arrays) -> None:
        self.pairs, self.uv = history["pairs"].copy(), history["uv"].copy()
        self.gap, self.share = history["gap"].copy(), history["share"].copy()
        self._searched = history["searched"].copy()
        self.force = np.zeros(self.gap.size)
        self.match = np.arange(self.gap.size)
        self.generation += 1

    @property
    def penetration(self) -> float:
        """Deepest penetration of a rod [mm]; beyond its ends, where contact fades out, there is none of it."""
        return max(0.0, -float(self.gap[self.share >= 1.0].min(initial=0.0)))

    def _stored(self, gap: np.ndarray) -> float:
        return kernels.energy(self.area, self.pairs, gap, self.share, self.law.stiffness, self.law.ramp)


def _end_share(u: np.ndarray, sections: np.ndarray) -> np.ndarray:
    """1 on a rod, falling to 0 one slice beyond its ends."""
    return np.clip(1.0 + np.minimum(u, sections - 1.0 - u), 0.0, 1.0)
