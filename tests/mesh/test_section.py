import numpy as np
import pytest

from knotfem.errors import InputError, MissingDependency
from knotfem.mesh.section import (
    LAYOUTS,
    Section,
    area,
    available,
    make_section,
    read_section,
    scale_for_bending,
    second_moments,
    write_section,
)

SHIPPED = "meshes/sections/section_{}.msh"


@pytest.fixture(scope="module")
def sections(pytestconfig) -> dict[int, Section]:
    """Made by gmsh; where it cannot load, which must be said, those that ship."""
    try:
        import gmsh  # noqa: F401
    except (ImportError, OSError):
        with pytest.raises(MissingDependency, match="apt-get install"):
            make_section(4)
        return {count: read_section(pytestconfig.rootpath / SHIPPED.format(count)) for count in available}
    return {count: make_section(count) for count in available}


def corner_determinants(section: Section) -> tuple[np.ndarray, np.ndarray]:
    corners = section.points[section.quads]
    ahead = np.roll(corners, -1, axis=1) - corners
    behind = np.roll(corners, 1, axis=1) - corners
    det = ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]
    return det, det / np.linalg.norm(ahead, axis=-1) / np.linalg.norm(behind, axis=-1)


def rewrite(path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize("count", available)
def test_counts_axis_and_ring(sections, count):
    section = sections[count]
    assert len(section.quads) == count
    assert section.points[section.axis].tolist() == [0.0, 0.0]
    angle = 2 * np.pi * np.arange(section.sides) / section.sides
    np.testing.assert_allclose(
        section.points[section.ring], np.column_stack([np.cos(angle), np.sin(angle)]), atol=1e-15
    )
    assert section.sides == 4 * LAYOUTS[count].across


def test_the_papers_section_has_53_nodes_and_16_sides(sections):
    assert len(sections[44].points) == 53
    assert sections[44].sides == 16
    assert len(sections[48].points) == 57


@pytest.mark.parametrize("count", available)
def test_elements_are_counter_clockwise_and_well_shaped(sections, count):
    det, scaled = corner_determinants(sections[count])
    assert det.min() > 0
    assert scaled.min() > 0.7
    areas = det.mean(axis=1)
    assert areas.max() / areas.min() < 2.7


@pytest.mark.parametrize("count", available)
def test_mirror_symmetry_is_exact(sections, count):
    points = sections[count].points
    known = {tuple(p) for p in points.tolist()}
    for image in ((-points[:, 0], points[:, 1]), (points[:, 0], -points[:, 1])):
        assert {(x + 0.0, y + 0.0) for x, y in zip(*image, strict=True)} == known
    swapped = np.array(sorted(map(tuple, np.round(points[:, ::-1], 12) + 0.0)))
    np.testing.assert_allclose(swapped, np.array(sorted(map(tuple, np.round(points, 12) + 0.0))), atol=1e-11)


@pytest.mark.parametrize(("count", "factor"), [(4, 0.812), (12, 0.812), (44, 0.950), (48, 0.950), (104, 0.977)])
def test_bending_stiffness_of_the_facetted_disc(sections, count, factor):
    i_xx, i_yy, i_xy = second_moments(sections[count])
    assert i_xx / (np.pi / 4) == pytest.approx(factor, abs=5e-4)
    assert i_yy == pytest.approx(i_xx, rel=1e-14)
    assert i_xy == pytest.approx(0.0, abs=1e-14)
    scale = scale_for_bending(sections[count])
    assert i_xx * scale**4 == pytest.approx(np.pi / 4, rel=1e-14)


@pytest.mark.parametrize("count", [12, 44])
def test_moments_agree_with_quadrature_over_the_quadrilaterals(sections, count):
    from skfem import CellBasis, ElementQuad1, MeshQuad

    section = sections[count]
    basis = CellBasis(MeshQuad(section.points.T.copy(), section.quads.T.copy()), ElementQuad1(), intorder=4)
    x, y = basis.global_coordinates()
    assert area(section) == pytest.approx(basis.dx.sum(), rel=1e-13)
    i_xx, i_yy, i_xy = second_moments(section)
    assert i_xx == pytest.approx((y**2 * basis.dx).sum(), rel=1e-13)
    assert i_yy == pytest.approx((x**2 * basis.dx).sum(), rel=1e-13)
    assert i_xy == pytest.approx((x * y * basis.dx).sum(), abs=1e-13)


def test_moments_of_a_rectangle_shaped_ring():
    points = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 3.0]])
    rectangle = Section(points, np.array([[0, 1, 2, 3]]), 0, np.arange(4))
    assert area(rectangle) == pytest.approx(6.0)
    assert second_moments(rectangle) == pytest.approx((2 * 27 / 3, 3 * 8 / 3, 4 * 9 / 4))


