"""What a scene would take, found out without running it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from knotfem.models.base import Model
from knotfem.models.build import build_model
from knotfem.models.described import deforming
from knotfem.scene.load import Overrides, load_scene
from knotfem.scene.model import Scene
from knotfem.scene.steps import Loaded, Pull
from knotfem.solver.term import Term
from knotfem.sparse.linear import available

MEMORY_MB = (330.0, 0.021)
"""Memory of a run: in all, and for each unknown; measured on the bowline at 15,000 and 96,000 unknowns."""
UNUSED = {
    "fem": ("contact.line_stiffness_over_hertz", "tie.source", "tie.source_state"),
    "rod": (
        "contact.stiffness_over_modulus", "contact.stick_over_diameter", "rods.mesh.section_elements",
        "rods.mesh.element", "rods.mesh.match_bending_stiffness",
    ),
}  # fmt: skip
"""Keys that tell one model how to compute, and mean nothing to the other."""


@dataclass(frozen=True)
class Cost:
    """What runs of a model were measured to take.

    Attributes:
        factor, power: wall seconds of a Newton iteration, factor times unknowns to the power: measured on the bowline at
            15,000 and 96,000 unknowns on two cores, of discrete rods on one.
        per_mm: Newton iterations for each mm of a pull.
        relaxing: Newton iterations before it.
    """

    factor: float
    power: float
    per_mm: float
    relaxing: float

    def seconds_per_iteration(self, unknowns: int) -> float:
        """Expected wall time of a Newton iteration [s]."""
        return self.factor * unknowns**self.power


COSTS = {"fem": Cost(4.4e-8, 1.5, 11.0, 150.0), "rod": Cost(6.5e-6, 1.0, 6.0, 90.0)}


def expected_minutes(scene: Scene, unknowns: int) -> float:
    """Expected wall time of a run [min]."""
    cost = COSTS[scene.model]
    pulled = sum(step.displacement for step in scene.loading_steps if isinstance(step, Pull))
    iterations = cost.relaxing * bool(scene.tying_steps) + cost.per_mm * pulled
    return iterations * cost.seconds_per_iteration(unknowns) / 60.0


def check(source: Scene | str | Path, overrides: Overrides = ()) -> dict[str, Any]:
    """Effects that will run and those that will not, size, expected memory and time.

    Args:
        source: a scene, as for `load_scene`.
        overrides: likewise.

    Raises:
        InputError: a scene that is wrong, or a centreline along which no rod can lie.
    """
    scene = load_scene(source, overrides)
    model = build_model(scene)
    unknowns = model.dofs
    return {
        "effects": model.describe(),
        "absent": model.absent,
        "keys of the other model": list(UNUSED[scene.model]),
        "dofs": unknowns,
        "hexes": model.hexes,
        "segments": model.segments,
        "mapping": f"{_mapped(model)} alone; tying has no contact",
        "system": _symmetry(model.terms, scene),
        "linear_solver": available()[0] if scene.solver.linear == "auto" else scene.solver.linear,
        "expected_memory_mb": round(MEMORY_MB[0] + MEMORY_MB[1] * unknowns),
        "expected_minutes": float(f"{expected_minutes(scene, unknowns):.2g}"),
        "warnings": model.warnings,
    }


def _mapped(model: Model) -> str:
    return ", ".join(deforming(model.terms)) if model.hexes else "the centrelines"


def _symmetry(terms: list[Term], scene: Scene) -> str:
    """Whether the matrix is symmetric, and what decides; hexahedra's is then stored and factorised as such."""
    culprits = list(dict.fromkeys(term.name for term in terms if not term.symmetric))
    ends = (end for step in scene.steps for end in step.all_ends().values())
    if any(isinstance(end, Loaded) and end.following for end in ends):
        culprits.append("following load, in its steps")
    kind = f"unsymmetric ({', '.join(culprits)})" if culprits else "symmetric"
    return f"{kind}, stored in full" if scene.model == "rod" else kind
