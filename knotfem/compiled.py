"""Compiled kernels: loops over plain arrays that Numba turns into machine code."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast, overload

from numba import njit

P = ParamSpec("P")
R = TypeVar("R")


@overload
def kernel(function: Callable[P, R]) -> Callable[P, R]: ...
@overload
def kernel(
    *, parallel: bool = False, inline: str = "never", error_model: str = "python"
) -> Callable[[Callable[P, R]], Callable[P, R]]: ...
def kernel(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Compile a function when it is first called, and keep the machine code on disk.

    Args:
        function: to be compiled.
        **options: of `numba.njit`: `parallel`, `inline`, `error_model`.
    """
    compiled = njit(cache=True, **options)
    return cast(Any, compiled if function is None else compiled(function))
