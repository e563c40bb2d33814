"""The plain numbers of discrete rods that a scene stands for."""

import numpy as np
import pytest

from knotfem.contact.friction import Friction
from knotfem.models.rod.build import contact_spec, make_rods, rod_spec
from knotfem.models.rod.initial import initial_rods
from knotfem.models.shared_terms import obstacles_of
from knotfem.run.check import check
from knotfem.scene import load_scene

COARSE = ("model=rod", "rods.0.mesh.element_length=10 mm")


def test_stiffness_is_that_of_the_section():
    scene = load_scene("bowline", COARSE)
    (initial,) = initial_rods(scene)
    spec = rod_spec(scene.rods[0], initial)
    area, E = np.pi * 9.0, 1.425
    assert spec.bending == pytest.approx(E * np.pi * 81.0 / 4.0)
    assert spec.twisting == pytest.approx(spec.bending * 2.0 / 3.0, rel=1e-3)
    core = 75.5e3 * np.pi * 0.127**2
    assert spec.axial == pytest.approx(E * area + core)
    assert scene.rods[0].core_axial_stiffness / scene.rods[0].axial_stiffness == pytest.approx(core / spec.axial)
    assert spec.mass_per_length == pytest.approx(1.16e-9 * area)
    np.testing.assert_array_equal(spec.spacing, 10.0)


def test_contact_is_hertzian_or_harder():
    soft, hard = (
        contact_spec(load_scene("bowline", [*COARSE, *more])) for more in (("contact.line_stiffness_over_hertz=1",), ())
    )
    assert soft is not None
    assert hard is not None
    assert soft.stiffness == pytest.approx(1.425 / 3.0, rel=2e-3)
    assert hard.stiffness == pytest.approx(100.0 * soft.stiffness)
    assert (soft.ramp, soft.sample_spacing) == pytest.approx((0.2, 0.75))
    assert contact_spec(load_scene("bowline", [*COARSE, "contact.enabled=false"])) is None


def test_friction_is_that_of_each_pair():
    scene = load_scene("bowline", [*COARSE, 'contact.pairs=[{between=["rod", "cylinder"], friction=0.1}]'])
    rods = make_rods(scene, initial_rods(scene), obstacles_of(scene))
    between, on_cylinder = (term for term in rods.terms if isinstance(term, Friction))
    assert between.coefficients.tolist() == [[0.33]]
    assert on_cylinder.coefficients.tolist() == [0.1]
    assert on_cylinder.external


def test_segments_longer_than_the_radius_are_warned_of_where_strands_touch():
    def said(*overrides: str) -> list[str]:
        return check(load_scene("bowline", ["model=rod", *overrides]))["warnings"]

    assert not said("rods.0.mesh.element_length=3 mm")
    (warning,) = said("rods.0.mesh.element_length=4 mm")
    assert warning.startswith("rods.0.mesh.element_length: segments of 4 mm are longer than the radius, 3 mm")
    assert not said("rods.0.mesh.element_length=4 mm", "contact.enabled=false")
