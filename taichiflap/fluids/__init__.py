"""Fluid models, each behind the `interface`.

Built-in models are selected by name; a model in any importable module is selected by `module:NAME`.
"""

import contextlib
import functools
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
"""Packages of the built-in models, by their name in the case file."""


def known(solver: str) -> Model | None:
    """A fluid model, if loading it runs no untrusted code: a built-in model, or one that is already imported."""
    module = solver.removeprefix(ELSEWHERE)
    return load(solver) if module == solver or module in sys.modules else None


def check(case: Case) -> None:
    """Check a case against its fluid model.

    Raises:
        ModelError: if the model does not exist.
        CaseError: if the model cannot compute the case, or does not accept its `numbers`.
    """
    model = load(case.solver)
    model.parameters(case)
    problems = model.problems(case)
    if problems:
        raise CaseError(case.title or model.name, problems)


@contextlib.contextmanager
def blamed(solver: str) -> Iterator[None]:
    """Context that locates errors in an external model while its arrays are made and its kernel is compiled.

    Raises:
        ModelError: one sentence with the file, the line and the error.
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
    """File and line of an error in a module, and its message."""
    file = str(getattr(sys.modules.get(name), "__file__", name))
    # Taichi compiles a function from its source; its error message lists the lines, innermost last.
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
        ModelError: if the module does not exist or is not a fluid model.
    """
    name = solver.removeprefix(ELSEWHERE)
    if name == solver:
        return _ours(name)
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise
        raise ModelError(
            f'solver = "{solver}": Python cannot find the module {error.name}; install it, or add its folder to '
            "PYTHONPATH"
        ) from None
    model = getattr(module, "MODEL", None)
    if not isinstance(model, Model):
        raise ModelError(
            f'solver = "{solver}": {name} is not a fluid model: it needs MODEL, an instance of a class derived from '
            "taichiflap.fluids.interface.Model"
        )
    return model


@functools.cache
def _ours(name: str) -> Model:
    """One of taichiflap's models; a study asks for it several times a case."""
    model: Model = importlib.import_module(f".{name}", __name__).MODEL
    return model
