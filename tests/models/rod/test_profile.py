"""Tension, twist and moments of discrete rods in tables and fields, against closed forms."""

import numpy as np
import pytest
from reduced import BENDING, RADIUS, TWISTING, End, Rods, crossing, line, settle, spec, still

from knotfem.models.rod.fields import AROUND, tube_fields, tube_mesh, tube_rings
from knotfem.models.rod.profile import at_nodes, profile_rows, twist_rows
from knotfem.models.series import Fields
from knotfem.scene import load_scene
from knotfem.scene.rods import Rod
from knotfem.solver.constraints import Clamp
from knotfem.solver.schemes import Scheme

N, LENGTH, AXIAL = 40, 80.0, 4e3


def named(core_fraction: float = 0.0) -> tuple[Rod, ...]:
    """A scene's rods, of which tables take the names and the fraction of the core in EA."""
    (rod,) = load_scene("cantilever", ["rods.0.core=none"]).rods
    if core_fraction == 0.0:
        return (rod,)
    stiffness = rod.axial_stiffness * core_fraction / (1.0 - core_fraction)
    core = f"{{youngs_modulus='{float(stiffness / np.pi)!r} MPa', radius='1 mm'}}"
    return load_scene("cantilever", [f"rods.0.core={core}"]).rods


def arc(curvature: float, twist: float = 0.0) -> Rods:
    """A rod bent into an arc and twisted evenly, held at both ends, as it lies."""
    h = LENGTH / N
    middle = curvature * h * (np.arange(N) + 0.5)
    edges = h * np.stack([np.cos(middle), np.sin(middle), 0.0 * middle], axis=1)
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(edges, axis=0)])

    def director(s: np.ndarray) -> np.ndarray:
        bend, turn = curvature * s, twist * s
        across = np.stack([-np.sin(bend), np.cos(bend), 0.0 * bend], axis=-1)
        return np.cos(turn)[..., None] * across + np.sin(turn)[..., None] * np.array([0.0, 0.0, 1.0])

    model = Rods([spec(points, axial=AXIAL, directors=director(h * (np.arange(N) + 0.5)))])
    angle = curvature * LENGTH
    tangents = np.array([1.0, 0.0, 0.0]), np.array([np.cos(angle), np.sin(angle), 0.0])
    directors = director(np.array(0.0)), director(np.array(LENGTH))
    clamps = [
        Clamp(node, lambda time, t=t, d=d: (t, d)) for node, t, d in zip((0, N), tangents, directors, strict=True)
    ]
    model.begin(End(clamps=clamps))
    return model


def columns(rows) -> dict[str, np.ndarray]:
    listed = list(rows)
    return {name: np.array([row[name] for row in listed]) for name in listed[0]}


def nodal(model: Rods) -> tuple[np.ndarray, ...]:
    return at_nodes(model.discrete, model.x)


def tensions(model: Rods, core_fraction: float):
    return profile_rows(model.discrete, named(core_fraction), model.x, 0.0, 0.0)


def twists(model: Rods, time: float, displacement: float):
    return twist_rows(model.discrete, named(), model.x, time, displacement)


def fields_of(model: Rods) -> Fields:
    return tube_fields(model.discrete, model.contacts(), model.x, [0.5] * model.layout.rods)


def test_bend_and_twist_are_those_of_the_arc_up_to_the_clamps():
    twist, torque, curvature, moment = nodal(arc(0.02, 0.01))
    assert curvature == pytest.approx(np.full(N + 1, 0.02), rel=1e-9)
    assert moment == pytest.approx(np.full(N + 1, 0.02 * BENDING), rel=1e-9)
    assert twist == pytest.approx(np.full(N + 1, 0.01), rel=1e-9)
    assert torque == pytest.approx(np.full(N + 1, 0.01 * TWISTING), rel=1e-9)


def test_free_end_carries_no_moment():
    model = arc(0.02, 0.01)
    model.begin()
    for values in nodal(model):
        assert values[0] == values[-1] == 0.0


def test_table_of_twist_has_a_row_a_node():
    table = columns(twists(arc(0.02, 0.01), 1.5, 2.5))
    assert table["arclength_mm"] == pytest.approx(np.linspace(0.0, LENGTH, N + 1))
    assert table["s_over_L"][[0, -1]].tolist() == [0.0, 1.0]
    assert set(table["time_s"]) == {1.5}
    assert table["torque_Nmm"] == pytest.approx(np.full(N + 1, 0.01 * TWISTING), rel=1e-9)


def test_tension_is_what_stretches_the_segments_shared_by_stiffness():
    model = still(line(N, LENGTH) * np.array([1.001, 1.0, 1.0]), axial=AXIAL, spacing=LENGTH / N)
    model.begin()
    table = columns(tensions(model, 0.8))
    assert table["tension_N"] == pytest.approx(np.full(N + 1, 0.001 * AXIAL), rel=1e-9)
    assert table["core_N"] == pytest.approx(0.8 * table["tension_N"], rel=1e-9)
    assert table["core_N"] + table["bulk_N"] == pytest.approx(table["tension_N"], rel=1e-9)
    assert np.abs(table["shear_N"]).max() < 1e-9


