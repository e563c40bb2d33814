"""What a user should know of a run: said once when it happens, kept for the summary."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from knotfem.scene.steps import Pull, Step


class Remarks:
    """Says each thing once.

    Args:
        notify: is told it.

    Attributes:
        kept: for the summary, in their order, by what they are about: `said`, `step`, `time_s`, `displacement_mm`.
    """

    def __init__(self, notify: Callable[[str], None]) -> None:
        self._notify = notify
        self.kept: dict[str, dict[str, Any]] = {}

    def tell(self, about: str, said: str, step: Step, time: float, displacement: float) -> None:
        """Say something, unless something about the same has been said.

        Args:
            about: tells one remark from another.
            said: in words, with {when} for the displacement, or the time in steps that pull nothing.
            step: of the scene.
            time: [s].
            displacement: of the reported end [mm].
        """
        if about in self.kept:
            return
        when = f"{displacement:.4g} mm" if isinstance(step, Pull) else f"{time:.4g} s"
        sentence = f"{step.name}: {said.replace('{when}', when)}"
        self.kept[about] = {"said": sentence, "step": step.name, "time_s": time, "displacement_mm": displacement}
        self._notify(sentence)

    def figures(self) -> list[dict[str, Any]]:
        """For the summary."""
        return list(self.kept.values())
