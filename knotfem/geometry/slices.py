"""Lengths of the slices that a rod is divided into, and where they lie along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.types import Array


@dataclass(frozen=True, eq=False)
class Slices:
    """Slices of a rod free of stress, one behind the other.

    Attributes:
        lengths: [mm], shape [slices].
    """

    lengths: Array

    @property
    def count(self) -> int:
        """How many there are."""
        return self.lengths.size

    @property
    def equal(self) -> bool:
        """Whether all are of one length; they are then counted, so that rounding does not add up."""
        return bool((self.lengths == self.lengths[0]).all())

    @property
    def arclength(self) -> Array:
        """Of the cross-sections between them and at the ends [mm], shape [slices + 1]."""
        if self.equal:
            return np.arange(self.count + 1) * self.lengths[0]
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def fractions(self) -> Array:
        """Arclength over the length of the rod, shape [slices + 1]."""
        if self.equal:
            return np.arange(self.count + 1) / self.count
        return self.arclength / self.arclength[-1]

    @property
    def middles(self) -> Array:
        """Arclength of their middles over the length of the rod, shape [slices]."""
        if self.equal:
            return (np.arange(self.count) + 0.5) / self.count
        return 0.5 * (self.fractions[1:] + self.fractions[:-1])

    def at_sections(self, values: Array) -> Array:
        """Values in the middles of slices taken linearly to the cross-sections; an end takes that of its one slice.

        Args:
            values: shape [slices, ...].

        Returns:
            Shape [slices + 1, ...].
        """
        share = self.lengths[:-1] / (self.lengths[:-1] + self.lengths[1:])
        share = share.reshape(-1, *(1 for _ in values.shape[1:]))
        inner = (1.0 - share) * values[:-1] + share * values[1:]
        return np.concatenate([values[:1], inner, values[-1:]])


def equal_slices(length: float, count: int) -> Slices:
    """A number of slices of one length.

    Args:
        length: of the rod [mm].
        count: of slices.
    """
    return Slices(np.full(count, length / count))
