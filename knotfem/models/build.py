"""The model that a scene names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from knotfem.models.base import Additions, Model
from knotfem.scene.model import Scene

if TYPE_CHECKING:
    from knotfem.models.rod.initial import SourceRod


def build_model(scene: Scene, additions: Additions | None = None, source: Sequence[SourceRod] | None = None) -> Model:
    """The model of a scene; that of the other kind is not imported.

    Args:
        scene: what the user asked for.
        additions: of the user's own.
        source: rods as another run has left them, from which discrete rods set out.

    Raises:
        InputError: a centreline or a section that cannot be, or a feature that the model does not have.
    """
    if scene.model == "rod":
        from knotfem.models.rod.model import RodModel

        return RodModel(scene, additions, source)
    from knotfem.models.solid.model import SolidModel

    return SolidModel(scene, additions)
