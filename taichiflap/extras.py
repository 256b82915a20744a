"""Packages that not every installation has: imported where they are used, and named when they are missing."""

import importlib
from typing import Any

from .errors import UserError


def extra(package: str, name: str, need: str, error: type[UserError]) -> Any:
    """A package of the extra `name`.

    Args:
        need: what the user is told, such as `"--cluster needs Dask"`.

    Raises:
        UserError: an `error` that says how to install it, when it is missing.
    """
    try:
        return importlib.import_module(package)
    except ImportError:
        raise error(f'{need}: pip install "taichiflap[{name}]"') from None
