"""Scenes from files and overrides: what is read, what is refused and how."""

import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem import shipped
from knotfem.errors import InputError, SeveralErrors
from knotfem.geometry.readers import NURBS_SUFFIXES, READERS
from knotfem.models.centreline import centrelines_of
from knotfem.scene import Scene, load_scene, scene_to_toml
from knotfem.scene.load import describe
from knotfem.scene.rods import CURVE_SUFFIXES

MINIMAL = """
[[rods]]
centerline = "overhand"
length = "480 mm"
diameter = "6 mm"
material = { youngs_modulus = "1.25 MPa", density = "1160 kg/m^3" }
mesh = { element_length = "2 mm" }
"""


@pytest.fixture
def scene_file(tmp_path: Path) -> Path:
    path = tmp_path / "my knot.toml"
    path.write_text(MINIMAL)
    return path


def refused(source: str | Path, *overrides: str) -> InputError:
    with pytest.raises(InputError) as caught:
        load_scene(source, overrides)
    return caught.value


@pytest.mark.parametrize("name", shipped.scene_names())
def test_shipped_scenes_are_right(name: str) -> None:
    scene = load_scene(name)
    assert scene.name == Path(name).name
    assert scene.description
    assert scene.steps
    assert describe(name) == scene.description


def test_the_paper_scene_has_the_papers_figures() -> None:
    scene = load_scene("bowline-paper")
    rod, (cylinder,), pull = scene.rods[0], scene.obstacles, scene.steps[-1]
    assert (rod.length, rod.diameter, rod.slices, rod.mesh.section_elements) == (600.0, 6.0, 600, 44)
    assert rod.core is not None
    assert rod.core.axial_stiffness == pytest.approx(3826, abs=1)
    assert rod.material.youngs_modulus * 3.141592653589793 * 3.0**4 / 4 == pytest.approx(90.65, abs=0.01)
    assert rod.material.density == 1.16e-9
    assert (cylinder.diameter, cylinder.friction, scene.contact.friction) == (20.0, 0.39, 0.33)
    assert scene.gravity is not None
    assert scene.gravity.acceleration == 9810.0
    assert pull.kind == "pull"
    assert (pull.displacement, pull.speed, pull.duration) == (99.0, 4.0, 24.75)
    assert pull.ends["rod"].start.motion == "driven"
    assert pull.ends["rod"].end.motion == "free"
    assert [step.kind for step in scene.tying_steps] == ["relax"]
    assert scene.loading_steps == (pull,)


def test_defaults(scene_file: Path) -> None:
    scene = load_scene(scene_file)
    assert scene.name == "my-knot"
    assert (scene.model, scene.gravity, scene.drag, scene.rods[0].core) == ("fem", None, None, None)
    eps = scene.contact.stiffness_over_modulus * 1.0 / scene.rods[0].diameter
    assert eps == 8.0


def test_overrides() -> None:
    scene = load_scene(
        "bowline",
        [
            "rods.0.length=500 mm",
            "contact.friction=0.37",
            'contact.pairs=[{between=["rod", "rod"], friction=0.1}]',
            "solver.linear=superlu",
            "gravity=none",
            "rods.0.core=none",
            "steps.1.displacement=20 mm",
            "drag.rate = 1 1/s",
            "description=a bowline = a knot",
        ],
    )
    assert scene.rods[0].length == 500.0
    assert scene.friction_between("rod", "rod") == 0.1
    assert scene.friction_between("rod", "cylinder") == scene.friction_between("cylinder", "rod") == 0.39
    assert scene.solver.linear == "superlu"
    assert scene.gravity is None
    assert scene.rods[0].core is None
    assert scene.steps[1].kind == "pull"
    assert scene.steps[1].displacement == 20.0
    assert scene.drag is not None
    assert scene.drag.rate == 1.0
    assert scene.description == "a bowline = a knot"


def test_an_override_makes_a_table(scene_file: Path) -> None:
    scene = load_scene(scene_file, ["gravity.acceleration=9.81 m/s^2"])
    assert scene.gravity is not None
    assert scene.gravity.direction == (0.0, 0.0, -1.0)


