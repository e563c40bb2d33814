"""Steps of a scene: what happens to the ends of the rods, one step after the other."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, ClassVar, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from knotfem.scene.quantity import Duration, Force, PositiveDuration, PositiveLength, PositiveSpeed
from knotfem.scene.table import Direction, Flag, Friction, Name, Number, Table, refusal


class Clamped(Table):
    """The end is held where it is: place and orientation."""

    motion: Literal["clamped"] = "clamped"


class Pinned(Table):
    """The end's place is held, it may turn."""

    motion: Literal["pinned"]


class Free(Table):
    """Nothing acts on the end."""

    motion: Literal["free"]


class Driven(Table):
    """The end keeps its orientation and moves by the step's displacement.

    Attributes:
        motion: always "driven".
        direction: of any length.
    """

    motion: Literal["driven"]
    direction: Direction


class Loaded(Table):
    """A force acts on the end, which may move and turn.

    Attributes:
        motion: always "loaded".
        force: its size [N].
        direction: of any length, as it is at the start of the step.
        following: whether the force then turns with the end.
    """

    motion: Literal["loaded"]
    force: Force
    direction: Direction
    following: Flag = False


class Turned(Table):
    """The end's place is held and its section turned about the rod's tangent there.

    Attributes:
        motion: always "turned".
        turns: full turns during the step, right-handed about the tangent in the direction of the arclength.
    """

    motion: Literal["turned"]
    turns: Number


AnyEnd = Clamped | Pinned | Free | Driven | Loaded | Turned
End = Annotated[AnyEnd, Field(discriminator="motion")]


class RodEnds(Table):
    """What happens to the two ends of one rod; an end that is not mentioned is clamped.

    Attributes:
        start: the loading end, arclength 0.
        end: the other one.
    """

    start: End = Clamped()
    end: End = Clamped()


class FrictionPoint(Table):
    """A point of a friction schedule.

    Attributes:
        time: since the start of the step [s].
        friction: Coulomb coefficient of rod on rod.
    """

    time: Duration
    friction: Friction


def _rising(schedule: tuple[FrictionPoint, ...]) -> tuple[FrictionPoint, ...]:
    for before, after in pairwise(schedule):
        if after.time <= before.time:
            raise refusal(
                "times that do not rise", found=f"{after.time:g} s after {before.time:g} s", expected="rising times"
            )
    return schedule


class _Step(Table):
    """What all steps share.

    Attributes:
        name: for tables and progress; the kind by default.
        ends: for every rod.
        friction_schedule: what `contact.friction` becomes against time, linear between its points, the coefficients of
            pairs of rods in proportion; empty leaves it as it is.
        must_hold: whether a knot that unravels ends the run with an error.
        rate: "quasi-static" lets loads advance only as fast as the rods follow in equilibrium, and follows a jump as
            overdamped motion under loads that stand still; times and speeds then only say how far loads are. "real"
            takes speeds and times, inertia and drag as the scene gives them.
        until: "end" takes the step to its end whatever the knot does. "decided" ends the run as soon as the knot is no
            longer what it was: it unravels, and nothing that follows changes that.
        driven: whether the kind drives ends.
        turning: whether it turns them.
        limit: its key that says how long it lasts at most.
    """

    driven: ClassVar[bool] = False
    turning: ClassVar[bool] = False
    limit: ClassVar[str] = "duration"

    name: Name = ""
    ends: dict[Name, RodEnds] = Field(default_factory=dict)
    friction_schedule: Annotated[tuple[FrictionPoint, ...], AfterValidator(_rising)] = ()
    must_hold: Flag = True
    rate: Literal["quasi-static", "real"] = "quasi-static"
    until: Literal["end", "decided"] = "end"

    @property
    def real(self) -> bool:
        """Whether it goes in real time."""
        return self.rate == "real"

    def all_ends(self) -> dict[tuple[str, str], AnyEnd]:
        """Every end by rod and side, the side being "start" or "end"."""
        return {(rod, side): getattr(ends, side) for rod, ends in self.ends.items() for side in ("start", "end")}

    def having(self, kind: type[AnyEnd]) -> list[tuple[str, str]]:
        """Rod and side of the ends that move in one way."""
        return [place for place, end in self.all_ends().items() if isinstance(end, kind)]

    @property
    def loading(self) -> bool:
        """Whether it is more than coming to rest as tied."""
        return True

    @model_validator(mode="after")
    def _check_schedule(self) -> Self:
        longest = getattr(self, self.limit)
        if self.friction_schedule and self.friction_schedule[-1].time > longest * (1.0 + 1e-12):
            raise refusal(
                "outlasts the step",
                at="friction_schedule",
                found=f"{self.friction_schedule[-1].time:g} s",
                expected=f"at most {longest:g} s",
            )
        return self

    @model_validator(mode="after")
    def _check_driven(self) -> Self:
        places = self.having(Driven)
        if places and not self.driven:
            raise refusal("only a pull drives an end", at=f"ends.{'.'.join(places[0])}", expected='kind = "pull"')
        if self.driven and not places:
            raise refusal(
                "no end is driven", at="ends", expected='an end with motion = "driven" (for a force: kind = "load")'
            )
        places = self.having(Turned)
        if places and not self.turning:
            raise refusal("only a turn turns an end", at=f"ends.{'.'.join(places[0])}", expected='kind = "turn"')
        if self.turning and not places:
            raise refusal("no end is turned", at="ends", expected='an end with motion = "turned"')
        return self


