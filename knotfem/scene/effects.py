"""What acts on the rods of a scene: obstacles, contact, gravity, drag, inertia."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from knotfem.scene.quantity import Acceleration, PositiveLength, Rate, Resistance
from knotfem.scene.table import Direction, Flag, Friction, Name, Number, Point, Table

Positive = Annotated[Number, Field(gt=0.0)]


class Cylinder(Table):
    """A rigid circular cylinder without ends.

    Attributes:
        name: for pairs.
        kind: always "cylinder".
        diameter: of the cylinder [mm].
        point: any point of its axis [mm].
        axis: direction, of any length.
        friction: Coulomb coefficient against every rod, unless a pair says otherwise.
    """

    name: Name = "cylinder"
    kind: Literal["cylinder"] = "cylinder"
    diameter: PositiveLength
    point: Point = (0.0, 0.0, 0.0)
    axis: Direction
    friction: Friction


class Pair(Table):
    """Friction of one pair of surfaces.

    Attributes:
        between: two names, of rods or of a rod and an obstacle; twice the same rod is its self-contact.
        friction: Coulomb coefficient.
    """

    between: tuple[Name, Name]
    friction: Friction


class Contact(Table):
    """Contact between rods, of a rod with itself and with obstacles.

    The constants of the penalty are given in units of the rod, so that a scaled rod behaves alike.

    Attributes:
        enabled: whether surfaces touch at all.
        friction: Coulomb coefficient of rod on rod.
        pairs: pairs that differ from it.
        stiffness_over_modulus: penalty stiffness [MPa/mm] in units of E/d; 48 is 8 E per mm at d = 6 mm.
        ramp_over_diameter: overlap over which the pressure rises smoothly.
        onset_over_ramp: gap at which contact begins, over the ramp. At 0.25 surfaces in a tight knot meet at no gap on
            the average; at 0.5 the paper's bowline is 1 % thicker, and its force 4 % larger.
        stick_over_diameter: tangential displacement at which friction is fully mobilised.
        sample_spacing_over_diameter: largest distance between the points of a surface that are looked at.
        line_stiffness_over_hertz: of the rod model, whose sections are all but rigid; 1 gives way as two crossed
            strands of the material do by Hertz's law.
    """

    enabled: Flag = True
    friction: Friction = 0.33
    pairs: tuple[Pair, ...] = ()
    stiffness_over_modulus: Positive = 48.0
    ramp_over_diameter: Positive = 1.0 / 30.0
    onset_over_ramp: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.25
    stick_over_diameter: Positive = 0.005
    sample_spacing_over_diameter: Annotated[Number, Field(ge=0.01, le=1.0)] = 0.125
    line_stiffness_over_hertz: Positive = 100.0


class Gravity(Table):
    """Weight.

    Attributes:
        acceleration: of free fall [mm/s^2].
        direction: of any length.
    """

    acceleration: Acceleration
    direction: Direction = (0.0, 0.0, -1.0)


class Drag(Table):
    """Viscous drag on the mass in steps that go in real time.

    Quasi-static steps take numerical drag instead, whose size follows from what it may carry.

    Attributes:
        rate: drag force over momentum [1/s].
        relaxing: the same in relax steps, where only the rest is asked for; None for the same rate.
    """

    rate: Rate
    relaxing: Rate | None = None

    def rate_of(self, relaxing: bool) -> float:
        """Rate of a step [1/s]."""
        return self.relaxing if relaxing and self.relaxing is not None else self.rate


class QuasiStatic(Table):
    """Steps in which loads advance only as fast as the rods follow in equilibrium.

    Attributes:
        tolerance: largest fraction of the load that drag may carry in a state of equilibrium; the balance itself
            limits it from below, see `solver.force_tolerance`.
        settling_move_over_diameter: largest move of a node that a step aims at where loads stand still and the rods
            settle.
        settling_slip_over_diameter: likewise, longest slip of contacts. Where friction leaves a loose knot depends on
            the path there, which smaller steps follow closer; motion without slip leaves no trace.
    """

    tolerance: Annotated[Number, Field(gt=0.0, le=0.1)] = 0.0001
    settling_move_over_diameter: Annotated[Number, Field(gt=0.0, le=2.0)] = 0.5
    settling_slip_over_diameter: Annotated[Number, Field(gt=0.0, le=2.0)] = 0.02


class Inertia(Table):
    """Time integration of steps that go in real time.

    Attributes:
        scheme: "quasi-static" has no inertia; "backward-euler" takes the energy of fast motions, "hht" and
            "generalised-alpha" keep that of slow ones.
        relaxing: that of relax steps, where only the rest is asked for and a scheme that keeps energy rings on; where
            `scheme` is "quasi-static" they have no inertia either.
        hht_alpha: numerical damping of "hht", 0 for none.
        spectral_radius: at infinite frequency, of "generalised-alpha", 1 for no damping.
    """

    scheme: Literal["quasi-static", "backward-euler", "hht", "generalised-alpha"] = "hht"
    relaxing: Literal["backward-euler", "hht", "generalised-alpha"] = "backward-euler"
    hht_alpha: Annotated[Number, Field(ge=-0.5, le=0.0)] = -0.05
    spectral_radius: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.8

    def scheme_of(self, relaxing: bool) -> str:
        """Scheme of a step."""
        return self.relaxing if relaxing and self.scheme != "quasi-static" else self.scheme


class ViscousDrag(Table):
    """Drag of a fluid at rest on the centreline, force per length over velocity (Gray and Hancock 1955).

    Attributes:
        normal: across the centreline; for slender rods about twice the other [MPa s = N s/mm^2].
        tangential: along it [MPa s].
    """

    normal: Resistance
    tangential: Resistance


class Effects(Table):
    """Further effects.

    Attributes:
        viscous_drag: of a fluid, or none.
    """

    viscous_drag: ViscousDrag | None = None
