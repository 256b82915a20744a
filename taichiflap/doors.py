"""Lazy imports: a package's public names are imported at first use, and old module names still work."""

import contextlib
import importlib
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

MOVED = {
    "taichiflap.beam": "taichiflap.structure.beam",
    "taichiflap.body": "taichiflap.march.state",
    "taichiflap.linear": "taichiflap.kernels.linear",
    "taichiflap.profile": "taichiflap.structure.chordwise",
    "taichiflap.profiles": "taichiflap.motion.waveforms",
    "taichiflap.runtime": "taichiflap.kernels.runtime",
    "taichiflap.variables": "taichiflap.results.variables",
}
"""Modules of version 0.1 that have moved, and their new names. The old names are removed in version 0.3."""


def lazy(package: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """A package's `__getattr__`.

    Args:
        package: the package's `__name__`.
        homes: for each public name the module that defines it.
    """

    def fetch(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(importlib.import_module(f".{homes[name]}", package), name)

    return fetch


@contextlib.contextmanager
def late(*names: str) -> Iterator[None]:
    """Around the import of a library: modules that it imports without need are loaded when it uses them."""
    waiting = {name: _Late(name) for name in names if name not in sys.modules}
    sys.modules.update(waiting)
    try:
        yield
    finally:
        for name, stub in waiting.items():
            del sys.modules[name]
            home, _, own = name.rpartition(".")
            if home in sys.modules:
                setattr(sys.modules[home], own, stub)


class _Late(ModuleType):
    """Stands for a module until something of it is asked for."""

    def __getattr__(self, name: str) -> Any:
        return getattr(importlib.import_module(self.__name__), name)


class Moved(MetaPathFinder, Loader):
    """Imports a module of `MOVED` under its old name, with a warning."""

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        return ModuleSpec(name, self) if name in MOVED else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        home = MOVED[spec.name]
        warnings.warn(f"{spec.name} is now {home}", DeprecationWarning, stacklevel=2)
        module = importlib.import_module(home)
        self._own = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        # Restore the spec, which Python has replaced by that of the old name.
        module.__spec__ = self._own


def leave_words() -> None:
    """Make moved modules importable under their old names."""
    if not any(isinstance(finder, Moved) for finder in sys.meta_path):
        sys.meta_path.append(Moved())