class Relax(_Step):
    """Goes to rest, however long it takes, a friction schedule to its end; forces act in full at once.

    Attributes:
        kind: always "relax".
        protocol: how friction comes to lie where it does. "overdamped": the rods move to rest as an overdamped body,
            with friction. "free-twist": then the centrelines are frozen and friction is off until the sections have
            turned to where they twist the rods least; then friction is on and the rods come to rest again. A scene that
            is read has three steps in its place.
        frozen: whether the centrelines stay where they are and nothing rubs, so that only sections turn.
        kinetic_over_elastic: in real time, at rest once the kinetic energy is below this fraction of the elastic one.
        longest: in real time, after which a rod that does not come to rest is given up [s].
    """

    limit: ClassVar[str] = "longest"

    kind: Literal["relax"]
    protocol: Literal["overdamped", "free-twist"] = "overdamped"
    frozen: Flag = False
    kinetic_over_elastic: Annotated[Number, Field(gt=0.0)] = 1e-6
    longest: PositiveDuration = 100.0

    @property
    def loading(self) -> bool:
        """Whether an end is loaded meanwhile."""
        return bool(self.having(Loaded))

    @property
    def way(self) -> str:
        """How it comes to rest."""
        if self.frozen:
            return "sections turn, centrelines frozen, without friction"
        return "in real time" if self.real else "overdamped, with friction"

    def stages(self, name: str) -> tuple[Relax, ...]:
        """The steps that its protocol consists of.

        Args:
            name: of the first of them.
        """
        if self.protocol == "overdamped":
            return (self.model_copy(update={"name": name}),)
        plain = self.model_copy(update={"protocol": "overdamped"})
        later = plain.model_copy(update={"friction_schedule": ()})
        return (
            plain.model_copy(update={"name": name}),
            later.model_copy(update={"name": f"{name}-twist", "frozen": True}),
            later.model_copy(update={"name": f"{name}-again"}),
        )


class Pull(_Step):
    """Moves every driven end by the same displacement.

    Tables report force and displacement of the first of them: rods in the scene's order, start before end.

    Attributes:
        kind: always "pull".
        displacement: in the end's direction [mm].
        slip: ends the step once a free end has been drawn in by so much [mm], into what holds it; None takes it to its
            displacement.
        speed: of the driven ends [mm/s]; needed in real time. Quasi-static, it relates the displacement to the time of
            tables and schedules and changes nothing else; None for 1 mm/s.
    """

    driven: ClassVar[bool] = True

    kind: Literal["pull"]
    displacement: PositiveLength
    slip: PositiveLength | None = None
    speed: PositiveSpeed | None = None

    @property
    def nominal_speed(self) -> float:
        """Displacement over time [mm/s]."""
        return 1.0 if self.speed is None else self.speed

    @property
    def duration(self) -> float:
        """How long the step takes [s]."""
        return self.displacement / self.nominal_speed

    @model_validator(mode="after")
    def _check_speed(self) -> Self:
        if self.real and self.speed is None:
            raise refusal("missing key", at="speed", expected='a speed such as "4 mm/s", or rate = "quasi-static"')
        return self


class Turn(_Step):
    """Turns ends about the rod's tangent there, which twists the rod.

    Attributes:
        kind: always "turn".
        duration: of the step [s].
    """

    turning: ClassVar[bool] = True

    kind: Literal["turn"]
    duration: PositiveDuration


class Load(_Step):
    """Brings the forces of loaded ends from what they were to what they are to be, linearly in time.

    Attributes:
        kind: always "load".
        duration: of the step [s].
        slip: ends the step once a free end has been drawn in by so much [mm], into what holds it; None takes it to its
            end.
    """

    kind: Literal["load"]
    duration: PositiveDuration
    slip: PositiveLength | None = None

    @model_validator(mode="after")
    def _check_loaded(self) -> Self:
        if not self.having(Loaded):
            raise refusal("no end is loaded", at="ends", expected='an end with motion = "loaded"')
        return self


class Hold(_Step):
    """Waits; forces act in full from the start.

    Attributes:
        kind: always "hold".
        duration: of the step [s].
    """

    kind: Literal["hold"]
    duration: PositiveDuration


class Release(_Step):
    """Lets ends go, until the rod rests or the knot is lost; forces act in full from the start.

    Attributes:
        kind: always "release".
        duration: in real time, at most [s].
        kinetic_over_elastic: in real time, at rest once the kinetic energy is below this fraction of the elastic one.
        must_hold: by default an unravelled knot is a result, no error.
        until: by default the run ends once the knot has unravelled.
    """

    kind: Literal["release"]
    duration: PositiveDuration
    kinetic_over_elastic: Annotated[Number, Field(gt=0.0)] = 1e-6
    must_hold: Flag = False
    until: Literal["end", "decided"] = "decided"


Step = Annotated[Relax | Pull | Turn | Load | Hold | Release, Field(discriminator="kind")]
