"""What the verbs share: their options, error messages, progress and where the results are."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from knotfem.errors import OVERRIDES, ROPE, InputError, KnotfemError, SeveralErrors
from knotfem_cli.text import facts, spoken, width_of, wrapped

if TYPE_CHECKING:
    from knotfem.results.moment import Moment
    from knotfem.results.run import Run
    from knotfem.run.progress import Progress
    from knotfem.scene.model import Scene

F = TypeVar("F", bound=Callable[..., Any])

LONG = 3600.0
"""Computations that are expected to take longer are asked about [s]."""
HIGHLIGHTS = (
    "steps",
    "newton_iterations",
    "cutbacks",
    "max_stretch_deviation",
    "max_penetration_over_d",
    "knot_before",
    "knot_after",
    "verdict",
    "failure_mode",
    "events",
    "final_force_N",
    "linear_solver",
    "peak_memory_mb",
)
"""What a verb shows of summary.json, where it is there and not zero."""

OPTIONS = (
    "at", "step", "label", "width", "height", "font", "axis", "xlim", "ylim", "force_unit", "quantity", "zoom", "focus",
)  # fmt: skip
"""Arguments of the library that are options of the same name here."""
run_argument = click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
output_option = click.option("-o", "--output", type=click.Path(path_type=Path), help="Where to write.")
force_option = click.option("--force", is_flag=True, help="Replace the run that is there.")
model_option = click.option("--model", type=click.Choice(["fem", "rod"]), help="Hexahedra or the reduced rod model.")
from_option = click.option(
    "--from", "from_run", metavar="RUN", help="A 3D run of the same rods from whose tied knot the rod model sets out."
)
last_option = click.option("--last", is_flag=True, help="With --from: from the last state that this run has reached.")
rope_option = click.option(
    "--rope",
    "rope",
    metavar="KEY=VALUE...",
    multiple=True,
    help='The scene for your own rope: diameter="10 mm" youngs_modulus="5 MPa" friction=0.25 obstacle_friction=0.3.',
)
yes_option = click.option("--yes", is_flag=True, help="Do not ask before more than an hour of computation.")
at_option = click.option(
    "--at", metavar="LENGTH", help='A stored displacement over all steps, such as "60 mm"; the last by default.'
)
step_option = click.option("--step", metavar="NAME", help="A stored state of this step of the scene.")


def shared_options(command: F) -> F:
    """The options of every verb."""
    options = (
        click.option(
            "--set",
            "overrides",
            metavar="KEY=VALUE",
            multiple=True,
            help='Change a key of the scene, such as rods.0.length="500 mm"; none removes it.',
        ),
        click.option("--quiet", is_flag=True, help="No progress."),
        click.option("--log-format", type=click.Choice(["text", "json"]), default="text", show_default=True),
    )
    for option in reversed(options):
        command = option(command)
    return command


def engine_options(command: F) -> F:
    """Where the runs of a study are computed."""
    options = (
        click.option("--jobs", "processes", type=click.IntRange(min=1),
                     help="Runs at a time on this machine; one for each processor by default."),
        click.option("--scheduler", metavar="ADDRESS", help="A dask scheduler that runs already: tcp://host:8786."),
        click.option("--cluster", metavar="FILE", type=click.Path(path_type=Path),
                     help="Jobs of Slurm, PBS, SGE or LSF, as the TOML file says (docs/studies.md)."),
    )  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


def plainly(error: OSError) -> InputError:
    """The message for a file, or the output, that cannot be used, where no function has said more."""
    place = error.filename or "the output"
    return InputError(f"cannot be used ({error.strerror or error})", file=place)


class Verb(click.Command):
    """Turns the errors that a user can meet into one message and an exit code."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Let --rope take all properties that follow it."""
        return super().parse_args(ctx, _each_with_option(args, "--rope"))

    def invoke(self, ctx: click.Context) -> Any:
        """Run the verb."""
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()
            return result
        except BrokenPipeError:
            raise
        except (KnotfemError, OSError) as caught:
            error = plainly(caught) if isinstance(caught, OSError) else caught
            said = _in_options(error)
            as_json = ctx.params.get("log_format") == "json"
            with suppress(OSError):
                told = json.dumps({"error": said, "exit_code": error.exit_code}) if as_json else f"knotfem: {said}"
                click.echo(told, err=True)
            ctx.exit(error.exit_code)


def _each_with_option(args: Sequence[str], option: str) -> list[str]:
    """Arguments in which an option precedes each of the texts KEY=VALUE that follow it."""
    found: list[str] = []
    for argument in args:
        following = len(found) > 1 and found[-2] == option and "=" in found[-1]
        if following and re.match(r"[a-z_]+\s*=", argument):
            found.append(option)
        found.append(argument)
    return found


def _in_options(error: KnotfemError) -> str:
    """The message, in which overrides and the argument `at` have the names of their options."""
    if isinstance(error, SeveralErrors):
        return "\n".join(_in_options(one) for one in error.errors)
    if not isinstance(error, InputError):
        return str(error)
    file = {OVERRIDES: "--set", ROPE: "--rope"}.get(str(error.file), error.file)
    key = f"--{error.key.replace('_', '-')}" if error.key in OPTIONS else error.key
    return str(InputError(error.problem, file=file, key=key, found=error.found, expected=error.expected))


def with_model(
    overrides: tuple[str, ...], model: str | None, from_run: str | None = None, last: bool = False
) -> tuple[str, ...]:
    """The overrides, with those that --model, --from and --last stand for."""
    chosen = overrides if model is None else (*overrides, f"model={model}")
    if from_run is not None:
        chosen = (*chosen, f"tie.source={json.dumps(from_run)}")
    return (*chosen, "tie.source_state=last") if last else chosen


