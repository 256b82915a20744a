"""Fluid models, each behind the `interface`.

The models of this package go by their names; any other module that Python can import is one too, as `module:NAME`.
"""

import importlib

from ..case.solver import ELSEWHERE
from ..errors import UserError
from .interface import Model

MODELS = ("dbet", "uvlm")
"""Packages here that hold a model, by the name that a case file gives it."""


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
