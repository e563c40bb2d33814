"""Energies of a run."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Energies:
    """Energy balance since the start of the last relaxing or the first loading step [N mm].

    Attributes:
        work: of supports, clamps and loads so far.
        friction: that sliding has taken so far.
        taken: that each resistance (drag, internal damping, ...) has taken so far, by name.
        algorithmic: that the time integration has taken so far.
        elastic: stored in the rods now.
        contact: stored in contacts now.
        fields: stored in each field of force (gravity, ...) now, by name.
        kinetic: now.
        initial: stored at the start.
        throughput: work put in and out so far, each by its size.
    """

    work: float = 0.0
    friction: float = 0.0
    taken: dict[str, float] = field(default_factory=dict)
    algorithmic: float = 0.0
    elastic: float = 0.0
    contact: float = 0.0
    fields: dict[str, float] = field(default_factory=dict)
    kinetic: float = 0.0
    initial: float = 0.0
    throughput: float = 0.0

    @property
    def stored(self) -> float:
        """Stored now."""
        return self.elastic + self.contact + self.kinetic + sum(self.fields.values())

    @property
    def dissipated(self) -> float:
        """Taken so far."""
        return self.friction + self.algorithmic + sum(self.taken.values())

    @property
    def error(self) -> float:
        """Work put in that is neither stored nor dissipated."""
        return self.work - (self.stored - self.initial) - self.dissipated
