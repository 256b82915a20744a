"""A whole case: its tables, reading, changing and checking it."""

import difflib
import math
import re
import tomllib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np
import tomli_w
from pydantic import Field, ValidationError, model_validator

from ..errors import UserError
from ..notation import printable
from .body import Body
from .dbet import Dbet
from .document import DocumentError, check, names_no_file, own_case, read_text, read_toml
from .fluid import Fluid
from .messages import describe
from .motion import Motion
from .navier_stokes import NavierStokes
from .output import Output
from .schema import CaseTable, ModelTable, key, needed, optional_table
from .solver import ELSEWHERE, Solver, model_name
from .tables import Table
from .tabulated import Origin, PointsError, reopened, with_points
from .time import Time
from .uvlm import Uvlm
from .wing import Wing

MAX_STEPS = 5_000_000
LEAST_STEPS = 4
"""Minimum number of steps per period, or per run, with an automatic step."""
WITHIN_WORDS = str.maketrans("-.:/", "____")
"""Characters allowed in a setting's value without quotes."""
HALF_A_NUMBER = re.compile(r"[+-]?(\d+\.|\.\d+)([eE][+-]?\d+)?")
"""A number as other languages write it, but not TOML."""
LONGEST_SHOWN = 60
"""Maximum length of a rejected value in a message."""
MOMENTS = 1024
"""Number of times at which the speed is sampled for the automatic step."""


class CaseError(UserError):
    """Raised for an invalid case; lists every problem, one per line."""

    def __init__(self, source: str, problems: list[str]) -> None:
        # Keep each problem on one line, even if the file's text has line breaks.
        self.source, self.problems = source, [printable(one) for one in problems]
        problems = self.problems
        super().__init__("\n".join(f"{source}: {problem}" for problem in problems))


