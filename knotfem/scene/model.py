"""The scene: everything that a run needs to know, validated."""

from __future__ import annotations

from collections.abc import Sized
from itertools import combinations_with_replacement
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, ValidationInfo, field_validator, model_validator

from knotfem.errors import ROPE, InputError
from knotfem.scene.control import Accuracy, Output, Solver, Tie
from knotfem.scene.effects import Contact, Cylinder, Drag, Effects, Gravity, Inertia, QuasiStatic
from knotfem.scene.rods import Rod
from knotfem.scene.rope import Scaled, read_rope, tables_for
from knotfem.scene.steps import Pull, Relax, RodEnds, Step
from knotfem.scene.table import Name, Table, input_errors, known_name, one_error, refusal

LARGEST_MOVE = 4.0 / 3.0
"""Of `solver.move_over_diameter` with hexahedra: with it the force of a pulled overhand errs by 2 %, with 2 by 8 %."""

LARGEST_TOLERANCE = 1e-3
"""Of `solver.force_tolerance`, in units of B/r^2; resultants may err ten times as much, a third of a loose knot's."""

LEAST_TOLERANCE = 1e-15
"""Likewise; the axial stiffness of a round rod is 4 B/r^2, and forces have rounding errors of 1e-16 of that."""

MOST_STEPS = 10_000
"""Of a scene, which is read within seconds."""

MOST_OUTPUTS = 1e6
"""Of a step."""


