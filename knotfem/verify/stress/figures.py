"""The figures that every hard case has, and their limits."""

from __future__ import annotations

from dataclasses import dataclass

from knotfem.scene import Scene
from knotfem.verify.rehearsal import Rehearsal
from knotfem.verify.verdict import Kind, Quantity

FEW_CUTBACKS, CUTBACKS = 3.0, 0.5
"""So many are always allowed, and this share of the steps."""
SMALLEST_J = 0.05
PENETRATION = 0.10
"""Deepest penetration over the diameter."""
ENERGY = 0.02
"""Largest part of the work that may be missing from the energy account."""


@dataclass(frozen=True)
class Figures:
    """What came of a run.

    Attributes:
        ended: "yes", or the error that ended it.
        steps: accepted.
        cutbacks: failed attempts at a step.
        jacobian: smallest determinant of the deformation gradient.
        penetration: deepest, over the diameter.
        before: knot that was tied.
        after: knot at the end.
        energy_error: largest missing energy over the work of loading; None where nothing was loaded.
    """

    ended: str
    steps: int
    cutbacks: int
    jacobian: float
    penetration: float
    before: str
    after: str
    energy_error: float | None

    @property
    def finished(self) -> bool:
        return self.ended == "yes"

    def quantities(
        self, *, before: str = "", after: str = "", condition: str = "", penetration: float = PENETRATION,
        energy: float = ENERGY,
    ) -> list[Quantity]:  # fmt: skip
        """The figures beside their limits.

        Args:
            before: knot that must have been tied, or "" for whichever it is.
            after: knot that must be left, likewise.
            condition: tells runs of one case apart.
            penetration: largest share of the diameter.
            energy: largest part of the work that may be missing.
        """
        figures: list[tuple[str, float | str | None, float | str, Kind]] = [
            ("finished", self.ended, "yes", "equal"),
            ("cutbacks", float(self.cutbacks), max(FEW_CUTBACKS, CUTBACKS * self.steps), "at most"),
            ("smallest J", self.jacobian, SMALLEST_J, "at least"),
            ("penetration / d", self.penetration, penetration, "at most"),
            ("knot before", self.before, before or self.before, "equal"),
            ("knot after", self.after, after or self.after, "equal"),
            ("energy error", self.energy_error, energy, "at most"),
        ]
        return [
            Quantity(name, found, limit, kind=kind, condition=condition)
            for name, found, limit, kind in figures
            if found is not None
        ]


def figures_of(rehearsal: Rehearsal) -> Figures:
    """The figures of a scene that was taken to its end in memory."""
    return Figures(
        "yes",
        rehearsal.steps,
        rehearsal.cutbacks,
        rehearsal.jacobian,
        rehearsal.penetration / rehearsal.model.diameter,
        rehearsal.before,
        rehearsal.knots(),
        rehearsal.missing / rehearsal.turned_over if rehearsal.turned_over > 0.0 else None,
    )


def mesh_of(scene: Scene) -> str:
    """What the table of verdicts says of the mesh."""
    mesh = scene.rods[0].mesh
    return f"{mesh.section_elements} hexes a section, h = {mesh.element_length:g} mm"
