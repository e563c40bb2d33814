from dataclasses import replace

import numpy as np
import pytest

from knotfem.errors import InputError, MissingDependency
from knotfem.mesh.rod import RodMesh, extrude
from knotfem.mesh.section_file import read_section
from knotfem.plot import opengl
from knotfem.plot.colour_bar import round_ticks
from knotfem.plot.render import Camera, Cylinder, Look, _limits, render_mesh, show_mesh, zoomed
from knotfem.plot.scale_bar import add_scale_bar, round_length
from knotfem.plot.surface import Surface


@pytest.fixture(scope="module")
def rod(pytestconfig) -> RodMesh:
    return extrude(read_section(pytestconfig.rootpath / "meshes/sections/section_12.msh"), 3.0, 40.0, 20)


def picture(path) -> np.ndarray:
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def draw(rod: RodMesh, out, look: Look, **options) -> np.ndarray | None:
    """The picture; nothing on a machine without OpenGL, which must say so."""
    if opengl.find_window() is None:
        with pytest.raises(MissingDependency, match="apt-get install"):
            render_mesh(rod.nodes, rod.hexes, out, look, **options)
        return None
    render_mesh(rod.nodes, rod.hexes, out, look, **options)
    return picture(out)


def test_a_standing_rod_fills_the_picture_upright_and_coloured_from_low_to_high(rod, tmp_path):
    look = Look(rod.nodes[:, 2], [rod.ring_nodes], colour_map="coolwarm", label="z (mm)")
    pixels = draw(rod, tmp_path / "a.png", look, size=(150, 400), camera=Camera(direction=(0, 1, 0)), title="rod")
    if pixels is None:
        return
    assert pixels.shape == (400, 150, 3)
    middle = pixels[:, 40:70].reshape(400, -1, 3)
    drawn = (middle.min(axis=2) < 200).any(axis=1)
    assert drawn[60:340].all()
    top, bottom = middle[80].mean(axis=0), middle[320].mean(axis=0)
    assert top[0] > top[2]
    assert bottom[2] > bottom[0]


def test_cell_values_colour_as_nodal_ones_and_facets_can_be_drawn(rod, tmp_path):
    cells = rod.nodes[rod.hexes, 2].mean(axis=1)
    smooth = draw(rod, tmp_path / "a.png", Look(cells, [rod.ring_nodes]), size=(120, 200))
    facets = draw(rod, tmp_path / "b.png", Look(cells, limits=(0.0, 40.0)), size=(120, 200))
    if smooth is not None and facets is not None:
        assert np.abs(smooth - facets).mean() < 12
        assert (smooth != facets).any()


def test_a_cylinder_is_drawn_grey(rod, tmp_path):
    bare = draw(rod, tmp_path / "a.png", Look(rings=[rod.ring_nodes]), size=(200, 200))
    cylinder = Cylinder((10.0, 0.0, 20.0), (0.0, 1.0, 0.0), 5.0)
    with_it = draw(rod, tmp_path / "b.png", Look(rings=[rod.ring_nodes], cylinders=[cylinder]), size=(200, 200))
    if bare is None or with_it is None:
        return
    added = (np.abs(bare - with_it).max(axis=2) > 20) & (np.ptp(with_it, axis=2) < 25)
    assert 100 < added.sum() < 4000


def test_an_endless_cylinder_reaches_as_far_as_the_rods_lie_around_it():
    line = np.column_stack([np.zeros(401), np.linspace(-20, 20, 401), np.linspace(-20, 20, 401)])
    centre, axis, length = Cylinder((0, 3, 0), (0, 2, 0), 5.0).extent(line)
    np.testing.assert_array_equal(axis, [0, 1, 0])
    np.testing.assert_allclose(centre, 0.0, atol=1e-12)
    assert length == pytest.approx(2 * 9.9 + 5.0)
    assert Cylinder((99, 0, 0), (0, 1, 0), 5.0).extent(line)[2] == 15.0
    assert Cylinder((0, 0, 0), (0, 1, 0), 5.0, 7.0).extent(line)[2] == 7.0


def test_zooming_shows_the_target_larger(rod, tmp_path):
    far = draw(rod, tmp_path / "a.png", Look(rings=[rod.ring_nodes]), size=(100, 100))
    camera = zoomed(Camera(), rod.nodes[rod.axis_nodes[8:12]], 3.0)
    near = draw(rod, tmp_path / "b.png", Look(rings=[rod.ring_nodes]), size=(100, 100), camera=camera)
    if far is not None and near is not None:
        assert (near.min(axis=2) < 200).sum() > 2 * (far.min(axis=2) < 200).sum()


def test_zoom_enlarges_about_the_middle(rod, tmp_path):
    options = {"size": (100, 100), "camera": Camera(zoom=3.0)}
    far = draw(rod, tmp_path / "a.png", Look(rings=[rod.ring_nodes]), size=(100, 100))
    near = draw(rod, tmp_path / "b.png", Look(rings=[rod.ring_nodes]), **options)
    if far is not None and near is not None:
        assert (near.min(axis=2) < 200).sum() > 2 * (far.min(axis=2) < 200).sum()


def test_rods_do_not_end_at_the_colour_bar(rod, tmp_path):
    look = Look(rod.nodes[:, 2], [rod.ring_nodes], label="z (mm)")
    camera = Camera(direction=(0, 1, 0), up=(1, 0, 0), zoom=3.0)
    pixels = draw(rod, tmp_path / "a.png", look, size=(300, 200), camera=camera)
    if pixels is not None:
        assert pixels[95:105, -3:].mean() < 240
        assert (pixels[95:105, -3:] > 180).all()


