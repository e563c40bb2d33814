"""Rods of a scene: curve, material, core, mesh."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from knotfem import shipped
from knotfem.scene.elements import ORDERS
from knotfem.scene.quantity import Angle, Duration, PositiveDensity, PositiveLength, PositivePressure
from knotfem.scene.stiffness import axial_stiffness, bending_stiffness, mass_per_length, twisting_stiffness
from knotfem.scene.table import Direction, Flag, Integer, Name, Number, Point, Table, known_name, refusal

CURVE_SUFFIXES = (".csv", ".tsv", ".txt", ".xyz", ".dat", ".obj", ".vect", ".json", ".toml")
MOST_SLICES = 10**6
"""Of a rod: more than any machine holds."""


class Smoothing(Table):
    """Laplacian smoothing of the centreline, as in the paper's appendix; no iterations leave the curve as it is.

    Attributes:
        gamma: weight of the neighbours' mean in one iteration, between 0 and 1.
        iterations: how often.
        keep_size: whether each iteration is followed by one that takes the shrinkage of loops back (after Taubin), as
            measured points want it.
    """

    gamma: Annotated[Number, Field(gt=0.0, lt=1.0)] = 0.1
    iterations: Annotated[Integer, Field(ge=0, le=100_000)] = 0
    keep_size: Flag | None = None


class Rotation(Table):
    """A turn about an axis through the origin.

    Attributes:
        axis: its direction, of any length.
        angle: right-handed [rad].
    """

    axis: Direction = (0.0, 0.0, 1.0)
    angle: Angle = 0.0


class Material(Table):
    """The nearly incompressible neo-Hookean solid.

    Attributes:
        model: its law.
        youngs_modulus: E at small strain [MPa].
        bulk_over_shear: bulk over shear modulus; 500 is a Poisson's ratio of 0.499.
        density: mass over volume [tonne/mm^3].
        relaxation_time: of internal damping after Kelvin and Voigt, E (e + tau de/dt) [s]; 0 for none. Rod model only.
    """

    model: Literal["neo-hooke"] = "neo-hooke"
    youngs_modulus: PositivePressure
    bulk_over_shear: Annotated[Number, Field(gt=2.0 / 3.0)] = 500.0
    density: PositiveDensity
    relaxation_time: Duration = 0.0

    @property
    def shear_modulus(self) -> float:
        """G [MPa], from E = 9 k G / (3 k + 1) with k = K / G."""
        return self.youngs_modulus * (3.0 * self.bulk_over_shear + 1.0) / (9.0 * self.bulk_over_shear)

    @property
    def bulk_modulus(self) -> float:
        """K [MPa]."""
        return self.bulk_over_shear * self.shear_modulus

    @property
    def poissons_ratio(self) -> float:
        """Poisson's ratio at small strain."""
        return self.youngs_modulus / (2.0 * self.shear_modulus) - 1.0


class Core(Table):
    """A wire on the axis that carries axial force only.

    Attributes:
        youngs_modulus: of the wire [MPa].
        radius: of the wire [mm].
    """

    youngs_modulus: PositivePressure
    radius: PositiveLength

    @property
    def axial_stiffness(self) -> float:
        """EA [N]."""
        return axial_stiffness(self.youngs_modulus, self.radius)


def _known_element(name: str) -> str:
    known_name(name, list(ORDERS), "element", at="")
    return name


def _known_section(path: str) -> str:
    if not Path(path).exists():
        raise refusal("no such file", expected="a mesh of the cross-section: .msh, .vtk, .vtu, .inp")
    return path


