"""The base of every table of a scene: frozen, strict, and helpful about keys that it does not know."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    Strict,
    ValidationError,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from knotfem.errors import InputError, SeveralErrors
from knotfem.names import suggestion
from knotfem.scene.quantity import Length, Quantity


class Table(BaseModel):
    """A table of the scene file."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    older: ClassVar[Mapping[str, str]] = {}
    """Keys by names that they had in older scenes, which are read as well."""

    @model_validator(mode="wrap")
    @classmethod
    def _check_keys(cls, data: Any, validate: ModelWrapValidatorHandler[Self]) -> Self:
        """All unknown and missing keys, besides what is wrong with those that are there."""
        if not isinstance(data, Mapping):
            return validate(data)
        data = {new if (new := cls.older.get(key, key)) not in data else key: value for key, value in data.items()}
        known = {key: value for key, value in data.items() if key in cls.model_fields}
        missing = [key for key, field in cls.model_fields.items() if field.is_required() and key not in data]
        problems = [
            refusal("unknown key", at=str(key), expected=suggestion(str(key), list(cls.model_fields)))
            for key in data
            if key not in known
        ]
        problems += [refusal("missing key", at=key, expected=_expected(cls.model_fields[key])) for key in missing]
        if not problems:
            return validate(data)
        lines = [InitErrorDetails(type=problem, loc=(), input=data) for problem in problems]
        try:
            validate(known)
        except ValidationError as error:
            lines += [
                _again(detail) for detail in error.errors() if detail["loc"][-1:] not in [(key,) for key in missing]
            ]
        raise ValidationError.from_exception_data(cls.__name__, lines)


def _expected(field: FieldInfo) -> str:
    quantities = [entry for entry in field.metadata if isinstance(entry, Quantity)]
    return quantities[0].expected if quantities else "a value"


def _again(detail: ErrorDetails) -> InitErrorDetails:
    """A problem that was found, to be raised among others."""
    kind: Any = detail["type"]
    if kind in OWN:
        kind = PydanticCustomError(kind, "{problem}", detail.get("ctx"))
    return InitErrorDetails(type=kind, loc=detail["loc"], input=detail["input"], ctx=detail.get("ctx", {}))


OWN = ("refusal", "quantity")
"""Types of the errors that this package raises."""


def refusal(problem: str, *, at: str = "", found: str | None = None, expected: str = "") -> PydanticCustomError:
    """What a validator raises; `input_errors` turns it into the one message for the user.

    Args:
        problem: what is wrong.
        at: key below the table that is being validated.
        found: the value, where it is not the validator's own input.
        expected: what would be right.
    """
    return PydanticCustomError(
        "refusal", "{problem}", {"problem": problem, "at": at, "found": found, "expected": expected}
    )


def known_name(name: str, known: list[str], what: str, *, at: str) -> None:
    """Refuse a name that is not among the known ones.

    Raises:
        PydanticCustomError: with the closest known name.
    """
    if name not in known:
        raise refusal(f"no {what} has this name", at=at, found=f'"{name}"', expected=suggestion(name, known))


def input_errors(error: ValidationError, data: object, *, file: str | PathLike[str] | None = None) -> list[InputError]:
    """All problems that pydantic found, a message for each key.

    Args:
        error: what pydantic raised.
        data: the tables that were validated.
        file: that they are from.
    """
    found: dict[str, InputError] = {}
    details = error.errors(include_url=False)
    places = [detail["loc"] for detail in details]
    for detail in details:
        inside = (place[: len(detail["loc"])] == detail["loc"] and place != detail["loc"] for place in places)
        if detail["type"] == "too_short" and any(inside):
            continue  # entries that are wrong are not counted
        key, (problem, expected) = _key(detail, data), _explain(detail)
        place = None if file is None else str(file)
        said = InputError(problem, file=place, key=key or None, found=_found(detail), expected=expected)
        found.setdefault(key, said)
    return list(found.values())


def one_error(found: Sequence[InputError]) -> InputError:
    """What to raise for the problems that were found."""
    return found[0] if len(found) == 1 else SeveralErrors(found)


def _explain(detail: ErrorDetails) -> tuple[str, str | None]:
    context = detail.get("ctx", {})
    match detail["type"]:
        case "quantity" | "refusal":
            return context["problem"], context["expected"] or None
        case "literal_error":
            names = [part.strip("'") for part in context["expected"].replace(" or ", ", ").split(", ")]
            return "unknown choice", suggestion(str(detail["input"]), names)
        case "union_tag_invalid":
            names = [part.strip("'") for part in context["expected_tags"].split(", ")]
            return "unknown choice", suggestion(context["tag"], names)
        case "union_tag_not_found":
            return "missing key", "a value"
        case "string_pattern_mismatch":
            return "not a name", "letters, digits, - and _"
        case "model_type" | "dict_type" | "model_attributes_type":
            return "wrong kind of value", "a table"
        case "tuple_type":
            return "wrong kind of value", "a list"
        case "missing":
            return "too few entries", "a complete list"
        case "too_short" | "too_long":
            return "wrong number of entries", detail["msg"].partition("should have ")[2].partition(" after")[0]
        case _:
            return "wrong value", detail["msg"].removeprefix("Input should be ")


def _key(detail: ErrorDetails, data: object) -> str:
    """The dotted key of a problem, without the tags that pydantic puts between."""
    parts: list[str] = []
    for part in detail["loc"]:
        below: Any = dict(enumerate(data)) if isinstance(data, list) else data
        if isinstance(below, Mapping) and part in below:
            data = below[part]
            parts.append(str(part))
    context = detail.get("ctx", {})
    if context.get("at"):
        parts.append(context["at"])
    if detail["type"].startswith("union_tag"):
        parts.append(context["discriminator"].strip("'"))
    return ".".join(parts)


def _found(detail: ErrorDetails) -> str | None:
    context, value = detail.get("ctx", {}), detail["input"]
    if context.get("found") or context.get("at"):
        return context["found"]
    if detail["type"] == "union_tag_invalid":
        return f'"{context["tag"]}"'
    if isinstance(value, Mapping | BaseModel):
        return None if detail["type"] in ("refusal", "union_tag_not_found") else "a table"
    if isinstance(value, str):
        return f'"{value}"'
    return str(value).lower() if isinstance(value, bool) else str(value)


def _finite_direction(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    if math.hypot(*vector) == 0.0:
        raise refusal("a direction of no length", expected="three numbers, not all zero, such as [0, 0, 1]")
    return vector


LARGEST_FRICTION = 10.0
"""Of any two surfaces."""


def _possible_friction(coefficient: float) -> float:
    if coefficient > LARGEST_FRICTION:
        expected = f"at most {LARGEST_FRICTION:g}: rubber on dry glass has 1 to 2"
        raise refusal("no surfaces rub like this", expected=expected)
    return coefficient


Flag = Annotated[bool, Strict()]
Integer = Annotated[int, Strict()]
Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Friction = Annotated[float, Strict(), Field(allow_inf_nan=False, ge=0.0), AfterValidator(_possible_friction)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]+$")]
Direction = Annotated[tuple[Number, Number, Number], AfterValidator(_finite_direction)]
Point = tuple[Length, Length, Length]