def test_curve_files_are_found_from_the_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "curves").mkdir()
    curve = tmp_path / "curves" / "mine.csv"
    curve.write_bytes(shipped.centreline_path("overhand").read_bytes())
    scene_file = tmp_path / "scene.toml"
    scene_file.write_text(MINIMAL.replace('"overhand"', '"curves/mine.csv"'))
    monkeypatch.chdir("/")
    assert load_scene(scene_file).rods[0].centerline == str(curve)
    monkeypatch.chdir(curve.parent)
    assert load_scene("overhand", ["rods.0.centerline=mine.csv"]).rods[0].centerline == str(curve)


def test_a_centreline_may_be_spelt_in_two_ways(tmp_path: Path) -> None:
    one, other = tmp_path / "one.toml", tmp_path / "other.toml"
    one.write_text(MINIMAL)
    other.write_text(MINIMAL.replace("centerline =", "centreline ="))
    assert load_scene(one).rods == load_scene(other).rods
    for scene_file in (one, other):
        for key in ("centerline", "centreline"):
            assert load_scene(scene_file, [f"rods.0.{key}=bowline"]).rods[0].centerline == "bowline"
            assert load_scene(scene_file, {f"rods.rod.{key}": "bowline"}).rods[0].centerline == "bowline"
    rod = tomllib.loads(other.read_text())["rods"][0]
    assert load_scene("overhand", {"rods": [rod]}).rods == load_scene(one).rods
    assert rod["centreline"] == "overhand"
    other.write_text(MINIMAL.replace("centerline =", 'centreline = "bowline"\ncenterline ='))
    with pytest.raises(InputError, match=r"other\.toml: rods\.0\.centreline: the same key twice"):
        load_scene(other)


@pytest.mark.parametrize("suffix", CURVE_SUFFIXES)
def test_every_kind_of_curve_file_is_read(tmp_path: Path, suffix: str) -> None:
    points = "0 0 0\n1 0 0\n2 0 0\n3 0 0\n"
    written = {
        ".csv": "x,y,z\n" + points.replace(" ", ","),
        ".tsv": "x\ty\tz\n" + points.replace(" ", "\t"),
        ".txt": points,
        ".xyz": points,
        ".dat": points,
        ".obj": "".join(f"v {line}\n" for line in points.splitlines()),
        ".vect": f"VECT\n1 4 0\n4\n0\n{points}",
        ".json": '{"points": [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], "order_u": 4, "use_endpoint_u": true}',
        ".toml": "points = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]\norder_u = 4\nuse_endpoint_u = true\n",
    }
    curve = tmp_path / f"mine{suffix}"
    curve.write_text(written[suffix])
    scene = load_scene("cantilever", [f"rods.0.centerline={curve}"])
    (line,) = centrelines_of(scene)
    assert line.points[:, 0] == pytest.approx([80.0 * i / line.slices.count for i in range(line.slices.count + 1)])
    assert set(written) == set(CURVE_SUFFIXES) == {*READERS, *NURBS_SUFFIXES}


def test_a_curve_file_of_another_kind_is_not_taken_for_a_shipped_name(tmp_path: Path, monkeypatch) -> None:
    """A suffix in capitals is none other; a file without a suffix, or with an unknown one, is refused as a file."""
    monkeypatch.chdir(tmp_path)
    for name in ("MINE.CSV", "mine.stl", "mine"):
        (tmp_path / name).write_bytes(shipped.centreline_path("overhand").read_bytes())
    assert load_scene("overhand", ["rods.0.centerline=MINE.CSV"]).rods[0].curve_file == tmp_path / "MINE.CSV"
    for name in ("mine.stl", "mine"):
        with pytest.raises(InputError, match=r"unknown kind of centreline file; found .*/mine"):
            load_scene("overhand", [f"rods.0.centerline={name}"])
    with pytest.raises(InputError, match=r"no such file.*found .*/absent\.step"):
        load_scene("overhand", ["rods.0.centerline=absent.step"])


