"""A commented case file to start from, written from the models of `taichiflap.case` so that it is never stale."""

from collections.abc import Iterator
from typing import Any

import tomli_w
from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from .case import Case, case_schema

COMMENT_COLUMN = 34
EXAMPLE: dict[str, Any] = {
    "title": "My wing",
    "motion.plunge": {"amplitude": 0.02, "phase_deg": 90.0},
    "motion.pitch": {"amplitude_deg": 15.0, "phase_deg": 0.0, "mean_deg": 0.0},
}
"""Where the default is nothing to start from: a hawkmoth's stroke."""


def commented_case() -> str:
    """Text of a valid case file with every key, its meaning, unit and default."""
    lines = [
        "# A taichiflap case. SI units; angles in degrees where the key ends in _deg.",
        "# Keys without a default must be given; the others may be left out.",
        *_keys(Case, ""),
    ]
    return "\n".join(lines) + "\n"


def _keys(model: type[BaseModel], prefix: str) -> Iterator[str]:
    sections = []
    for key, field in model.model_fields.items():
        section = field.annotation
        path = f"{prefix}{key}"
        if path in EXAMPLE and path != "title":
            table = ", ".join(f"{k} = {_toml(v)}" for k, v in EXAMPLE[path].items())
            yield f"{key} = {{ {table} }}"
        elif isinstance(section, type) and issubclass(section, BaseModel):
            sections.append((path, section))
        else:
            yield _commented(f"{key} = {_toml(_example(path, field))}", model, key, field)
    for path, section in sections:
        yield ""
        yield f"[{path}]  # {(section.__doc__ or '').strip().rstrip('.')}"
        yield from _keys(section, f"{path}.")


def _example(path: str, field: Any) -> Any:
    if path in EXAMPLE:
        return EXAMPLE[path]
    return field.default if field.default is not PydanticUndefined else field.examples[0]


def _commented(text: str, model: type[BaseModel], key: str, field: Any) -> str:
    schema = case_schema() if model is Case else model.model_json_schema()
    unit = schema["properties"][key].get("unit", "")
    note = f"{unit}: {field.description}" if unit else field.description
    needed = "" if field.default is not PydanticUndefined else " (must be given)"
    return f"{text:<{COMMENT_COLUMN}}# {note}{needed}"


def _toml(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(_toml(item) for item in value)}]"
    if isinstance(value, float):
        return f"{value:.12g}" if value != int(value) or abs(value) >= 1e6 else repr(value)
    return tomli_w.dumps({"v": value}).partition("= ")[2].strip()
