"""Declaration of the keys and tables of a case file: each key with its description, unit and range."""

from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, field_validator
from pydantic_core import PydanticCustomError

if TYPE_CHECKING:
    from .case import Case

LEAST = 1e-30
"""Smaller non-zero values are rejected as input errors, since their products and quotients would underflow or overflow.
"""


def _without_nothing(schema: dict[str, Any]) -> None:
    """Omit null defaults from the JSON schema, since TOML has no null."""
    for entry in schema.get("properties", {}).values():
        if "default" in entry and entry["default"] is None:
            del entry["default"]


class CaseTable(BaseModel):
    """A table of the case file: no unknown keys, no text for a number, immutable."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, json_schema_extra=_without_nothing,
        defer_build=True,  # a table is checked as a part of its case
    )  # fmt: skip

    @field_validator("*")
    @classmethod
    def _of_some_size(cls, value: Any) -> Any:
        if not all(text.isprintable() for text in ([value] if isinstance(value, str) else _names(value))):
            raise ValueError("must be one line of printable characters")
        tiny = _tiny(value)
        if tiny:
            raise ValueError(f"{tiny:g} is too small; give at least {LEAST:g} in size, or 0 if the key may be 0")
        return value


class ModelTable(CaseTable):
    """The table of a fluid model, which has the model's name.

    Attributes:
        own_steps: whether the time step follows from the flow where the case does not say.
    """

    own_steps: ClassVar[bool] = False

    def check(self, case: "Case") -> None:
        """Refuse a case that the model cannot compute.

        Raises:
            ValueError: with the key, its value and the cure.
            PydanticCustomError: for a key that is missing.
        """


def _names(value: Any) -> list[str]:
    """Names in a table of user-defined parameters."""
    return [name for name in value if isinstance(name, str)] if isinstance(value, dict) else []


def _tiny(value: Any) -> float:
    """A number in a value that is too small; zero if all are valid."""
    if isinstance(value, tuple):
        return next(filter(None, map(_tiny, value)), 0.0)
    return value if isinstance(value, float) and 0.0 < abs(value) < LEAST else 0.0


def key(default: Any = ..., *, unit: str = "", text: str, example: Any = None, **limits: Any) -> Any:
    """A key of the case file with its description, unit and allowed range."""
    example = default if example is None else example
    extra: dict[str, Any] = {"unit": unit} if unit else {}
    return Field(default, description=text, examples=[example], json_schema_extra=extra, **limits)


def optional_table(table: type[BaseModel]) -> Any:
    """An optional table. Its defaults need no validation."""
    return Field(default_factory=table.model_construct, description=(table.__doc__ or "").strip().rstrip("."))


def as_tuple(value: Any) -> Any:
    """Convert a list from the file to a tuple, since tables are immutable."""
    return tuple(value) if isinstance(value, list) else value


def needed(name: str, why: str) -> PydanticCustomError:
    """Error that a table's validator raises for a key that other keys require."""
    return PydanticCustomError("needed", "{name} is missing: {why}", {"name": name, "why": why})
