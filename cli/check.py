"""`knotfem check`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import click

import knotfem as kf
from knotfem_cli.common import Verb, from_option, last_option, model_option, shared_options, with_model
from knotfem_cli.text import facts, spoken, width_of


@click.command(cls=Verb)
@click.argument("scene")
@model_option
@from_option
@last_option
@shared_options
def check(
    scene: str,
    model: str | None,
    from_run: str | None,
    last: bool,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Validate a scene and say what it would take; run nothing.

    Prints the resolved scene with every default, the effects that will run and those that will not, degrees of
    freedom, expected memory and time. With --quiet, only whether the scene is right.

    \b
    Example:
      knotfem check bowline --set 'rods.0.mesh.element_length=1 mm'
    """
    from knotfem.scene import scene_to_toml

    resolved = kf.load_scene(scene, with_model(overrides, model, from_run, last))
    found = kf.check(resolved)
    if log_format == "json":
        click.echo(json.dumps({"scene": resolved.model_dump(mode="json"), **found}))
    elif not quiet:
        click.echo(scene_to_toml(resolved))
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
    return said | {spoken(name): value for name, value in found.items() if name not in tables and value != 0}


def _spoken_names(values: Mapping[str, str]) -> dict[str, str]:
    return {spoken(name): text for name, text in values.items()}


def _slices(number: int, shortest_mm: float, longest_mm: float) -> str:
    lengths = f"{shortest_mm:.3g} mm"
    if longest_mm > shortest_mm * (1.0 + 1e-9):
        lengths = f"{shortest_mm:.3g} to {longest_mm:.3g} mm"
    return f"{number} of {lengths}"
