"""`[motion]`: what the leading edge is made to do."""

from ..keys import Section, key, section


class Plunge(Section):
    """Plunge along Z: amplitude * sin(2 pi frequency t + phase)."""

    amplitude: float = key(0.0, unit="m", text="amplitude", ge=0, le=100)
    phase_deg: float = key(0.0, unit="deg", text="phase advance", ge=-360, le=360)


class Pitch(Section):
    """Pitch about the leading edge: mean + amplitude * sin(2 pi frequency t + phase)."""

    amplitude_deg: float = key(0.0, unit="deg", text="amplitude", ge=0, le=360)
    phase_deg: float = key(0.0, unit="deg", text="phase advance", ge=-360, le=360)
    mean_deg: float = key(0.0, unit="deg", text="mean angle", ge=-360, le=360)


class Motion(Section):
    """Prescribed motion of the leading edge."""

    frequency: float = key(unit="Hz", text="flapping frequency", example=25.0, gt=0, le=1e5)
    plunge: Plunge = section(Plunge)
    pitch: Pitch = section(Pitch)
