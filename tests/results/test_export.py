"""`knotfem export`: runs of both models for other programs."""

import json
import math

import meshio
import numpy as np
import pytest
from click.testing import CliRunner

import knotfem as kf
from knotfem.errors import InputError
from knotfem.mesh.rod import RodMesh
from knotfem.models.solid.body import meshes_of
from knotfem.results.export import export
from knotfem_cli.main import knotfem_command

COARSE = [
    "rods.0.mesh.section_elements=12",
    "rods.0.mesh.element_length=8 mm",
    "steps.0.duration=0.2 s",
    "solver.threads=1",
]
CELLS = ("stress", "largest_principal_strain", "pressure", "tension")


@pytest.fixture(scope="module")
def solid(tmp_path_factory) -> kf.Run:
    return kf.pull("cantilever", COARSE, out=tmp_path_factory.mktemp("solid") / "run", progress=False)


@pytest.fixture(scope="module")
def rod(tmp_path_factory) -> kf.Run:
    return kf.pull("cantilever", [*COARSE, "model=rod"], out=tmp_path_factory.mktemp("rod") / "run", progress=False)


def mesh_of_run(run: kf.Run) -> RodMesh:
    ((mesh, _),) = meshes_of(run.scene)
    return mesh


@pytest.mark.parametrize("reference", [False, True])
@pytest.mark.parametrize("suffix", [".vtu", ".xdmf"])
def test_hexahedra_with_all_fields(solid, tmp_path, suffix, reference):
    path = tmp_path / f"rod{suffix}"
    state = export(solid, path, reference=reference)
    fields, rod, mesh = state.fields, mesh_of_run(solid), meshio.read(path)
    np.testing.assert_array_equal(mesh.points, fields.reference if reference else fields.points)
    np.testing.assert_array_equal(mesh.cells_dict["hexahedron"], rod.hexes)
    np.testing.assert_array_equal(mesh.cells_dict["line"], rod.core)
    np.testing.assert_allclose(mesh.point_data["displacement"], fields.points - fields.reference, atol=1e-12)
    for name in ("stress", "largest_principal_strain", "contact_pressure", "arclength"):
        np.testing.assert_array_equal(mesh.point_data[name], fields.point_data[name])
    for name in CELLS:
        np.testing.assert_array_equal(mesh.cell_data_dict[name]["hexahedron"], fields.cell_data[name])
    np.testing.assert_array_equal(mesh.cell_data_dict["tension"]["line"], fields.cell_data["tension"][::12])
    np.testing.assert_array_equal(np.flatnonzero(mesh.point_data["axis"]), rod.axis_nodes)
    assert np.abs(mesh.point_data["displacement"]).max() > 1e-3


def test_discrete_rods_are_lines_with_what_they_carry(rod, tmp_path):
    state = export(rod, tmp_path / "rod.vtu")
    fields, mesh = state.fields, meshio.read(tmp_path / "rod.vtu")
    slices = rod.scene.rods[0].slices
    assert set(mesh.cells_dict) == {"line"}
    np.testing.assert_array_equal(
        mesh.cells_dict["line"], np.column_stack([np.arange(slices), np.arange(1, slices + 1)])
    )
    np.testing.assert_allclose(mesh.points, fields.points.reshape(slices + 1, -1, 3).mean(axis=1), atol=1e-12)
    for name in ("tension", "curvature", "twist"):
        expected = fields.point_data[name].reshape(slices + 1, -1)[:, 0]
        np.testing.assert_allclose(mesh.point_data[name], expected)
    assert mesh.point_data["curvature"].max() > 0.0
    assert np.flatnonzero(mesh.point_data["end"]).tolist() == [slices]
    export(rod, tmp_path / "rod.inp")
    assert "*ELEMENT, TYPE=B31" in (tmp_path / "rod.inp").read_text()
    export(rod, tmp_path / "straight.vtu", reference=True)
    assert np.ptp(meshio.read(tmp_path / "straight.vtu").points[:, :2], axis=0).max() < 1e-12


