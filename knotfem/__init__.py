"""Knots in elastic rods: tied by a centreline mapping, pulled with frictional self-contact, read out as tension.

    import knotfem as kf

    scene = kf.load_scene("bowline", {"contact.friction": 0.37, "model": "rod"})
    run = kf.pull(scene)
    run.force.plot()

Nothing heavy is imported before it is used.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from knotfem.version import __version__

if TYPE_CHECKING:
    from knotfem import theory
    from knotfem.api import pull, resume, steps, tie
    from knotfem.contact.rigid import Foot, RigidSurface
    from knotfem.errors import (
        InputError,
        Interrupted,
        KnotfemError,
        KnotLost,
        MissingDependency,
        NotConverged,
        Stopped,
    )
    from knotfem.models.base import Obstacle
    from knotfem.models.material import Material
    from knotfem.results.compare import Comparison, compare
    from knotfem.results.data import open_run
    from knotfem.results.export import export
    from knotfem.results.plot import plot
    from knotfem.results.run import Run
    from knotfem.run.check import check
    from knotfem.run.events import TimeStepDone
    from knotfem.scene.load import load_scene
    from knotfem.scene.model import Scene
    from knotfem.solver.term import Role, Term, TimeStep
    from knotfem.study.accuracy_check.report import CheckedAccuracy
    from knotfem.study.accuracy_check.run import check_accuracy
    from knotfem.study.holding import hold
    from knotfem.study.stability.diagram import StabilityDiagram
    from knotfem.study.stability.run import stability
    from knotfem.study.sweep.run import sweep
    from knotfem.study.sweep.table import StudyTable

_PLACES = {
    "pull": "knotfem.api",
    "resume": "knotfem.api",
    "steps": "knotfem.api",
    "tie": "knotfem.api",
    "Foot": "knotfem.contact.rigid",
    "RigidSurface": "knotfem.contact.rigid",
    "InputError": "knotfem.errors",
    "Interrupted": "knotfem.errors",
    "KnotLost": "knotfem.errors",
    "KnotfemError": "knotfem.errors",
    "MissingDependency": "knotfem.errors",
    "NotConverged": "knotfem.errors",
    "Stopped": "knotfem.errors",
    "Material": "knotfem.models.material",
    "Obstacle": "knotfem.models.base",
    "Comparison": "knotfem.results.compare",
    "compare": "knotfem.results.compare",
    "open_run": "knotfem.results.data",
    "export": "knotfem.results.export",
    "plot": "knotfem.results.plot",
    "Run": "knotfem.results.run",
    "check": "knotfem.run.check",
    "TimeStepDone": "knotfem.run.events",
    "Scene": "knotfem.scene.model",
    "load_scene": "knotfem.scene.load",
    "Role": "knotfem.solver.term",
    "Term": "knotfem.solver.term",
    "TimeStep": "knotfem.solver.term",
    "CheckedAccuracy": "knotfem.study.accuracy_check.report",
    "check_accuracy": "knotfem.study.accuracy_check.run",
    "StudyTable": "knotfem.study.sweep.table",
    "StabilityDiagram": "knotfem.study.stability.diagram",
    "hold": "knotfem.study.holding",
    "stability": "knotfem.study.stability.run",
    "sweep": "knotfem.study.sweep.run",
}
_MODULES = {"theory": "knotfem.theory"}

__all__ = [
    "CheckedAccuracy", "Comparison", "Foot", "InputError", "Interrupted", "KnotLost", "KnotfemError", "Material",
    "MissingDependency", "NotConverged", "Obstacle", "RigidSurface", "Role", "Run", "Scene", "StabilityDiagram",
    "Stopped", "StudyTable", "Term", "TimeStep", "TimeStepDone", "__version__", "check", "check_accuracy", "compare",
    "export", "hold", "load_scene", "open_run", "plot", "pull", "resume", "stability", "steps", "sweep", "theory",
    "tie",
]  # fmt: skip


class _Package(ModuleType):
    """Keeps the verbs `plot`, `stability` and `tie` what they are when the subpackages of these names are imported."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _PLACES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(import_module(_PLACES[name]), name)
    if name in _MODULES:
        return import_module(_MODULES[name])
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
