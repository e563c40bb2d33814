"""What a user may add to a scene as objects, and what is refused."""

import numpy as np
import pytest

from knotfem.contact.friction import Friction
from knotfem.contact.rigid import make_cylinder
from knotfem.errors import InputError
from knotfem.models.base import Additions, Obstacle
from knotfem.models.build import build_model
from knotfem.models.material import NeoHooke
from knotfem.models.rod.model import RodModel
from knotfem.models.solid.model import SolidModel
from knotfem.scene import load_scene
from knotfem.terms.load import EndForce

COARSE = ("rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=10 mm")


def peg(name: str = "peg") -> Obstacle:
    return Obstacle(make_cylinder(np.zeros(3), np.array([0.0, 1.0, 0.0]), 4.0), 0.2, name)


@pytest.mark.parametrize("model", ["fem", "rod"])
def test_obstacles_stand_beside_those_of_the_scene(model):
    scene = load_scene("bowline", [*COARSE, f"model={model}"])
    built = build_model(scene, Additions(obstacles=[peg()]))
    assert built.obstacle_names == ["cylinder", "peg"]
    names = [term.name for term in built.terms]
    assert names.count("cylinder") == names.count("cylinder friction") == 2


@pytest.mark.parametrize("model", ["fem", "rod"])
@pytest.mark.parametrize(
    ("overrides", "obstacles", "message"),
    [
        (["contact.enabled=false"], ["peg"], "contact.enabled: obstacles need contact; found false; expected true"),
        ([], ["cylinder"], "obstacles: used twice; found cylinder"),
        ([], ["rod"], "obstacles: used twice; found rod"),
        ([], ["peg", "peg"], "obstacles: used twice; found peg"),
    ],
)
def test_obstacles_that_cannot_be_are_refused(model, overrides, obstacles, message):
    scene = load_scene("bowline", [*COARSE, f"model={model}", *overrides])
    with pytest.raises(InputError, match=message):
        build_model(scene, Additions(obstacles=[peg(name) for name in obstacles]))


def test_materials_are_those_of_a_rod_of_hexahedra():
    law = NeoHooke(1.0)
    scene = load_scene("bowline", COARSE)
    built = build_model(scene, Additions(materials={"rod": law}))
    assert isinstance(built, SolidModel)
    assert built.body.rods[0].bulk.material is law
    with pytest.raises(InputError, match=r'materials: no rod has this name; found rods; expected "rod"'):
        build_model(scene, Additions(materials={"rods": law}))
    light = load_scene("bowline", [*COARSE, "model=rod"])
    with pytest.raises(InputError, match=r'materials: discrete rods have no bulk; found rod; expected model = "fem"'):
        build_model(light, Additions(materials={"rod": law}))


def test_terms_of_the_users_own_are_those_of_the_model_and_of_its_steps():
    scene = load_scene("bowline", [*COARSE, "model=rod"])
    own = EndForce(np.array([0]), np.ones(1), lambda time: np.zeros(3))
    built = build_model(scene, Additions(terms=[own]))
    assert isinstance(built, RodModel)
    assert built.terms == [*built.discrete.terms, own]
    equations = built.equations(scene.steps[0], built.origin(built.straight()), {})
    assert equations.system.terms[: len(built.terms)] == built.terms
    equations.system.close()


def test_friction_of_an_obstacle_may_differ_from_rod_to_rod():
    scene = load_scene("sheet-bend", ["model=rod"])
    post = Obstacle(make_cylinder(np.array([0.0, 0.0, 500.0]), np.array([0.0, 1.0, 0.0]), 4.0), np.array([0.0, 0.3]))
    terms = build_model(scene, Additions(obstacles=[post])).terms
    (friction,) = (term for term in terms if isinstance(term, Friction) and term.external)
    np.testing.assert_array_equal(friction.coefficients, [0.0, 0.3])
