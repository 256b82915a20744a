"""`[time]`: how long and in which steps."""

from ..keys import Section, key


class Time(Section):
    """Duration and step."""

    periods: int = key(15, text="flapping periods", ge=1, le=100_000)
    steps_per_period: int = key(200, text="time steps a period", ge=4, le=1_000_000)
