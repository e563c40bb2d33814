"""The cross-section of a rod in a scene: a number of quadrilaterals or a file."""

import pytest

from knotfem.errors import InputError
from knotfem.mesh.make_section import section_of
from knotfem.mesh.section_file import write_section
from knotfem.scene import load_scene
from knotfem.scene.write import scene_to_toml

KEY = "rods.0.mesh.section"


@pytest.fixture
def file(tmp_path):
    write_section(section_of(28), tmp_path / "mine.msh")
    return tmp_path / "mine.msh"


def test_a_file_given_on_the_command_line_stands_in_for_the_number(file, monkeypatch):
    monkeypatch.chdir(file.parent)
    mesh = load_scene("cantilever", [f"{KEY}=mine.msh"]).rods[0].mesh
    assert mesh.section == str(file)
    assert load_scene("cantilever").rods[0].mesh.section is None


def test_a_file_is_found_beside_the_scene_and_the_resolved_scene_reads_back(file):
    text = scene_to_toml(load_scene("cantilever")).replace("section_elements = 12", 'section = "mine.msh"')
    (file.parent / "scene.toml").write_text(text)
    scene = load_scene(file.parent / "scene.toml")
    assert scene.rods[0].mesh.section == str(file)
    again = file.parent / "again.toml"
    again.write_text(scene_to_toml(scene))
    assert "section_elements" not in again.read_text()
    assert load_scene(again) == scene
    assert load_scene(again, [f"{KEY}_elements=44"]).rods[0].mesh.section is None
    assert load_scene(again, [f"{KEY}=none"]).rods[0].mesh.section_elements == 12


def test_both_are_refused(file):
    text = scene_to_toml(load_scene("cantilever"))
    text = text.replace("section_elements = 12", 'section_elements = 12\nsection = "mine.msh"')
    (file.parent / "scene.toml").write_text(text)
    with pytest.raises(InputError, match=r"section_elements: two cross-sections; expected either"):
        load_scene(file.parent / "scene.toml")
    with pytest.raises(InputError, match=r"^overrides: rods\.0\.mesh\.section_elements: two cross-sections"):
        load_scene("cantilever", [f"{KEY}={file}", f"{KEY}_elements=12"])


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(InputError, match=r'mesh\.section: no such file; found ".*absent\.msh"; expected a mesh'):
        load_scene("cantilever", [f"{KEY}={tmp_path / 'absent.msh'}"])
    with pytest.raises(InputError, match=r"mesh\.section: wrong value; found 5"):
        load_scene("cantilever", [f"{KEY}=5"])
