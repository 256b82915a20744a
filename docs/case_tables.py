"""The keys of a case file as Markdown, one table a section and one anchor a key, from the JSON schema."""

from collections.abc import Iterator, Mapping
from typing import Any

from taichiflap.notation import engineering, short

Schema = Mapping[str, Any]
HEAD = ("| key | unit | value | default | meaning |", "|---|---|---|---|---|")


def case_tables(schema: Schema) -> str:
    """All sections of a case file, in their order."""
    definitions = schema["$defs"]
    plain = {key: one for key, one in schema["properties"].items() if not sections(one)}
    lines = ["## Top level", "", *table(plain, schema, "")]
    for name, one in schema["properties"].items():
        for section in sections(one):
            lines += section_lines(name, definitions[section], definitions)
    return "\n".join(lines) + "\n"


def section_lines(path: str, section: Schema, definitions: Schema) -> Iterator[str]:
    """A section's heading, what it is, its table, and the sections within it."""
    inner = {key: sections(one) for key, one in section["properties"].items()}
    kind = section["properties"].get("kind", {}).get("const")
    yield from ("", f"## `[{path}]`" + (f', `kind = "{kind}"`' if kind else ""), "")
    yield from (" ".join(line.split()) for line in section.get("description", "").splitlines())
    yield ""
    yield from table(
        {key: one for key, one in section["properties"].items() if not inner[key]}, section, f"{path}.", kind
    )
    for key, names in inner.items():
        for name in names:
            yield from section_lines(f"{path}.{key}", definitions[name], definitions)


def sections(one: Schema) -> list[str]:
    """Names of the sections that a key may hold."""
    found = [part.get("$ref") for part in (one, *one.get("oneOf", ()), *one.get("anyOf", ()))]
    return [name.rpartition("/")[2] for name in found if name]


def table(keys: Schema, section: Schema, prefix: str, kind: str | None = None) -> Iterator[str]:
    """The keys of a section."""
    yield from HEAD
    for key, one in keys.items():
        if key == "kind":
            continue
        anchor = ".".join(part for part in (f"{prefix}{key}", kind if kind != "harmonic" else None) if part)
        needed = key in section.get("required", ())
        default = "must be given" if needed else shown(one.get("default"))
        meaning = " ".join(one.get("description", "").split())
        cells = (f'<span id="{anchor}"></span>`{key}`', one.get("unit", ""), allowed(one), default, meaning)
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def allowed(one: Schema) -> str:
    """The values that a key takes, in words."""
    several = [part for part in (*one.get("oneOf", ()), *one.get("anyOf", ())) if part.get("type") != "null"]
    if several:
        return " or ".join(dict.fromkeys(allowed(part) for part in several))
    if "enum" in one or "const" in one:
        return ", ".join(f'`"{value}"`' for value in one.get("enum") or [one["const"]])
    if one.get("type") == "array":
        if "prefixItems" in one:
            return f"[{', '.join(allowed(part) for part in one['prefixItems'])}]"
        return f"list of {allowed(one['items'])}"
    if one.get("type") in ("number", "integer"):
        return f"{one['type'].replace('number', '')} {ranged(one)}".strip() or "number"
    return {"boolean": "`true`, `false`", "string": one.get("title") if "pattern" in one else "text"}.get(
        one.get("type", ""), "table"
    )


def ranged(one: Schema) -> str:
    """A number's range."""
    low, high = one.get("minimum"), one.get("maximum")
    above, below = one.get("exclusiveMinimum"), one.get("exclusiveMaximum")
    if low is not None and high is not None:
        return f"{short(float(low))} to {short(float(high))}"
    parts = (("> ", above), ("≥ ", low), ("< ", below), ("≤ ", high))
    return ", ".join(f"{sign}{short(float(value))}" for sign, value in parts if value is not None)


def shown(value: Any) -> str:
    """A default as the file would say it."""
    if value is None or value in ("", [], {}):
        return ""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, Mapping):
        return "`{ " + ", ".join(f"{key} = {item}" for key, item in value.items()) + " }`"
    if isinstance(value, str):
        return f'`"{value}"`'
    return f"`{engineering(value) if isinstance(value, float) else value}`"
