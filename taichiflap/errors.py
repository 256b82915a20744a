"""What a user can put right: one clear line a problem, with no traceback. Imports nothing."""


class UserError(ValueError):
    """The base of the errors that the command line prints as they are."""

    exit_code = 2
    """2 for what was asked wrongly; 1 for a run that failed."""