@pytest.mark.parametrize(
    ("scales", "message"),
    [
        ({"hitch": "rope"}, "no rod has this name"),
        ({"hitch": "hitch"}, "takes its scale from another"),
        ({"hitch": "bight", "bight": "hitch"}, "takes its scale from another"),
        ({"hitch": 0.0}, "greater than 0"),
    ],
)
def test_a_scale_is_a_factor_or_another_rod(scales: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scene("sheet-bend", {f"rods.{rod}.scale": scale for rod, scale in scales.items()})


REFUSED = [
    ("contact.frictoin=0.3", "contact.frictoin", 'unknown key; expected "friction"'),
    ("rods.0.mesh.elment_length=2 mm", "rods.0.mesh.elment_length", 'expected "element_length"'),
    ("contact.friction=-0.1", "contact.friction", "found -0.1; expected greater than or equal to 0"),
    ("contact.friction=nan", "contact.friction", "finite"),
    ("contact.friction=yes", "contact.friction", "valid number"),
    ("contact.enabled=1", "contact.enabled", "boolean"),
    ("contact=3", "contact", "expected a table"),
    ("rods.0.length=500", "rods.0.length", "a bare number, its unit is missing; found 500; expected a length"),
    ("rods.0.length=5 MPa", "rods.0.length", '"MPa" measures something else'),
    ("rods.0.length=none", "rods.0.length", "missing key; expected a length"),
    ("rods.0.length=5 mm", "rods.0.length", "shorter than it is thick"),
    ("rods.0.diameter=0 mm", "rods.0.diameter", "out of range"),
    ("rods.0.material.youngs_modulus=-1 MPa", "rods.0.material.youngs_modulus", "out of range"),
    ("rods.0.material.density=0 kg/m^3", "rods.0.material.density", "out of range"),
    ("rods.0.material.bulk_over_shear=0.5", "rods.0.material.bulk_over_shear", "greater than 0.666"),
    ("rods.0.core.radius=3 mm", "rods.0.core.radius", "as thick as the rod"),
    ("rods.0.mesh.element_length=500 mm", "rods.0.mesh.element_length", "too long"),
    ("rods.0.mesh.turning_angle=0", "rods.0.mesh.turning_angle", "found 0; expected greater than 0"),
    ("rods.0.mesh.turning_angle=5 deg", "rods.0.mesh.turning_angle", "valid number"),
    ("rods.0.mesh.section_elements=12.5", "rods.0.mesh.section_elements", "integer"),
    ("rods.0.mesh.element=hex9", "rods.0.mesh.element", '"hex8"'),
    ("rods.0.centerline=bowlin", "rods.0.centerline", '"bowline"'),
    ("rods.0.centreline=bowlin", "rods.0.centerline", '"bowline"'),
    ("rods.0.centerline=nowhere.csv", "rods.0.centerline", "no such file"),
    ("rods.0.name=a/b", "rods.0.name", "not a name"),
    ("rods=[]", "rods", "at least 1 item"),
    ("rods=3", "rods", "expected a list"),
    ("rods.1.length=5 mm", "rods.1", "no such entry"),
    ("rods.first.length=5 mm", "rods.first", "no such entry"),
    ("rods.0.length.mm=5", "rods.0.length.mm", "no table here"),
    ("obstacles.0.axis=[0, 0, 0]", "obstacles.0.axis", "no length"),
    ("obstacles.0.axis=[0, 1]", "obstacles.0.axis", "too few"),
    ("obstacles.0.name=rod", "obstacles", "share a name"),
    ("contact.pairs=[{between=['rod', 'cylindre'], friction=0}]", "contact.pairs.0.between", '"cylinder"'),
    ("contact.pairs=[{between=['cylinder', 'cylinder'], friction=0}]", "contact.pairs.0.between", "at least one rod"),
    ("model=beam", "model", "one of fem, rod"),
    ("solver.linear=dense", "solver.linear", "one of auto, pardiso, superlu"),
    ("steps.1.kind=pul", "steps.1.kind", '"pull"'),
    ("steps.1.kind=none", "steps.1.kind", "missing key"),
    ("steps.1.ends.rod.start=none", "steps.1.ends", "no end is driven"),
    ("steps.1.ends.rod.start.motion=drivn", "steps.1.ends.rod.start.motion", '"driven"'),
    ("steps.1.ends.rod.start.direction=none", "steps.1.ends.rod.start.direction", "missing key"),
    ("steps.1.ends.rope.end={motion='free'}", "steps.1.ends.rope", "no rod has this name"),
    ("steps.0.ends.rod.start={motion='driven', direction=[0, 0, 1]}", "steps.0.ends.rod.start", "only a pull"),
    ("steps.0={kind='load', duration='1 s'}", "steps.0.ends", "no end is loaded"),
    (
        "steps.0.friction_schedule=[{time='1 s', friction=0.1}, {time='1 s', friction=0}]",
        "steps.0.friction_schedule",
        "do not rise",
    ),
]


@pytest.mark.parametrize("model", ["fem", "rod"])
@pytest.mark.parametrize(
    ("override", "found"),
    [
        ("contact.enabled=false", "contact.enabled = false"),
        ("contact.friction=0", "contact.friction = 0"),
        ("contact.pairs=[{between=['rod', 'rod'], friction=0}]", "no friction between rods"),
    ],
)
def test_friction_schedule_needs_friction_to_scale(model: str, override: str, found: str) -> None:
    schedule = "steps.1.friction_schedule=[{time='1 s', friction=0.1}]"
    error = refused("overhand", f"model={model}", override, schedule)
    assert error.key == "steps.1.friction_schedule"
    assert error.found == found


@pytest.mark.parametrize(("override", "key", "text"), REFUSED)
def test_refuses_naming_the_override(override: str, key: str, text: str) -> None:
    error = refused("bowline", override)
    assert error.key == key
    assert str(error.file) == "overrides"
    assert text in str(error)
    assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("override", "key", "text"),
    [
        ("steps.pull.displacement=20", "steps.pull.displacement", "found 20"),
        ("steps.pull.displacment='20 mm'", "steps.pull.displacment", "unknown key"),
        ("steps.pull.displacement.a.b=1", "steps.pull.displacement.a", "no table here"),
        ("rods.rod.length=5", "rods.rod.length", "found 5"),
        ("rods.rod.mesh.element_length=5", "rods.rod.mesh.element_length", "found 5"),
        ("steps.pull={kind='pull'}", "steps.pull.displacement", "missing key"),
    ],
)
def test_refuses_an_override_in_its_own_words(override: str, key: str, text: str) -> None:
    error = refused("bowline", override)
    assert str(error).startswith(f"overrides: {key}: ")
    assert text in str(error)


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (["rods.0.diameter='6 m'"], "overrides: rods.0.diameter: makes rods.0.length wrong: shorter than it is thick"),
        (
            ["contact.friction=0.2", "rods.rod.diameter='6 m'", "model=rod"],
            "overrides: rods.rod.diameter: makes rods.0.length wrong: shorter than it is thick; found 600 mm",
        ),
        (["rods.0.diameter='0.1 mm'"], "overrides: rods.0.diameter: makes rods.0.core.radius wrong: the core is as"),
    ],
)
def test_an_override_that_makes_another_key_wrong_is_named(overrides: list[str], said: str) -> None:
    assert str(refused("bowline", *overrides)).startswith(said)


