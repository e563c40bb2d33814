import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.geometry.slices import Slices
from knotfem.tie import KINDS, make_path

TIMES = (0.0, 0.13, 0.5, 0.77, 1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_ends_are_the_straight_rod_and_exactly_the_target(kind, overhand):
    path = make_path(kind, overhand)
    rod = path.at(0.0)
    edges = np.diff(rod, axis=0)
    assert path.kind == kind
    assert path.describe()["kind"] == kind
    assert np.array_equal(path.at(1.0), overhand)
    np.testing.assert_allclose(
        edges, np.broadcast_to(path.slices.lengths[0] * np.array(path.describe()["direction"]), (120, 3)), atol=1e-12
    )
    np.testing.assert_allclose(path.stretch(0.0), 1.0, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "direct"])
def test_stretch_is_edge_length_over_rest_length(kind, overhand):
    path = make_path(kind, overhand)
    rest = np.linalg.norm(path.at(0.0)[1] - path.at(0.0)[0])
    for t in TIMES:
        x = path.at(t)
        expected = [np.sqrt(((x[i + 1] - x[i]) ** 2).sum()) / rest for i in range(len(x) - 1)]
        np.testing.assert_allclose(path.stretch(t), expected, atol=1e-12)


def uneven(points: np.ndarray) -> tuple[np.ndarray, Slices]:
    """Every vertex of the first half of a polyline, every other of the second, and its chords."""
    kept = points[np.r_[0:60, 60:121:2]]
    return kept, Slices(np.linalg.norm(np.diff(kept, axis=0), axis=1))


@pytest.mark.parametrize("kind", KINDS)
def test_a_rod_of_unequal_slices_is_stretched_by_its_own_lengths(kind, overhand):
    target, slices = uneven(overhand)
    path = make_path(kind, target, slices=slices)
    rod = path.at(0.0)
    lengths = np.linalg.norm(np.diff(rod, axis=0), axis=1)
    np.testing.assert_allclose(lengths, slices.lengths, rtol=1e-12)
    np.testing.assert_allclose(np.diff(rod, axis=0), lengths[:, None] * path.direction, atol=1e-11)
    np.testing.assert_allclose(path.stretch(0.0), 1.0, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(path.stretch(1.0), 1.0, rtol=0.0, atol=1e-12)
    assert np.array_equal(path.at(1.0), target)
    if kind in ("polynomial", "inextensible"):
        dense = np.array([path.stretch(t) for t in np.linspace(0.0, 1.0, 301)])
        assert path.describe()["max_stretch_deviation"] == pytest.approx(np.abs(dense - 1.0).max(), abs=2e-5)
        assert np.abs(dense - 1.0).max() < (0.11 if kind == "polynomial" else 1e-10)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "direct"])
def test_extremes_told_are_those_of_all_times(kind, overhand):
    path = make_path(kind, overhand)
    told = path.describe()
    dense = np.array([path.stretch(t) for t in np.linspace(0.0, 1.0, 501)])
    assert told["min_stretch"] == pytest.approx(dense.min(), abs=2e-5)
    assert told["max_stretch"] == pytest.approx(dense.max(), abs=2e-5)
    assert told["max_stretch_deviation"] == pytest.approx(np.abs(dense - 1.0).max(), abs=2e-5)
    assert told["min_stretch"] <= dense.min() + 1e-12
    assert told["max_stretch"] >= dense.max() - 1e-12


@pytest.mark.parametrize("kind", ["polynomial", "inextensible"])
def test_straight_rod_stands_centred_on_the_knot(kind, overhand):
    path = make_path(kind, overhand)
    for t in TIMES:
        np.testing.assert_allclose(path.at(t).mean(axis=0), overhand.mean(axis=0), atol=1e-10)


@pytest.mark.parametrize("kind", KINDS)
def test_start_places_the_rod(kind, overhand):
    path = make_path(kind, overhand, start=(1.0, 2.0, 3.0), direction=(0.0, 3.0, 4.0))
    np.testing.assert_allclose(path.at(0.0)[0], (1.0, 2.0, 3.0), atol=1e-10)
    np.testing.assert_allclose(path.at(0.0)[-1], (1.0, 2.0 + 72.0, 3.0 + 96.0), atol=1e-10)


def test_linear_path_stands_where_the_paper_has_it(overhand):
    rod = make_path("linear", overhand).at(0.0)
    np.testing.assert_allclose(rod, np.arange(121)[:, None] * np.array([0.0, 0.0, 1.0]), atol=1e-10)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"kind": "slerp"}, "polynomial, inextensible, linear, direct"),
        ({"target": np.zeros((2, 3))}, "n >= 2"),
        ({"target": np.zeros((5, 2))}, "n >= 2"),
        ({"target": np.full((5, 3), np.nan)}, "not finite"),
        ({"target": np.zeros((5, 3))}, "coincide"),
        ({"target": [[0, 0, 0], [0, 0, 1], [0, 0, 3]]}, "equal chords"),
        ({"direction": (0.0, 0.0, 0.0)}, "not all zero"),
        ({"direction": (0.0, 1.0)}, "three finite numbers"),
        ({"direction": "up"}, "best"),
        ({"kind": "linear", "direction": "up"}, "best"),
        ({"start": (0.0, np.inf, 0.0)}, "start"),
        ({"slices": Slices(np.ones(3))}, "slices"),
        ({"degree": 0}, "degree"),
        ({"degree": 2.5}, "degree"),
        ({"degree": 3}, "1 to 2"),
        ({"threshold": 0.0}, "threshold"),
        ({"threshold": np.nan}, "threshold"),
    ],
)
def test_wrong_input_is_refused(arguments, says):
    good = {"kind": "polynomial", "target": [[0, 0, 0], [0, 0, 1], [0, 1, 1]], "degree": 2}
    with pytest.raises(InputError, match=says):
        make_path(**(good | arguments))


@pytest.mark.parametrize("t", [-1e-9, 1.0 + 1e-9, np.nan])
@pytest.mark.parametrize("kind", KINDS)
def test_times_outside_the_mapping_are_refused(kind, t, overhand):
    with pytest.raises(InputError, match="mapping time"):
        make_path(kind, overhand).at(t)


def test_direct_path_has_nothing_between(overhand):
    with pytest.raises(InputError, match="no intermediate states"):
        make_path("direct", overhand).at(0.5)
