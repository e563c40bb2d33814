"""Arclength along rods of unequal slices, and what samples stand for."""

import numpy as np
import pytest
from specimens import make_rod, surfaces

from knotfem.contact import curve
from knotfem.contact.curve_pairs import CurveSurface
from knotfem.contact.pieces import borders, middles
from knotfem.contact.stations import arclengths, make_stations
from knotfem.geometry.slices import Slices, equal_slices
from knotfem.mesh.rod_layout import make_layout

GRADED = Slices(1.15 ** np.array([0.0, 1, 2, 3, 4, 5, 4, 3, 2, 1, 0, 0]))
"""From 1 mm to 2 mm and back."""


def test_arclength_is_the_place_along_the_straight_centreline():
    layout = make_layout([12, 4], [GRADED.lengths, 2.0], [3.0, 3.0])
    x = np.zeros((layout.nodes, 4))
    x[:, 2] = layout.arclength
    rods, u = np.repeat([0, 1], 57), np.concatenate([np.linspace(-1.0, 13.0, 57), np.linspace(-1.0, 5.0, 57)])
    room, found = curve.curve_room(), arclengths(CurveSurface(layout).stations, rods, u)
    for k in range(u.size):
        base = int(layout.first[rods[k]]) + curve.axial_basis(u[k], int(np.diff(layout.first)[rods[k]]), room.w)
        curve.curve_point(x, base, room.w, room.C)
        assert found[k] == pytest.approx(room.C[0, 2], abs=1e-13)
    np.testing.assert_allclose(found[57:], 2.0 * u[57:], atol=1e-13)


def test_samples_of_tubes_lie_at_their_arclengths():
    rod = make_rod(float(GRADED.lengths.sum()), GRADED)
    surface, samples = surfaces([rod], 0.75)
    places = samples.places(rod.mesh.nodes)[:, 2]
    np.testing.assert_allclose(arclengths(surface.stations, samples.rod, samples.u), places, atol=1e-12)
    assert samples.view.measure.sum() == pytest.approx(2.0 * np.pi * 3.0 * GRADED.lengths.sum(), rel=1e-12)


@pytest.mark.parametrize("cut", [middles, borders])
@pytest.mark.parametrize("spacing", [0.3, 0.45, 0.75, 5.0])
def test_samples_stand_for_the_arclength_around_them(cut, spacing):
    u, length = cut(GRADED, spacing)
    assert length.sum() == pytest.approx(GRADED.lengths.sum(), rel=1e-12)
    stations, zero = make_stations(np.arange(13), [GRADED], [3.0]), np.zeros(u.size, dtype=np.int64)
    apart = np.diff(arclengths(stations, zero, u))
    if spacing < 2.0:
        assert apart.max() <= spacing + 1e-12
        assert apart.min() > 0.4 * spacing
    fine = np.linspace(0.0, 12.0, 24 * 5040 + 1)
    along = arclengths(stations, np.zeros(fine.size, dtype=np.int64), fine)
    if cut is borders:
        ends = np.concatenate([[0.0], 0.5 * (u[1:] + u[:-1]), [12.0]])
    else:
        per_slice = np.histogram(u, np.arange(13))[0]
        ends = np.append(np.concatenate([i + np.arange(many) / many for i, many in enumerate(per_slice)]), 12.0)
    np.testing.assert_allclose(length, np.diff(np.interp(ends, fine, along)), rtol=1e-7)


@pytest.mark.parametrize("spacing", [0.3, 0.7])
def test_equal_slices_have_equal_samples_to_the_bit(spacing):
    slices = equal_slices(10.0, 7)
    pieces = int(np.ceil(slices.lengths[0] / spacing))
    u, length = middles(slices, spacing)
    np.testing.assert_array_equal(u, (np.arange(7 * pieces) + 0.5) / pieces)
    np.testing.assert_array_equal(length, slices.lengths[0] / pieces)
    u, length = borders(slices, spacing)
    np.testing.assert_array_equal(u, np.arange(7 * pieces + 1) / pieces)
    np.testing.assert_array_equal(length[1:-1], slices.lengths[0] / pieces)
    np.testing.assert_array_equal(length[[0, -1]], 0.5 * (slices.lengths[0] / pieces))


def test_stations_of_several_rods():
    stations = make_stations(np.arange(16), [GRADED, equal_slices(6.0, 2)], [3.0, 2.0])
    np.testing.assert_array_equal(stations.first, [0, 13, 16])
    np.testing.assert_allclose(stations.longest, [1.15**5, 3.0])
    np.testing.assert_allclose(stations.arclength[13:], [0.0, 3.0, 6.0])
