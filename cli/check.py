"""`knotfem check`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

import knotfem as kf
from knotfem_cli.common import (
    Verb,
    from_option,
    last_option,
    model_option,
    rope_option,
    scene_for,
    shared_options,
    with_model,
)
from knotfem_cli.text import Sentences, facts, spoken, width_of


@click.command(cls=Verb)
@click.argument("scene")
@model_option
@from_option
@last_option
@rope_option
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write the resolved scene: a .toml file.")
@shared_options
def check(
    scene: str,
    model: str | None,
    from_run: str | None,
    last: bool,
    rope: tuple[str, ...],
    output: Path | None,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Validate a scene and say what it would take; run nothing.

    Prints the resolved scene with every default, the effects that will run and those that will not, degrees of
    freedom, expected memory and time. With --quiet, only whether the scene is right. With
    -o the resolved scene goes into a file, for any verb that takes one.

    \b
    Example:
      knotfem check bowline --set 'rods.0.mesh.element_length=1 mm'
      knotfem check bowline --rope diameter="10 mm" friction=0.25 -o mine.toml
    """
    from knotfem.errors import InputError
    from knotfem.files import write_atomically
    from knotfem.scene import scene_to_toml

    if output is not None and output.suffix.lower() != ".toml":
        found = output.suffix or "no suffix"
        raise InputError("not the name of a scene's file", key="--output", file=output, found=found, expected=".toml")
    resolved = scene_for(scene, with_model(overrides, model, from_run, last), rope)
    found = kf.check(resolved)
    if resolved.rope is not None:
        found["rope"] = str(resolved.rope)
    if output is not None:
        write_atomically(output, scene_to_toml(resolved))
    if log_format == "json":
        click.echo(json.dumps({"scene": resolved.model_dump(mode="json"), **found}))
    elif not quiet:
        click.echo(scene_to_toml(resolved) if output is None else f"the resolved scene is in {output}\n")
        click.echo(facts(_in_words(found), width=width_of()))


def _in_words(found: Mapping[str, Any]) -> dict[str, Any]:
    """What `knotfem.check` has found, for a reader."""
    tables = {
        "effects": ("effects that act", _spoken_names),
        "absent": ("effects that do not", _spoken_names),
        "unused_keys": ("keys without effect in this model", list),
        "slices": ("slices", lambda rods: {rod: _slices(**of_it) for rod, of_it in rods.items()}),
    }
    said = {name: in_words(found[key]) for key, (name, in_words) in tables.items() if key in found}
    others = {**found, "warnings": Sentences(found["warnings"])}
    return said | {spoken(name): value for name, value in others.items() if name not in tables and value != 0}


def _spoken_names(values: Mapping[str, str]) -> dict[str, str]:
    return {spoken(name): text for name, text in values.items()}


def _slices(number: int, shortest_mm: float, longest_mm: float) -> str:
    lengths = f"{shortest_mm:.3g} mm"
    if longest_mm > shortest_mm * (1.0 + 1e-9):
        lengths = f"{shortest_mm:.3g} to {longest_mm:.3g} mm"
    return f"{number} of {lengths}"
