"""States of a body: values that are never changed once made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from knotfem.types import Arrays


@dataclass(frozen=True, eq=False)
class Motion:
    """Positions and velocities of all nodes at one time.

    Attributes:
        x: unknowns [mm], shape [nodes, width]; the first three of a node are its place.
        v: velocities [mm/s], shape of x.
        a: accelerations [mm/s^2], shape of x.
        time: [s].
    """

    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    time: float = 0.0

    @classmethod
    def at_rest(cls, x: np.ndarray, time: float = 0.0) -> Self:
        """At x without velocity."""
        return cls(x.copy(), np.zeros_like(x), np.zeros_like(x), time)


@dataclass(frozen=True, eq=False)
class State(Motion):
    """An accepted state: the motion, and the history variables of all terms.

    Attributes:
        history: of each term by its label, see `knotfem.solver.term.Term.history`.
    """

    history: Mapping[str, Arrays] = field(default_factory=dict)

    @classmethod
    def of(cls, motion: Motion, history: Mapping[str, Arrays]) -> State:
        """A motion with history variables."""
        return cls(motion.x, motion.v, motion.a, motion.time, history)


def longest_move(dx: np.ndarray) -> float:
    """Length of the longest move of a node, whichever way it points; of its other unknowns the largest change.

    Args:
        dx: shape [nodes, width], the first three along x, y, z.
    """
    move = float(np.sqrt(np.einsum("ni,ni->n", dx[:, :3], dx[:, :3]).max()))
    return max(move, float(np.abs(dx[:, 3:]).max(initial=0.0)))