@pytest.mark.parametrize("count", available)
def test_shipped_file_is_what_gmsh_makes(sections, count, pytestconfig):
    shipped, made = read_section(pytestconfig.rootpath / SHIPPED.format(count)), sections[count]
    np.testing.assert_allclose(shipped.points, made.points, atol=1e-7)
    np.testing.assert_array_equal(shipped.quads, made.quads)
    np.testing.assert_array_equal(shipped.ring, made.ring)


def test_unknown_count_names_the_available_ones():
    with pytest.raises(InputError, match=r"found 45; expected one of 4, 12, 20, 28, 44, 48"):
        make_section(45)


def test_written_and_read_back_to_the_last_bit(sections, tmp_path):
    write_section(sections[44], tmp_path / "s.msh")
    again = read_section(tmp_path / "s.msh")
    np.testing.assert_array_equal(again.points, sections[44].points)
    np.testing.assert_array_equal(again.quads, sections[44].quads)


def test_any_numbering_orientation_and_stray_node_is_brought_into_order(sections, tmp_path):
    import meshio

    section, rng = sections[28], np.random.default_rng(1)
    number = rng.permutation(len(section.points) + 1)
    points = np.full((len(section.points) + 1, 3), 9.0)
    points[number[:-1], :2], points[number[:-1], 2] = section.points, 0.0
    quads = number[section.quads]
    quads[::2] = quads[::2, ::-1]
    meshio.Mesh(points, [("quad", rng.permutation(quads))]).write(tmp_path / "s.msh", file_format="gmsh")
    again = read_section(tmp_path / "s.msh")
    np.testing.assert_array_equal(again.points, section.points)
    np.testing.assert_array_equal(again.quads, section.quads)
    np.testing.assert_array_equal(again.ring, section.ring)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("1 0.0000000000000000e+00 0.0", "1 1.0000000000000000e-03 0.0", "node at the origin"),
        ("2 1.0000000000000000e+00", "2 1.0000100000000000e+00", "unit circle.*found a distance of 1e-05"),
        ("2 1.0000000000000000e+00", "2 nan", "not finite"),
        ("2 1.0000000000000000e+00 0.0", "2 1.0000000000000000e+00 0.9", "not convex"),
        ("1 3 2 1 1 1 2 3 4", "1 3 2 1 1 4 5 6 1", "each edge in at most two"),
        ("1 3 2 1 1 1 2 3 4\n", "1 2 2 1 1 1 2 3\n", "unit circle"),
        ("2.2 0 8", "oh no", "cannot be read as a Gmsh mesh"),
        ("$Nodes", "$Nothing", "cannot be read|no cells"),
    ],
)
def test_wrong_file_is_refused(sections, tmp_path, old, new, message):
    path = tmp_path / "wrong.msh"
    write_section(sections[4], path)
    rewrite(path, old, new)
    with pytest.raises(InputError, match=message) as caught:
        read_section(path)
    assert str(path) in str(caught.value)


def test_a_missing_file_and_a_mesh_without_quadrilaterals_are_refused(tmp_path):
    import meshio

    with pytest.raises(InputError, match="no such cross-section"):
        read_section(tmp_path / "absent.msh")
    triangle = meshio.Mesh(np.eye(3), [("triangle", np.array([[0, 1, 2]]))])
    triangle.write(tmp_path / "t.msh", file_format="gmsh")
    with pytest.raises(InputError, match="found triangle"):
        read_section(tmp_path / "t.msh")
