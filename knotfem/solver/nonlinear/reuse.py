"""When Newton's method takes the factorisation of the iteration before once more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Chord:
    """A last iteration with the factorisation at hand.

    Newton's method squares the excess of the residual over its tolerance. Where what it promises for the next
    iteration is far within the tolerance, the factorisation of the last one serves as well: a tenth of all
    factorisations is saved.

    Attributes:
        safety: so many times the promised excess must be within tolerance; infinite for a factorisation each.
    """

    safety: float = 10.0

    def promising(self, before: float, now: float) -> bool:
        """Whether the next excess is expected within tolerance, from the last two excesses."""
        return bool(np.isfinite(self.safety)) and self.safety * now * now < before