@pytest.mark.parametrize(
    ("ends", "ticks"),
    [
        ((0.0, 14.97), [0.0, 5.0, 10.0]),
        ((-0.0445, 0.529), [0.0, 0.2, 0.4]),
        ((-0.00461, 0.00461), [-0.004, -0.002, 0.0, 0.002, 0.004]),
        ((0.0, 1.0), [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]),
    ],
)
def test_ticks_of_the_colour_bar_are_round(ends, ticks):
    assert round_ticks(*ends) == pytest.approx(ticks)


def test_rounding_at_the_ends_of_the_colours_is_zero():
    points = np.zeros((3, 3))
    for low, high in ((1.4e-13, 0.5), (-1e-9, 0.5), (-0.5, 3e-8)):
        values = np.array([low, 0.5 * (low + high), high])
        found = _limits([Surface(points, np.zeros((0, 4), dtype=int), values)])
        assert found == ((0.0, 0.5) if high == 0.5 else (-0.5, 0.0))
    assert _limits([Surface(points, np.zeros((0, 4), dtype=int), np.array([0.1, 0.2, 0.3]))]) == (0.1, 0.3)


def test_rods_in_a_window_share_their_colours_and_stand_beside_endless_cylinders(rod, monkeypatch):
    import pyvista

    shown = []
    monkeypatch.setattr(opengl, "find_window", lambda: "default")
    monkeypatch.setattr(pyvista.Plotter, "show", lambda plotter: shown.append(plotter) or "viewer")
    halves = [rod.ring_nodes[:11], rod.ring_nodes[10:]]
    cylinder = Cylinder((8.0, 0.0, 20.0), (0.0, 1.0, 0.0), 5.0)
    look = Look(rod.nodes[:, 2], halves, label="z (mm)")
    assert show_mesh(rod.nodes, rod.hexes, replace(look, cylinders=[cylinder])) == "viewer"
    *rods, obstacle = (actor.mapper for actor in shown[0].actors.values() if hasattr(actor.mapper, "dataset"))
    assert [mapper.scalar_range for mapper in rods] == [pytest.approx((0.0, 40.0))] * 2
    assert np.ptp(obstacle.dataset.points[:, 1]) == pytest.approx(cylinder.extent(rod.nodes)[2], abs=0.2)
    assert list(shown[0].scalar_bars.keys()) == ["z (mm)"]
    show_mesh(rod.nodes, rod.hexes, replace(look, limits=(-50.0, 50.0)))
    assert {actor.mapper.scalar_range for actor in shown[1].actors.values() if hasattr(actor.mapper, "dataset")} == {
        (-50.0, 50.0)
    }


def test_refusals_come_before_any_drawing(rod, tmp_path):
    with pytest.raises(InputError, match=r"found \.jpg; expected \.png"):
        render_mesh(rod.nodes, rod.hexes, tmp_path / "a.jpg")
    with pytest.raises(InputError, match="scalars do not fit"):
        render_mesh(rod.nodes, rod.hexes, tmp_path / "a.png", Look(np.zeros(7)))
    assert list(tmp_path.iterdir()) == []


def test_without_opengl_the_message_names_the_cure(rod, tmp_path, monkeypatch):
    monkeypatch.setattr(opengl, "find_window", lambda: None)
    with pytest.raises(MissingDependency, match="apt-get install libegl1"):
        render_mesh(rod.nodes, rod.hexes, tmp_path / "a.png")
    with pytest.raises(MissingDependency, match="apt-get install libegl1"):
        show_mesh(rod.nodes, rod.hexes)


def test_a_window_that_crashes_is_not_chosen(monkeypatch):
    monkeypatch.setattr(opengl, "_DRAW", "import os; os.abort()")
    monkeypatch.setattr("sys.platform", "linux")
    assert opengl.find_window.__wrapped__() is None
    monkeypatch.setattr(opengl, "_DRAW", "import os; print('drawn by', os.environ['VTK_DEFAULT_OPENGL_WINDOW'])")
    monkeypatch.delenv("VTK_DEFAULT_OPENGL_WINDOW", raising=False)
    assert opengl.find_window.__wrapped__() == "vtkEGLRenderWindow"


def test_scale_bar_is_as_long_as_it_says(rod, tmp_path, monkeypatch):
    from knotfem.plot import render

    assert [round_length(most) for most in (0.0199, 0.02, 4.99, 5.0, 1.0, 730.0)] == [0.01, 0.02, 2.0, 5.0, 1.0, 500.0]
    lengths = []
    monkeypatch.setattr(render, "add_scale_bar", lambda *given: lengths.append((add_scale_bar(*given), given[1])))
    camera = Camera(direction=(0, 1, 0), up=(1, 0, 0))
    pixels = draw(rod, tmp_path / "a.png", Look(rings=[rod.ring_nodes]), size=(1400, 600), camera=camera)
    if pixels is None:
        return
    ((length, mm_per_pixel),) = lengths
    corner = pixels[560:, : int(length / mm_per_pixel) + 20].max(axis=2)
    row = corner[(corner < 200).sum(axis=1).argmax()]
    assert (row < 200).sum() == pytest.approx(length / mm_per_pixel, abs=4)
    rod_columns = np.flatnonzero((pixels[:540].min(axis=2) < 200).any(axis=0))
    assert np.ptp(rod_columns) * mm_per_pixel == pytest.approx(40.0, abs=0.5)
