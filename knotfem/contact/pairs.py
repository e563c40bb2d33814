"""Normal contact between all strands of all rods, by penalty on their smooth surfaces.

Each strand is secondary and primary in turn (two half passes). Samples are fixed material points, no further apart than
an eighth of the diameter: with one sample at each node crossing strands would touch at one point, the force would hop
and Newton's method would not settle. The tangent holds the exact curvature terms: without them a tight knot takes 15
iterations a step instead of 5.
"""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.law import Penalty, penalty
from knotfem.contact.samples import Samples, SampleView, sample_points
from knotfem.contact.search import find_pairs, match_pairs
from knotfem.contact.stations import arclengths
from knotfem.contact.surface import PairView, Surface, SurfaceView, Target, add_pair, room_of
from knotfem.solver.state import longest_move
from knotfem.solver.term import Role, Term, TimeStep
from knotfem.sparse.pattern import Matrix, stencil_keys, view_of
from knotfem.sparse.scatter import MatrixView
from knotfem.types import Arrays


@kernel
def _assemble(
    x: np.ndarray, surface: SurfaceView, samples: SampleView, points: np.ndarray, pairs: PairView, residual: np.ndarray,
    matrix: MatrixView,
) -> bool:  # fmt: skip
    """Residual and tangent of all pairs, whose `force` is filled. False where a block lies outside the pattern."""
    room = room_of(surface)
    for k in range(pairs.sample.size):
        _, pressure, slope = penalty(pairs.gap[k], pairs.law)
        carried = samples.measure[pairs.sample[k]] * pairs.weight[k]
        pairs.force[k], pairs.slope[k] = carried * pressure, carried * slope
        if pairs.force[k] == 0.0:
            continue
        if not add_pair(x, surface, samples, points, pairs, k, Target(residual, matrix), room):
            return False
    return True


@kernel
def _energy(samples: SampleView, pairs: PairView) -> float:
    """Energy stored by all pairs."""
    total = 0.0
    for k in range(pairs.sample.size):
        stored = penalty(pairs.gap[k], pairs.law)[0]
        total += samples.measure[pairs.sample[k]] * pairs.weight[k] * stored
    return total


