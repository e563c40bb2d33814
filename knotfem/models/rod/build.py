"""From a scene to the plain numbers of the reduced model."""

from __future__ import annotations

from importlib import import_module

import numpy as np

from knotfem.errors import InputError
from knotfem.models.conditions import gravity_of, make_scheme
from knotfem.models.registry import REGISTRY, obstacle_friction, rod_friction
from knotfem.models.rod.initial import LaidRod
from knotfem.models.rod.model import RodModel
from knotfem.models.rod.spec import ContactSpec, CylinderSpec, RodSpec
from knotfem.scene.model import Scene
from knotfem.scene.registered import settings_of
from knotfem.scene.rods import Rod
from knotfem.terms.registry import ON_RODS, REGISTERED


def refuse_foreign(scene: Scene) -> None:
    """Refuse what a scene asks for and the reduced model does not have.

    Raises:
        InputError: an effect that works on hexahedra only.
    """
    for entry in REGISTRY:
        if entry.name in REGISTERED and entry.name not in ON_RODS and not entry.absent(scene):
            raise InputError(
                "the rod model does not have this effect",
                key=f"effects.{entry.name}",
                expected='none, or model = "fem"',
            )


def coarse(scene: Scene) -> list[str]:
    """Warnings of segments longer than the radius, where strands touch and so bend tightly.

    The bowline's force at 33 radii errs by 5 % with segments of one radius, by 12 % with 4/3.
    """
    if not scene.contact.enabled:
        return []
    lengths = [(index, rod.length / rod.slices, 0.5 * rod.diameter) for index, rod in enumerate(scene.rods)]
    return [
        f"rods.{index}.mesh.element_length: segments of {h:.3g} mm are longer than the radius, {r:.3g} mm: "
        "tight bends are not resolved"
        for index, h, r in lengths
        if h > r * (1.0 + 1e-9)
    ]


def core_share(rod: Rod) -> float:
    """Share of the core in the axial stiffness."""
    return rod.core.axial_stiffness / axial_stiffness(rod) if rod.core is not None else 0.0


def axial_stiffness(rod: Rod) -> float:
    """EA of bulk and core [N]."""
    bulk = rod.material.youngs_modulus * np.pi * rod.diameter**2 / 4.0
    return bulk + (rod.core.axial_stiffness if rod.core is not None else 0.0)


def rod_spec(laid: LaidRod) -> RodSpec:
    """Stiffness and mass of a rod: bending and twisting by the bulk, as the truss core of the hexahedra has neither."""
    rod = laid.scene
    fourth = (0.5 * rod.diameter) ** 4
    return RodSpec(
        laid.target.points,
        0.5 * rod.diameter,
        bending=rod.material.youngs_modulus * np.pi * fourth / 4.0,
        twisting=rod.material.shear_modulus * np.pi * fourth / 2.0,
        axial=axial_stiffness(rod),
        mass_per_length=rod.material.density * np.pi * rod.diameter**2 / 4.0,
        spacing=rod.length / rod.slices,
        directors=laid.directors,
        relaxation_time=rod.material.relaxation_time,
    )


def contact_spec(scene: Scene) -> ContactSpec | None:
    """Contact by Hertz's law for the softest rod, or stiffer where the scene says so."""
    c, d = scene.contact, scene.diameter
    if not c.enabled:
        return None
    from knotfem.contact.curve_contact import hertz_line_stiffness

    softest = min((rod.material for rod in scene.rods), key=lambda material: material.youngs_modulus)
    stiffness = c.line_stiffness_over_hertz * hertz_line_stiffness(softest.youngs_modulus, softest.poissons_ratio)
    return ContactSpec(stiffness, rod_friction(scene), c.ramp_over_diameter * d, c.sample_spacing_over_diameter * d)


def make_rods(scene: Scene, laid: list[LaidRod]) -> RodModel:
    """The reduced model of a scene whose rods are laid into the knot.

    Raises:
        InputError: the scene asks for what the model does not have.
    """
    refuse_foreign(scene)
    cylinders = [
        CylinderSpec(np.array(o.point), np.array(o.axis), 0.5 * o.diameter, mu)
        for o, mu in zip(scene.obstacles, obstacle_friction(scene), strict=True)
    ]
    model = RodModel(
        [rod_spec(rod) for rod in laid],
        contact_spec(scene),
        cylinders if scene.contact.enabled else (),
        gravity_of(scene),
        0.0 if scene.drag is None else scene.drag.rate_of(False) or scene.drag.rate_of(True),
        make_scheme(scene),
        scene.solver.linear,
        scene.solver.threads or 1,
    )
    model.effects += [
        import_module(ON_RODS[entry.name]).make(settings_of(scene.effects, entry.name), model.layout)
        for entry in REGISTRY
        if entry.name in ON_RODS and not entry.absent(scene)
    ]
    return model
