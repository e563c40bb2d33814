"""Mappings by name."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.tie.direct import direct_path
from knotfem.tie.inextensible import inextensible_path
from knotfem.tie.linear import linear_path
from knotfem.tie.path import CentrelinePath
from knotfem.tie.polynomial import polynomial_path

KINDS = ("polynomial", "inextensible", "linear", "direct")


def make_path(
    kind: str,
    target: ArrayLike,
    *,
    direction: str | ArrayLike | None = None,
    start: ArrayLike | None = None,
    degree: int = 8,
    threshold: float = 0.3,
    refine: bool = False,
) -> CentrelinePath:
    """Returns the mapping of that name from a straight rod into the target.

    Args:
        kind: one of `KINDS`.
        target: vertices of the knotted centreline, shape (n + 1, 3), mm, in equal chords.
        direction: of the straight rod, a vector or "best"; by default "best" for polynomial and inextensible, +z for
            linear and direct.
        start: place of the straight rod's first vertex, shape (3,), mm; by default centred on the target for
            polynomial and inextensible, the origin for linear and direct.
        degree: of the temporary displacement; polynomial only.
        threshold: largest |lambda - 1|; polynomial only.
        refine: go on to the smallest |lambda - 1|; polynomial only.

    Raises:
        InputError: unknown kind, or an argument that makes no sense.
        NotConverged: the polynomial's threshold is out of reach.
    """
    given: dict[str, Any] = {"direction": direction, "start": start}
    place = {key: value for key, value in given.items() if value is not None}
    match kind:
        case "polynomial":
            return polynomial_path(target, degree=degree, threshold=threshold, refine=refine, **place)
        case "inextensible":
            return inextensible_path(target, **place)
        case "linear":
            return linear_path(target, **place)
        case "direct":
            return direct_path(target, **place)
    raise InputError("unknown mapping path", found=kind, expected=", ".join(KINDS))
