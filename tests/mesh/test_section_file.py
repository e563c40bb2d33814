from dataclasses import dataclass, replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from knotfem import shipped
from knotfem.errors import InputError
from knotfem.mesh.make_section import section_from, section_of
from knotfem.mesh.section_file import read_section, write_section

SETTINGS = settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@dataclass
class Drawn:
    """A user's mesh: nodes of shape (m, 3) and quadrilaterals."""

    points: np.ndarray
    quads: np.ndarray

    def write(self, path: Path, **options) -> Path:
        if path.suffix == ".msh":
            options.setdefault("file_format", "gmsh")
        meshio.Mesh(self.points, [("quad", self.quads)]).write(path, **options)
        return path


def drawn(count: int = 12, *, scale: float = 1.0) -> Drawn:
    section = section_of(count)
    points = np.column_stack([scale * section.points, np.zeros(len(section.points))])
    return Drawn(points, section.quads.copy())


def refused(mesh: Drawn, tmp_path: Path, match: str, suffix: str = ".vtk") -> str:
    path = mesh.write(tmp_path / f"wrong{suffix}")
    with pytest.raises(InputError, match=match) as caught:
        read_section(path)
    assert str(path) in str(caught.value)
    assert caught.value.expected
    return str(caught.value)


def test_written_and_read_back_to_the_last_bit(tmp_path):
    write_section(section_of(44), tmp_path / "s.msh")
    again = read_section(tmp_path / "s.msh")
    np.testing.assert_array_equal(again.points, section_of(44).points)
    np.testing.assert_array_equal(again.quads, section_of(44).quads)


def test_any_numbering_orientation_and_stray_node_is_brought_into_order(tmp_path):
    section, rng = section_of(28), np.random.default_rng(1)
    number = rng.permutation(len(section.points) + 1)
    points = np.full((len(section.points) + 1, 3), 9.0)
    points[number[:-1], :2], points[number[:-1], 2] = section.points, 0.0
    quads = number[section.quads]
    quads[::2] = quads[::2, ::-1]
    again = read_section(Drawn(points, rng.permutation(quads)).write(tmp_path / "s.msh", file_format="gmsh"))
    np.testing.assert_array_equal(again.points, section.points)
    np.testing.assert_array_equal(again.quads, section.quads)
    np.testing.assert_array_equal(again.ring, section.ring)


@given(
    suffix=st.sampled_from([".msh", ".vtk", ".vtu", ".inp", ".xdmf", ".obj"]),
    count=st.sampled_from([4, 12, 20, 44]),
    scale=st.floats(1e-2, 1e2),
    centre=st.tuples(*[st.floats(-50, 50)] * 2),
    turn=st.floats(-np.pi, np.pi),
    seed=st.integers(0, 1000),
)
@SETTINGS
def test_a_disc_of_any_size_place_turn_numbering_and_format_is_the_same_section(
    tmp_path, suffix, count, scale, centre, turn, seed
):
    mesh, rng = drawn(count), np.random.default_rng(seed)
    c, s = np.cos(turn), np.sin(turn)
    points = scale * mesh.points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]) + scale * np.array([*centre, 0.0])
    number = rng.permutation(len(points))
    shuffled = np.empty_like(points)
    shuffled[number] = points
    quads = number[mesh.quads]
    flip = rng.random(len(quads)) < 0.5
    quads[flip] = quads[flip, ::-1]
    read = read_section(Drawn(shuffled, rng.permutation(quads)).write(tmp_path / f"s{suffix}"))
    section = section_of(count)
    assert read.sides == section.sides
    assert np.abs(read.points[read.axis]).max() < 1e-9
    step = 2 * np.pi / section.sides
    tolerance = 1e-9 * max(1.0, *np.abs(centre))
    for k in range(section.sides):
        c, s = np.cos(k * step), np.sin(k * step)
        turned = section.points @ np.array([[c, s], [-s, c]])
        if np.abs(np.linalg.norm(turned[:, None] - read.points, axis=2).min(axis=1)).max() < tolerance:
            break
    else:
        pytest.fail("it is another section")
    assert len(read.quads) == len(section.quads)


@pytest.mark.parametrize("normal", [(1, 0, 0), (0, 1, 0), (0.3, -0.5, 0.8)])
def test_a_disc_in_any_plane(tmp_path, normal):
    n = np.array(normal) / np.linalg.norm(normal)
    a = np.cross(n, [0.0, 0.3, 1.0])
    a /= np.linalg.norm(a)
    mesh = drawn(44, scale=3.0)
    path = replace(mesh, points=mesh.points[:, :2] @ np.array([a, np.cross(n, a)]) + [5.0, -1.0, 2.0])
    read = read_section(path.write(tmp_path / "s.vtu"))
    assert (len(read.quads), read.sides) == (44, 16)


