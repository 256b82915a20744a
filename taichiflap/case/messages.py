"""Error messages of a case file: the key, its value, the allowed values, and the nearest valid key."""

import difflib
import functools
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from ..notation import engineering

Keys = list[str | int]


def describe(detail: ErrorDetails, document: Mapping[str, Any], root: type[BaseModel]) -> str:
    """One-line message for one of pydantic's errors about `document`, checked as the model `root`."""
    found = detail["type"]
    context = detail.get("ctx", {})
    keys = _keys(detail["loc"], document, root)
    if found == "needed":
        keys += context["name"].split(".")
    if found == "union_tag_invalid":
        kinds = context["expected_tags"].replace("'", '"').replace(", ", " or ")
        return f"{_dotted(keys)}.kind = {_shown(context['tag'])}: must be {kinds}"
    name = _dotted(keys)
    if found == "extra_forbidden":
        return f"{name}: unknown key{_nearest_key(keys, document, root)}"
    owner, key = _owner(keys, document, root)
    allowed = _allowed(owner, key) if owner else ""
    if found == "needed":
        return f"{name}: missing; give {allowed}; {context['why']}"
    if found == "missing" and isinstance(detail["loc"][-1], str):
        return f"{name}: missing; give {allowed}"
    message = detail["msg"].removeprefix("Value error, ")
    if found == "value_error":
        given = "" if isinstance(detail["input"], Mapping) else f" = {_shown(detail['input'])}"
        return f"{name}{given}: {message}" if keys else message
    return f"{name or 'case'} = {_shown(detail['input'])}: must be {allowed or message[:1].lower() + message[1:]}"


def _keys(loc: tuple[str | int, ...], document: Any, root: type[BaseModel]) -> Keys:
    """The path within the file: pydantic's path without the tags of alternatives."""
    keys: Keys = []
    value: Any = document
    model: type[BaseModel] | None = root
    chosen = False
    for key in loc:
        if chosen:  # the tag of a table that has several kinds
            chosen = False
            continue
        if isinstance(value, Mapping):
            value = value.get(str(key))
        elif isinstance(value, list | tuple) and isinstance(key, int) and key < len(value):
            value = value[key]
        else:
            continue
        keys.append(key)
        field = model.model_fields.get(str(key)) if model else None
        chosen = field is not None and len(tables(field)) > 1
        model = _table(field, value) if field else None
    return keys


def _dotted(keys: Iterable[str | int]) -> str:
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys).removeprefix(".")


def tables(field: FieldInfo) -> list[type[BaseModel]]:
    """The tables that a key may hold, one per kind; empty for a plain value."""
    annotations = [get_args(part)[0] if get_origin(part) is Annotated else part for part in get_args(field.annotation)]
    return [part for part in (field.annotation, *annotations) if isinstance(part, type) and issubclass(part, BaseModel)]


def first_line(table: type[BaseModel]) -> str:
    """First line of a table's description."""
    return (table.__doc__ or "").strip().partition("\n")[0]


def _table(field: FieldInfo, value: Any = None) -> type[BaseModel] | None:
    """The table that a key holds: the kind that `value` names, or else the first."""
    found = tables(field)
    kind = value.get("kind") if isinstance(value, Mapping) else None
    asked = [part for part in found if "kind" in part.model_fields and kind in get_args(_annotation(part, "kind"))]
    return next(iter([*asked, *found]), None)


def _annotation(model: type[BaseModel], key: str) -> Any:
    return model.model_fields[key].annotation


def _owner(keys: Keys, document: Any, root: type[BaseModel]) -> tuple[type[BaseModel] | None, str]:
    """The table that holds the last named key of a path, and that key."""
    owner: type[BaseModel] | None = None
    model: type[BaseModel] | None = root
    name, value = "", document
    for key in keys:
        if isinstance(key, int) or model is None or key not in model.model_fields:
            break
        owner, name = model, key
        value = value.get(key) if isinstance(value, Mapping) else None
        model = _table(model.model_fields[key], value)
    return owner, name


