"""Tables of the effects that come whole in one file: made from their own settings when a scene first names them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from functools import cache
from typing import Annotated, Any, get_type_hints

from pydantic import BeforeValidator, SerializeAsAny, create_model

from knotfem.scene.quantity import Quantity
from knotfem.scene.table import Table, refusal
from knotfem.terms.registry import REGISTERED, module_of


@cache
def table_of(name: str) -> type[Table]:
    """The table of a registered effect."""
    settings = module_of(name).Settings
    hints = get_type_hints(settings)
    keys: dict[str, Any] = {}
    for field in fields(settings):
        kind = hints[field.name]
        if measured := field.metadata.get("quantity"):
            *texts, minimum = measured
            kind = Annotated[kind, Quantity(*texts, minimum=minimum)]
        keys[field.name] = (kind, ... if field.default is MISSING else field.default)
    return create_model(settings.__name__, __base__=Table, **keys)


def _reader(name: str) -> Callable[[object], Table]:
    def read(table: object) -> Table:
        if not isinstance(table, Mapping | Table):
            raise refusal("wrong kind of value", found=str(table), expected="a table")
        return table_of(name).model_validate(table)

    return read


_optional: dict[str, Any] = {name: (Annotated[Any, BeforeValidator(_reader(name))], None) for name in REGISTERED}
_Effects = create_model("Effects", __base__=Table, **_optional)

RegisteredEffects = Annotated[SerializeAsAny[Table], BeforeValidator(_Effects.model_validate)]
"""Settings of the registered effects that a scene has."""


def no_effects() -> Table:
    """Of a scene that has none of them."""
    return _Effects()


def settings_of(effects: Table, name: str) -> Any:
    """Settings of one of them as its module wants them, or None where the scene has none."""
    table = getattr(effects, name)
    return None if table is None else module_of(name).Settings(**table.model_dump())
