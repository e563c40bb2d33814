"""Effects that come whole in one file: settings, when absent, residual and tangent. One line below registers one.

Such a module holds `Settings`, a frozen dataclass whose fields are made by `quantity` or plain numbers; `absent`, which
says why settings call for nothing ("" where they call for the effect); and `make`. A scene names it under [effects].
It is imported only for a scene that does. How to write one: docs/new-effect.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import numpy as np

    from knotfem.mesh.rod import RodMesh
    from knotfem.solver.term import Term

REGISTERED = {
    "viscous_drag": "knotfem.terms.viscous",
}
"""Module of each effect by its name, which is also its table's."""
ON_RODS = {
    "viscous_drag": "knotfem.terms.rod_viscous",
}
"""Module of its counterpart in the rod model, whose `make` takes settings and layout, where there is one."""
INTERNAL_DAMPING = "internal damping"
"""Of the rod model's materials."""
BOOKED_BY_NAME = (*REGISTERED, INTERNAL_DAMPING)
"""Effects with an energy account of their own."""


class Strand(Protocol):
    """What an effect learns of one rod, in the numbering of the whole model."""

    @property
    def mesh(self) -> RodMesh:
        """The straight rod."""
        ...

    @property
    def section_nodes(self) -> np.ndarray:
        """Shape [sections, nodes a section]."""
        ...

    @property
    def axis_nodes(self) -> np.ndarray:
        """Nodes on the centreline, shape [sections]."""
        ...


class EffectModule(Protocol):
    """What the module of a registered effect offers."""

    Settings: type

    def absent(self, settings: Any) -> str:
        """Why these settings call for nothing; "" where they call for the effect."""
        ...

    def make(self, settings: Any, rods: Sequence[Strand]) -> Term:
        """The effect on all rods."""
        ...


def quantity(
    what: str, unit: str, display: str, example: str, *, minimum: float | None = None, default: float | None = None
) -> Any:
    """A field of `Settings` that is read with a unit.

    Args:
        what: name for messages, with its article.
        unit: of the number inside.
        display: unit that people write.
        example: for messages.
        minimum: smallest allowed number, or none.
        default: None where a scene must give it.
    """
    metadata = {"quantity": (what, unit, display, example, minimum)}
    return field(metadata=metadata) if default is None else field(default=default, metadata=metadata)


def module_of(name: str) -> EffectModule:
    """Import a registered effect."""
    module: Any = import_module(REGISTERED[name])
    return module
