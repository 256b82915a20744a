"""Matplotlib without the documentation of its classes' properties, which takes a third of its import's time.

Commands draw without it; a Python session has it, since a user may ask for it there.
"""

import os
from typing import Any


def skip() -> None:
    """Call before anything else of matplotlib is imported. TAICHIFLAP_DEBUG=1 keeps the documentation."""
    if os.environ.get("TAICHIFLAP_DEBUG"):
        return
    import matplotlib.artist  # noqa: PLC0415 - figures alone need it

    artist: Any = matplotlib.artist
    artist.kwdoc = _nothing
    artist.Artist._update_set_signature_and_docstring = classmethod(_nothing)


def _nothing(_: object) -> str:
    return ""
