"""What a scene would take, found out without running it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from knotfem.models.base import Model
from knotfem.models.build import build_model
from knotfem.models.described import deforming
from knotfem.run.expected import Expected, expected, may_unravel, refuse_too_large
from knotfem.run.knot_words import in_words
from knotfem.run.monitor import KnotMonitor
from knotfem.run.source import source_rods
from knotfem.scene.load import Overrides, load_scene
from knotfem.scene.model import Scene
from knotfem.scene.steps import Loaded
from knotfem.solver.term import Term
from knotfem.sparse.linear import solver_name

UNUSED = {
    "fem": ("contact.line_stiffness_over_hertz", "tie.source", "tie.source_state"),
    "rod": (
        "contact.stiffness_over_modulus", "rods.mesh.section_elements", "rods.mesh.element",
        "rods.mesh.match_bending_stiffness",
    ),
}  # fmt: skip
"""Keys that tell one model how to compute, and mean nothing to the other."""


def check(source: Scene | str | Path, overrides: Overrides = ()) -> dict[str, Any]:
    """Knots that are to be tied, sizes of curves, effects that will run and those that will not, and what it takes.

    Args:
        source: a scene, as for `load_scene`.
        overrides: likewise.

    Raises:
        InputError: a scene or a source that is wrong, or a centreline along which no rod can lie.
    """
    scene = load_scene(source, overrides)
    refuse_too_large(scene)
    model = build_model(scene, source=source_rods(scene))
    takes = expected(scene, model.dofs)
    knots = KnotMonitor(model).knots_along([target.points for target in model.targets])
    return {
        "knots": in_words(knots),
        "curves": {rod: str(size) for rod, size in model.curves.items()},
        "effects": model.describe(),
        "absent": model.absent,
        "unused_keys": list(UNUSED[scene.model]),
        "dofs": takes.unknowns,
        "hexes": model.hexes,
        "segments": model.segments,
        "slices": model.slices,
        "mapping": f"{_mapped(model)} alone; tying has no contact",
        "system": _symmetry(model.terms, scene),
        "linear_solver": solver_name(scene.solver.linear),
        "expected_memory_mb": round(takes.memory_mb),
        "expected_minutes": _minutes(takes.seconds),
        **_if_it_unravels(scene, takes),
        "warnings": model.warnings,
    }


def _minutes(seconds: float) -> float:
    return float(f"{seconds / 60.0:.2g}")


def _if_it_unravels(scene: Scene, takes: Expected) -> dict[str, float]:
    """The expected time of a knot that unravels, where that is a result of the scene."""
    if not may_unravel(scene):
        return {}
    return {"expected_minutes_if_it_unravels": _minutes(takes.if_it_unravels)}


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
