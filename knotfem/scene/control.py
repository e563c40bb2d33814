"""How a scene is computed: the mapping, the solver, what is written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from knotfem.scene.quantity import PositiveDuration, PositiveForce, PositiveLength
from knotfem.scene.table import Flag, Integer, Number, Table

OLDER_KEYS = {"rung": "level"}
"""Keys of measured settings as scenes and records of older versions name them, which stay readable."""


class Tie(Table):
    """The mapping of the straight rod into the knot.

    Attributes:
        path: "polynomial" adds optimised temporary displacements, "linear" none, "inextensible" turns the tangents on
            great circles, "direct" maps in one increment.
        degree: of the temporary displacements.
        threshold: largest |lambda - 1| to aim at.
        optimise_direction: choose the straight rod's direction too; without, it lies along z.
        increments: of the mapping.
        source: folder of a tied three-dimensional run, from whose knot the rod model sets out instead of the
            centreline's, or none.
        source_state: of that run: its tied knot, or the last state that it has reached.
    """

    path: Literal["polynomial", "linear", "inextensible", "direct"] = "polynomial"
    degree: Annotated[Integer, Field(ge=2, le=20)] = 8
    threshold: Annotated[Number, Field(gt=0.0, lt=1.0)] = 0.3
    optimise_direction: Flag = True
    increments: Annotated[Integer, Field(ge=1, le=10_000)] = 10
    source: str | None = None
    source_state: Literal["tied", "last"] = "tied"


class Solver(Table):
    """Newton's method and its linear systems.

    Attributes:
        linear: "auto" takes PARDISO where it is there and SuperLU elsewhere, and records which.
        force_tolerance: largest out-of-balance nodal force [N].
        move_over_diameter: largest move of a node in a step that is aimed at; limits the time step; with
            hexahedra at most 4/3.
        max_iterations: Newton iterations of one step.
        max_cutbacks: how often in a row a failed step is shortened.
        threads: 0 for as many as there are.
        time_limit: wall time after which the run stops with a checkpoint [s], or none.
    """

    linear: Literal["auto", "pardiso", "superlu"] = "auto"
    force_tolerance: PositiveForce = 1e-5
    move_over_diameter: Annotated[Number, Field(gt=0.0)] = 0.5
    max_iterations: Annotated[Integer, Field(ge=1, le=10_000)] = 15
    max_cutbacks: Annotated[Integer, Field(ge=0, le=1000)] = 12
    threads: Annotated[Integer, Field(ge=0, le=1024)] = 0
    time_limit: PositiveDuration | None = None


class Output(Table):
    """What a run writes and how often.

    Attributes:
        fields: whether to write the time series for ParaView.
        every_displacement: between fields and tension profiles while an end is driven [mm].
        every_time: between them in other steps [s].
        checkpoint_every: wall time between checkpoints [s].
    """

    fields: Flag = True
    every_displacement: PositiveLength = 3.0
    every_time: PositiveDuration = 1.0
    checkpoint_every: PositiveDuration = 60.0


class Accuracy(Table):
    """What the settings of a scene were measured to promise; a record, it changes nothing.

    Attributes:
        wanted: largest relative error that was asked for.
        measured: relative error of these settings plus the reference's own uncertainty.
        quantity: what the error is of, such as "force".
        scene: on which it was measured.
        level: refinement level whose settings these are; older scenes name it "rung".
    """

    older: ClassVar[Mapping[str, str]] = OLDER_KEYS

    wanted: Annotated[Number, Field(gt=0.0)]
    measured: Annotated[Number, Field(ge=0.0)]
    quantity: str
    scene: str
    level: str
