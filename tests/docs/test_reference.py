"""The reference is what the code says, complete, and found by any name."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from knotfem import reference, shipped
from knotfem.errors import InputError
from knotfem.run.column_meanings import COLUMNS, TABLES
from knotfem.run.field_meanings import FIELDS
from knotfem.run.summary_meanings import SUMMARY
from knotfem.scene import load_scene
from knotfem_cli.main import knotfem_command

FOLDER = Path(__file__).parents[2] / "docs" / "reference"


def test_pages_are_what_the_code_says():
    pages = reference.pages()
    assert {path.name for path in FOLDER.glob("*.md")} == set(pages)
    for name, text in pages.items():
        assert (FOLDER / name).read_text() == text, "python -m knotfem.reference docs/reference writes it"


def leaves(value: object, above: tuple[str, ...] = ()) -> set[tuple[str, ...]]:
    if isinstance(value, dict):
        return {leaf for key, entry in value.items() for leaf in leaves(entry, (*above, key))}
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return {leaf for entry in value for leaf in leaves(entry, above)}
    return {above}


@pytest.mark.parametrize("name", ["bowline", "bowline-lowered", "sheet-bend", "cantilever"])
def test_every_key_of_a_scene_has_an_entry(name):
    assert name in shipped.scene_names()
    known = {key.plain for key in reference.scene_keys()}
    rods = [rod.name for rod in load_scene(name).rods]
    written = {
        tuple(part for part in leaf if part not in rods) for leaf in leaves(load_scene(name).model_dump(mode="json"))
    }
    assert written - known == set()


def test_every_key_has_a_meaning_and_a_kind():
    for key in reference.scene_keys():
        assert key.kind, key.path
        assert re.sub(r"\[[^]]*\]", "", key.meaning).strip(" ."), key.path


def test_every_column_has_a_meaning():
    assert {name for columns in TABLES.values() for name in columns} == set(COLUMNS)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("contact.friction", "default  0.33"),
        ("rods.0.length", "length [mm], > 0"),
        ("rods.0.centreline", "a shipped name"),
        ("steps.pull.speed", "steps.N[pull].speed"),
        ("unrest_N", "dynamic residual"),
        ("stress", "xx, yy, zz, xy, yz, xz"),
        ("pressure", "not that of contacts"),
        ("element", '"hex8-reduced"'),
        ("steps.1.ends.rod.start.direction", "steps.N.ends.N.start[driven].direction"),
        ("steps.pull.ends.rod.start", "steps.N.ends.N.start[loaded].force"),
        ("ends.rod.end.motion", '"clamped", "pinned"'),
        ("rods.0.origin.2", "where the curve's own origin goes"),
        ("contact.pairs.0.between.1", "two names, of rods"),
        ("rods.0.mesh", "rods.N.mesh.element_length"),
        ("steps.1", "steps.N[pull].displacement"),
        ("verdict", "no longer what it was"),
        ("holding", "holding_force_N"),
        ("holding_force_N", "largest force in equilibrium before that [N]"),
        ("jumps", "from one branch of equilibria"),
        ("largest |stretch - 1| while mapped", "steps after tying do not count"),
        ("holding force", "largest force in equilibrium before that [N]"),
        ("slipping force", "when the free end had been drawn in by the slip"),
        ("slipping force [N]", "when the free end had been drawn in by the slip"),
        ("force.csv", "displacement_mm"),
        ("study.csv", "a row is a point of a study"),
        ("boundary.csv", "low, high, monotone"),
        ("onset_friction", "column of study.csv: onset_friction\n  friction at which strands began to slip"),
        ("lost_friction", "friction at which the knot was lost"),
        ("rests", "column of study.csv"),
        ("low", "column of boundary.csv"),
        ("monotone", "1 where the knot holds at no friction below"),
        ("protocol", 'column of study.csv: protocol\n  "kept"'),
        ("point", "column of study.csv: point"),
        ("status.json", "running, done"),
    ],
)
def test_help_of_a_name(name, said):
    result = CliRunner().invoke(knotfem_command, ["help", name], env={"COLUMNS": "200"})
    assert result.exit_code == 0
    assert said in result.output


def test_names_that_several_things_have_are_all_told():
    text = reference.look_up("friction")
    assert all(path in text for path in ("contact.friction", "obstacles.N.friction", "contact.pairs.N.friction"))
    assert text.count("column of") == 2
    assert reference.look_up("twist").count("\n\n") == 2


def test_a_name_is_not_taken_for_that_of_an_entry_elsewhere():
    assert "obstacles" not in reference.look_up("contact.friction")
    with pytest.raises(InputError):
        reference.look_up("steps.1.ends.rod.start.directions")


def test_what_nothing_is_called():
    with pytest.raises(InputError, match=r'found "contact\.frictoin"; expected "contact\.friction"'):
        reference.look_up("contact.frictoin")
    with pytest.raises(InputError, match=r'expected "rods\.length"'):
        reference.look_up("rods.0.lenght")
    with pytest.raises(InputError, match=r'found "frictoin"; expected "friction"'):
        reference.look_up("frictoin")
    with pytest.raises(InputError, match="expected a key of a scene"):
        reference.look_up("contact.qqqqqq")


def test_fields_of_both_models_have_an_entry(tmp_path):
    import knotfem as kf

    coarse = {
        "rods.rod.length": "400 mm", "rods.rod.mesh.element_length": "10 mm", "rods.rod.mesh.section_elements": 4,
        "contact.enabled": False, "tie.path": "direct", "steps.pull.displacement": "1 mm", "solver.threads": 1,
    }  # fmt: skip
    common = []
    for model in ("fem", "rod"):
        folder = tmp_path / model
        run = kf.pull("overhand", {**coarse, "model": model}, out=folder)
        fields = run.states[-1].fields
        assert set(fields.point_data) | set(fields.cell_data) == {
            name for name, field in FIELDS.items() if model in field.models and field.places != "field data"
        }
        assert set(fields.cell_data) <= set(fields.point_data)
        assert set(run.summary) <= set(SUMMARY)
        common.append(set(fields.point_data))
        assert_described(folder / "results.vtkhdf", [state.displacement for state in run.states])
    assert common[0] & common[1] >= {"displacement", "tension", "contact_pressure", "largest_principal_strain"}


def assert_described(file: Path, displacements: list[float]) -> None:
    import h5py
    import numpy as np
    import pyvista
    from vtkmodules.util.numpy_support import vtk_to_numpy

    with h5py.File(file) as opened:
        root = opened["VTKHDF"]
        assert isinstance(root, h5py.Group)
        for kind in ("PointData", "CellData", "FieldData"):
            group = root[kind]
            assert isinstance(group, h5py.Group)
            for name, data in group.items():
                assert (data.attrs["description"], data.attrs["unit"]) == (FIELDS[name].text, FIELDS[name].unit)
                assert data.attrs.get("components", "") == FIELDS[name].components
    reader = pyvista.get_reader(str(file)).reader  # has no steps of its own; that of VTK has
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(displacements)
    found = []
    for step in range(len(displacements)):
        reader.SetStep(step)
        reader.Update()
        (value,) = vtk_to_numpy(reader.GetOutput().GetFieldData().GetArray("displacement_mm"))
        found.append(value)
    np.testing.assert_allclose(found, displacements, rtol=1e-6, atol=1e-9)