class PairContact(Term):
    """Normal contact of all pairs.

    Args:
        surface: of all rods.
        samples: where contact is looked for.
        law: normal law.

    Attributes:
        pairs: near pairs.
        points: places of the samples [mm], shape [samples, 3].
        match: where each pair stood before the last search, or -1, shape [pairs].
        generation: number of searches.
    """

    name, role = "contact", Role.CONTACT

    def __init__(self, surface: Surface, samples: Samples, law: Penalty) -> None:
        self.surface, self.samples, self.law = surface, samples, law
        smallest, limits = float(surface.stations.radius.min()), surface.limits
        self.reach, self._stale = limits.gap * smallest, limits.stale * smallest
        self._closing = limits.closing * smallest
        self._coupled = min(law.onset + limits.coupled * smallest, self.reach)
        self.points = np.zeros((samples.count, 3))
        self.generation = 0
        self._x = np.zeros((0, surface.width))
        self.load({})

    def describe(self) -> str:
        unit = "MPa/mm" if self.surface.parameters == 2 else "N/mm^2"
        return f"{self.samples.count} samples, penalty {self.law.stiffness:.4g} {unit}"

    @property
    def near(self) -> np.ndarray:
        """Pairs so near that they may touch within a few steps, shape [n]."""
        return np.flatnonzero(self.pairs.gap < self._coupled)

    def couplings(self, nodes: int) -> np.ndarray | None:
        stencils = self.surface.stencils(self.samples, self.pairs, self.near)
        keys = [stencil_keys(stencil, nodes) for stencil in stencils if stencil.size]
        return np.unique(np.concatenate(keys)) if keys else None

    def begin(self, step: TimeStep) -> None:
        """Weights follow the closest points from step to step."""
        self.pairs.weight[:] = self.surface.weights(step.start.x, self.samples, self.points, self.pairs)

    def update(self, x: np.ndarray) -> None:
        sample_points(x, self.samples.view.nodes, self.samples.view.weights, self.points)
        if self._searched.shape != x.shape or longest_move((x - self._searched)[:, :3]) > self._stale:
            self.search(x)
        self._x = x
        self.surface.project(x, self.samples.view, self.points, self.pairs)

    def search(self, x: np.ndarray) -> None:
        """Find the near pairs anew; weights of known pairs are kept.

        A strand may have slid by more than a radius since the last search: known pairs are followed to x first.
        """
        old, samples = self.pairs, self.samples
        self.surface.project(x, samples.view, self.points, old)
        found, at = find_pairs(x, self.surface, samples.view, samples.start, self.points, self.reach)
        self.match = np.empty(len(found), dtype=np.int64)
        stations, before = self.surface.stations, np.stack([old.sample, old.rod], axis=1)
        was, now = arclengths(stations, old.rod, old.at[:, 0]), arclengths(stations, found[:, 1], at[:, 0])
        match_pairs(before, was, found, now, stations.radius, self.match)
        nothing = np.zeros(len(found))
        self.pairs = self._view(
            found[:, 0].copy(), found[:, 1].copy(), at, np.empty(len(found)), nothing.copy(), nothing
        )
        fresh = self.surface.weights(x, samples, self.points, self.pairs)
        kept = old.weight[self.match] if old.weight.size else fresh
        self.pairs.weight[:] = np.where(self.match >= 0, kept, fresh)
        self._searched = x.copy()
        self.generation += 1

    def allowed_fraction(self, x: np.ndarray, dx: np.ndarray) -> float:
        if not self.pairs.sample.size:
            return 1.0
        moved = self._moved(x + dx)
        near = np.isfinite(moved.gap) & np.isfinite(self.pairs.gap)
        closing = np.maximum(self.pairs.gap[near], 0.0) - moved.gap[near]
        most = float(closing.max(initial=0.0))
        return min(1.0, self._closing / most) if most > 0.0 else 1.0

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        view = view_of(matrix, residual.shape[1])
        return _assemble(x, self.surface.view, self.samples.view, self.points, self.pairs, residual, view)

    def merit(self, x: np.ndarray) -> float:
        return _energy(self.samples.view, self._moved(x))

    def energy(self, x: np.ndarray) -> float:
        return _energy(self.samples.view, self.pairs)

    def history(self) -> Arrays:
        named = zip(_HISTORY, self.pairs[:6], strict=True)
        return {**{name: array.copy() for name, array in named}, "searched": self._searched.copy()}

    def load(self, history: Arrays) -> None:
        arrays = (history[name].copy() for name in _HISTORY) if history else self._no_pairs()
        self.pairs = self._view(*arrays)
        self._searched = history["searched"].copy() if history else np.zeros((0, self.surface.width))
        self.match = np.arange(self.pairs.sample.size)
        self.generation += 1

    def coefficients(self, table: np.ndarray) -> np.ndarray:
        """Of each pair, shape [pairs], from those of two rods each, shape [rods, rods]."""
        return table[self.samples.rod[self.pairs.sample], self.pairs.rod]

    @property
    def penetration(self) -> float:
        """Deepest penetration of a rod [mm]; beyond its ends, where contact fades out, there is none of it."""
        u, last = self.pairs.at[:, 0], np.diff(self.surface.stations.first)[self.pairs.rod] - 1.0
        return max(0.0, -float(self.pairs.gap[(u >= 0.0) & (u <= last)].min(initial=0.0)))

    def normals(self, chosen: np.ndarray) -> np.ndarray:
        """Unit vectors from the primary surface to the samples of the chosen pairs, shape [n, 3]."""
        return self.surface.normals(self._x, self.points[self.pairs.sample[chosen]], self.pairs, chosen)

    @property
    def touching(self) -> int:
        """Pairs that carry force."""
        return int(np.count_nonzero(self.pairs.force))

    def _moved(self, x: np.ndarray) -> PairView:
        """The pairs at other positions, from where they are."""
        moved = self.pairs._replace(at=self.pairs.at.copy(), gap=np.empty_like(self.pairs.gap))
        self.surface.project(x, self.samples.view, self.samples.places(x), moved)
        return moved

    def _no_pairs(self) -> tuple[np.ndarray, ...]:
        index, value = np.zeros(0, dtype=np.int64), np.zeros(0)
        return index, index, np.zeros((0, self.surface.parameters)), value, value, value

    def _view(self, *arrays: np.ndarray) -> PairView:
        sample, rod, at, gap, weight, force = arrays
        return PairView(sample, rod, at, gap, weight, force, np.zeros(len(force)), self.law)


_HISTORY = ("sample", "rod", "at", "gap", "weight", "force")
