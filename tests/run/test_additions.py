"""A run that was begun with objects of the user's own goes on with them, and without them not at all."""

import json
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from click.testing import CliRunner

import knotfem as kf
from knotfem.models.base import Additions, Model, TermMaker
from knotfem.models.material import NeoHooke
from knotfem.run.additions import names_of, require
from knotfem.run.directory import RunDirectory
from knotfem.run.stop import StopRequest
from knotfem_cli.main import knotfem_command

BEAM = {
    "model": "rod", "rods.0.mesh.element_length": "8 mm", "rods.0.core": None, "output.fields": False,
    "solver.threads": 1, "gravity": None, "drag": None, "inertia.scheme": "quasi-static",
    "steps": [
        {
            "kind": "pull", "name": "draw", "displacement": "8 mm", "speed": "20 mm/s",
            "ends": {"rod": {"end": {"motion": "driven", "direction": [0.0, 0.0, 1.0]}}},
        }
    ],
}  # fmt: skip
"""Of the scene "cantilever": a rod whose end is driven sideways."""


class Wind(kf.Term):
    """A constant force on all inner nodes."""

    name, role, external = "wind", kf.Role.LOAD, True

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: object) -> bool:
        residual[1:-1, 1] -= 1e-4
        return True

    def merit(self, x: np.ndarray) -> float:
        return -1e-4 * float(x[1:-1, 1].sum())


def wind(model: Model) -> Wind:
    return Wind()


class Floor:
    """The half space below a height."""

    def distance(self, points: np.ndarray) -> np.ndarray:
        return points[:, 2] + 40.0

    def foot(self, points: np.ndarray) -> kf.Foot:
        normal = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        return kf.Foot(self.distance(points), normal, np.zeros((len(points), 3, 3)))


def floor() -> kf.Obstacle:
    return kf.Obstacle(Floor(), 0.2, "floor")


@pytest.fixture
def stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A run with a wind that was stopped amid its pull."""
    left = {"asked": 20}

    def due(self: StopRequest) -> bool:
        left["asked"] -= 1
        return left["asked"] < 0

    with monkeypatch.context() as patch:
        patch.setattr(StopRequest, "due", property(due))
        with pytest.raises(kf.Stopped):
            kf.pull("cantilever", BEAM, terms=[wind], out=tmp_path / "run")
    return tmp_path / "run"


def test_names_say_as_what_objects_are_passed() -> None:
    additions = Additions(
        [wind, Wind(), cast(TermMaker, Wind), lambda model: Wind()], [floor()], {"rod": NeoHooke(1.0)}
    )
    assert names_of(additions) == {
        "terms": ["wind", "wind", "wind", "<lambda>"],
        "obstacles": ["floor"],
        "materials": ["rod: NeoHooke"],
    }
    assert not any(names_of(Additions()).values())


def test_what_is_missing_is_named() -> None:
    begun = {"terms": ["wind", "wind"], "obstacles": ["floor"], "materials": ["rod: Yeoh"]}
    require(begun, begun, None, same=True)
    now = {"terms": ["wind"], "obstacles": [], "materials": ["rod: Gent"]}
    with pytest.raises(kf.InputError) as refused:
        require(begun, now, Path("run"), same=False)
    assert str(refused.value) == (
        "run: objects of your own are missing that the run was begun with: terms=[wind], obstacles=[floor], "
        "materials={rod: Yeoh}; found terms=[wind], materials={rod: Gent}; expected terms=[wind, wind], "
        "obstacles=[floor], materials={rod: Yeoh}, passed to kf.resume or kf.pull"
    )
    more = {**begun, "obstacles": ["floor", "ball"]}
    require(begun, more, None, same=False)
    with pytest.raises(kf.InputError, match=r"the run was begun without obstacles=\[ball\]; expected the same as"):
        require(begun, more, None, same=True)


def test_run_is_resumed_with_its_own_terms_only(stopped: Path, tmp_path: Path) -> None:
    provenance = json.loads((stopped / "provenance.json").read_text())
    assert provenance["additions"] == {"terms": ["wind"], "obstacles": [], "materials": []}
    before = {file.name: file.read_bytes() for file in stopped.iterdir() if file.is_file()}
    for verb in ("resume", "pull"):
        shell = CliRunner().invoke(knotfem_command, [verb, str(stopped)])
        assert shell.exit_code == 3
        assert f"{stopped}: objects of your own are missing that the run was begun with: terms=[wind]" in shell.stderr
        assert "expected terms=[wind], passed to kf.resume or kf.pull" in shell.stderr
    with pytest.raises(kf.InputError, match=r"missing .* terms=\[wind\]; found obstacles=\[floor\]"):
        kf.resume(stopped, obstacles=[floor()])
    with pytest.raises(kf.InputError, match=r"the run was begun without obstacles=\[floor\]"):
        kf.resume(stopped, terms=[wind], obstacles=[floor()])
    assert {file.name: file.read_bytes() for file in stopped.iterdir() if file.is_file()} == before
    resumed = kf.resume(stopped, terms=[Wind()])
    whole = kf.pull("cantilever", BEAM, terms=[wind])
    for name, values in whole.table("force").items():
        assert name == "wall_s" or np.array_equal(values, resumed.table("force")[name]), name
    plain = kf.pull("cantilever", BEAM)
    assert np.abs(plain.table("tension")["y_mm"]).max() < 1e-3 < np.abs(resumed.table("tension")["y_mm"]).max()


@pytest.mark.parametrize("on_disk", [False, True])
def test_tied_rod_is_pulled_with_what_it_was_tied_with_and_more(tmp_path: Path, on_disk: bool) -> None:
    tied = kf.tie("cantilever", BEAM, terms=[wind], out=tmp_path / "tied" if on_disk else None)
    assert tied.additions["terms"] == ["wind"]
    with pytest.raises(kf.InputError, match=r"missing .* terms=\[wind\]; found none"):
        kf.pull(tied)
    with pytest.raises(kf.InputError, match=r"missing .* terms=\[wind\]; found none"):
        next(kf.steps(tied))
    pulled = kf.pull(tied, terms=[wind, Wind()])
    assert pulled.additions["terms"] == ["wind", "wind"]
    if on_disk:
        with pytest.raises(kf.InputError, match=r"missing .* terms=\[wind\]"):
            kf.pull(tied, out=tmp_path / "other")
        assert not (tmp_path / "other").exists()
        other = kf.pull(tied, terms=[wind, Wind()], out=tmp_path / "other")
        assert np.array_equal(other.table("force")["force_N"], pulled.table("force")["force_N"])
        assert other.additions == pulled.additions
        with pytest.raises(kf.InputError, match=r"the run was begun without terms=\[wind\]"):
            kf.pull(tied, terms=[wind, Wind()], out=tied.path)


def test_run_that_never_began_may_be_begun_with_others(tmp_path: Path) -> None:
    run = RunDirectory.create(kf.load_scene("cantilever", BEAM), tmp_path / "run")
    with pytest.raises(kf.InputError, match="obstacles need contact"):
        kf.pull(run.path, obstacles=[floor()], out=run.path)
    assert kf.resume(run.path, terms=[wind]).additions["terms"] == ["wind"]
