"""A comparison with a user's own measurement as text and as a page."""

import cmath
import math
from collections.abc import Iterator, Sequence

from ... import pages
from .against import ORDERS, ROUND_OFF, Comparison, Figures
from .tiers import Tier

HEADS = ("mean", *(f"harmonic {order}" for order in range(1, ORDERS + 1)), "peak", "at", "rms diff.")
WIDTH = 18
"""Characters of a column of the terminal."""


def stated(found: Comparison, tiers: Sequence[Tier]) -> Iterator[str]:
    """How trace and models were put beside each other: phase and reference; models in doubt, and failures."""
    unit = "beats" if found.periodic else "s"
    labels = {tier.name: tier.label for tier in tiers}
    if found.alone:
        alone = ", ".join(f"{labels[name]} {late:+.3f}" for name, late in found.alone.items())
        yield (
            f"phase: the trace is delayed by {found.shift:.3f} {unit}, one shift for all its quantities and models "
            f"(each model alone: {alone}); peak times and phases are after this shift"
        )
    else:
        yield f"phase: the trace is delayed by {found.shift:.3f} {unit}, as stated"
    if any(units[0] == "1" for name, units in found.trace.units.items() if name in found.measured):
        scale = found.scale
        own = "the speed of the stream" if scale.stream else "rms of the middle of the chord over a beat"
        speed = "as stated" if found.speed_given else own
        area = "as stated" if found.area_given else "chord times span"
        yield (
            f"reference: {scale.speed:.4g} m/s ({speed}), {scale.area:.4g} m2 ({area}), "
            f"density {scale.density:.4g} kg/m3"
        )
    for name, keys in found.own.items():
        yield f"{labels[name]} has the case's own {', '.join(keys)}; leave them out of the case for its defaults"
    for name, doubt in found.doubts.items():
        yield f"warning: {labels[name]}: {doubt}"
    for name, reason in found.failed.items():
        yield f"{labels[name]} failed: {reason}"


def lines(found: Comparison, tiers: Sequence[Tier]) -> Iterator[str]:
    """The comparison for the terminal."""
    yield f"{found.trace.path} compared with the models"
    yield from (f"  {line}" for line in stated(found, tiers))
    for name, (_, rows) in _tables(found, tiers).items():
        yield f"  {name}"
        for head, *cells in (("", *HEADS), *rows):
            yield f"    {head:<16}" + "".join(f"{cell:>{WIDTH}}" for cell in cells)


def blocks(found: Sequence[Comparison], tiers: Sequence[Tier], names: Sequence[str]) -> list[pages.Block]:
    """The page: a section a trace, with its figure.

    Args:
        names: the stems of the figures.
    """
    said: list[pages.Block] = [
        pages.Heading(1, "Measurement and models"),
        pages.Paragraph(
            "Harmonics are amplitude and phase, of `a cos(2 pi n t/T + phase)`. The peak is the largest magnitude; its "
            "time is in beats, or in s of a motion that does not repeat. The last column is the root mean square of "
            "the difference over that of the measurement. Models are means over their settled "
            "beats; ± is the standard error of the mean, of ten settled beats and more."
        ),
    ]
    for one, name in zip(found, names, strict=True):
        said.append(pages.Heading(2, one.trace.path.name))
        said += [pages.Paragraph(f"{line[0].upper()}{line[1:]}.") for line in stated(one, tiers)]
        for quantity, (head, rows) in _tables(one, tiers).items():
            said.append(pages.Table((quantity, *head), rows))
        said.append(pages.Figure(name, f"{one.trace.path.name} and the models"))
    return said


def _tables(found: Comparison, tiers: Sequence[Tier]) -> dict[str, tuple[tuple[str, ...], list[tuple[str, ...]]]]:
    """By quantity with its unit the heads, and a row for the measurement and each model."""
    told = {}
    for quantity, measured in found.measured.items():
        own = found.modelled[quantity]
        size = max(abs(one.peak) for one in (measured, *own.values()))
        rows = [("measured", *_cells(measured, size), "")]
        for tier in tiers:
            if tier.name in own:
                rows.append(
                    (tier.label, *_cells(own[tier.name], size), f"{100 * found.rms(quantity, tier.name):.0f} %")
                )
        unit = found.trace.units[quantity][0]
        told[quantity if unit == "1" else f"{quantity} [{unit}]"] = (HEADS, rows)
    return told


def _cells(one: Figures, size: float) -> tuple[str, ...]:
    waves = [_wave(wave, size) for wave in one.harmonics] or ["-"] * ORDERS
    error = f" ± {one.error:.2g}" if one.error > ROUND_OFF * size else ""
    return (_told(one.mean, size) + error, *waves, _told(one.peak, size), f"{one.peak_time:.3f}")


def _wave(wave: complex, size: float) -> str:
    if abs(wave) <= ROUND_OFF * size:
        return "0"
    return f"{abs(wave):.3g}, {math.degrees(cmath.phase(wave)):.0f} deg"


def _told(value: float, size: float) -> str:
    return f"{value:.4g}" if abs(value) > ROUND_OFF * size else "0"
