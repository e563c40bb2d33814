"""What the terms of a scene are, for a reader."""

from __future__ import annotations

from collections.abc import Sequence

from knotfem.models.effects import LOAD
from knotfem.scene.model import Scene
from knotfem.scene.steps import Loaded
from knotfem.solver.term import Role, Term


def described(terms: Sequence[Term], scene: Scene) -> dict[str, str]:
    """What runs, by name, with its figures; terms of one name side by side."""
    said: dict[str, list[str]] = {}
    for term in terms:
        said.setdefault(term.name, []).append(term.describe())
    if loaded := [step.name for step in scene.steps if step.having(Loaded)]:
        said[LOAD.name] = [f"in {', '.join(loaded)}"]
    return {name: "; ".join(texts) for name, texts in said.items()}


def deforming(terms: Sequence[Term]) -> list[str]:
    """Names of the terms that resist deformation of the rods."""
    return list(dict.fromkeys(term.name for term in terms if term.role is Role.ELASTIC))
