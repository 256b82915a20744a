"""`[output]`: the contents of the result file."""

from .schema import CaseTable, key


class Output(CaseTable):
    """Contents of the result file."""

    every: int = key(
        1, text="steps between stored fields (shape, pressure, wake); series are stored at every step", ge=1, le=10**6
    )