def test_a_shipped_section_of_rounded_digits_is_set_right(tmp_path):
    mesh = drawn(44, scale=3.0)
    read = read_section(replace(mesh, points=np.round(mesh.points, 4)).write(tmp_path / "s.vtk"))
    angle = 2 * np.pi * np.arange(16) / 16
    np.testing.assert_allclose(read.points[read.ring], np.column_stack([np.cos(angle), np.sin(angle)]), atol=1e-15)
    np.testing.assert_allclose(read.points, section_of(44).points, atol=2e-4)


def test_gmsh_itself_draws_one(tmp_path):
    gmsh = pytest.importorskip("gmsh", exc_type=ImportError)
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo = gmsh.model.geo
        centre = geo.addPoint(0, 0, 0)
        rim = [geo.addPoint(3 * np.cos(a), 3 * np.sin(a), 0) for a in np.pi / 2 * np.arange(4)]
        spokes = [geo.addLine(centre, p) for p in rim]
        arcs = [geo.addCircleArc(rim[i], centre, rim[(i + 1) % 4]) for i in range(4)]
        for curve, steps in [*((s, 4) for s in spokes), *((a, 4) for a in arcs)]:
            geo.mesh.setTransfiniteCurve(curve, steps + 1)
        for i in range(4):
            face = geo.addPlaneSurface([geo.addCurveLoop([spokes[i], arcs[i], -spokes[(i + 1) % 4]])])
            geo.mesh.setRecombine(2, face)
        geo.synchronize()
        gmsh.option.setNumber("Mesh.RecombinationAlgorithm", 2)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 1)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(tmp_path / "mine.msh"))
    finally:
        gmsh.finalize()
    read = read_section(tmp_path / "mine.msh")
    assert read.sides % 4 == 0
    assert section_from(tmp_path / "mine.msh", order=2).quads.shape == (len(read.quads), 9)


def test_not_finite(tmp_path):
    mesh = drawn()
    mesh.points[1, 0] = np.nan
    refused(mesh, tmp_path, "not finite")


def test_not_plane(tmp_path):
    mesh = drawn()
    mesh.points[2, 2] = 0.2
    refused(mesh, tmp_path, "lie in one plane; found a node .* off it")


def test_quadrilateral_that_is_not_convex(tmp_path):
    mesh = drawn()
    mesh.points[mesh.quads[0][0]] = [0.6, 0.6, 0.0]
    refused(mesh, tmp_path, r"not convex; found \d+ of 12, the first around \(")


def test_boundary_node_off_the_circle(tmp_path):
    mesh = drawn(scale=3.0)
    rim = section_of(12).ring[1]
    mesh.points[rim] *= 1.02
    said = refused(mesh, tmp_path, "boundary of a cross-section is a circle; found a node at")
    assert f"({mesh.points[rim, 0]:.6g}, {mesh.points[rim, 1]:.6g})" in said


def test_square_section(tmp_path):
    line = np.linspace(-1.0, 1.0, 5)
    x, y = np.meshgrid(line, line, indexing="ij")
    i = np.arange(25).reshape(5, 5)
    quads = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], axis=-1).reshape(-1, 4)
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(25)])
    refused(Drawn(points, quads), tmp_path, "boundary of a cross-section is a circle")


def test_uneven_boundary(tmp_path):
    mesh, rim = drawn(), section_of(12).ring[3]
    angle = np.arctan2(mesh.points[rim, 1], mesh.points[rim, 0]) + 0.1
    mesh.points[rim] = [np.cos(angle), np.sin(angle), 0.0]
    refused(mesh, tmp_path, "at equal angles; found a step of .* degrees .*expected 45 degrees.*transfinite")


def test_no_node_on_the_axis(tmp_path):
    mesh = drawn(scale=3.0)
    mesh.points[0] = [0.3, 0.1, 0.0]
    refused(mesh, tmp_path, r"node on the rod's axis; found the nearest at \(0\.3, 0\.1\)")


def test_two_nodes_in_one_place(tmp_path):
    mesh = drawn()
    mesh.points = np.vstack([mesh.points, mesh.points[:1]])
    mesh.quads[0][mesh.quads[0] == 0] = len(mesh.points) - 1
    refused(mesh, tmp_path, r"two nodes in one place; found 1 such pairs, the first at \(0, 0\).*Coherence")


