"""The model that a scene names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from knotfem.errors import InputError
from knotfem.models.base import Additions, Model
from knotfem.models.centreline import pushed_inwards
from knotfem.models.plausible import unusual
from knotfem.names import suggestion
from knotfem.scene.model import Scene

if TYPE_CHECKING:
    from knotfem.models.rod.initial import SourceRod


def build_model(scene: Scene, additions: Additions | None = None, source: Sequence[SourceRod] = ()) -> Model:
    """The model of a scene; that of the other kind is not imported.

    Args:
        scene: what the user asked for.
        additions: of the user's own.
        source: rods as another run has left them, from which discrete rods set out, or none.

    Raises:
        InputError: a centreline or a section that cannot be, or additions that the scene or its model cannot take.
    """
    if additions is not None:
        _check_additions(scene, additions)
    if scene.model == "rod":
        from knotfem.models.rod.model import RodModel

        model: Model = RodModel(scene, additions, source)
    else:
        from knotfem.models.solid.model import SolidModel

        model = SolidModel(scene, additions)
    model.warnings = [*unusual(scene), *pushed_inwards(scene, model.targets), *model.warnings]
    return model


def _check_additions(scene: Scene, additions: Additions) -> None:
    rods = [rod.name for rod in scene.rods]
    taken = [*rods, *(obstacle.name for obstacle in scene.obstacles)]
    for obstacle in additions.obstacles:
        if obstacle.name in taken:
            raise InputError("used twice", key="obstacles", found=obstacle.name, expected="a name of its own")
        taken.append(obstacle.name)
    if additions.materials and scene.model == "rod":
        problem = "discrete rods have no bulk"
        raise InputError(problem, key="materials", found=", ".join(additions.materials), expected='model = "fem"')
    for name in additions.materials:
        if name not in rods:
            raise InputError("no rod has this name", key="materials", found=name, expected=suggestion(name, rods))
