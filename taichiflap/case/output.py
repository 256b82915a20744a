"""`[output]`: what is kept."""

from .schema import Section, key


class Output(Section):
    """What the result file keeps."""

    every: int = key(1, text="steps between stored frames", ge=1, le=1_000_000)
