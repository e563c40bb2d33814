"""All hard cases."""

from __future__ import annotations

from knotfem.verify.case import Case
from knotfem.verify.stress import cycles, input, invariance, knots, pressure, steps, twist


def hard_cases(*, small: bool = False) -> list[Case]:
    """The cases of `knotfem verify --hard`.

    Args:
        small: their small versions.
    """
    modules = (knots, pressure, input, twist, cycles, invariance, steps)
    return [case for module in modules for case in module.cases(small=small)]
