"""What a case file may say: keys, units, ranges, defaults, and the messages when it says something else."""

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import tomli_w
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from .errors import UserError
from .problems import describe

MAX_STEPS = 5_000_000


class CaseError(UserError):
    """A case that cannot be run: every problem found, one line each."""

    def __init__(self, source: str, problems: list[str]) -> None:
        self.source, self.problems = source, problems
        super().__init__("\n".join(f"{source}: {problem}" for problem in problems))


def _key(default: Any = ..., *, unit: str = "", text: str, example: Any = None, **limits: Any) -> Any:
    """A key of the case file with its meaning, its unit and its allowed range."""
    example = default if example is None else example
    extra: dict[str, Any] = {"unit": unit} if unit else {}
    return Field(default, description=text, examples=[example], json_schema_extra=extra, **limits)


def _section(model: type[BaseModel]) -> Any:
    return Field(default_factory=model, description=(model.__doc__ or "").strip().rstrip("."))


def _as_tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _one_or_each(value: Any) -> str:
    return "each" if isinstance(value, list | tuple) else "one"


def _all_or_number(value: Any) -> str:
    return "all" if isinstance(value, str) else "number"


_Damping = Annotated[float, Field(ge=0, le=10)]
DampingRatio = Annotated[
    Annotated[_Damping, Tag("one")] | Annotated[tuple[_Damping, ...], BeforeValidator(_as_tuple), Tag("each")],
    Discriminator(_one_or_each),
]
WakeLength = Annotated[
    Annotated[int, Field(ge=1, le=1_000_000), Tag("number")] | Annotated[Literal["all"], Tag("all")],
    Discriminator(_all_or_number),
]
Velocity = Annotated[
    tuple[Annotated[float, Field(ge=-1000, le=1000)], Annotated[float, Field(ge=-1000, le=1000)]],
    BeforeValidator(_as_tuple),
]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Wing(_Section):
    """A uniform wing section, clamped at its leading edge."""

    chord: float = _key(unit="m", text="chord, leading to trailing edge", example=0.02, gt=0, le=100)
    span: float = _key(unit="m", text="span, out of the page", example=0.05, gt=0, le=100)
    thickness: float = _key(unit="m", text="thickness", example=40e-6, gt=0, le=10)
    density: float = _key(unit="kg/m3", text="density of the wing's material", example=1000.0, gt=0, le=1e5)
    youngs_modulus: float = _key(unit="Pa", text="Young's modulus", example=24.5e9, gt=0, le=1e13)
    modes: int = _key(1, text="elastic modes kept; 0 is a rigid wing", ge=0, le=20)
    damping_ratio: DampingRatio = _key(0.05, text="damping ratio: one, or one per mode")

    @field_validator("damping_ratio")
    @classmethod
    def _one_per_mode(cls, value: Any, info: ValidationInfo) -> Any:
        modes = info.data.get("modes")
        if isinstance(value, tuple) and modes is not None and len(value) < modes:
            raise ValueError(f"too few for {modes} modes; give one number, or one per mode")
        return value


class Plunge(_Section):
    """Plunge along Z: amplitude * sin(2 pi frequency t + phase)."""

    amplitude: float = _key(0.0, unit="m", text="amplitude", ge=0, le=100)
    phase_deg: float = _key(0.0, unit="deg", text="phase advance", ge=-360, le=360)


class Pitch(_Section):
    """Pitch about the leading edge: mean + amplitude * sin(2 pi frequency t + phase)."""

    amplitude_deg: float = _key(0.0, unit="deg", text="amplitude", ge=0, le=360)
    phase_deg: float = _key(0.0, unit="deg", text="phase advance", ge=-360, le=360)
    mean_deg: float = _key(0.0, unit="deg", text="mean angle", ge=-360, le=360)


class Motion(_Section):
    """Prescribed motion of the leading edge."""

    frequency: float = _key(unit="Hz", text="flapping frequency", example=25.0, gt=0, le=1e5)
    plunge: Plunge = _section(Plunge)
    pitch: Pitch = _section(Pitch)


class Fluid(_Section):
    """The fluid around the wing."""

    density: float = _key(1.225, unit="kg/m3", text="density of the fluid", ge=0, le=1e5)
    velocity: Velocity = _key((0.0, 0.0), unit="m/s", text="free stream along Y and Z (-Y is up)")


class Dbet(_Section):
    """Deformable blade element theory, quasi-steady."""

    elements: int = _key(50, text="blade elements along the chord", ge=1, le=10_000)
    lift_max: float = _key(1.8, text="largest lift coefficient, at 45 degrees", ge=0, le=100)
    drag_min: float = _key(0.4, text="drag coefficient along the chord", ge=0, le=100)
    drag_max: float = _key(4.0, text="drag coefficient across the chord", ge=0, le=100)
    added_mass: bool = _key(True, text="include the added mass of the fluid")
    speed: Literal["full", "truncated"] = _key(
        "full", text="square of the local speed: full, or truncated as the paper's Eqs 21-22"
    )


class Uvlm(_Section):
    """Unsteady vortex lattice on the deformed camber line, with a free wake."""

    panels: int = _key(50, text="panels along the chord", ge=1, le=1000)
    spacing: Literal["uniform"] = _key("uniform", text="spacing of the panels")
    wake: WakeLength = _key("all", text='wake vortices kept, or "all"')
    old_wake: Literal["drop"] = _key("drop", text="what happens to the oldest vortex of a full wake")
    shedding: Literal["local", "fixed"] = _key(
        "local",
        text="new vortex at 0.25 of the trailing edge's travel relative to the flow, or at a fixed distance",
    )
    shedding_distance: float = _key(
        0.05, unit="chords", text='distance behind the trailing edge, for shedding = "fixed"', gt=0, le=10
    )
    core: float = _key(0.0, unit="chords", text="Krasny core of every wake interaction", ge=0, le=1)


class Time(_Section):
    """Duration and step."""

    periods: int = _key(15, text="flapping periods", ge=1, le=100_000)
    steps_per_period: int = _key(200, text="time steps a period", ge=4, le=1_000_000)


class Output(_Section):
    """What the result file keeps."""

    every: int = _key(1, text="steps between stored frames", ge=1, le=1_000_000)


class Case(_Section):
    """One case: an elastic wing section, its motion, the fluid and the model that computes it.

    Attributes follow the case file: `case.wing.chord` is the file's `chord` in `[wing]`. SI units; angles in
    degrees where the key ends in `_deg`. Cases are immutable; `override` gives a changed copy.
    """

    title: str = Field("", description="a line that says what this is")
    solver: Literal["uvlm", "dbet"] = Field("uvlm", description="fluid model")
    wing: Wing
    motion: Motion
    fluid: Fluid = _section(Fluid)
    dbet: Dbet = _section(Dbet)
    uvlm: Uvlm = _section(Uvlm)
    time: Time = _section(Time)
    output: Output = _section(Output)

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
            value = tomllib.loads(f"value = {text}")["value"]
        except (tomllib.TOMLDecodeError, RecursionError):
            if not text.replace("-", "_").isidentifier():
                problems.append(f'--set {setting}: {text!r} is not a number, true, false, a "text" or a [list]')
                continue
            value = text
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
