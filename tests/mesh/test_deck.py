import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from knotfem.mesh.deck import TURN, carried, rigid_motion
from knotfem.mesh.make_section import section_of

FLAT = np.column_stack([3.0 * section_of(12).points, np.zeros(len(section_of(12).points))])


@given(seed=st.integers(0, 10**6), angle=st.floats(0.0, 3.1))
@settings(max_examples=50, deadline=None)
def test_a_rigid_motion_is_found_and_done_in_stages(seed, angle):
    rng = np.random.default_rng(seed)
    axis = rng.standard_normal(3)
    turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
    shift = rng.uniform(-50, 50, 3)
    moved = FLAT @ turn.T + shift
    found, before, after = rigid_motion(FLAT, moved)
    np.testing.assert_allclose(found, turn, atol=1e-10)
    np.testing.assert_allclose(after - before, shift, atol=1e-10)
    stages = carried(FLAT, moved)
    np.testing.assert_allclose(stages[-1], moved, atol=1e-9)
    assert len(stages) == max(1, np.ceil(angle / TURN - 1e-6))
    for stage in stages:
        np.testing.assert_allclose(
            np.linalg.norm(stage - stage.mean(axis=0), axis=1), np.linalg.norm(FLAT, axis=1), atol=1e-10
        )


def test_what_is_not_rigid_grows_in_proportion():
    moved = FLAT * [1.1, 1.1, 1.0] + [0.0, 0.0, 5.0]
    (stage,) = carried(FLAT, moved)
    np.testing.assert_allclose(stage, moved, atol=1e-12)
    turn = Rotation.from_rotvec([0.0, 2.0 * TURN, 0.0]).as_matrix()
    first, second = carried(FLAT, moved @ turn.T)
    np.testing.assert_allclose(second, moved @ turn.T, atol=1e-10)
    assert np.linalg.norm(first - first.mean(axis=0), axis=1).max() == pytest.approx(3.0 * 1.05)