def _nearest_key(keys: Keys, document: Any, root: type[BaseModel]) -> str:
    *path, last = keys
    model: type[BaseModel] | None = root
    kinds: list[type[BaseModel]] = []
    value = document
    for name in path:
        value = value[name]
        field = model.model_fields[str(name)] if model else None
        kinds = tables(field) if field else []
        model = _table(field, value) if field else None
    others = [_shown(get_args(_annotation(kind, "kind"))[0]) for kind in kinds if last in kind.model_fields]
    if others:
        return f"; it belongs to kind = {' or '.join(others)}"
    here = list(model.model_fields) if model else []
    nearest = difflib.get_close_matches(str(last), here, 1)
    if nearest:
        return f"; did you mean {_dotted([*path, nearest[0]])}?"
    elsewhere = [path for path in _all_keys(root) if path.rpartition(".")[2] == last]
    if elsewhere:
        return f"; did you mean {elsewhere[0]}?"
    return f"; keys here: {', '.join(here)}"


def _all_keys(model: type[BaseModel], prefix: str = "") -> Iterable[str]:
    for key, field in model.model_fields.items():
        table = _table(field)
        if table:
            yield from _all_keys(table, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"


def _allowed(owner: type[BaseModel], key: str) -> str:
    """Allowed values of a key, from its schema: 'a number > 0 and <= 100 m, e.g. 0.02 (chord)'."""
    field = owner.model_fields[key]
    table = _table(field)
    if table:
        return f"a table: {first_line(table)}"
    schema = _schema(owner)["properties"][key]
    kinds = _alternatives(schema)
    words = " or ".join(dict.fromkeys(_kind(kind) for kind in kinds))
    unit = f" {schema['unit']}" if "unit" in schema else ""
    example = f", e.g. {_shown(field.examples[0])}" if field.examples else ""
    return f"{words}{unit}{example} ({field.description})"


@functools.cache
def _schema(model: type[BaseModel]) -> dict[str, Any]:
    return model.model_json_schema()


def _alternatives(schema: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    several = schema.get("oneOf") or schema.get("anyOf")
    if not several:
        return [] if schema.get("type") == "null" else [schema]
    return [kind for one in several for kind in _alternatives(one)]


_KINDS = {"number": "a number", "integer": "a whole number", "boolean": "true or false", "string": "text"}
_LIMITS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}


def _kind(schema: Mapping[str, Any]) -> str:
    if "const" in schema or "pattern" in schema:
        return _shown(schema.get("const", schema.get("title")))
    if "enum" in schema:
        return " or ".join(_shown(value) for value in schema["enum"])
    if schema.get("type") == "array":
        items = schema.get("prefixItems") or [schema.get("items", {})]
        if "prefixItems" in items[0]:
            columns = [(column["title"], _limits(column)) for column in items[0]["prefixItems"]]
            row = ", ".join(title for title, _ in columns)
            return f"a table [[{row}], ...] with {', '.join(f'{title} {limits}' for title, limits in columns)}"
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
    text = engineering(value) if isinstance(value, float) else str(_listed(value))
    return text if len(text) <= 60 else f"{text[:57]}..."


def key_units(name: str, root: type[BaseModel]) -> tuple[str, str]:
    """Unit and description of a dotted key of the model `root`; empty strings if absent."""
    owner, key = _owner([*name.split(".")], {}, root)
    if owner is None:
        return "", ""
    field = owner.model_fields[key]
    extra = field.json_schema_extra
    return str(extra.get("unit", "")) if isinstance(extra, dict) else "", field.description or ""


def holds_whole(name: str, document: Mapping[str, Any], root: type[BaseModel]) -> bool:
    """Whether a dotted key takes whole numbers."""
    *_, last = name.split(".")
    owner, key = _owner([*name.split(".")], document, root)
    if owner is None or key != last:
        return False
    kinds = {kind.get("type") for kind in _alternatives(_schema(owner)["properties"][key])}
    return "integer" in kinds and "number" not in kinds


def _listed(value: Any) -> Any:
    return [_listed(item) for item in value] if isinstance(value, list | tuple) else value
