"""What is wrong with a case file, in words: the key, its value, what is allowed, and the nearest valid key."""

import difflib
from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

Keys = list[str | int]


def describe(detail: ErrorDetails, document: Mapping[str, Any], root: type[BaseModel]) -> str:
    """One line for one of pydantic's findings about `document`, a file that should fit the model `root`."""
    keys = _real_keys(detail["loc"], document)
    name = _dotted(keys)
    if detail["type"] == "extra_forbidden":
        return f"{name}: unknown key{_nearest_key(keys, root)}"
    owner, key = _owner(keys, root)
    allowed = _allowed(owner, key) if owner else ""
    if detail["type"] == "missing" and isinstance(detail["loc"][-1], str):
        return f"{name}: missing; give {allowed}"
    message = detail["msg"].removeprefix("Value error, ")
    if detail["type"] == "value_error":
        return f"{name} = {_shown(detail['input'])}: {message}" if keys else message
    return f"{name or 'case'} = {_shown(detail['input'])}: must be {allowed or message[:1].lower() + message[1:]}"


def _real_keys(loc: tuple[str | int, ...], document: Any) -> Keys:
    """The path within the file: pydantic's, without the tags of the alternatives that it tried."""
    keys: Keys = []
    value: Any = document
    for key in loc:
        if isinstance(value, Mapping):
            value = value.get(str(key))
        elif isinstance(value, list) and isinstance(key, int) and key < len(value):
            value = value[key]
        else:
            continue
        keys.append(key)
    return keys


def _dotted(keys: Iterable[str | int]) -> str:
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys).removeprefix(".")


def _section(field: FieldInfo) -> type[BaseModel] | None:
    annotation = field.annotation
    return annotation if isinstance(annotation, type) and issubclass(annotation, BaseModel) else None


def _owner(keys: Keys, root: type[BaseModel]) -> tuple[type[BaseModel] | None, str]:
    """The section that holds the last named key of a path, and that key."""
    owner: type[BaseModel] | None = None
    model: type[BaseModel] | None = root
    name = ""
    for key in keys:
        if isinstance(key, int) or model is None or key not in model.model_fields:
            break
        owner, name = model, key
        model = _section(model.model_fields[key])
    return owner, name


def _nearest_key(keys: Keys, root: type[BaseModel]) -> str:
    *tables, last = keys
    model: type[BaseModel] | None = root
    for table in tables:
        model = _section(model.model_fields[str(table)]) if model else None
    here = list(model.model_fields) if model else []
    nearest = difflib.get_close_matches(str(last), here, 1)
    if nearest:
        return f"; did you mean {_dotted([*tables, nearest[0]])}?"
    elsewhere = [path for path in _all_keys(root) if path.rpartition(".")[2] == last]
    if elsewhere:
        return f"; did you mean {elsewhere[0]}?"
    return f"; keys here: {', '.join(here)}"


def _all_keys(model: type[BaseModel], prefix: str = "") -> Iterable[str]:
    for key, field in model.model_fields.items():
        section = _section(field)
        if section:
            yield from _all_keys(section, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"


def _allowed(owner: type[BaseModel], key: str) -> str:
    """What a key may hold, from its schema: 'a number > 0 and <= 100 m, e.g. 0.02 (chord)'."""
    field = owner.model_fields[key]
    if _section(field):
        return f"a table: {(field.annotation.__doc__ or '').strip()}"
    schema = owner.model_json_schema()["properties"][key]
    kinds = schema.get("oneOf", [schema])
    words = " or ".join(dict.fromkeys(_kind(kind) for kind in kinds))
    unit = f" {schema['unit']}" if "unit" in schema else ""
    example = f", e.g. {_shown(field.examples[0])}" if field.examples else ""
    return f"{words}{unit}{example} ({field.description})"


_KINDS = {"number": "a number", "integer": "a whole number", "boolean": "true or false", "string": "text"}
_LIMITS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}


def _kind(schema: Mapping[str, Any]) -> str:
    if "const" in schema:
        return _shown(schema["const"])
    if "enum" in schema:
        return " or ".join(_shown(value) for value in schema["enum"])
    if schema.get("type") == "array":
        items = schema.get("prefixItems") or [schema.get("items", {})]
        count = f"{len(items)} " if "prefixItems" in schema else ""
        return f"a list of {count}numbers, each {_limits(items[0])}"
    return f"{_KINDS.get(str(schema.get('type')), 'a value')} {_limits(schema)}".strip()


def _limits(schema: Mapping[str, Any]) -> str:
    return " and ".join(f"{sign} {schema[key]:g}" for key, sign in _LIMITS.items() if key in schema)


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"' if len(value) <= 60 else f'"{value[:57]}..."'
    text = str(list(value)) if isinstance(value, tuple) else str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def key_units(name: str, root: type[BaseModel]) -> tuple[str, str]:
    """Unit and meaning of a dotted key of the model `root`, empty where it has none."""
    owner, key = _owner([*name.split(".")], root)
    if owner is None:
        return "", ""
    field = owner.model_fields[key]
    extra = field.json_schema_extra
    return str(extra.get("unit", "")) if isinstance(extra, dict) else "", field.description or ""
