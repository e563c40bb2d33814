"""The command `knotfem`: finds the verb, turns errors into exit codes."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from importlib import import_module
from typing import IO

import click

import knotfem

VERBS = (
    "scenes", "check", "tie", "pull", "tension", "resume", "render", "export", "plot", "compare", "cost", "sweep",
    "stability", "hold", "verify", "doctor", "help",
)  # fmt: skip


class Verbs(click.Group):
    """Imports a verb when it is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """In the order of work."""
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The verb, or none."""
        return getattr(import_module(f"knotfem_cli.{cmd_name}"), cmd_name) if cmd_name in VERBS else None


@click.command(cls=Verbs, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(knotfem.__version__, prog_name="knotfem")
def knotfem_command() -> None:
    """Knots in elastic rods: tied, pulled, read out as tension.

    \b
    Example:
      knotfem tie bowline -o knot
      knotfem pull knot
      knotfem tension knot -o tension.csv
    """


def main() -> None:
    """Run the command line and leave with its exit code."""
    try:
        code = knotfem_command.main(prog_name="knotfem", standalone_mode=False)
        sys.stdout.flush()
    except click.ClickException as error:
        code = error.exit_code
        with suppress(OSError):
            error.show()
    except (click.Abort, KeyboardInterrupt):
        code = 130
    except BrokenPipeError:
        code = 0
    except OSError as error:
        from knotfem_cli.common import plainly

        message = plainly(error)
        code = message.exit_code
        with suppress(OSError):
            click.echo(f"knotfem: {message}", err=True)
    for stream in (sys.stdout, sys.stderr):
        _leave(stream)
    sys.exit(code)


def _leave(stream: IO[str]) -> None:
    """Let a stream that cannot be written fall silent, so that Python does not complain of it at the end."""
    try:
        stream.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