def test_what_is_wrong_in_the_file_itself_is_not_blamed_on_an_override(scene_file: Path) -> None:
    scene_file.write_text(MINIMAL.replace('"6 mm"', "6"))
    assert str(refused(scene_file, "contact.friction=0.2")).startswith(f"{scene_file}: rods.0.diameter: a bare")


def test_one_override_may_come_as_a_text() -> None:
    assert load_scene("bowline", "contact.friction=0.2").contact.friction == 0.2
    with pytest.raises(InputError, match=r'^overrides: not an override; found "contact\.friction"'):
        load_scene("bowline", "contact.friction")
    with pytest.raises(InputError, match=r"^overrides: contact\.fricton: unknown key"):
        load_scene("bowline", {"contact.fricton": 0.3})


def test_refuses_naming_the_file(scene_file: Path) -> None:
    scene_file.write_text(MINIMAL.replace('"6 mm"', "6"))
    error = refused(scene_file)
    assert (str(error.file), error.key, error.found) == (str(scene_file), "rods.0.diameter", "6")
    assert error.exit_code == 3


def test_says_what_else_is_wrong(scene_file: Path) -> None:
    scene_file.write_text(MINIMAL.replace('"6 mm"', "6").replace('"2 mm"', "2"))
    assert "rods.0.mesh.element_length: a bare number" in str(refused(scene_file)).splitlines()[1]