def test_hanging_node(tmp_path):
    mesh = drawn(4)
    (quad,) = np.flatnonzero(
        (mesh.quads == section_of(4).ring[0]).any(axis=1) & (mesh.points[mesh.quads].sum(axis=1)[:, 1] > 0)
    )
    a, b, c, d = mesh.points[mesh.quads[quad]]
    new = len(mesh.points)
    mesh.points = np.vstack([mesh.points, 0.5 * (a + b), 0.5 * (c + d)])
    p, q, r, s = mesh.quads[quad]
    mesh.quads = np.vstack([np.delete(mesh.quads, quad, axis=0), [[p, new, new + 1, s], [new, q, r, new + 1]]])
    refused(mesh, tmp_path, "a node hangs on the edge.*found [12] such nodes")


def test_hole(tmp_path):
    mesh = drawn(44)
    centre = np.linalg.norm(mesh.points[mesh.quads].mean(axis=1), axis=1)
    mesh.quads = np.delete(mesh.quads, np.argsort(centre)[4], axis=0)
    refused(mesh, tmp_path, "one closed loop; found another boundary at")


def test_two_discs(tmp_path):
    mesh = drawn()
    count = len(mesh.points)
    apart = mesh.points + np.array([4.0, 0.0, 0.0])
    both = Drawn(np.vstack([mesh.points, apart]), np.vstack([mesh.quads, mesh.quads + count]))
    refused(both, tmp_path, "one closed loop")


def test_quadrilateral_given_twice(tmp_path):
    mesh = drawn()
    mesh.quads = np.vstack([mesh.quads, mesh.quads[3:4]])
    refused(mesh, tmp_path, "at most two quadrilaterals; found overlapping ones at the edge")


def test_node_that_is_not_there(tmp_path):
    path = tmp_path / "wrong.msh"
    write_section(section_of(4), path)
    text = path.read_text()
    path.write_text(text.replace("1 3 2 1 1 1 2 3 4", "1 3 2 1 1 1 2 3 44"))
    with pytest.raises(InputError, match=r"names a node that is not there|cannot be read"):
        read_section(path)


@pytest.mark.parametrize(("kind", "cells"), [("triangle", [[0, 1, 2]]), ("quad9", [np.arange(9)])])
def test_other_cells(tmp_path, kind, cells):
    mesh = drawn()
    meshio.Mesh(mesh.points, [("quad", mesh.quads), (kind, np.array(cells))]).write(tmp_path / "s.vtu")
    with pytest.raises(InputError, match=f"four nodes and nothing else; found {kind}"):
        read_section(tmp_path / "s.vtu")


def test_no_cells(tmp_path):
    meshio.Mesh(np.eye(3), []).write(tmp_path / "s.inp")
    with pytest.raises(InputError, match="found no cells"):
        read_section(tmp_path / "s.inp")


def test_files_that_are_none(tmp_path, capfd):
    with pytest.raises(InputError, match=r"no such cross-section mesh; expected"):
        read_section(tmp_path / "absent.msh")
    (tmp_path / "s.txt").write_text("quads")
    with pytest.raises(InputError, match=r"no mesh format has this suffix; found \.txt; expected .*\.msh"):
        read_section(tmp_path / "s.txt")
    (tmp_path / "s.msh").write_text("quads")
    with pytest.raises(InputError, match=r"cannot be read as a mesh \(.*gmsh"):
        read_section(tmp_path / "s.msh")
    assert capfd.readouterr() == ("", "")


@given(data=st.data(), suffix=st.sampled_from([".msh", ".vtk", ".inp", ".vtu", ".obj"]))
@SETTINGS
def test_a_damaged_file_is_refused_or_read_but_raises_nothing_else(tmp_path, data, suffix):
    path = tmp_path / f"s{suffix}"
    drawn(4).write(path)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        if data.draw(st.booleans()):
            content[place] = data.draw(st.integers(0, 255))
        else:
            del content[place : place + data.draw(st.integers(1, 40))]
    path.write_bytes(bytes(content))
    try:
        section = read_section(path)
    except InputError:
        return
    assert section.sides >= 3


def test_the_shipped_files_are_taken_as_they_are():
    for count in shipped.section_counts():
        mesh = meshio.read(shipped.section_path(count))
        known = {tuple(p) for p in mesh.points[:, :2].tolist()}
        assert {tuple(p) for p in read_section(shipped.section_path(count)).points.tolist()} == known