class RodMesh(Table):
    """Hexahedra of a rod.

    Attributes:
        section: file with a mesh of the cross-section, scaled to the rod's radius; instead of `section_elements`.
        section_elements: quadrilaterals of the cross-section, or the nearest number with which a disc can be meshed.
        element_length: of a hexahedron along the rod [mm], rounded so that they divide the rod; with a `turning_angle`
            the longest.
        turning_angle: by which the tied centreline turns in a slice at the most [rad]; None for slices of one length.
            The curvature is the largest of the tied centreline within two diameters and the displacement of all pulls.
        element: formulation.
        match_bending_stiffness: scale the facetted section so that its bending stiffness is the circle's.
    """

    section: Annotated[str, AfterValidator(_known_section)] | None = None
    section_elements: Annotated[Integer, Field(ge=4, le=10_000)] = 12
    element_length: PositiveLength
    turning_angle: Annotated[Number, Field(gt=0.0)] | None = None
    element: Annotated[str, AfterValidator(_known_element)] = "hex8-reduced"
    match_bending_stiffness: Flag = True

    @model_validator(mode="before")
    @classmethod
    def _check_section(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and data.get("section") is not None and "section_elements" in data:
            raise refusal(
                "two cross-sections", at="section_elements", expected="either a section or a number of section_elements"
            )
        return data

    @model_serializer(mode="wrap")
    def _without_the_other(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        tables = write(self)
        if self.section is not None:
            del tables["section_elements"]
        return tables


def is_curve_file(curve: str) -> bool:
    """Whether a centreline is given by a file, not by a shipped name."""
    path = Path(curve)
    return bool(path.suffix) or path.name != curve


def _known_curve(curve: str) -> str:
    if not is_curve_file(curve):
        known_name(curve, shipped.centreline_names(), "shipped centreline", at="")
    elif not Path(curve).exists():
        raise refusal("no such file", expected="a file of points or of a NURBS curve, or a shipped name")
    elif Path(curve).suffix.lower() not in CURVE_SUFFIXES:
        raise refusal("unknown kind of centreline file", expected=f"one of {', '.join(CURVE_SUFFIXES)}")
    return curve


class Rod(Table):
    """One rod.

    Attributes:
        name: for ends, pairs, tables.
        centerline: a shipped name, or a file of points or of a NURBS curve; scaled about the origin to the rod's length
            where there is no `scale` and no unit in the header of the file. Scenes may spell the key `centreline`.
        curve: number of the curve in a file of several, from 1.
        cut_at: number of the point at which a closed curve is cut open, from 1.
        scale: factor by which the coordinates of the curve are multiplied [mm per unit of the file], or the name of
            another rod, drawn in the same frame, whose factor is taken; None for the unit in the header of the file,
            such as x_mm, which a factor must not contradict. In its own size, the ends of the curve are made straight
            and longer, or cut, so that it is as long as the rod.
        length: of the rod, free of stress [mm].
        diameter: of its circular cross-section [mm].
        rotation: of the scaled curve, before `origin`.
        origin: where the curve's own origin goes [mm].
        smoothing: of the curve.
        twist: angle by which the section at the rod's end is turned about the tangent there when the knot is tied,
            right-handed in the direction of the arclength; spread evenly along the rod, and held by clamped ends.
            Without it, a tied rod is free of twist.
        material: of the bulk.
        core: wire on the axis, or none.
        mesh: hexahedra.
    """

    name: Name = "rod"
    centerline: Annotated[str, AfterValidator(_known_curve)]
    curve: Annotated[Integer, Field(ge=1)] | None = None
    cut_at: Annotated[Integer, Field(ge=1)] | None = None
    scale: Annotated[Number, Field(gt=0.0)] | Name | None = None
    length: PositiveLength
    diameter: PositiveLength
    origin: Point = (0.0, 0.0, 0.0)
    rotation: Rotation = Rotation()
    smoothing: Smoothing = Smoothing()
    twist: Angle = 0.0
    material: Material
    core: Core | None = None
    mesh: RodMesh

    @property
    def slices(self) -> int:
        """Intervals between cross-sections if all are of one length; quadratic hexahedra span two."""
        return ORDERS[self.mesh.element] * round(self.length / self.mesh.element_length)

    @property
    def curve_file(self) -> Path:
        """File of the centreline."""
        given = Path(self.centerline)
        return given if is_curve_file(self.centerline) else shipped.centreline_path(self.centerline)

    @property
    def radius(self) -> float:
        """Half the diameter [mm]."""
        return 0.5 * self.diameter

    @property
    def bending_stiffness(self) -> float:
        """B [N mm^2] of the bulk; the core has none."""
        return bending_stiffness(self.material.youngs_modulus, self.radius)

    @property
    def twisting_stiffness(self) -> float:
        """C [N mm^2] of the bulk; the core has none."""
        return twisting_stiffness(self.material.shear_modulus, self.radius)

    @property
    def bulk_axial_stiffness(self) -> float:
        """EA of the bulk [N]."""
        return axial_stiffness(self.material.youngs_modulus, self.radius)

    @property
    def core_axial_stiffness(self) -> float:
        """EA of the core [N]; 0 without one."""
        return 0.0 if self.core is None else self.core.axial_stiffness

    @property
    def axial_stiffness(self) -> float:
        """EA of bulk and core [N]."""
        return self.bulk_axial_stiffness + self.core_axial_stiffness

    @property
    def mass_per_length(self) -> float:
        """Of the bulk [tonne/mm]."""
        return mass_per_length(self.material.density, self.radius)

    @model_validator(mode="after")
    def _check_proportions(self) -> Self:
        if self.length <= self.diameter:
            raise refusal(
                "shorter than it is thick", at="length", found=f"{self.length:g} mm", expected="more than the diameter"
            )
        if self.slices < 2:
            raise refusal(
                "too long for the rod",
                at="mesh.element_length",
                found=f"{self.mesh.element_length:g} mm",
                expected=f"at most half of the rod's {self.length:g} mm",
            )
        if self.slices > MOST_SLICES:
            raise refusal(
                "too many slices",
                at="mesh.element_length",
                found=f"{self.mesh.element_length:g} mm",
                expected=f"at least {self.length / MOST_SLICES:.3g} mm",
            )
        if self.core is not None and 2.0 * self.core.radius >= self.diameter:
            raise refusal(
                "the core is as thick as the rod",
                at="core.radius",
                found=f"{self.core.radius:g} mm",
                expected=f"less than {self.diameter / 2.0:g} mm",
            )
        return self