@pytest.mark.parametrize("override", ["gravity", "=3", "a..b=1", ""])
def test_refuses_what_is_no_override(override: str) -> None:
    assert "not an override" in str(refused("bowline", override))


def test_refuses_two_rods_of_one_name(scene_file: Path) -> None:
    scene_file.write_text(MINIMAL + MINIMAL)
    error = refused(scene_file)
    assert error.key == "rods.1.name"
    assert "used twice" in str(error)


def test_refuses_two_steps_of_one_name() -> None:
    assert "used twice" in str(refused("bowline", "steps.0.name=a", "steps.1.name=a"))


def test_unnamed_steps_get_names_of_their_own() -> None:
    step = "{kind='hold', duration='1 s'}"
    scene = load_scene("bowline", [f"steps=[{step}, {{kind='hold', name='hold', duration='1 s'}}, {step}]"])
    assert [step.name for step in scene.steps] == ["hold-2", "hold", "hold-3"]


def test_refuses_files_that_are_no_scene(tmp_path: Path) -> None:
    broken = tmp_path / "broken.toml"
    broken.write_text("[[rods]\n")
    assert "not a TOML file" in str(refused(broken))
    broken.write_bytes(b"\xff\xfe\x00")
    assert "not a TOML file" in str(refused(broken))
    assert "no such file" in str(refused(tmp_path / "none.toml"))
    assert "a directory" in str(refused(tmp_path))
    assert '"bowline"' in str(refused("bowlin"))
    broken.write_text("")
    assert refused(broken).key == "rods"


@pytest.mark.parametrize("name", shipped.scene_names())
def test_the_written_scene_is_the_same_scene(name: str, tmp_path: Path) -> None:
    scene = load_scene(name)
    path = tmp_path / "scene.toml"
    path.write_text(scene_to_toml(scene))
    assert load_scene(path) == scene
    assert load_scene(scene, {"description": scene.description}) == scene


def test_every_default_is_written(scene_file: Path) -> None:
    text = scene_to_toml(load_scene(scene_file))
    for key in ("model", "stiffness_over_modulus", "threshold", "force_tolerance", "checkpoint_every", "gamma"):
        assert f"\n{key} = " in text


vectors = st.tuples(*[st.floats(min_value=-1e3, max_value=1e3)] * 3).filter(any)


