"""A case file: its sections together, reading and changing it, and the messages when it does not fit."""

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal

import tomli_w
from pydantic import Field, ValidationError, model_validator

from .errors import UserError
from .keys import Section, section
from .problems import describe
from .sections.dbet import Dbet
from .sections.fluid import Fluid
from .sections.motion import Motion
from .sections.output import Output
from .sections.time import Time
from .sections.uvlm import Uvlm
from .sections.wing import Wing

MAX_STEPS = 5_000_000


class CaseError(UserError):
    """A case that cannot be run: every problem found, one line each."""

    def __init__(self, source: str, problems: list[str]) -> None:
        self.source, self.problems = source, problems
        super().__init__("\n".join(f"{source}: {problem}" for problem in problems))


class Case(Section):
    """One case: an elastic wing section, its motion, the fluid and the model that computes it.

    Attributes follow the case file: `case.wing.chord` is the file's `chord` in `[wing]`. SI units; angles in
    degrees where the key ends in `_deg`. Cases are immutable; `override` gives a changed copy.
    """

    title: str = Field("", description="a line that says what this is")
    solver: Literal["uvlm", "dbet"] = Field("uvlm", description="fluid model")
    wing: Wing
    motion: Motion
    fluid: Fluid = section(Fluid)
    dbet: Dbet = section(Dbet)
    uvlm: Uvlm = section(Uvlm)
    time: Time = section(Time)
    output: Output = section(Output)

    @model_validator(mode="after")
    def _bounded(self) -> "Case":
        if self.steps > MAX_STEPS:
            raise ValueError(
                f"time.periods * time.steps_per_period = {self.steps}: at most {MAX_STEPS} steps in one case"
            )
        return self

    @property
    def steps(self) -> int:
        """Number of time steps."""
        return self.time.periods * self.time.steps_per_period

    @property
    def step(self) -> float:
        """Time step, s."""
        return 1.0 / (self.motion.frequency * self.time.steps_per_period)

    def override(self, *settings: str, **named: Any) -> "Case":
        """A copy with some keys changed, checked like a file: `case.override("wing.modes=0", title="rigid")`.

        Raises:
            CaseError: with every problem found.
        """
        document = apply_settings(self.to_dict(), settings, "override")
        return parse_case({**document, **named}, "override")

    def to_dict(self) -> dict[str, Any]:
        """The case as plain dictionaries, lists and numbers."""
        return self.model_dump(mode="json")

    def to_toml(self) -> str:
        """The case as a file that `load_case` reads back to an equal case."""
        return tomli_w.dumps(self.to_dict())


def load_case(path: str | Path, settings: Iterable[str] = ()) -> Case:
    """Read a case file.

    Args:
        path: a TOML file.
        settings: overrides such as `"wing.modes=0"`, applied before any check.

    Raises:
        CaseError: with every problem found, each with its key, its value and the cure.
    """
    path = Path(path)
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise CaseError(str(path), [f"no such file{_nearest_file(path)}"]) from None
    except OSError as error:
        raise CaseError(str(path), [f"cannot be read: {error.strerror}"]) from None
    except UnicodeDecodeError:
        raise CaseError(str(path), ["not a text file in UTF-8"]) from None
    except tomllib.TOMLDecodeError as error:
        raise CaseError(str(path), [f"not valid TOML: {error}"]) from None
    except RecursionError:
        raise CaseError(str(path), ["not a case file: tables nested too deeply"]) from None
    return parse_case(apply_settings(document, settings, str(path)), str(path))


def parse_case(document: Mapping[str, Any], source: str = "case") -> Case:
    """Check a case given as nested dictionaries; `source` is named in the messages.

    Raises:
        CaseError: with every problem found.
    """
    try:
        return Case.model_validate(document)
    except ValidationError as error:
        problems = [describe(detail, document, Case) for detail in error.errors(include_url=False)]
        raise CaseError(source, list(dict.fromkeys(problems))) from None


def apply_settings(document: Mapping[str, Any], settings: Iterable[str], source: str) -> dict[str, Any]:
    """Apply `KEY=VALUE` settings to a document; values are TOML, and a bare word is a string.

    Raises:
        CaseError: for a setting that has no `=`, no readable value, or that goes through a number or text.
    """
    changed = _copy(document)
    problems = []
    for setting in settings:
        key, equals, text = (part.strip() for part in setting.partition("="))
        if not equals or not key:
            problems.append(f"--set {setting}: write KEY=VALUE, for example wing.modes=0")
            continue
        try:
            value = read_value(text)
        except ValueError as error:
            problems.append(f"--set {setting}: {error}")
            continue
        *tables, last = key.split(".")
        table = changed
        for name in tables:
            inner = table.setdefault(name, {})
            if not isinstance(inner, dict):
                problems.append(f"--set {setting}: {name} is a value, not a table")
                break
            table = inner
        else:
            table[last] = value
    if problems:
        raise CaseError(source, problems)
    return changed


def read_value(text: str) -> Any:
    """The value that a setting gives: TOML, or a bare word as a string.

    Raises:
        ValueError: when it is neither.
    """
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError):
        if text.replace("-", "_").isidentifier():
            return text
        raise ValueError(f'{text!r} is not a number, true, false, a "text" or a [list]') from None


def case_schema() -> dict[str, Any]:
    """JSON schema of a case file, for editors and validators."""
    schema = Case.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _copy(document: Mapping[str, Any]) -> dict[str, Any]:
    return {key: _copy(value) if isinstance(value, Mapping) else value for key, value in document.items()}


def _nearest_file(path: Path) -> str:
    try:
        names = [other.name for other in path.parent.glob("*.toml")]
    except OSError:
        return ""
    nearest = difflib.get_close_matches(path.name, names, 1)
    return f"; did you mean {path.with_name(nearest[0])}?" if nearest else ""
