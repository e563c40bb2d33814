"""The run directory that a search for an accuracy leaves: a copy of the run that it chose, whole or not there."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from knotfem.errors import InputError, cannot_write
from knotfem.files import PART_SUFFIX, unfinished, write_atomically
from knotfem.results.data import open_run
from knotfem.results.figures import RunFigures
from knotfem.results.run import Run
from knotfem.run.directory import RunDirectory
from knotfem.scene.control import Accuracy
from knotfem.scene.write import scene_to_toml


def check_place(out: Path, folder: Path, *, force: bool) -> None:
    """Refuse a place that holds something else, before anything is computed.

    The result of an earlier search in the same folder is replaced.

    Args:
        out: where the result is to go.
        folder: of the search's runs.
        force: whether any run may be replaced.

    Raises:
        InputError: a file, other files, or another run.
    """
    if out.exists() and not out.is_dir():
        raise InputError("this is a file", file=out, expected="a folder for the run")
    if not out.is_dir() or not any(out.iterdir()):
        return
    if not RunDirectory.is_run(out):
        raise InputError("the folder holds other files", file=out, expected="a new or empty folder")
    if not force and _searched_in(out) != str(folder.resolve()):
        raise InputError("the folder holds a run already", file=out, expected="another folder, or --force")


def _searched_in(out: Path) -> str | None:
    with suppress(InputError):
        block = RunDirectory(out).read_summary().get("accuracy")
        return block.get("folder") if isinstance(block, Mapping) else None
    return None


def deliver(chosen: RunDirectory, out: Path, block: Mapping[str, Any]) -> Run:
    """Copy a run, with what is known of its accuracy in its scene, summary and force curve.

    Args:
        chosen: the run.
        out: the folder of the copy; a run there is replaced.
        block: the table `accuracy` of summary.json.

    Raises:
        InputError: it cannot be written.
        InUse: another process computes the run that is there.
    """
    out = out.resolve()
    part, old = unfinished(out), unfinished(out.with_name(f"{out.name}.old"))
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        shutil.copytree(chosen.path, part, ignore=shutil.ignore_patterns("*.lock", f"*{PART_SUFFIX}"))
        _annotate(RunDirectory(part), out.name, block)
        with RunDirectory(out).locked():
            if out.exists():
                out.replace(old)
            part.replace(out)
    except OSError as error:
        raise cannot_write(Path(error.filename or out), error) from error
    finally:
        shutil.rmtree(part, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)
    return open_run(out)


def _annotate(run: RunDirectory, name: str, block: Mapping[str, Any]) -> None:
    """Put the accuracy into a copy, and draw its figures."""
    scene = run.scene
    if block["estimate"] is not None:
        known = Accuracy(
            wanted=block["target"],
            measured=block["estimate"],
            quantity=block["quantity"],
            scene=scene.name,
            level=block["level"],
        )
        scene = scene.model_copy(update={"accuracy": known})
    write_atomically(run.scene_file, scene_to_toml(scene))
    run.write_summary({**run.read_summary(), "accuracy": dict(block)})
    RunFigures().finished(RunDirectory(run.path), name)
