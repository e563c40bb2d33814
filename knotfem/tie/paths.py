"""Choice of a mapping by its name."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.slices import Slices
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
    slices: Slices | None = None,
) -> CentrelinePath:
    """Return the mapping of a name from a straight rod to the target.

    Args:
        kind: one of `KINDS`.
        target: vertices of the knotted centreline, shape (n + 1, 3), mm, in chords as long as the slices.
        direction: of the straight rod, a vector or "best"; by default "best" for polynomial and inextensible, +z for
            linear and direct.
        start: position of the straight rod's first vertex, shape (3,), mm; by default, the rod's middle lies at the
            target's centroid for polynomial and inextensible, its first vertex at the origin for linear and direct.
        degree: of the temporary displacements; polynomial only.
        threshold: largest |lambda - 1|; polynomial only.
        refine: minimise |lambda - 1| instead of stopping at the threshold; polynomial only.
        slices: edges of the straight rod, mm; by default all as long as the mean chord of the target.

    Raises:
        InputError: an unknown name, or an argument that is not valid.
        NotConverged: the threshold cannot be reached with this degree.
    """
    given: dict[str, Any] = {"direction": direction, "start": start, "slices": slices}
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
