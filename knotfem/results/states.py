"""Stored states of a run with their fields."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from knotfem.results.fields import StateFields
from knotfem.results.moment import AtMoment, Moment
from knotfem.scene.model import Scene


@dataclass(frozen=True, eq=False)
class RunState(AtMoment):
    """A stored state.

    Attributes:
        scene: of the run.
        moment: when it was.
        read: reads mesh and fields.
    """

    scene: Scene
    moment: Moment
    read: Callable[[], StateFields]

    @property
    def fields(self) -> StateFields:
        """Mesh and fields, read anew each time."""
        return self.read()

    @property
    def points(self) -> np.ndarray:
        """Places [mm], shape [points, 3]."""
        return self.fields.points

    def render(
        self,
        out: str | Path,
        colour: str = "strain",
        *,
        focus: Literal["all", "knot"] = "all",
        zoom: float = 1.0,
        view: Sequence[float] | None = None,
    ) -> None:
        """Draw the rods into a PNG file; see `knotfem.results.pictures.draw`."""
        from knotfem.results.pictures import draw

        draw(self.fields, self.scene, Path(out), colour, focus=focus, zoom=zoom, view=view)

    def show(self, colour: str = "strain") -> object:
        """Show the rods in a window or a notebook; see `knotfem.results.pictures.show`."""
        from knotfem.results.pictures import show

        return show(self.fields, self.scene, colour)
