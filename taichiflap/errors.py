"""What a user can put right: one clear line a problem, with no traceback."""

import importlib
from typing import Any


class UserError(ValueError):
    """The base of the errors that the command line prints as they are."""

    exit_code = 2
    """2 for what was asked wrongly; 1 for a run that failed."""


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
