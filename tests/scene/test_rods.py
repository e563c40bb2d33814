"""Material constants that follow from what a scene states."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from knotfem.scene.rods import Material
from knotfem.scene.steps import FrictionPoint


@given(modulus=st.floats(min_value=1e-3, max_value=1e3), ratio=st.floats(min_value=0.7, max_value=1e6))
def test_moduli_agree(modulus: float, ratio: float) -> None:
    material = Material.model_validate(
        {"youngs_modulus": f"{modulus!r} MPa", "bulk_over_shear": ratio, "density": "1160 kg/m^3"}
    )
    g, k = material.shear_modulus, material.bulk_modulus
    assert 9 * k * g / (3 * k + g) == pytest.approx(modulus)
    assert k / g == pytest.approx(ratio)
    assert material.poissons_ratio == pytest.approx((3 * k - 2 * g) / (2 * (3 * k + g)), abs=1e-12)


def test_nearly_incompressible_by_default() -> None:
    material = Material.model_validate({"youngs_modulus": "1.5 MPa", "density": "1160 kg/m^3"})
    assert material.poissons_ratio == pytest.approx(0.499, abs=2e-5)


def test_tables_are_frozen() -> None:
    point = FrictionPoint.model_validate({"time": "1 s", "friction": 0.3})
    with pytest.raises(ValueError, match="frozen"):
        point.friction = 0.4  # pyright: ignore[reportAttributeAccessIssue]