class Scene(Table):
    """What the user asked for; lengths in mm, forces in N, stresses in MPa, times in s, masses in tonne.

    Attributes:
        name: also of the run directory.
        description: one line.
        model: "fem" for hexahedra, "rod" for the reduced model.
        rods: at least one.
        obstacles: rigid bodies.
        contact: between rods and with obstacles.
        gravity: weight, or none.
        drag: viscous drag in real time, or none.
        effects: further ones.
        inertia: time integration in real time.
        quasi_static: what equilibrium means in all other steps.
        tie: mapping of the straight rods into the knot.
        solver: Newton's method.
        output: what is written.
        rope: how the scene was made for another rope, where it was.
        accuracy: what mesh and solver settings were measured to promise, where they come from a cost table.
        steps: after the mapping, in order; an end that a step does not mention is clamped.
    """

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_.-]+$")]
    description: str = ""
    model: Literal["fem", "rod"] = "fem"
    rods: Annotated[tuple[Rod, ...], Field(min_length=1)]
    obstacles: tuple[Cylinder, ...] = ()
    contact: Contact = Contact()
    gravity: Gravity | None = None
    drag: Drag | None = None
    effects: Effects = Effects()
    inertia: Inertia = Inertia()
    quasi_static: QuasiStatic = QuasiStatic()
    tie: Tie = Tie()
    solver: Solver = Solver()
    output: Output = Output()
    rope: Scaled | None = None
    accuracy: Accuracy | None = None
    steps: tuple[Step, ...] = ()

    @property
    def force_scale(self) -> float:
        """B/r^2 of the softest rod [N]."""
        return min(rod.bulk_axial_stiffness / 4.0 for rod in self.rods)

    @property
    def diameter(self) -> float:
        """Of the thinnest rod, by which lengths are measured [mm]."""
        return min(rod.diameter for rod in self.rods)

    @property
    def youngs_modulus(self) -> float:
        """Of the softest rod, by which stresses are measured [MPa]."""
        return min(rod.material.youngs_modulus for rod in self.rods)

    @property
    def tying_steps(self) -> tuple[Relax, ...]:
        """The relaxing steps at the head in which no end is loaded: with the mapping, what tying means."""
        found: list[Relax] = []
        for step in self.steps:
            if not isinstance(step, Relax) or step.loading:
                break
            found.append(step)
        return tuple(found)

    @property
    def loading_steps(self) -> tuple[Step, ...]:
        """The steps after tying."""
        return self.steps[len(self.tying_steps) :]

    @property
    def sliding(self) -> float:
        """How far rods may slide along themselves: the displacement of all pulls [mm]."""
        return sum(step.displacement for step in self.steps if isinstance(step, Pull))

    def with_rope(self, **rope: Any) -> Scene:
        """The same scene for another rope, which is similar to it where nothing has weight.

        All lengths, displacements and speeds are multiplied by the ratio of the diameters, moduli by that of the
        moduli, forces and their tolerance by the ratio of E d^2; coefficients between rods, those of schedules too, by
        that of friction. Gravity, densities, fluids and times stay. The attribute `rope` of the result says it.

        Args:
            **rope: `diameter` and `youngs_modulus` with units, such as "10 mm" and "5 MPa", `friction` of rope on rope,
                `obstacle_friction` of rope on obstacles; at least one of them.

        Raises:
            InputError: a property that no rope has, or a scene that such a rope makes impossible.
        """
        wanted = read_rope(rope)
        if self.tie.source is not None and (wanted.diameter, wanted.youngs_modulus) != (None, None):
            raise InputError("sets out from a run of another rope", key="tie.source", expected="a scene without it")
        tables = tables_for(wanted, self)
        try:
            return type(self).model_validate(tables)
        except ValidationError as error:
            raise one_error(input_errors(error, tables, file=ROPE)) from None

    def friction_between(self, first: str, second: str) -> float:
        """Coulomb coefficient of two surfaces.

        Args:
            first: name of a rod or an obstacle.
            second: likewise; twice the same rod asks for its self-contact.
        """
        for pair in self.contact.pairs:
            if set(pair.between) == {first, second}:
                return pair.friction
        named = {obstacle.name: obstacle.friction for obstacle in self.obstacles}
        return named.get(first, named.get(second, self.contact.friction))

    @field_validator("rods", "obstacles")
    @classmethod
    def _check_names(cls, items: tuple[Rod, ...] | tuple[Cylinder, ...]) -> tuple[Rod, ...] | tuple[Cylinder, ...]:
        names: list[Name] = []
        for index, item in enumerate(items):
            if item.name in names:
                raise refusal("used twice", at=f"{index}.name", found=f'"{item.name}"', expected="a name of its own")
            names.append(item.name)
        return items

    @field_validator("rods")
    @classmethod
    def _check_frames(cls, rods: tuple[Rod, ...]) -> tuple[Rod, ...]:
        scales = {rod.name: rod.scale for rod in rods}
        for index, rod in enumerate(rods):
            if isinstance(rod.scale, str):
                known_name(rod.scale, list(scales), "rod", at=f"{index}.scale")
                if rod.scale == rod.name or isinstance(scales[rod.scale], str):
                    found, expected = f'"{rod.scale}"', "a rod that is scaled by a number or to its length"
                    raise refusal(
                        "this rod takes its scale from another", at=f"{index}.scale", found=found, expected=expected
                    )
        return rods

    @field_validator("steps", mode="before")
    @classmethod
    def _count_steps(cls, steps: Any) -> Any:
        if isinstance(steps, Sized) and len(steps) > MOST_STEPS:
            raise refusal("too many", found=f"{len(steps):,} steps", expected=f"at most {MOST_STEPS:,}, longer ones")
        return steps

    @field_validator("steps")
    @classmethod
    def _complete_steps(cls, steps: tuple[Step, ...], info: ValidationInfo) -> tuple[Step, ...]:
        """Name the steps, mention every rod, replace protocols by their stages."""
        if "rods" not in info.data:
            return steps
        rods = [rod.name for rod in info.data["rods"]]
        complete: list[Step] = []
        taken = {step.name for step in steps if step.name}
        names: set[str] = set()
        counts: dict[str, int] = {}
        for index, step in enumerate(steps):
            for rod in step.ends:
                known_name(rod, rods, "rod", at=f"{index}.ends.{rod}")
            name = step.name or _free_name(step.kind, taken, counts)
            if name in names:
                raise refusal("used twice", at=f"{index}.name", found=f'"{name}"', expected="a name of its own")
            ends = {rod: step.ends.get(rod, RodEnds()) for rod in rods}
            stages = step.stages(name) if isinstance(step, Relax) else (step.model_copy(update={"name": name}),)
            for stage in stages[1:]:
                if stage.name in taken:
                    raise refusal("used twice", at=f"{index}.name", found=f'"{stage.name}"', expected="another name")
            names |= {stage.name for stage in stages}
            taken |= {stage.name for stage in stages}
            complete += [stage.model_copy(update={"ends": ends}) for stage in stages]
        return tuple(complete)

    @model_validator(mode="after")
    def _check_source(self) -> Self:
        if self.tie.source is not None and self.model != "rod":
            raise refusal(
                "only the rod model sets out from another run",
                at="tie.source",
                found=f'"{self.tie.source}"',
                expected='none, or model = "rod"',
            )
        if self.tie.source is None and self.tie.source_state != "tied":
            found = f'"{self.tie.source_state}"'
            raise refusal("there is no source", at="tie.source_state", found=found, expected="tie.source with it")
        return self

    @model_validator(mode="after")
    def _check_damping(self) -> Self:
        for index, rod in enumerate(self.rods):
            if self.model == "fem" and rod.material.relaxation_time > 0.0:
                raise refusal(
                    "only the rod model has internal damping",
                    at=f"rods.{index}.material.relaxation_time",
                    found=f"{rod.material.relaxation_time:g} s",
                    expected='none, or model = "rod"',
                )
        return self

    @model_validator(mode="after")
    def _check_moves(self) -> Self:
        move = self.solver.move_over_diameter
        if self.model == "fem" and move > LARGEST_MOVE:
            expected = f"at most {LARGEST_MOVE:.4g}"
            raise refusal("steps too long", at="solver.move_over_diameter", found=f"{move:g}", expected=expected)
        return self

    @model_validator(mode="after")
    def _check_tolerance(self) -> Self:
        if self.solver.force_tolerance > LARGEST_TOLERANCE * self.force_scale:
            raise refusal(
                "as large as the force of a knot",
                at="solver.force_tolerance",
                found=f"{self.solver.force_tolerance:g} N",
                expected=f"at most {LARGEST_TOLERANCE * self.force_scale:.2g} N, a thousandth of B/r^2",
            )
        if self.solver.force_tolerance < LEAST_TOLERANCE * self.force_scale:
            raise refusal(
                "as small as rounding errors",
                at="solver.force_tolerance",
                found=f"{self.solver.force_tolerance:g} N",
                expected=f"at least {LEAST_TOLERANCE * self.force_scale:.2g} N, 1e-15 of B/r^2",
            )
        return self

    @model_validator(mode="after")
    def _check_outputs(self) -> Self:
        every = {"every_displacement": self.output.every_displacement, "every_time": self.output.every_time}
        for step in self.steps:
            if isinstance(step, Relax):
                continue
            pulls = isinstance(step, Pull)
            key, length = ("every_displacement", step.displacement) if pulls else ("every_time", step.duration)
            if length / every[key] > MOST_OUTPUTS:
                unit, what = ("mm", "displacement") if pulls else ("s", "duration")
                expected = f"at least {length / MOST_OUTPUTS:.3g} {unit}, since {step.name} has a {what} of "
                expected += f"{length:g} {unit}"
                found = f"{every[key]:g} {unit}"
                raise refusal("too many outputs", at=f"output.{key}", found=found, expected=expected)
        return self

    @model_validator(mode="after")
    def _check_schedules(self) -> Self:
        rods = [rod.name for rod in self.rods]
        coefficients = [self.friction_between(*pair) for pair in combinations_with_replacement(rods, 2)]
        if not self.contact.enabled:
            found = "contact.enabled = false"
        elif self.contact.friction == 0.0:
            found = "contact.friction = 0"
        else:
            found = "" if max(coefficients) > 0.0 else "no friction between rods"
        for index, step in enumerate(self.steps):
            if step.friction_schedule and found:
                at = f"steps.{index}.friction_schedule"
                expected = "contact with contact.friction above 0, which the schedule scales"
                raise refusal("a schedule without friction", at=at, found=found, expected=expected)
        return self

    @model_validator(mode="after")
    def _check_pairs(self) -> Self:
        rods, obstacles = [rod.name for rod in self.rods], [obstacle.name for obstacle in self.obstacles]
        for obstacle in obstacles:
            if obstacle in rods:
                raise refusal("a rod and an obstacle share a name", at="obstacles", found=f'"{obstacle}"')
        seen: list[set[str]] = []
        for index, pair in enumerate(self.contact.pairs):
            at = f"contact.pairs.{index}.between"
            if set(pair.between) in seen:
                raise refusal("used twice", at=at, found=", ".join(pair.between), expected="a pair of its own")
            seen.append(set(pair.between))
            for name in pair.between:
                known_name(name, rods + obstacles, "rod or obstacle", at=at)
            if set(pair.between) <= set(obstacles):
                raise refusal("obstacles do not touch each other", at=at, expected="at least one rod")
        return self


def _free_name(kind: str, taken: set[str], counts: dict[str, int]) -> str:
    """A name that no step has; `counts` of kinds that have been named so far goes on."""
    for count in range(counts.get(kind, 0) + 1, len(taken) + 2):
        name = kind if count == 1 else f"{kind}-{count}"
        if name not in taken:
            counts[kind] = count
            return name
    raise AssertionError("there are more names than steps")
