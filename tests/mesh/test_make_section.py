import subprocess
import sys

import numpy as np
import pytest

from knotfem import shipped
from knotfem.errors import InputError, MissingDependency
from knotfem.mesh.layout import LARGEST, Layout, layouts, nearest_count
from knotfem.mesh.make_section import make_section, other_count, possible_elements, section_of
from knotfem.mesh.section import Section
from knotfem.mesh.section_file import read_section

SHIPPED = shipped.section_counts()
MADE = [count for count in layouts() if count < 200 or count > LARGEST - 30]


@pytest.fixture(scope="module")
def sections() -> dict[int, Section]:
    """Made by gmsh; where it cannot load, which must be said, those that ship."""
    try:
        import gmsh  # noqa: F401
    except (ImportError, OSError):
        with pytest.raises(MissingDependency, match="apt-get install"):
            make_section(4)
        return {count: section_of(count) for count in SHIPPED}
    return {count: make_section(count) for count in MADE}


def corner_determinants(section: Section) -> tuple[np.ndarray, np.ndarray]:
    corners = section.points[section.quads]
    ahead = np.roll(corners, -1, axis=1) - corners
    behind = np.roll(corners, 1, axis=1) - corners
    det = ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]
    return det, det / np.linalg.norm(ahead, axis=-1) / np.linalg.norm(behind, axis=-1)


def test_counts_axis_and_ring(sections):
    for count, section in sections.items():
        assert len(section.quads) == count
        assert section.points[section.axis].tolist() == [0.0, 0.0]
        angle = 2 * np.pi * np.arange(section.sides) / section.sides
        np.testing.assert_allclose(
            section.points[section.ring], np.column_stack([np.cos(angle), np.sin(angle)]), atol=1e-15
        )
        assert section.sides == 4 * layouts()[count].across


def test_the_papers_section_has_53_nodes_and_16_sides(sections):
    assert len(sections[44].points) == 53
    assert sections[44].sides == 16
    assert len(sections[48].points) == 57


def test_elements_are_counter_clockwise_and_well_shaped(sections):
    for count, section in sections.items():
        det, scaled = corner_determinants(section)
        assert det.min() > 0
        assert scaled.min() > 0.7, count
        areas = det.mean(axis=1)
        assert areas.max() / areas.min() < (2.7 if count in SHIPPED else 3.6), count


def test_mirror_symmetry_is_exact(sections):
    for section in sections.values():
        points = section.points
        known = {tuple(p) for p in points.tolist()}
        for image in ((-points[:, 0], points[:, 1]), (points[:, 0], -points[:, 1])):
            assert {(x + 0.0, y + 0.0) for x, y in zip(*image, strict=True)} == known
        swapped = np.array(sorted(map(tuple, np.round(points[:, ::-1], 12) + 0.0)))
        np.testing.assert_allclose(swapped, np.array(sorted(map(tuple, np.round(points, 12) + 0.0))), atol=1e-11)


@pytest.mark.parametrize("count", SHIPPED)
def test_shipped_file_is_what_gmsh_makes(sections, count):
    ready, made = read_section(shipped.section_path(count)), sections[count]
    np.testing.assert_allclose(ready.points, made.points, atol=1e-7)
    np.testing.assert_array_equal(ready.quads, made.quads)
    np.testing.assert_array_equal(ready.ring, made.ring)
    np.testing.assert_array_equal(section_of(count).points, ready.points)


@pytest.mark.parametrize(
    ("count", "layout"),
    [(4, (2, True, 0)), (12, (2, True, 1)), (20, (2, True, 2)), (28, (4, False, 1)), (44, (4, False, 2)),
     (48, (4, True, 2)), (80, (6, False, 2)), (104, (6, False, 3)), (108, (6, True, 3))],
)  # fmt: skip
def test_layouts_that_ship(count, layout):
    assert layouts()[count] == Layout(*layout)
    assert layouts()[count].elements == count


def test_the_nearest_count_is_taken_and_said():
    assert [nearest_count(n) for n in (4, 7, 8, 16, 50, 52, 60, 70, LARGEST)] == [4, 4, 12, 20, 48, 56, 60, 64, 480]
    assert possible_elements(5, order=2) == 5
    assert possible_elements(5, order=1) == 4
    assert other_count(44) is None
    assert other_count(60) is None
    assert other_count(5, order=2) is None
    assert "asked for 50 quadrilaterals, made 48" in (other_count(50) or "")
    assert max(np.diff(list(layouts()))) <= 28
    assert max(abs(nearest_count(n) - n) for n in range(4, 130)) <= 8


def test_any_count_makes_a_section(sections):
    assert len(section_of(50).quads) == 48
    if 56 in sections:
        np.testing.assert_array_equal(section_of(52).points, sections[56].points)
        assert section_of(52, order=2).quads.shape == (56, 9)
    assert len(section_of(5, order=2).quads) == 5


def test_impossible_counts_are_refused():
    with pytest.raises(InputError, match=r"section_elements: .*found 45; expected 44"):
        make_section(45)
    with pytest.raises(InputError, match=f"found 501; expected at most {LARGEST}"):
        section_of(LARGEST + 1)


def test_without_gmsh_the_cure_is_said_and_shipped_sections_are_there(monkeypatch):
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(MissingDependency, match=r"pip install gmsh.*shipped"):
        make_section(56)
    assert len(section_of(44).quads) == 44


INSIDE = """
import signal, sys
import gmsh
gmsh.initialize(interruptible=False, readConfigFiles=False)
gmsh.option.setNumber("General.Terminal", 1)
gmsh.option.setNumber("Mesh.ElementOrder", 2)
gmsh.model.add("mine")
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
gmsh.model.occ.synchronize()
before = gmsh.model.list(), len(gmsh.model.getEntities())
from knotfem.mesh.make_section import make_section
assert len(make_section(56).quads) == 56
assert gmsh.isInitialized()
assert gmsh.model.getCurrent() == "mine"
assert (gmsh.model.list(), len(gmsh.model.getEntities())) == before
assert gmsh.option.getNumber("General.Terminal") == 1
assert gmsh.option.getNumber("Mesh.ElementOrder") == 2
"""
ALONE = """
import signal
from knotfem.mesh.make_section import make_section
handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
make_section(56)
assert {number: signal.getsignal(number) for number in handlers} == handlers
import gmsh
assert not gmsh.isInitialized()
"""


@pytest.mark.parametrize("program", [INSIDE, ALONE], ids=["inside another program", "alone"])
def test_gmsh_leaves_no_trace(sections, program):
    if 56 not in sections:
        pytest.skip("gmsh cannot be loaded here")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
