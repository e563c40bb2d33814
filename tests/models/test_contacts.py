"""What contacts.csv says of contacts that nothing holds: they slip, in either model."""

import numpy as np
import pytest

from knotfem.models.build import build_model
from knotfem.models.contacts import contact_rows
from knotfem.scene import load_scene

COARSE = (
    "rods.0.mesh.section_elements=4",
    "rods.1.mesh.section_elements=4",
    "rods.0.mesh.element_length=4 mm",
    "rods.1.mesh.element_length=4 mm",
    'rods.1.origin=["0 mm", "0 mm", "5.7 mm"]',
    "tie.path=direct",
    "steps=[]",
)
SUNK = 0.2
"""Rods are moved down by this, into what they would else only touch [mm]."""


def pressed(*overrides: str) -> list[dict]:
    """Rows of two rods that are pushed into each other."""
    scene = load_scene("crossed-rods", [*COARSE, *overrides])
    model = build_model(scene)
    x = model.straight().x
    if scene.model == "fem":
        *_, last = model.mapping(model.paths(), "superlu")
        x = last.state.x
    x = x.copy()
    x[:, 2] -= SUNK
    for term in model.terms:
        term.update(x)
    for term in model.terms:
        assert term.assemble(x, np.zeros_like(x), None)
    return list(contact_rows(model, model.contacts(), 0.0, 0.0))


@pytest.mark.parametrize("model", ["fem", "rod"])
@pytest.mark.parametrize("friction", ["contact.friction=0.0", 'contact.pairs=[{between=["lower","upper"],friction=0}]'])
def test_contacts_without_friction_slip(model, friction):
    rows = pressed(f"model={model}", friction)
    assert rows
    assert {row["state"] for row in rows} == {"slips"}
    assert {row["friction_force_N"] for row in rows} == {0.0}


@pytest.mark.parametrize("model", ["fem", "rod"])
def test_contacts_with_friction_stick_where_nothing_has_moved(model):
    assert {row["state"] for row in pressed(f"model={model}")} == {"sticks"}


@pytest.mark.parametrize("model", ["fem", "rod"])
def test_contacts_with_a_slippery_cylinder_slip(model):
    rows = pressed(
        f"model={model}",
        'obstacles=[{diameter="20 mm",axis=[0,1,0],point=["0 mm","0 mm","-13 mm"],friction=0.0}]',
    )
    assert {row["state"] for row in rows if row["other"] == "cylinder"} == {"slips"}
