"""User errors: one clear line per problem, without a traceback."""

import importlib
from typing import Any


class UserError(ValueError):
    """Base class of errors that the command line prints without a traceback."""

    exit_code = 2
    """Exit code: 2 for wrong input, 1 for a failed run."""


def extra(package: str, name: str, need: str, error: type[UserError]) -> Any:
    """Import a package of the extra `name`.

    Args:
        need: start of the message, such as `"--cluster needs Dask"`.

    Raises:
        UserError: an `error` with the installation command, if it is missing.
    """
    try:
        return importlib.import_module(package)
    except ImportError:
        raise error(f'{need}: pip install "taichiflap[{name}]"') from None
