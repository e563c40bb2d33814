import subprocess
import sys
from dataclasses import replace

import meshio
import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.mesh.deck import Solid, Springs, deck
from knotfem.mesh.export import Block, ExportMesh, rod_blocks, rod_sets, suffixes, write_mesh
from knotfem.mesh.make_section import section_of
from knotfem.mesh.rod import RodMesh, extrude

GROUPS = ["bulk", "core", "start_face", "end_face", "side"]


@pytest.fixture(scope="module")
def rod() -> RodMesh:
    return extrude(section_of(12), 3.0, 8.0, 4)


@pytest.fixture(scope="module")
def made(rod) -> ExportMesh:
    bulk, core, *surfaces = rod_blocks(rod)
    tensor = np.arange(6.0 * len(rod.hexes)).reshape(-1, 6)
    blocks = [
        Block(bulk.group, bulk.kind, bulk.cells, bulk.abaqus, {"stress": tensor, "strain": tensor[:, 0]}),
        Block(core.group, core.kind, core.cells, core.abaqus, {"tension": np.arange(4.0)}),
        *surfaces,
    ]
    data = {
        "arclength": rod.nodes[:, 2],
        "displacement": 2.0 * rod.nodes,
        "stress": np.tile(np.arange(6.0), (len(rod.nodes), 1)),
    }
    cards = deck([Solid("bulk", 0.4, 20.0, 1e-9), Springs("core", 5.0)], ["start"], [{3: np.array([0.0, 0.0, 0.1])}])
    return ExportMesh(rod.nodes, blocks, data, rod_sets(rod), cards)


@pytest.mark.parametrize("suffix", [".vtu", ".xdmf"])
def test_fields_groups_and_sets_read_back(made, rod, tmp_path, suffix):
    write_mesh(made, tmp_path / f"rod{suffix}")
    mesh = meshio.read(tmp_path / f"rod{suffix}")
    np.testing.assert_array_equal(mesh.points, rod.nodes)
    np.testing.assert_array_equal(mesh.cells_dict["hexahedron"], rod.hexes)
    np.testing.assert_array_equal(mesh.cells_dict["line"], rod.core)
    for name, values in made.point_data.items():
        np.testing.assert_array_equal(mesh.point_data[name], values)
    for name, nodes in made.node_sets.items():
        np.testing.assert_array_equal(np.flatnonzero(mesh.point_data[name]), np.sort(nodes))
    np.testing.assert_array_equal(mesh.cell_data_dict["stress"]["hexahedron"], made.blocks[0].data["stress"])
    np.testing.assert_array_equal(mesh.cell_data_dict["tension"]["line"], np.arange(4.0))
    assert not mesh.cell_data_dict["stress"]["line"].any()
    assert [set(part) for part in mesh.cell_data["group"]] == [{1}, {2}]
    assert sorted(p.name for p in tmp_path.iterdir()) == (["rod.h5", "rod.xdmf"] if suffix == ".xdmf" else ["rod.vtu"])


def test_gmsh_reads_back_with_its_groups(made, rod, tmp_path):
    """Without fields on cells, which meshio 5.3 writes but cannot read."""
    write_mesh(replace(made, blocks=[replace(block, data={}) for block in made.blocks]), tmp_path / "rod.msh")
    mesh = meshio.gmsh.read(tmp_path / "rod.msh")
    np.testing.assert_array_equal(mesh.points, rod.nodes)
    np.testing.assert_array_equal(mesh.cells_dict["hexahedron"], rod.hexes)
    tags = mesh.cell_data_dict["gmsh:physical"]["quad"]
    ends = {
        name: np.unique(mesh.cells_dict["quad"][tags == mesh.field_data[f"{name}_face"][0]])
        for name in ("start", "end")
    }
    np.testing.assert_array_equal(ends["start"], rod.section_nodes[0])
    np.testing.assert_array_equal(ends["end"], rod.section_nodes[-1])
    assert (tags == mesh.field_data["side"][0]).sum() == 4 * 8
    assert set(mesh.field_data) == set(GROUPS)
    np.testing.assert_array_equal(mesh.point_data["stress"][0], [0, 3, 5, 3, 1, 4, 5, 4, 2])


OPEN = """
import gmsh, sys
gmsh.initialize(interruptible=False)
gmsh.option.setNumber("General.Terminal", 0)
gmsh.open(sys.argv[1])
names = sorted(gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups())
quality = gmsh.model.mesh.getElementQualities(gmsh.model.mesh.getElementsByType(5)[0], "minDetJac")
views = {gmsh.view.option.getString(tag, "Name"): tag for tag in gmsh.view.getTags()}
print(*names, len(quality), min(quality) > 0, *sorted(views))
kind, tags, data, *_ = gmsh.view.getModelData(views["strain"], 0)
print(kind, sum(float(row[0]) for row in data))
"""