def test_decks_carry_the_ends_or_hold_them(solid, tmp_path):
    state = export(solid, tmp_path / "straight.inp", reference=True)
    rod = mesh_of_run(solid)
    text = (tmp_path / "straight.inp").read_text()
    assert "*HYPERELASTIC, NEO HOOKE" in text
    assert "*SPRING, ELSET=core" in text
    rows = [line.split(",") for line in text.partition("*ELEMENT")[0].splitlines() if line[:1].isdigit()]
    points = np.array([[float(x) for x in row[1:]] for row in rows])
    np.testing.assert_allclose(points[rod.section_nodes[0]], state.fields.points[rod.section_nodes[0]], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(np.diff(points[rod.axis_nodes], axis=0), axis=1), rod.element_length)
    node = int(rod.section_nodes[-1, 0])
    moved = [line.split(",") for line in text.split("*STATIC")[-1].splitlines() if line.startswith(f"{node + 1}, ")]
    reached = points[node] + [float(row[3]) for row in moved]
    np.testing.assert_allclose(reached, state.fields.points[node], atol=1e-9)
    export(solid, tmp_path / "bent.inp")
    assert "start, 1, 3\nend, 1, 3\n" in (tmp_path / "bent.inp").read_text()


def test_two_rods_have_names_of_their_own(tmp_path):
    overrides = [f"rods.{i}.mesh.{key}" for i in (0, 1) for key in ("section_elements=4", "element_length=20 mm")]
    scene = kf.load_scene("crossed-rods", [*overrides, "solver.threads=1"])
    meshes = [mesh for mesh, _ in meshes_of(scene)]
    reference = np.concatenate([mesh.nodes for mesh in meshes])
    from knotfem.results.fields import StateFields
    from knotfem.results.moment import Moment
    from knotfem.results.states import RunState

    count = sum(len(mesh.hexes) for mesh in meshes)
    fields = StateFields(
        reference + 1.0, reference, np.zeros((count, 8), dtype=int), {}, {"tension": np.arange(count) + 0.0}
    )
    export(RunState(scene, Moment("", math.nan, math.nan, 0.0), lambda: fields), tmp_path / "two.msh")
    text = (tmp_path / "two.msh").read_text()
    for rod in scene.rods:
        assert f'"{rod.name}_bulk"' in text
        assert f'"{rod.name}_end_face"' in text
    wrong = StateFields(reference[:-1], reference[:-1], fields.cells, {}, fields.cell_data)
    with pytest.raises(InputError, match="not that of the scene"):
        export(RunState(scene, Moment("", math.nan, math.nan, 0.0), lambda: wrong), tmp_path / "wrong.vtu")


def knotfem(*arguments: object):
    return CliRunner().invoke(knotfem_command, ["export", *map(str, arguments)])


def test_the_verb(solid, tmp_path):
    done = knotfem(solid.path, "-o", tmp_path / "rod.vtu")
    assert (done.exit_code, done.stdout.split()) == (0, [str(tmp_path / "rod.vtu")])
    done = knotfem(solid.path, "-o", tmp_path / "rod.inp", "--reference", "--log-format", "json")
    found = json.loads(done.output)
    assert found["file"] == str(tmp_path / "rod.inp")
    assert found["time_s"] > 0.0


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["-o", "rod.stl"], 3, "no such mesh format; found .stl; expected .inp, .msh, .vtu, .xdmf"),
        (["-o", "absent/rod.vtu"], 3, "cannot be written"),
        (["-o", "rod.vtu", "--at", "60"], 3, "unit"),
        ([], 2, "output"),
    ],
)
def test_what_cannot_be_done_is_said_once_and_nothing_is_left(solid, tmp_path, monkeypatch, arguments, code, message):
    monkeypatch.chdir(tmp_path)
    done = knotfem(solid.path, *arguments)
    assert done.exit_code == code
    assert message in done.output
    assert "Traceback" not in done.output
    assert list(tmp_path.iterdir()) == []


def test_a_run_without_states_is_refused(tmp_path):
    run = kf.pull("cantilever", [*COARSE, "output.fields=false"], out=tmp_path / "run", progress=False)
    with pytest.raises(InputError, match="no state is stored"):
        export(run, tmp_path / "rod.vtu")
    assert not (tmp_path / "rod.vtu").exists()
