"""Numbering of the unknowns of a set of discrete rods.

A rod of n segments has n + 1 nodes; several rods are stacked one behind the other. Edge j runs from node j to node
j + 1, so that the last node of a rod has no edge. The unknowns of node j are its place [mm] and, in the fourth column,
the material frame angle of edge j times the radius: a path on the surface [mm], so that one tolerance and one largest
move serve all four. The fourth unknown of a rod's last node means nothing and is held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.slices import Slices


@dataclass(frozen=True, eq=False)
class RodLayout:
    """Nodes of all rods.

    Attributes:
        first: first node of each rod and the number of all nodes, shape [rods + 1].
        spacing: length of the segment ahead of each node when free of stress [mm], 0 at last nodes, shape [nodes].
        arclength: of each node when free of stress [mm], shape [nodes].
        radius: of each rod [mm], shape [rods].
        rod: rod of each node, shape [nodes].
        inner: nodes with an edge on both sides, shape [inner].
        edges: nodes with an edge ahead, shape [edges].
    """

    first: np.ndarray
    spacing: np.ndarray
    arclength: np.ndarray
    radius: np.ndarray
    rod: np.ndarray
    inner: np.ndarray
    edges: np.ndarray

    @property
    def nodes(self) -> int:
        return int(self.first[-1])

    @property
    def rods(self) -> int:
        return self.radius.size

    @property
    def last(self) -> np.ndarray:
        """Last node of each rod, shape [rods]."""
        return self.first[1:] - 1

    @property
    def per_radius(self) -> np.ndarray:
        """1/radius at each node [1/mm], shape [nodes]."""
        return (1.0 / self.radius)[self.rod]

    @property
    def sections(self) -> np.ndarray:
        """Each node is its own cross-section, shape [nodes]."""
        return np.arange(self.nodes)

    def slices(self, rod: int) -> Slices:
        """Segments of a rod."""
        return Slices(self.spacing[self.of(rod)][:-1])

    def of(self, rod: int) -> slice:
        """Nodes of a rod."""
        return slice(int(self.first[rod]), int(self.first[rod + 1]))


def make_layout(segments: list[int], spacing: Sequence[float | np.ndarray], radius: list[float]) -> RodLayout:
    """Number rods of so many segments.

    Args:
        segments: of each rod.
        spacing: length of a segment of each rod [mm], or that of each, shape [segments of the rod].
        radius: of each rod [mm].

    Raises:
        InputError: a rod of fewer than two segments.
    """
    if min(segments) < 2:
        raise InputError("too few segments", key="rod model", found=min(segments), expected="at least 2")
    first = np.concatenate([[0], np.cumsum(np.array(segments) + 1)]).astype(np.int64)
    rod = np.repeat(np.arange(len(segments)), np.diff(first))
    slices = [Slices(np.full(count, length, dtype=float)) for count, length in zip(segments, spacing, strict=True)]
    numbers = np.arange(first[-1])
    starts, ends = np.isin(numbers, first[:-1]), np.isin(numbers, first[1:] - 1)
    return RodLayout(
        first,
        np.concatenate([np.append(rod.lengths, 0.0) for rod in slices]),
        np.concatenate([rod.arclength for rod in slices]),
        np.array(radius, dtype=float),
        rod,
        numbers[~starts & ~ends],
        numbers[~ends],
    )
