"""Run directories: where a run keeps its scene, tables, checkpoints and status."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from knotfem.errors import OVERRIDES, InputError, InUse, cannot_write
from knotfem.files import PART_SUFFIX, held, read_json, write_atomically, write_json
from knotfem.run.checkpoint import CheckpointStore
from knotfem.run.colours import COLOURS, OLDER
from knotfem.run.fingerprint import (
    SETTINGS,
    check_fingerprint,
    fingerprint,
    first_difference,
    scene_difference,
)
from knotfem.run.process import has_gone, this_process
from knotfem.run.provenance import timestamp
from knotfem.scene.load import Overrides, load_scene
from knotfem.scene.model import Scene
from knotfem.scene.write import scene_to_toml
from knotfem.shipped import scene_names

State = Literal["running", "done", "failed", "stopped"]

TIED = "tied"
"""Name of the checkpoint at the end of tying, which stays."""
SOURCE = "source.json"
"""Name of the file that keeps the state of another run from which this one sets out."""

_SCENE, _TIE = "scene.toml", "tie.csv"
_FORCE = "force.csv"
_SERIES = (_TIE, _FORCE, "events.csv", "tension.csv", "twist.csv", "contacts.csv", "results.vtkhdf", SOURCE)
_RECORDS = ("provenance.json", "status.json", "summary.json", "log.jsonl")
_PLOTS = tuple(f"{name}.png" for name in ("stretch", "force", "tension"))
_PICTURES = tuple(f"knot-{colour}.png" for colour in (*COLOURS, *OLDER))
_FILES = (*_SERIES, *_RECORDS, *_PLOTS, *_PICTURES, _SCENE)


class RunDirectory:
    """The files of one run; every one is whole at any time.

    Attributes:
        path: the folder.
    """

    def __init__(self, path: Path) -> None:
        """Take a folder as it is; see `create` and `open`."""
        self.path = path

    @classmethod
    def create(cls, scene: Scene, path: Path | None = None, *, force: bool = False) -> RunDirectory:
        """Make the folder of a new run and write its scene.

        Args:
            scene: resolved.
            path: the folder; by default runs/<scene>-<n> with the first free n.
            force: replace a run that is there already.

        Raises:
            InputError: the folder holds a run (without `force`) or something else, or cannot be written.
        """
        try:
            run = cls(_make_folder(path, force) if path is not None else _make_default(scene.name))
        except OSError as error:
            raise cannot_write(Path(error.filename or path or "runs"), error) from error
        try:
            write_atomically(run.scene_file, scene_to_toml(scene))
        except InputError:
            with suppress(OSError):
                run.path.rmdir()
            raise
        return run

    @classmethod
    def means_run(cls, source: str | Path) -> bool:
        """Whether a source means a run, not a scene: its folder, or one that has not the name of a shipped scene."""
        return cls.is_run(source) or (Path(source).is_dir() and str(source) not in scene_names())

    @classmethod
    def open(cls, path: str | Path) -> RunDirectory:
        """Take the folder of an existing run.

        Raises:
            InputError: no run is there.
        """
        run = cls(Path(path))
        if not cls.is_run(run.path):
            problem = "no run is in this folder" if run.path.is_dir() else "no such run"
            raise InputError(problem, file=path, expected=f"a run directory, with its {_SCENE}")
        return run

    def spare(self, output: Path) -> None:
        """Refuse to write a result over a file that the run itself lives on.

        Raises:
            InputError: it would be.
        """
        place = output.resolve()
        if place.parent == self.path.resolve() and place.name in (*_SERIES, *_RECORDS, _SCENE):
            raise InputError("the run's own file", file=output, expected="another name or folder")

    @staticmethod
    def is_run(path: str | Path) -> bool:
        """Whether a folder holds a run."""
        return (Path(path) / _SCENE).is_file()

    @staticmethod
    def shadowed(source: str | Path) -> str | None:
        """A sentence for the user where a run hides the shipped scene of the same name, or None."""
        if str(source) not in scene_names() or not RunDirectory.is_run(source):
            return None
        cure = "for the scene, work in another folder or rename the run"
        return f"{source}: the run directory {source}, not the shipped scene of this name; {cure}"

    def branch(self, scene: Scene, path: Path | None = None, *, force: bool = False) -> RunDirectory:
        """A new run that goes on from this one's tied knot with other steps or effects.

        It takes over tables and series but the table of forces, which begins with what loads the knot; whoever goes on
        cuts them back to the tied knot, as after any checkpoint.

        Args:
            scene: may differ in whatever does not change the tied rods; friction may.
            path: as for `create`.
            force: as for `create`.

        Raises:
            InputError: this run is not tied, the scene would tie another knot, or as `create`.
        """
        tied = self.tied_checkpoint()
        self.check_branch(self.scene, scene, self.path)
        run = RunDirectory.create(scene, path, force=force)
        for name in _SERIES:
            if name != _FORCE and (self.path / name).exists():
                write_atomically(run.path / name, (self.path / name).read_bytes())
        run.checkpoints.adopt(tied, fingerprint=fingerprint(scene))
        return run

    def check_scene(self) -> None:
        """Refuse to take results for those of a scene that has been changed since.

        Raises:
            InputError: the first key that differs from those that the newest checkpoint was computed from.
        """
        check_fingerprint(self.checkpoints.metadata().get("fingerprint"), self.scene, self.scene_file)

    @staticmethod
    def check_branch(tied: Scene, scene: Scene, path: Path | None) -> None:
        """Refuse a scene that would tie another knot than a run did.

        Args:
            tied: scene of the run.
            scene: to go on with.
            path: of the run, for the message.

        Raises:
            InputError: what differs.
        """
        found = first_difference(_fixed_by_tying(tied), _fixed_by_tying(scene))
        if found is not None:
            expected = f"{found.before}, or a run of its own"
            raise InputError("differs from the tied run", file=path, key=found.key, found=found.now, expected=expected)

    def override(self, overrides: Overrides) -> None:
        """Compute from here on with other settings, which leave what is computed as it is; scene.toml stays.

        Args:
            overrides: as for `load_scene`, of keys under solver and output.

        Raises:
            InputError: an override of something else.
        """
        changed = load_scene(self.scene_file, overrides)
        found = scene_difference(self.scene, changed)
        if found is not None:
            expected = f"a key of {' or '.join(SETTINGS)}: the rest of a run stays, start another with -o"
            problem = "cannot change in a run"
            raise InputError(problem, file=OVERRIDES, key=found.key, found=found.now, expected=expected)
        self.scene = changed

    @property
    def tied(self) -> bool:
        """Whether the knot is tied, so that steps can follow."""
        return self.checkpoints.named(TIED) is not None

    def tied_checkpoint(self) -> Path:
        """The file of the tied knot.

        Raises:
            InputError: the knot is not tied yet.
        """
        path = self.checkpoints.named(TIED)
        if path is None:
            expected = "a run that knotfem tie or pull has brought that far"
            raise InputError("not tied yet", file=self.path, expected=expected)
        return path

    @property
    def scene_file(self) -> Path:
        """The file of the resolved scene."""
        return self.path / _SCENE

    @cached_property
    def scene(self) -> Scene:
        """The resolved scene."""
        return load_scene(self.scene_file)

    @cached_property
    def checkpoints(self) -> CheckpointStore:
        """States to go on from."""
        return CheckpointStore(self.path / "checkpoints")

    def write_status(self, state: State, **progress: Any) -> None:
        """Replace status.json.

        Args:
            state: of the run.
            **progress: whatever helps a reader, such as phase, displacement_mm, fraction.
        """
        write_json(self.path / "status.json", {"state": state, "updated": timestamp(), **this_process(), **progress})

    def read_status(self) -> dict[str, Any]:
        """What status.json holds.

        Raises:
            InputError: missing or damaged.
        """
        return read_json(self.path / "status.json")

    @property
    def status(self) -> dict[str, Any]:
        """What status.json holds, empty where there is none or it is damaged; `stopped` if its process has gone."""
        try:
            status = self.read_status()
        except InputError:
            return {}
        gone = {"state": "stopped", "reason": f"process {status.get('pid')} ended without saying why"}
        return {**status, **gone} if has_gone(status) else status

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """Replace summary.json."""
        write_json(self.path / "summary.json", summary)

    def read_summary(self) -> dict[str, Any]:
        """What summary.json holds.

        Raises:
            InputError: missing or damaged.
        """
        return read_json(self.path / "summary.json")

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the run for this process; ends with the process, however that ends.

        Raises:
            InUse: another process is computing the run.
        """
        with held(self._lock_file, InUse("another process is computing this run", file=self.path)):
            for part in self.path.rglob(f".*{PART_SUFFIX}"):
                part.unlink(missing_ok=True)
            yield

    @property
    def _lock_file(self) -> Path:
        """Beside the run, so that the run's folder has nothing but the run, or in it where the place is not ours.

        A process that is killed leaves the file, but not the lock.
        """
        folder = self.path.resolve()
        return folder.with_name(f".{folder.name}.lock") if os.access(folder.parent, os.W_OK) else folder / ".lock"


