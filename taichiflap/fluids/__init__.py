"""Fluid models. Each is one module behind the interface that `taichiflap.march` describes."""

import importlib
from types import ModuleType


def load(solver: str) -> ModuleType:
    """The module of a fluid model by its name in the case file; only that one is imported."""
    return importlib.import_module(f"{__name__}.{solver}")
