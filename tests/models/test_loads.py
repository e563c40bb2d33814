"""Forces on ends, in either model: what they set out from and what they become."""

from __future__ import annotations

import numpy as np
import pytest

from knotfem.models.base import Model
from knotfem.models.build import build_model
from knotfem.models.rod.model import FRAMES
from knotfem.scene import load_scene
from knotfem.solver.state import Motion, State
from knotfem.solver.system import labelled
from knotfem.solver.term import TimeStep

COARSE = ("rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=10 mm", "solver.threads=1")
STEP = 'steps=[{kind="load", duration="2 s", ends={rod={end={%s}}}}]'
LOADED = 'motion="loaded", force="%g N", direction=%s, following=%s'
TURN = np.array([[1.0, 0.0, 0.0], [0.0, 0.8, -0.6], [0.0, 0.6, 0.8]])


def origin_of(model: Model) -> State:
    """Straight rods at rest."""
    state = model.straight()
    if model.hexes:
        return State.of(Motion.at_rest(model.series_mesh().reference), {})
    return state


def turned(state: State) -> State:
    """A state turned as a whole, frames of discrete rods with it."""
    x, history = state.x.copy(), dict(state.history)
    x[:, :3] = x[:, :3] @ TURN.T
    if FRAMES in history:
        frames = history[FRAMES]
        history[FRAMES] = {**frames, **{name: frames[name] @ TURN.T for name in ("tangent", "director")}}
    return State.of(Motion.at_rest(x), history)


def force_in(kind: str, force: float, direction: str, following: str, before: np.ndarray, time: float) -> np.ndarray:
    """Force of a load step on the end of a turned straight rod, which bore `before`, after so many seconds."""
    scene = load_scene("cantilever", [*COARSE, f"model={kind}", STEP % (LOADED % (force, direction, following))])
    model = build_model(scene)
    origin = turned(origin_of(model))
    system = model.equations(scene.steps[0], origin, {"rod.end": before}).system
    (load,) = [term for term in system.terms if term.name == "load"]
    load.begin(TimeStep(origin, time))
    residual = np.zeros_like(origin.x)
    load.assemble(origin.x, residual, None)
    system.close()
    return -residual[:, :3].sum(axis=0)


@pytest.mark.parametrize("model", ["fem", "rod"])
def test_a_dead_load_goes_from_the_force_that_was_there_to_its_own(model: str) -> None:
    """Turned by a right angle too, no jump."""
    before, after = np.array([0.0, 0.0, -0.01]), np.array([0.0, 0.03, 0.0])
    for time, part in ((0.0, 0.0), (0.5, 0.25), (2.0, 1.0), (3.0, 1.0)):
        found = force_in(model, 0.03, "[0, 1, 0]", "false", before, time)
        np.testing.assert_allclose(found, (1.0 - part) * before + part * after, atol=1e-12)


@pytest.mark.parametrize("model", ["fem", "rod"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_following_load_of_the_same_size_stays_as_it_was(model: str, sign: float) -> None:
    """Its end has turned away from the direction that the scene names."""
    scene = load_scene("cantilever", [*COARSE, f"model={model}"])
    start = build_model(scene).straight().x
    along = start[-1, :3] - start[0, :3] if model == "rod" else np.array([0.0, 0.0, 1.0])
    tangent = TURN @ along / np.linalg.norm(along)
    direction = str((sign * (tangent + 0.3 * np.cross(tangent, [0.0, 0.6, 0.8]))).tolist())
    for time in (0.0, 1.0, 2.0):
        found = force_in(model, 0.02, direction, "true", sign * 0.02 * tangent, time)
        np.testing.assert_allclose(found, sign * 0.02 * tangent, atol=1e-9)


@pytest.mark.parametrize("model", ["fem", "rod"])
def test_the_first_driven_end_is_reported(model: str) -> None:
    scene = load_scene("crossed-rods", ["solver.threads=1", "rods.0.mesh.section_elements=4", f"model={model}"])
    built = build_model(scene)
    (step,) = [step for step in scene.steps if step.kind == "pull"]
    made = built.equations(step, origin_of(built), {})
    assert [label for label, _, _ in made.drives] == ["upper.start", "upper.end"]
    made.system.close()


@pytest.mark.parametrize("model", ["fem", "rod"])
def test_friction_of_a_cylinder_is_known_by_its_obstacle(model: str) -> None:
    """The history variables of one run may go to another that rubs on other obstacles."""
    peg = "{{name='{}', diameter='4 mm', axis=[0,1,0], point=['0 mm','0 mm','{} mm'], friction={}}}"
    pegs = [peg.format("a", -9, 0.0), peg.format("b", 9, 0.4)]
    scene = load_scene(
        "cantilever", [*COARSE, f"model={model}", "contact.enabled=true", f"obstacles=[{','.join(pegs)}]"]
    )
    labels = [label for label, term in labelled(build_model(scene).terms) if term.name == "cylinder friction"]
    assert labels == ["cylinder friction-2"]
