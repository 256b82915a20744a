"""Matplotlib without two things that commands do not need, which take a third of its import's time.

These are the documentation of its classes' properties, and TeX's names of letters. A Python session has both.
"""

import os
from typing import Any

from ..doors import late


def skip() -> None:
    """Call before anything else of matplotlib is imported. TAICHIFLAP_DEBUG=1 keeps everything."""
    if os.environ.get("TAICHIFLAP_DEBUG"):
        return
    with late("fontTools.agl"):
        import matplotlib.artist  # noqa: PLC0415 - figures alone need it

        artist: Any = matplotlib.artist
        artist.kwdoc = _nothing
        artist.Artist._update_set_signature_and_docstring = classmethod(_nothing)
        import matplotlib.backends.backend_agg  # noqa: PLC0415


def _nothing(_: object) -> str:
    return ""