def test_forces_on_nodes_and_stretch_of_segments_are_two_ways_to_one_tension():
    rng = np.random.default_rng(3)
    points = line(N, LENGTH) + 0.05 * rng.normal(size=(N + 1, 3))
    model = still(points, axial=AXIAL, spacing=LENGTH / N)
    model.begin()
    table = columns(tensions(model, 0.5))
    ends = [0, -1]
    assert table["tension_N"][ends] == pytest.approx((table["core_N"] + table["bulk_N"])[ends], rel=1e-9)
    assert table["shear_N"].max() > 0.1


def test_shear_is_what_the_moment_changes_by():
    """A cantilever under an end force: bent a little, M falls linearly and the shear is its slope."""
    s = np.linspace(0.0, LENGTH, N + 1)
    force = 1e-4
    deflection = force / BENDING * (LENGTH * s**2 / 2.0 - s**3 / 6.0)
    model = still(np.stack([s, deflection, 0.0 * s], axis=1), axial=AXIAL, spacing=LENGTH / N)
    model.begin()
    table = columns(tensions(model, 0.5))
    assert table["shear_N"][5:-5] == pytest.approx(np.full(N - 9, force), rel=2e-3)


def test_tubes_are_closed_rings_round_the_axis():
    model = arc(0.02, 0.01)
    mesh, fields = tube_mesh(model.layout), fields_of(model)
    assert mesh.cells.shape == (N * AROUND, 4)
    assert np.bincount(mesh.cells.ravel()).tolist() == [2] * AROUND + [4] * AROUND * (N - 1) + [2] * AROUND
    (ring,) = tube_rings(model.layout)
    for points in (mesh.reference, fields.points):
        centre = points[ring].mean(axis=1)
        assert np.linalg.norm(points[ring] - centre[:, None], axis=2) == pytest.approx(RADIUS)
    assert fields.points[ring].mean(axis=1) == pytest.approx(model.centreline(), abs=1e-12)
    outwards = np.cross(*(np.diff(mesh.reference[mesh.cells[:, [0, 1, 3]]], axis=1)[:, [0, 1]].swapaxes(0, 1)))
    assert np.all(np.einsum("ei,ei->e", outwards[:, :2], mesh.reference[mesh.cells[:, 0], :2]) != 0.0)


def test_surface_strain_is_the_bending_of_the_arc():
    model = arc(0.02)
    fields = fields_of(model)
    strain = fields.point_data["largest_principal_strain"].reshape(N + 1, AROUND)
    outer, inner = np.log1p(0.02 * RADIUS), np.log1p(-0.02 * RADIUS)
    assert strain.max(axis=1) == pytest.approx(np.full(N + 1, outer), rel=1e-2)
    opposite = np.linalg.norm(fields.points.reshape(N + 1, AROUND, 3)[:, :, :2] - np.array([0.0, 50.0]), axis=2)
    innermost = strain[np.arange(N + 1), opposite.argmin(axis=1)]
    assert innermost == pytest.approx(np.full(N + 1, -0.5 * inner), rel=1e-2)


def test_twist_shears_the_surface():
    strain = fields_of(arc(0.0, 0.01)).point_data["largest_principal_strain"]
    assert strain == pytest.approx(np.full(strain.size, 0.5 * 0.01 * RADIUS), rel=1e-9)


def test_contact_pressure_carries_the_contact_force():
    model = crossing(0.3)
    onto = np.zeros_like(model.x)
    model.contact.assemble(model.x, onto, None)
    fields = fields_of(model)
    pressure = fields.point_data["contact_pressure"].reshape(-1, AROUND)
    points = fields.points.reshape(-1, AROUND, 3)
    area = 2.0 * np.pi * RADIUS / AROUND * 2.0
    for rod in range(2):
        nodes = model.layout.of(rod)
        inwards = (points[nodes].mean(axis=1)[:, None] - points[nodes]) / RADIUS
        force = np.einsum("na,nai->i", pressure[nodes], inwards) * area
        assert force == pytest.approx(-onto[nodes, :3].sum(axis=0), rel=2e-3, abs=1e-9)
        assert abs(force[2]) > 0.3


def test_internal_damping_carries_its_part_of_the_load():
    """A rod that is pulled and turned at once by dead loads of its clamps: the profile meets the ends as it creeps."""
    model = Rods([spec(line(6, 30.0), axial=200.0, relaxation_time=0.05)], scheme=Scheme())
    axis = np.array([1.0, 0.0, 0.0])
    turning = model.turned("end", axis, lambda time: 2.0 * time, held=False)
    pulled = model.loaded("end", lambda time: 2.0 * axis)
    settle(model, model.clamped("start"), turning, pulled, duration=0.05, steps=10)
    table = columns(tensions(model, 0.25))
    assert table["tension_N"] == pytest.approx(np.full(7, 2.0), rel=1e-6)
    assert table["core_N"] + table["bulk_N"] == pytest.approx(np.full(7, 2.0), rel=1e-6)
    assert table["torque_Nmm"] == pytest.approx(np.full(7, TWISTING / 30.0 * 2.0 * (0.05 + 0.05)), rel=1e-3)
    assert model.discrete.stretch.tension(model.x).max() < 1.3
