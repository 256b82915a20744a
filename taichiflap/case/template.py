"""A commented template of a case file, generated from the models of `taichiflap.case`."""

from collections.abc import Iterator, Mapping
from typing import Any, get_args

import tomli_w
from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from ..notation import engineering
from .case import Case, case_schema
from .messages import first_line, tables

COMMENT_COLUMN = 34
EXAMPLE: dict[str, Any] = {
    "title": "My wing",
    "motion.frequency": 25.0,
    "wing.thickness": 40e-6,
    "wing.density": 1000.0,
    "wing.youngs_modulus": 24.5e9,
    "motion.plunge": {"amplitude": 0.02, "phase_deg": 90.0},
    "motion.pitch": {"amplitude_deg": 15.0, "phase_deg": 0.0, "mean_deg": 0.0},
    "motion.surge": {"amplitude": 0.0, "phase_deg": 0.0},
}
"""Values for keys without a useful default: a hawkmoth's wing and stroke. Other optional keys become comments."""


def commented_case() -> str:
    """Text of a valid case file with each key's description, unit and default."""
    lines = [
        "# A taichiflap case. SI units; angles in degrees where the key ends in _deg.",
        '# Keys marked "must be given" are required; all others are optional.',
        *_keys(Case, ""),
    ]
    return "\n".join(lines) + "\n"


def _keys(model: type[BaseModel], prefix: str, left_out: str = "") -> Iterator[str]:
    nested = []
    for key, field in model.model_fields.items():
        found = tables(field)
        path = f"{prefix}{key}"
        if len(found) > 1:
            yield from _kinds(key, path, found)
        elif found:
            hidden = "# " if field.default is None else ""
            if hidden and prefix:
                yield f"{hidden}{key} = {{ ... }}  # {field.description}: the table [{path}] below"
            nested.append((path, found[0], hidden))
        else:
            hidden = left_out or ("# " if field.default is None and path not in EXAMPLE else "")
            yield _commented(f"{hidden}{key} = {_toml(_example(path, field))}", model, key, field)
    for path, table, hidden in nested:
        yield ""
        yield f"{hidden}[{path}]  # {first_line(table).rstrip('.')}"
        yield from _keys(table, f"{path}.", hidden)


def _kinds(key: str, path: str, models: list[type[BaseModel]]) -> Iterator[str]:
    """A table with several kinds: the first, and the others as comments."""
    yield f"{key} = {_toml(EXAMPLE[path])}"
    for model in models[1:]:
        table = {
            name: EXAMPLE[path].get(name, _example(f"{path}.{name}", field))
            for name, field in model.model_fields.items()
            if name != "kind" and (field.default not in (None, ()) or name == "file")
        }
        kind = get_args(model.model_fields["kind"].annotation)[0]
        yield f"# {key} = {_toml({'kind': kind} | table)}"


def _example(path: str, field: Any) -> Any:
    if path in EXAMPLE:
        return EXAMPLE[path]
    return field.examples[0] if field.default in (PydanticUndefined, None) else field.default


def _commented(text: str, model: type[BaseModel], key: str, field: Any) -> str:
    schema = case_schema() if model is Case else model.model_json_schema()
    unit = schema["properties"][key].get("unit", "")
    note = f"{unit}: {field.description}" if unit else field.description
    needed = "" if field.default is not PydanticUndefined else " (must be given)"
    return f"{text:<{COMMENT_COLUMN}}# {note}{needed}"


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_toml(item)}' for key, item in value.items())} }}"
    if isinstance(value, tuple | list):
        return f"[{', '.join(_toml(item) for item in value)}]"
    if isinstance(value, float):
        return engineering(value)
    return tomli_w.dumps({"v": value}).partition("= ")[2].strip()
