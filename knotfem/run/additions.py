"""What a user adds to a run as objects: a run directory keeps their names, who goes on passes the objects again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from knotfem.errors import InputError
from knotfem.models.base import Additions, TermMaker

Names = Mapping[str, Sequence[str]]
"""Names of additions by the argument that they are passed as."""


def names_of(additions: Additions) -> dict[str, list[str]]:
    """Names of all additions; a function that makes a term goes by its own name, a material by rod and class."""
    return {
        "terms": [_name(term) for term in additions.terms],
        "obstacles": [obstacle.name for obstacle in additions.obstacles],
        "materials": [f"{rod}: {type(law).__name__}" for rod, law in additions.materials.items()],
    }


def require(begun: Names, now: Names, path: Path | None, *, same: bool) -> None:
    """Refuse to go on from a run without the objects that it was begun with.

    Args:
        begun: names of those.
        now: names of what is there now.
        path: of the run, for the message.
        same: whether there may be no others either.

    Raises:
        InputError: one is missing, or there are others.
    """
    missing, others = _less(begun, now), _less(now, begun)
    if any(missing.values()):
        expected = f"{_said(begun)}, passed to kf.resume or kf.pull"
        problem = f"objects of your own are missing that the run was begun with: {_said(missing)}"
        raise InputError(problem, file=path, found=_said(now), expected=expected)
    if same and any(others.values()):
        problem = f"the run was begun without {_said(others)}"
        raise InputError(problem, file=path, expected="the same as before, or another folder")


def _name(term: TermMaker) -> str:
    return getattr(term, "name", "") or getattr(term, "__name__", type(term).__name__)


def _less(names: Names, taken: Names) -> dict[str, list[str]]:
    """Names that are not taken, each as often as it is left."""
    return {kind: list((Counter(own) - Counter(taken.get(kind, ()))).elements()) for kind, own in names.items()}


def _said(names: Names) -> str:
    lists = {kind: ", ".join(own) for kind, own in names.items() if own}
    said = [f"{kind}={{{text}}}" if kind == "materials" else f"{kind}=[{text}]" for kind, text in lists.items()]
    return ", ".join(said) or "none"
