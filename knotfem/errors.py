"""Every error that a user can meet, with the exit code it ends a command with."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

OVERRIDES = "overrides"
"""The place of an error in overrides of a scene's keys; the command line calls it by its option."""

ROPE = "rope"
"""The place of an error in the properties of a user's own rope; likewise."""


class KnotfemError(Exception):
    """Base of all errors that carry a message for the user.

    Attributes:
        exit_code: process exit code of the command that lets the error through.
        run: results up to the error (`knotfem.Run`) where a run in memory raised it, else None.
    """

    exit_code = 1
    run: object | None = None


class InputError(KnotfemError):
    """A scene, a file or an option is wrong: says where, what was found and what is expected."""

    exit_code = 3

    def __init__(
        self,
        problem: str,
        *,
        file: str | Path | None = None,
        key: str | None = None,
        found: object | None = None,
        expected: str | None = None,
    ) -> None:
        self.problem, self.file, self.key, self.found, self.expected = problem, file, key, found, expected
        where = ": ".join(str(part) for part in (file, key) if part is not None)
        message = f"{where}: {problem}" if where else problem
        if found is not None:
            message += f"; found {found}"
        if expected is not None:
            message += f"; expected {expected}"
        super().__init__(message)


class InUse(InputError):
    """Another process is at work on a run or a study."""


class SeveralErrors(InputError):
    """All that is wrong with a file: a line for each error.

    Attributes:
        errors: at least one.
    """

    def __init__(self, errors: Sequence[InputError]) -> None:
        self.errors = tuple(errors)
        first = self.errors[0]
        super().__init__(first.problem, file=first.file, key=first.key, found=first.found, expected=first.expected)
        self.args = ("\n".join(str(error) for error in self.errors),)


def cannot_read(path: str | Path, error: OSError) -> InputError:
    """The error for a file that cannot be read."""
    return InputError(f"cannot be read ({error.strerror or error})", file=path)


def cannot_write(path: str | Path, error: OSError) -> InputError:
    """The error for a file or folder that cannot be written."""
    problem = f"cannot be written ({error.strerror or error})"
    return InputError(problem, file=path, expected="a writable folder with space")


class MissingDependency(KnotfemError):
    """An optional library or system component is absent; the message names it and its cure."""

    exit_code = 3


class NotConverged(KnotfemError):
    """The equations were not solved within the limits; the best state has been saved."""

    exit_code = 4


class KnotLost(KnotfemError):
    """Strands passed through each other, or a knot that must hold has unravelled."""

    exit_code = 5


class Stopped(KnotfemError):
    """SIGTERM or a time limit ended the run after writing a checkpoint."""

    exit_code = 75


class Interrupted(KnotfemError):
    """Ctrl-C ended the run after writing a checkpoint."""

    exit_code = 130