def scene_for(source: str, overrides: Sequence[str], rope: tuple[str, ...]) -> Scene:
    """The scene of a verb, for the user's own rope where there is one."""
    from knotfem.scene.load import load_scene
    from knotfem.scene.rope import rope_of

    return load_scene(source, overrides, rope=rope_of(rope))


def asks() -> bool:
    """Whether somebody sits at a terminal who can be asked."""
    return sys.stdin.isatty()


def ask_if_long(seconds: float, yes: bool, limit: float | None = None) -> None:
    """Ask whether to begin what is expected to take more than `LONG`.

    Args:
        seconds: that are expected [s].
        yes: whether the answer was given in advance.
        limit: after which it ends anyway [s], or None.

    Raises:
        InputError: nobody can be asked.
    """
    if yes or min(seconds, math.inf if limit is None else limit) <= LONG:
        return
    said = f"about {seconds / 3600.0:.2g} h of computation are expected, within a factor of three"
    if not asks():
        raise InputError(said, expected="--yes to begin it, or fewer elements, a shorter pull, --model rod")
    click.confirm(f"{said}. Begin it?", abort=True, err=True)


def ask_before(scene: Scene, yes: bool) -> None:
    """Ask whether to run a scene that is expected to take long; see `ask_if_long`."""
    from knotfem.run.expected import expected

    ask_if_long(expected(scene).if_it_unravels, yes, scene.solver.time_limit)


def displacement(at: str | None, option: str = "--at") -> float | None:
    """The value of --at, or of another option that takes a length [mm]."""
    if at is None:
        return None
    from knotfem.scene.quantity import LENGTH, parse_quantity

    return parse_quantity(at, LENGTH, option)


def say_state(wanted: float | None, found: Moment, run: str = "") -> None:
    """Say which stored state was taken, and that it is the nearest where another displacement [mm] was asked for.

    Args:
        wanted: displacement that was asked for, or None.
        found: the state.
        run: whose it is, where there are several.
    """
    other = wanted is not None and not math.isclose(found.displacement, wanted, rel_tol=1e-6, abs_tol=1e-6)
    what = "the nearest stored state" if other else "state"
    click.echo(f"{run}{', ' * bool(run)}{what}: {found}", err=True)


def moment_json(found: Moment) -> dict[str, Any]:
    """The stored state that was taken, for JSON."""
    named = {
        "step": found.step,
        "displacement_mm": found.displacement,
        "step_displacement_mm": found.step_displacement,
        "time_s": found.time,
    }
    return {key: value for key, value in named.items() if not isinstance(value, float) or math.isfinite(value)}


def progress_of(quiet: bool, log_format: str) -> Progress:
    """Progress of a computation, on standard error."""
    from knotfem.run.progress import make_progress

    return make_progress(quiet=quiet, log_format="json" if log_format == "json" else "text")


def show_run(run: Run, quiet: bool, log_format: str) -> None:
    """Say at the end where the results are."""
    summary = run.summary
    if log_format == "json":
        click.echo(json.dumps({"run": str(run.path), **summary}))
        return
    from knotfem.run.knot_words import knot_said

    found = {**summary, **{key: knot_said(summary.get(key)) for key in ("knot_before", "knot_after")}}
    shown = {spoken(key): found[key] for key in HIGHLIGHTS if found.get(key) not in (None, "none", 0.0)}
    if shown and not quiet:
        width = width_of(sys.stderr)
        click.echo(facts({**_times(summary), **shown}, width=width), err=True)
        for note in (*run.notes, *verdict_note(run)):
            click.echo("\n".join(wrapped(note, width)), err=True)
    click.echo(run.path)


def _times(summary: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """What each phase took, a line each."""
    spent = summary.get("phases") or {}
    lines = {name: f"{t['wall_s']:.3g} s, {t.get('cpu_s', 0.0):.3g} s of CPU time" for name, t in spent.items()}
    return {"phases": lines} if lines else {}


def verdict_note(run: Run) -> list[str]:
    """The verdict and, where a step ends at a slip, what the knot bore before, as sentences."""
    said = run.verdict_evidence.get("in_words")
    asked = any(getattr(step, "slip", None) is not None for step in run.scene.loading_steps)
    borne = run.holding() if said and asked else None
    return [text for text in (said, borne and str(borne)) if text]


def json_text(values: Mapping[str, Any]) -> str:
    """One line of JSON; NaN becomes null."""
    from knotfem.files import json_line

    return json_line(values).rstrip()


def show_estimate(found: Mapping[str, Any], quiet: bool, log_format: str) -> None:
    """Say what a study would take, and the script of a cluster's jobs as it is."""
    if log_format == "json":
        click.echo(json_text(found))
    elif not quiet:
        script = found.get("job_script")
        click.echo(facts({spoken(key): value for key, value in found.items() if key != "job_script"}, width=width_of()))
        if script is not None:
            click.echo(f"\n{script}", nl=False)


def numbers(text: str, key: str) -> tuple[float, ...]:
    """Numbers of a list such as "0.1, 0.15", or of a range such as "0:0.4:9" (first, last, how many).

    Raises:
        InputError: it is neither.
    """
    expected = 'numbers such as "0.1, 0.15", or first, last and how many, such as "0:0.4:9"'
    try:
        if ":" in text:
            first, last, count = text.split(":")
            n = int(count)
            step = (float(last) - float(first)) / (n - 1) if n > 1 else 0.0
            found = [round(float(first) + i * step, 12) for i in range(n)]
        else:
            found = [float(part) for part in text.replace(",", " ").split()]
    except (ValueError, ZeroDivisionError):
        raise InputError("not a list of numbers", key=key, found=text, expected=expected) from None
    if not found:
        raise InputError("no number", key=key, found=text, expected=expected)
    return tuple(found)