class Case(CaseTable):
    """One case: an elastic wing section, its motion, the fluid and the model that computes it.

    Attributes follow the case file: `case.wing.chord` is the file's `chord` in `[wing]`. SI units; angles in degrees
    where the key ends in `_deg`. Cases are immutable; `override` returns a changed copy.
    """

    title: str = Field("", description="one-line description of the case")
    solver: Solver = key("uvlm", text="fluid model; module:NAME loads your own model from a Python module")
    numbers: dict[str, bool | float | str] | None = key(
        None, text="parameters of your own fluid model", example={"lift_slope": 6.0}
    )
    wing: Wing
    motion: Motion
    fluid: Fluid = optional_table(Fluid)
    body: Body = optional_table(Body)
    dbet: Dbet = optional_table(Dbet)
    uvlm: Uvlm = optional_table(Uvlm)
    navier_stokes: NavierStokes = optional_table(NavierStokes)
    time: Time = optional_table(Time)
    output: Output = optional_table(Output)

    @model_validator(mode="before")
    @classmethod
    def _steps_of_its_own(cls, given: Any) -> Any:
        """Use the automatic time step where it is the model's default."""
        if not isinstance(given, Mapping):
            return given
        table = cls.model_fields.get(str(given.get("solver")))
        if not getattr(table and table.annotation, "own_steps", False):
            return given
        time = given.get("time", {})
        if isinstance(time, Time):
            time = time.model_dump(exclude_unset=True, exclude_none=True)
        if not isinstance(time, Mapping) or any(key in time for key in ("steps_per_period", "duration", "step")):
            return given
        return {**given, "time": {**time, "steps_per_period": "auto"}}

    @model_validator(mode="after")
    def _valid(self) -> "Case":
        return self._together()

    def _together(self) -> "Case":
        """Check the tables, each of which is valid, against each other."""
        self._move()
        self._fit_model()
        if not self._step_is_unknown:
            self._check_time()
        return self

    def _move(self) -> None:
        """Derive plunge, pitch and surge from measured angles."""
        measured, frequency = self.motion.measured, self.motion.frequency
        if measured and frequency:
            from ..motion import measured as angles  # noqa: PLC0415 - only measured angles need it

            if problem := measured.problem(frequency) or angles.problem(measured, frequency):
                raise ValueError(f"motion.measured: {problem}")
            # Derived motions do not count as keys given in the file.
            moved = self.motion.model_copy()
            moved.__dict__.update(angles.travels(measured, frequency, self.wing.widest))
            self.__dict__["motion"] = moved

    def _fit_model(self) -> None:
        if self.motion.frequency is None and self.time.periods is not None:
            raise needed(
                "motion.frequency", "for a non-periodic motion give time.duration and time.step instead of periods"
            )
        table = getattr(self, self.solver, None)
        if isinstance(table, ModelTable):
            table.check(self)

    def _check_time(self) -> None:
        if self.steps > MAX_STEPS:
            product = "duration / time.step" if self.time.periods is None else "periods * time.steps_per_period"
            raise ValueError(f"time.{product} = {self.steps}; the limit is {MAX_STEPS} steps per case")
        for name, axis in (("plunge", self.motion.plunge), ("pitch", self.motion.pitch), ("surge", self.motion.surge)):
            if isinstance(axis, Table) and (problem := axis.problem(self.motion.frequency, self.duration)):
                raise ValueError(f"motion.{name}: {problem}")

    @property
    def model(self) -> str:
        """Display name of the fluid model."""
        return model_name(self.solver)

    @property
    def periodic(self) -> bool:
        """Whether the motion has a frequency."""
        return self.motion.frequency is not None

    @property
    def beat(self) -> float:
        """Period in s; the duration of the run for a non-periodic motion."""
        return self.duration if self.motion.frequency is None else 1.0 / self.motion.frequency

    @property
    def duration(self) -> float:
        """Duration of the run, s."""
        return self.steps * self.step

    @property
    def steps(self) -> int:
        """Number of time steps."""
        return self._march[0]

    @property
    def step(self) -> float:
        """Time step, s."""
        return self._march[1]

    @property
    def steps_per_beat(self) -> float:
        """Number of time steps per `beat`."""
        return self.steps / self.time.periods if self.time.periods else self.beat / self.step

    def frames(self, steps: int | None = None) -> int:
        """Number of stored frames in the first `steps` steps, step 0 included (None: all steps).

        Fields are stored every `output.every` steps and at the last step.
        """
        steps = self.steps + 1 if steps is None else steps
        beside = steps > self.steps and self.steps % self.output.every > 0
        return -(-steps // self.output.every) + beside

    def step_of(self, frame: Any) -> Any:
        """Step index of a frame, or of an array of frames, counted from 0."""
        return np.minimum(np.asarray(frame) * self.output.every, self.steps)

    @property
    def reference_speed(self) -> float:
        """Reference speed for `uvlm.suction_limit`, m/s.

        The value given in the case, or the root-mean-square speed of the rigid leading edge relative to the stream.
        """
        return self.uvlm.reference_speed or self._leading_edge_speed

    @cached_property
    def _leading_edge_speed(self) -> float:
        return self._edge_speed(-self.wing.pivot)

    @cached_property
    def _march(self) -> tuple[int, float]:
        """Number of time steps, and the time step in s."""
        time, frequency = self.time, self.motion.frequency
        if time.periods is not None and frequency is not None:
            asked = time.steps_per_period
            if not isinstance(asked, int):
                asked = max(math.ceil(1.0 / (frequency * self.matched_step())), LEAST_STEPS)
            return time.periods * asked, 1.0 / (frequency * asked)
        duration = cast(float, time.duration)
        if time.step == "auto":
            steps = max(math.ceil(duration / self.matched_step()), LEAST_STEPS)
            return steps, duration / steps
        step = cast(float, time.step)
        return math.floor(duration / step * (1.0 + 1e-12)), step

    def _edge_speed(self, behind: float) -> float:
        """Root-mean-square speed (m/s) relative to the stream over a beat, at a distance behind the pivot in chords."""
        from ..motion import sampling as motion  # noqa: PLC0415 - few cases need it

        over = 1.0 / self.motion.frequency if self.motion.frequency else cast(float, self.time.duration)
        times = self.motion.growth * self.periodic + over * np.arange(MOMENTS) / MOMENTS
        return motion.typical_speed(self.motion, behind * self.wing.chord, self.fluid.velocity, times)

    @property
    def _step_is_unknown(self) -> bool:
        """Whether the step is that of an external model that has not been imported: a stored case does not do it."""
        if not self.solver.startswith(ELSEWHERE) or "auto" not in (self.time.step, self.time.steps_per_period):
            return False
        from .. import fluids  # noqa: PLC0415 - few cases ask

        return fluids.known(self.solver) is None

    def matched_step(self) -> float:
        """Time (s) in which the trailing edge travels the model's stride through the fluid.

        Raises:
            ValueError: if nothing moves; CaseError, if only an external model that has not been imported knows it.
        """
        from .. import fluids  # noqa: PLC0415 - only an automatic step needs them

        model = fluids.known(self.solver)
        if model is None:
            why = f'time: only the module of solver = "{self.solver}" knows its automatic step, and no file imports it'
            raise CaseError(self.title or "case", [why])
        speed = self._edge_speed(1.0 - self.wing.pivot)
        if not speed:
            raise ValueError('time: "auto" needs a moving wing or a stream; give the time step as a number')
        return model.stride(self) / speed

    def resolved(self) -> "Case":
        """The case with its automatic time step resolved and the fluid model's own defaults filled in."""
        from .. import fluids  # noqa: PLC0415 - to run it, not to read it

        name = {"steps_per_period": round(self.steps_per_beat), "step": self.step}
        automatic = {key: value for key, value in name.items() if getattr(self.time, key) == "auto"}
        found = self.model_copy(update={"time": self.time.model_copy(update=automatic)}) if automatic else self
        return fluids.load(self.solver).completed(found)

    def override(self, *settings: str, **named: Any) -> "Case":
        """A copy with some keys changed, checked like a file: `case.override("wing.modes=0", title="rigid")`.

        Raises:
            CaseError: with every problem found.
        """
        document = {**apply_settings(self._opened(settings), settings, "override"), **named}
        return self._following(document, "override", self.origin.folder or Path())

    def changed(
        self, values: Mapping[str, Any], source: str = "changed", checked: dict[Any, Any] | None = None
    ) -> "Case":
        """A copy with some dotted keys changed. Only the changed tables are checked again.

        Args:
            checked: tables with changed numbers that have been checked before, for many copies of this case; this one's
                are added.

        Raises:
            CaseError: with every problem found.
        """
        keys = _tables(values) if checked is not None and not self.origin.tables else {}
        if checked is None or not keys:
            return self._checked(values, source)
        if all(key in checked for key in keys.values()):
            tables = {name: checked[key] for name, key in keys.items()}
            with suppress(ValueError):  # which is told below
                found = self.model_copy(update=tables)
                for derived in [name for name in found.__dict__ if name.startswith("_")]:
                    del found.__dict__[derived]
                return found._together()._from(Origin(self.origin.folder))
        case = self._checked(values, source)
        # Cases that share a table's values share the table.
        case.__dict__.update({name: checked.setdefault(key, getattr(case, name)) for name, key in keys.items()})
        return case

    def _checked(self, values: Mapping[str, Any], source: str) -> "Case":
        document = self._opened(values)
        problems = [
            f"{key}: {hit} is a value, not a table" for key in values if (hit := _place(document, key, values[key]))
        ]
        if problems:
            raise CaseError(source, problems)
        return self._following(document, source, self.origin.folder)

    @property
    def origin(self) -> Origin:
        """Files from which the motion tables were read; empty for a case stored in a result or map."""
        return self.__dict__.get("_origin", Origin())

    def _following(self, document: Mapping[str, Any], source: str, folder: Path | None) -> "Case":
        """The case of a changed document. Motion tables shared with this case keep their origin."""
        case = parse_case(document, source, folder)
        kept = {name: given for name, given in self.origin.tables.items() if _points(case, name) == _points(self, name)}
        return case._from(Origin(self.origin.folder, kept | case.origin.tables))

    def _from(self, origin: Origin) -> "Case":
        # Stored like a cached property, so that it does not count as a field of the case.
        self.__dict__["_origin"] = origin
        return self

    def _opened(self, keys: Iterable[str]) -> dict[str, Any]:
        """The case by table: changed tables as plain values, unchanged tables as they are."""
        keys = {key.partition("=")[0].strip() for key in keys}
        names = {key.partition(".")[0] for key in keys}
        opened = self.model_dump(mode="json", exclude_none=True, include=names)
        # Defaults of the lattice depend on its leading edge, and those of the time are in periods.
        for name, table in (("uvlm", self.uvlm), ("time", self.time)):
            if name in opened:
                opened[name] = table.model_dump(mode="json", exclude_none=True, exclude_unset=True)
        if "motion" in opened:
            opened["motion"] = reopened(opened["motion"], keys, self.origin)
        return {name: opened.get(name, value) for name, value in self if value is not None}

    def _repr_html_(self) -> str:
        from ..notebook import html  # noqa: PLC0415 - notebooks alone ask for it

        return html.of_case(self)

    def to_dict(self) -> dict[str, Any]:
        """The case as plain dictionaries, lists and numbers."""
        return self.model_dump(mode="json", exclude_none=True)

    def to_toml(self) -> str:
        """The case as TOML text. `load_case` reads it back to an equal case."""
        return tomli_w.dumps(self.to_dict())


def _tables(values: Mapping[str, Any]) -> dict[str, Any]:
    """A key for each changed table by its name, made of the numbers that are changed; empty if not all are numbers."""
    found: dict[str, list[Any]] = {}
    for name, value in values.items():
        table, dot, _ = name.partition(".")
        if not dot or type(value) not in (int, float):
            return {}
        found.setdefault(table, []).append((name, type(value), value))
    return {table: tuple(changed) for table, changed in found.items()}


def _points(case: Case, name: str) -> Any:
    return getattr(getattr(case.motion, name), "given", None)


def load_case(path: str | Path, settings: Iterable[str] = ()) -> Case:
    """Read a case file.

    Args:
        path: a TOML file.
        settings: overrides such as `"wing.modes=0"`, or a single one, applied before any check.

    Raises:
        CaseError: with every problem found, each with its key, its value and the cure.
    """
    path = Path(path)
    try:
        document = read_toml(read_text(path))
    except FileNotFoundError:
        why = "is a broken link" if path.is_symlink() else f"no such file{_nearest_file(path)}"
        raise CaseError(str(path), [why]) from None
    except OSError as error:
        raise CaseError(str(path), [f"cannot be read: {error.strerror}"]) from None
    except UnicodeDecodeError:
        raise CaseError(str(path), [_no_text(path)]) from None
    except DocumentError as error:
        raise CaseError(str(path), [str(error)]) from None
    return parse_case(apply_settings(document, settings, str(path)), str(path), path.parent)


def parse_case(document: Mapping[str, Any], source: str = "case", folder: Path | None = Path()) -> Case:
    """Check a case given as nested dictionaries.

    Args:
        source: name of the case in messages.
        folder: folder of the files that the case names; None forbids such files.

    Raises:
        CaseError: with every problem found.
    """
    try:
        check(document)
        origin = Origin(folder)
        if folder is None:
            names_no_file(document)
        else:
            document, origin = with_points(document, folder)
        case = Case.model_validate(document)._from(origin)
        if folder is not None and case._step_is_unknown:
            from .. import fluids  # noqa: PLC0415 - few cases need it

            fluids.load(case.solver)
            case._check_time()
        return case
    except (DocumentError, PointsError) as error:
        raise CaseError(source, [str(error)]) from None
    except ValidationError as error:
        found = [detail for detail in error.errors(include_url=False) if detail["type"] != "none_required"]
        problems = [describe(detail, document, Case) for detail in found]
        raise CaseError(source, list(dict.fromkeys(problems))) from None
    except UserError:
        raise
    except ValueError as error:
        raise CaseError(source, [str(error)]) from None


def held_case(text: str, source: str) -> Case:
    """The case stored in a result or map, which is untrusted: no file is opened, and its text is made printable.

    Raises:
        CaseError: with every problem found.
    """
    try:
        document = own_case(text)
    except DocumentError as error:
        raise CaseError(source, [str(error)]) from None
    return parse_case(document, source, None)


def apply_settings(document: Mapping[str, Any], settings: Iterable[str], source: str) -> dict[str, Any]:
    """Apply `KEY=VALUE` settings to a document; values are TOML, and a bare word is a string.

    Raises:
        CaseError: if a setting has no `=`, an invalid value, or a key below something that is not a table.
    """
    changed = _copy(document)
    problems = []
    for setting in [settings] if isinstance(settings, str) else settings:
        key, equals, text = (part.strip() for part in setting.partition("="))
        if not equals or not all(key.split(".")):
            problems.append(f"--set {_shown(setting)}: write KEY=VALUE, for example wing.modes=0")
            continue
        try:
            value = read_value(text)
        except ValueError as error:
            problems.append(f"--set {_shown(setting)}: {error}")
            continue
        if hit := _place(changed, key, value):
            problems.append(f"--set {_shown(setting)}: {hit} is a value, not a table")
    if problems:
        raise CaseError(source, problems)
    return changed


def read_value(text: str) -> Any:
    """Value of a setting: TOML, or a bare word as a string.

    Raises:
        ValueError: if it is neither.
    """
    try:
        found = tomllib.loads(f"value = {text}")
    except (ValueError, OverflowError, RecursionError):
        if HALF_A_NUMBER.fullmatch(text):
            raise ValueError(f"{_shown(text)} needs digits on both sides of the point, as in 0.5") from None
        if text.translate(WITHIN_WORDS).isidentifier():
            return text
        found = {}
    if len(found) != 1:  # or several lines
        raise ValueError(
            f'{_shown(text)!r} is not a number, true, false, a [list] or a "text" (in a shell write \'KEY="TEXT"\')'
        )
    return found["value"]


def _shown(text: str) -> str:
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."


def case_schema() -> dict[str, Any]:
    """JSON schema of a case file, for editors and validators."""
    schema = Case.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _place(document: dict[str, Any], key: str, value: Any) -> str:
    """Set the value of a dotted key. Returns the first part of the key that is not a table, if any."""
    *tables, last = key.split(".")
    for name in tables:
        document = document.setdefault(name, {})
        if not isinstance(document, dict):
            return name
    document[last] = value
    return ""


def _copy(document: Mapping[str, Any]) -> dict[str, Any]:
    return {key: _copy(value) if isinstance(value, Mapping) else value for key, value in document.items()}


def _no_text(path: Path) -> str:
    with path.open("rb") as file:
        if file.read(4) == b"\x89HDF":
            return "this is a result or a map, not a case file; taichiflap info describes it"
    return "not a UTF-8 text file"


def _nearest_file(path: Path) -> str:
    try:
        names = [other.name for other in path.parent.glob("*.toml")]
    except OSError:
        return ""
    nearest = difflib.get_close_matches(path.name, names, 1)
    return f"; did you mean {path.with_name(nearest[0])}?" if nearest else ""
