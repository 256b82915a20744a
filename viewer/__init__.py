"""The browser viewer of taichiflap's results. Reads them through `taichiflap.results`; the solver never imports it."""

from .app import Viewer, ViewError, view

__all__ = ["ViewError", "Viewer", "view"]
