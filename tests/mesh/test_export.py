import meshio
import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.mesh.export import export
from knotfem.mesh.rod import RodMesh, extrude
from knotfem.mesh.section_file import read_section


@pytest.fixture(scope="module")
def rod(pytestconfig) -> RodMesh:
    return extrude(read_section(pytestconfig.rootpath / "meshes/sections/section_12.msh"), 3.0, 8.0, 4)


def test_vtu_reads_back(rod, tmp_path):
    moved = rod.nodes + np.array([1.0, 2.0, 3.0])
    export(rod, tmp_path / "rod.vtu", moved)
    mesh = meshio.read(tmp_path / "rod.vtu")
    np.testing.assert_array_equal(mesh.points, moved)
    np.testing.assert_array_equal(mesh.cells_dict["hexahedron"], rod.hexes)
    np.testing.assert_array_equal(mesh.cells_dict["line"], rod.core)
    np.testing.assert_array_equal(mesh.point_data["arclength"], rod.nodes[:, 2])
    assert [set(part) for part in mesh.cell_data["part"]] == [{1}, {2}]


def test_gmsh_reads_back_with_its_groups(rod, tmp_path):
    export(rod, tmp_path / "rod.msh")
    mesh = meshio.gmsh.read(tmp_path / "rod.msh")
    np.testing.assert_array_equal(mesh.points, rod.nodes)
    np.testing.assert_array_equal(mesh.cells_dict["hexahedron"], rod.hexes)
    tags = mesh.cell_data_dict["gmsh:physical"]["quad"]
    ends = {
        name: np.unique(mesh.cells_dict["quad"][tags == mesh.field_data[name][0]])
        for name in ("loading_end", "free_end")
    }
    np.testing.assert_array_equal(ends["loading_end"], rod.section_nodes[0])
    np.testing.assert_array_equal(ends["free_end"], rod.section_nodes[-1])
    assert (tags == mesh.field_data["side"][0]).sum() == 4 * 8
    assert set(mesh.field_data) == {"bulk", "core", "loading_end", "free_end", "side"}


def test_gmsh_itself_opens_the_file(rod, tmp_path):
    try:
        import gmsh
    except OSError:
        return
    export(rod, tmp_path / "rod.msh")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(tmp_path / "rod.msh"))
        names = {gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()}
        quality = gmsh.model.mesh.getElementQualities(gmsh.model.mesh.getElementsByType(5)[0], "minDetJac")
    finally:
        gmsh.finalize()
    assert names == {"bulk", "core", "loading_end", "free_end", "side"}
    assert len(quality) == len(rod.hexes)
    assert min(quality) > 0


def test_abaqus_reads_back_with_the_papers_elements_and_sets(rod, tmp_path):
    path = tmp_path / "rod.inp"
    export(rod, path)
    assert [line for line in path.read_text().splitlines() if line.startswith("*ELEMENT")] == [
        "*ELEMENT, TYPE=C3D8H",
        "*ELEMENT, TYPE=T3D2",
    ]
    mesh = meshio.read(path)
    np.testing.assert_array_equal(mesh.points, rod.nodes)
    np.testing.assert_array_equal(mesh.cells[0].data, rod.hexes)
    np.testing.assert_array_equal(mesh.cells[1].data, rod.core)
    np.testing.assert_array_equal(mesh.point_sets["loading_end"], rod.section_nodes[0])
    np.testing.assert_array_equal(mesh.point_sets["free_end"], rod.section_nodes[-1])
    np.testing.assert_array_equal(mesh.point_sets["axis"], rod.axis_nodes)
    np.testing.assert_array_equal(mesh.cell_sets["bulk"][0], np.arange(len(rod.hexes)))
    np.testing.assert_array_equal(mesh.cell_sets["core"][1], np.arange(len(rod.core)))


def test_refusals(rod, tmp_path):
    with pytest.raises(InputError, match=r"found \.stl; expected \.msh, \.vtu, \.inp"):
        export(rod, tmp_path / "rod.stl")
    with pytest.raises(InputError, match="do not fit"):
        export(rod, tmp_path / "rod.vtu", rod.nodes[1:])
    with pytest.raises(InputError, match="cannot be written"):
        export(rod, tmp_path / "absent" / "rod.vtu")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", ["msh", "vtu", "inp"])
def test_a_failing_write_leaves_the_old_file_and_no_other(rod, tmp_path, monkeypatch, suffix):
    path = tmp_path / f"rod.{suffix}"
    path.write_text("old")

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(type(path), "replace", fail)
    with pytest.raises(InputError, match="No space left"):
        export(rod, path)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    assert path.read_text() == "old"
