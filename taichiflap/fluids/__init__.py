"""Fluid models, each behind the `interface`.

The models of this package go by their names; any other module that Python can import is one too, as `module:NAME`.
"""

import contextlib
import importlib
import re
import sys
import traceback
from collections.abc import Iterator

from ..case.case import Case, CaseError
from ..case.solver import ELSEWHERE
from ..errors import UserError
from .interface import Model

MODELS = ("dbet", "navier_stokes", "uvlm")
"""Packages here that hold a model, by the name that a case file gives it."""


def known(solver: str) -> Model | None:
    """A fluid model, if that runs no code of a stranger's: one of this package, or one that is imported already."""
    module = solver.removeprefix(ELSEWHERE)
    return load(solver) if module == solver or module in sys.modules else None


def check(case: Case) -> None:
    """Look at what a case says to its fluid model.

    Raises:
        ModelError: when there is no such model.
        CaseError: when it cannot compute the case, or `numbers` says what it does not take.
    """
    model = load(case.solver)
    model.parameters(case)
    problems = model.problems(case)
    if problems:
        raise CaseError(case.title or model.name, problems)


@contextlib.contextmanager
def blamed(solver: str) -> Iterator[None]:
    """Tells where in a model of one's own something is wrong, while it makes its arrays and its kernel is compiled.

    Raises:
        ModelError: one sentence with the file, the line and what is wrong there.
    """
    if not solver.startswith(ELSEWHERE):
        yield
        return
    try:
        yield
    except UserError:
        raise
    except Exception as error:
        raise ModelError(f'solver = "{solver}": {_place(error, solver.removeprefix(ELSEWHERE))}') from error


def _place(error: Exception, name: str) -> str:
    """Where in a module an error arose, and what it says."""
    file = str(getattr(sys.modules.get(name), "__file__", name))
    # Taichi, which compiles a function from its text, tells the lines in the error's own words, the inmost last.
    lines = [str(one.lineno) for one in traceback.extract_tb(error.__traceback__) if one.filename == file]
    lines += re.findall(rf'File "{re.escape(file)}", line (\d+)', str(error))
    told = str(error).strip().rpartition("\n")[2].strip()
    kind = "" if type(error).__name__ == "TaichiCompilationError" else f"{type(error).__name__}: "
    return f"{file}{f', line {lines[-1]}' if lines else ''}: {kind}{told}"


class ModelError(UserError):
    """Raised when a fluid model cannot be loaded: one sentence with its name, the cause and the cure."""


def load(solver: str) -> Model:
    """A fluid model by its name in the case file; only that one is imported.

    Raises:
        ModelError: when there is no such module, or it is no fluid model.
    """
    name = solver.removeprefix(ELSEWHERE)
    if name == solver:
        return importlib.import_module(f".{name}", __name__).MODEL
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise
        raise ModelError(
            f'solver = "{solver}": Python finds no module {error.name}; install it, or name its folder in PYTHONPATH'
        ) from None
    model = getattr(module, "MODEL", None)
    if not isinstance(model, Model):
        raise ModelError(
            f'solver = "{solver}": {name} is no fluid model: it has no MODEL, an instance of a class derived from '
            "taichiflap.fluids.interface.Model"
        )
    return model
