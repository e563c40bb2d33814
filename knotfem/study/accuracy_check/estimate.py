"""The error of settings, estimated from what finer ones change, and which of them to take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

CHEAPEST = 0.02
"""Least cost of a finer setting that counts, over that of the present ones: times are uncertain by that much."""


@dataclass(frozen=True)
class Change:
    """What the next finer setting of a choice changes.

    Attributes:
        choice: name.
        before: its present value, for people.
        after: its finer one.
        factor: ratio of the finer size to the present one.
        change: relative, of the quantity that runs are compared by; None where it was not measured.
        cpu_s: of the finer run; None likewise.
        cost: CPU seconds of the finer run over those with the present setting; None likewise.
        missing: why it was not measured; "" where it was.
        expected: whether the change is what first order leaves of one at the coarser setting that was given up.
    """

    choice: str
    before: str
    after: str
    factor: float
    change: float | None = None
    cpu_s: float | None = None
    cost: float | None = None
    missing: str = ""
    expected: bool = False

    @property
    def error(self) -> float:
        """Estimated error of the present setting, on its way to the limit by first order; 0 where not measured."""
        return 0.0 if self.change is None else self.change / (1.0 - self.factor)

    @property
    def gain(self) -> float:
        """How much of this error the finer setting removes: what it changes."""
        return self.change or 0.0


def estimated_error(changes: Sequence[Change]) -> float | None:
    """Relative error of the present settings; None where the change of a choice is not known.

    Errors of separate choices add up to first order; they may cancel, which is not counted on.
    """
    if any(change.change is None for change in changes):
        return None
    return sum(change.error for change in changes)


def to_adopt(changes: Sequence[Change], target: float) -> list[Change]:
    """Choices whose finer settings are expected to bring the error within a target, by falling gain for their cost.

    Each is refined once; when all of them are and the target is still not reached, they are measured again.
    """

    def worth(change: Change) -> float:
        return change.gain / max((change.cost or 1.0) - 1.0, CHEAPEST)

    left, adopted = sum(change.error for change in changes), []
    for change in sorted(changes, key=worth, reverse=True):
        if left <= target or change.gain == 0.0:
            break
        adopted.append(change)
        left -= change.gain
    return adopted
