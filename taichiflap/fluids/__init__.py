"""Fluid models. Each is one module behind the interface that `taichiflap.march` describes.

The models of this package go by their names; any other module that Python can import is one too, as `module:NAME`.
"""

import importlib
from types import ModuleType

from ..case.solver import ELSEWHERE
from ..errors import UserError

MODELS = {"dbet": "dbet", "uvlm": "uvlm.model"}
"""Module of this package for each solver of the case file."""

INTERFACE = (
    "GROUPS", "allocate", "film", "trim", "nodes", "vortices", "work", "frame_bytes", "prepare", "settle", "record",
)  # fmt: skip


class ModelError(UserError):
    """A fluid model that cannot be had: one sentence with its name, the cause and the cure."""


def load(solver: str) -> ModuleType:
    """The module of a fluid model by its name in the case file; only that one is imported.

    Raises:
        ModelError: when there is no such module, or it is no fluid model.
    """
    name = solver.removeprefix(ELSEWHERE)
    if name == solver:
        return importlib.import_module(f".{MODELS[name]}", __name__)
    try:
        model = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise
        raise ModelError(
            f'solver = "{solver}": Python finds no module {error.name}; install it, or name its folder in PYTHONPATH'
        ) from None
    missing = [part for part in INTERFACE if not hasattr(model, part)]
    if missing:
        raise ModelError(f'solver = "{solver}": {name} is no fluid model: it has no {", ".join(missing)}')
    return model