def _fixed_by_tying(scene: Scene) -> dict[str, Any]:
    steps = "steps before the first that is no relax"
    keys = scene.model_dump(
        mode="json",
        include={"model", "rods", "obstacles", "contact", "tie"},
        exclude={"obstacles": {"__all__": {"friction"}}, "contact": {"friction", "pairs"}},
    )
    tying = {steps: [step.model_dump(mode="json") for step in scene.tying_steps]}
    return {**keys, **tying, "displacement of all pulls, by which slices were chosen": _sliding(scene)}


def _sliding(scene: Scene) -> float | None:
    """How far the rods slide, where the lengths of their slices depend on it [mm]."""
    return None if all(rod.mesh.turning_angle is None for rod in scene.rods) else scene.sliding


def _make_folder(path: Path, force: bool) -> Path:
    if path.exists() and not path.is_dir():
        raise InputError("this is a file", file=path, expected="a folder for the run")
    if path.is_dir() and any(path.iterdir()):
        if not RunDirectory.is_run(path):
            raise InputError("the folder holds other files", file=path, expected="a new or empty folder")
        if not force:
            raise InputError(
                "the folder holds a run already", file=path, expected="another folder, --force, or knotfem resume"
            )
        with RunDirectory(path).locked():
            _clear(path)
    path.mkdir(parents=True, exist_ok=True)
    return path


def _make_default(name: str, root: Path = Path("runs")) -> Path:
    root.mkdir(parents=True, exist_ok=True)
    number = 1
    while True:
        path = root / f"{name}-{number}"
        try:
            path.mkdir()
        except FileExistsError:
            number += 1
        else:
            return path


def _clear(path: Path) -> None:
    """Remove what a run wrote; files that someone else put there stay."""
    for name in _FILES:
        (path / name).unlink(missing_ok=True)
    for plot in path.glob("stretch-*.png"):
        plot.unlink(missing_ok=True)
    shutil.rmtree(path / "checkpoints", ignore_errors=True)
