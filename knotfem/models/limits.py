"""How far a state has come towards the limits within which a model is valid."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Reach:
    """One measure of a state, and its limit.

    Attributes:
        name: for the summary.
        value: of the state.
        limit: up to which the model is valid.
        meaning: of a value beyond it, in words, with the value and the limit.
    """

    name: str
    value: float
    limit: float
    meaning: str

    @property
    def exceeded(self) -> bool:
        """Whether the state is beyond the limit."""
        return self.value > self.limit
