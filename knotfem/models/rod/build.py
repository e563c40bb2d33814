"""From a scene to the plain numbers of discrete rods."""

from __future__ import annotations

from collections.abc import Sequence

from knotfem.models.base import Obstacle
from knotfem.models.conditions import drag_of, gravity_of, numerical_drag_of
from knotfem.models.effects import INERTIA, rod_friction
from knotfem.models.rod.assembly import DiscreteRods
from knotfem.models.rod.initial import InitialRod
from knotfem.models.rod.spec import ContactSpec, RodSpec
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod


def coarse(scene: Scene) -> list[str]:
    """Warnings of equal segments longer than the radius, where strands touch and so bend tightly.

    The bowline's force at 33 radii errs by 5 % with segments of one radius, by 12 % with 4/3.
    """
    if not scene.contact.enabled:
        return []
    equal = [(index, rod) for index, rod in enumerate(scene.rods) if rod.mesh.turning_angle is None]
    lengths = [(index, rod.length / rod.slices, rod.radius) for index, rod in equal]
    return [
        f"rods.{index}.mesh.element_length: segments of {h:.3g} mm are longer than the radius, {r:.3g} mm: "
        "tight bends are not resolved"
        for index, h, r in lengths
        if h > r * (1.0 + 1e-9)
    ]


def rod_spec(rod: Rod, initial: InitialRod) -> RodSpec:
    """Stiffness and mass of a rod: bending and twisting by the bulk, as the truss core of the hexahedra has neither."""
    return RodSpec(
        initial.target.points,
        rod.radius,
        bending=rod.bending_stiffness,
        twisting=rod.twisting_stiffness,
        axial=rod.axial_stiffness,
        mass_per_length=rod.mass_per_length,
        spacing=initial.target.slices.lengths,
        directors=initial.directors,
        relaxation_time=rod.material.relaxation_time,
    )


def contact_spec(scene: Scene) -> ContactSpec | None:
    """Contact, so many times as stiff as the softest rod by Hertz's law."""
    c, d = scene.contact, scene.diameter
    if not c.enabled:
        return None
    from knotfem.contact.curve_pairs import hertz_line_stiffness

    softest = min((rod.material for rod in scene.rods), key=lambda material: material.youngs_modulus)
    stiffness = c.line_stiffness_over_hertz * hertz_line_stiffness(softest.youngs_modulus, softest.poissons_ratio)
    return ContactSpec(
        stiffness,
        rod_friction(scene),
        c.ramp_over_diameter * d,
        c.stick_over_diameter * d,
        c.sample_spacing_over_diameter * d,
        c.onset_over_ramp,
    )


def make_rods(scene: Scene, initial: list[InitialRod], obstacles: Sequence[Obstacle] = ()) -> DiscreteRods:
    """Discrete rods of a scene.

    Args:
        scene: what the user asked for.
        initial: configuration of its rods.
        obstacles: of the scene and of the user's own.

    Raises:
        InputError: obstacles without contact.
    """
    return DiscreteRods(
        [rod_spec(rod, here) for rod, here in zip(scene.rods, initial, strict=True)],
        contact_spec(scene),
        obstacles,
        gravity_of(scene),
        drag_of(scene),
        numerical_drag=numerical_drag_of(scene),
        inertia=INERTIA.wanted(scene),
    )