@settings(deadline=None)
@given(
    length=st.floats(min_value=10.0, max_value=1e6),
    modulus=st.floats(min_value=1e-2, max_value=1e7),
    density=st.floats(min_value=1e-2, max_value=1e5),
    friction=st.floats(min_value=0.0, max_value=10.0),
    axis=vectors,
    angle=st.floats(min_value=-10.0, max_value=10.0),
    acceleration=st.floats(min_value=1e-9, max_value=1e4),
    text=st.text(max_size=30),
)
def test_any_scene_survives_writing(
    tmp_path_factory: pytest.TempPathFactory,
    length: float,
    modulus: float,
    density: float,
    friction: float,
    axis: tuple[float, float, float],
    angle: float,
    acceleration: float,
    text: str,
) -> None:
    base = load_scene("bowline").model_dump(mode="json", exclude_none=True)
    base["description"] = text
    base["rods"][0]["length"] = f"{length!r} mm"
    base["rods"][0]["rotation"] = {"axis": axis, "angle": f"{angle!r} rad"}
    base["rods"][0]["material"] |= {"youngs_modulus": f"{modulus!r} MPa", "density": f"{density!r} kg/m^3"}
    base["contact"]["friction"] = friction
    base["gravity"] = {"acceleration": f"{acceleration!r} m/s^2", "direction": axis}
    scene = Scene.model_validate(base)
    path = tmp_path_factory.getbasetemp() / "any.toml"
    path.write_text(scene_to_toml(scene), encoding="utf-8")
    assert load_scene(path) == scene
    assert load_scene(scene, {"contact.friction": friction}) == scene


def test_friction_of_two_rods() -> None:
    scene = load_scene("crossed-rods", ["contact.friction=0.25"])
    assert scene.friction_between("lower", "upper") == scene.friction_between("upper", "upper") == 0.25
    scene = load_scene("crossed-rods", ["contact.pairs=[{between=['upper', 'lower'], friction=0.1}]"])
    assert scene.friction_between("lower", "upper") == 0.1
    assert scene.friction_between("lower", "lower") == 0.33


def test_steps_of_hexahedra_are_not_too_long() -> None:
    error = refused("overhand", "solver.move_over_diameter=4")
    assert "solver.move_over_diameter: steps too long; found 4; expected at most 1.333" in str(error)
    assert load_scene("overhand", ["solver.move_over_diameter=4", "model=rod"]).solver.move_over_diameter == 4.0


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("rods.0.mesh.element_length=0.00001 mm", r"rods\.0\.mesh\.element_length: too many slices"),
        ("output.every_displacement=1e-15 mm", r"output\.every_displacement: too many outputs"),
        (
            "steps.pull.displacement=60 km",
            r"found 3 mm; expected at least 60 mm, since pull has a displacement of 6e\+07 mm",
        ),
        (
            "solver.force_tolerance=1e-300 N",
            r"solver\.force_tolerance: as small as rounding errors; found 1e-300 N; expected at least 1e-14 N",
        ),
        (
            'contact.pairs=[{between=["rod","rod"],friction=0.1},{between=["rod","rod"],friction=0.5}]',
            r"contact\.pairs\.1\.between: used twice",
        ),
    ],
)
def test_what_no_machine_holds_or_no_one_can_mean_is_refused(override: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scene("overhand", [override])


def test_a_byte_order_mark_is_no_statement(tmp_path: Path) -> None:
    path = tmp_path / "marked.toml"
    path.write_bytes(b"\xef\xbb\xbf" + shipped.scene_path("overhand").read_bytes())
    assert load_scene(path).rods == load_scene("overhand").rods


def test_all_that_is_wrong_is_said_at_once(tmp_path):
    file = tmp_path / "bad.toml"
    file.write_text(
        '[[rods]]\ncentreline="overhand"\ndiametre="6 mm"\n[rods.material]\nyoungs_modulus="1.4"\n'
        '[rods.mesh]\nsection_elements=2\n[contact]\nfriction=-1.0\n[[steps]]\nkind="pull"\n[[steps]]\nkind="tug"\n'
    )
    with pytest.raises(SeveralErrors) as caught:
        load_scene(file)
    found = {error.key: error.problem for error in caught.value.errors}
    assert found == {
        "rods.0.diametre": "unknown key",
        "rods.0.length": "missing key",
        "rods.0.diameter": "missing key",
        "rods.0.material.density": "missing key",
        "rods.0.material.youngs_modulus": "a bare number, its unit is missing",
        "rods.0.mesh.element_length": "missing key",
        "rods.0.mesh.section_elements": "wrong value",
        "contact.friction": "wrong value",
        "steps.0.displacement": "missing key",
        "steps.1.kind": "unknown choice",
    }
    assert str(caught.value).count("\n") == len(found) - 1
