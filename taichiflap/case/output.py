"""`[output]`: what is kept."""

from .schema import Section, key


class Output(Section):
    """What the result file keeps."""

    every: int = key(1, text="steps between stored fields: shape, pressure, wake; series have them all", ge=1, le=10**6)