def test_gmsh_itself_opens_the_file(made, rod, tmp_path):
    pytest.importorskip("gmsh", exc_type=ImportError)
    write_mesh(made, tmp_path / "rod.msh")
    done = subprocess.run(
        [sys.executable, "-c", OPEN, str(tmp_path / "rod.msh")], capture_output=True, text=True, check=True
    )
    views = ["arclength", "displacement", "strain", "stress", "stress", "tension"]
    first, second = done.stdout.splitlines()
    assert first.split() == [*sorted(GROUPS), str(len(rod.hexes)), "True", *sorted(set(views))]
    assert second == f"ElementData {float(np.sum(made.blocks[0].data['strain']))}"


def test_abaqus_reads_back_with_elements_sets_and_cards(made, rod, tmp_path):
    path = tmp_path / "rod.inp"
    write_mesh(made, path)
    text = path.read_text()
    assert [line for line in text.splitlines() if line.startswith("*ELEMENT")] == [
        "*ELEMENT, TYPE=C3D8I",
        "*ELEMENT, TYPE=SPRINGA",
    ]
    assert text.endswith(made.cards)
    assert max(len(field) for line in text.splitlines() if line[:1].isdigit() for field in line.split(",")) <= 20
    path.write_text(text.removesuffix(made.cards).replace("C3D8I", "C3D8").replace("SPRINGA", "T3D2"))
    mesh = meshio.read(path)
    np.testing.assert_allclose(mesh.points, rod.nodes, atol=1e-11)
    np.testing.assert_array_equal(mesh.cells[0].data, rod.hexes)
    np.testing.assert_array_equal(mesh.cells[1].data, rod.core)
    for name, nodes in rod_sets(rod).items():
        np.testing.assert_array_equal(mesh.point_sets[name], nodes)
    np.testing.assert_array_equal(mesh.cell_sets["bulk"][0], np.arange(len(rod.hexes)))
    np.testing.assert_array_equal(mesh.cell_sets["core"][1], np.arange(len(rod.core)))


def test_cards():
    text = deck([Solid("bulk", 0.4, 20.0, 1e-9), Springs("core", 5.0)], ["start", "end"])
    assert "*HYPERELASTIC, NEO HOOKE\n0.2, 0.1\n" in text
    assert "*SPRING, ELSET=core\n\n5\n" in text
    assert "*BOUNDARY\nstart, 1, 3\nend, 1, 3\n*STEP" in text
    assert text.count("*STEP, NLGEOM") == text.count("*END STEP") == 1
    moved = deck([], ["start"], [{0: np.array([1.0, 2.0, 3.0])}, {0: np.zeros(3)}])
    assert "1, 1, 1, 1\n1, 2, 2, 2\n1, 3, 3, 3\n" in moved
    assert moved.count("*STEP, NLGEOM") == 2


def test_a_second_rod_has_names_and_numbers_of_its_own(rod):
    blocks = rod_blocks(rod, 100, prefix="upper_")
    assert [block.group for block in blocks] == [f"upper_{name}" for name in GROUPS]
    np.testing.assert_array_equal(blocks[0].cells, rod.hexes + 100)
    assert rod_sets(rod, 100, prefix="upper_")["upper_start"].min() == 100


def test_quadratic_hexahedra_are_cut_in_eight():
    rod = extrude(section_of(5, order=2), 3.0, 8.0, 4)
    assert rod_blocks(rod)[0].cells.shape == (2 * 5 * 8, 8)


def test_refusals(made, tmp_path):
    assert suffixes() == [".inp", ".msh", ".vtu", ".xdmf"]
    with pytest.raises(InputError, match=r"no such mesh format; found \.stl; expected \.inp, \.msh, \.vtu, \.xdmf"):
        write_mesh(made, tmp_path / "rod.stl")
    with pytest.raises(InputError, match="cannot be written"):
        write_mesh(made, tmp_path / "absent" / "rod.vtu")
    (tmp_path / "rod.vtu").mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        write_mesh(made, tmp_path / "rod.vtu")
    assert [p.name for p in tmp_path.iterdir()] == ["rod.vtu"]


@pytest.mark.parametrize("suffix", suffixes())
def test_a_failing_write_leaves_the_old_files_and_no_other(made, tmp_path, monkeypatch, suffix):
    path = tmp_path / f"rod{suffix}"
    path.write_text("old")

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(type(path), "replace", fail)
    with pytest.raises(InputError, match="No space left"):
        write_mesh(made, path)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    assert path.read_text() == "old"
