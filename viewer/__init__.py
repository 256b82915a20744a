"""The browser viewer of results, maps and cases. The solver does not import it."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .app import Viewer, ViewError, view

__all__ = ["ViewError", "Viewer", "view"]


def __getattr__(name: str) -> Any:
    # Imported lazily, since viser is slow to import and `simulate --view` only starts another process.
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import app  # noqa: PLC0415

    return getattr(app, name)
