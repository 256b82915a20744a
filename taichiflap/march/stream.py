"""The free stream and its gust in kernels; `taichiflap.motion.gust` defines the gusts."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..case.case import Case
from ..kernels.arrays import array
from ..kernels.runtime import Octet, View, ti

KIND, SPEED, LENGTH, EDGE, CARRIED, AHEAD, ALONG_Y, ALONG_Z, FRONT = range(2, 11)
"""Columns after the free stream along Y and Z: index of the gust in `KINDS`; its velocity, m/s; its length, m; length
of the ramp at a sharp edge, m; speed of the stream, m/s; distance of the front upstream of the origin at t = 0, m;
direction of the stream; and position of the front along it at the current step, m.
"""

KINDS = "none", "sharp_edged", "one_minus_cosine", "sinusoidal"
NONE, SHARP_EDGED, ONE_MINUS_COSINE, SINUSOIDAL = range(4)


def streams(cases: Sequence[Case], pieces: Sequence[int]) -> Any:
    """Taichi array of `stream_rows`."""
    return array(stream_rows(cases, pieces))


def stream_rows(cases: Sequence[Case], pieces: Sequence[int]) -> np.ndarray:
    """The streams of a batch, one row per case.

    Args:
        pieces: number of elements along each case's chord; a sharp edge has the length of one.
    """
    rows = np.zeros((len(cases), FRONT + 1))
    for row, case, count in zip(rows, cases, pieces, strict=True):
        fluid = case.fluid
        row[:2] = fluid.velocity
        speed = math.hypot(*fluid.velocity)
        if fluid.gust == "none" or not speed:
            continue
        row[[KIND, SPEED, CARRIED]] = KINDS.index(fluid.gust), fluid.gust_velocity, speed
        row[[LENGTH, EDGE, AHEAD]] = fluid.gust_length or 1.0, case.wing.chord / count, speed * fluid.gust_arrival
        row[[ALONG_Y, ALONG_Z]] = np.array(fluid.velocity) / speed
    return rows


@ti.func
def carry_gust(stream: View, b, time):
    """Set the position of the gust front at a time."""
    stream[b, FRONT] = stream[b, CARRIED] * time - stream[b, AHEAD]


@ti.func
def gust_across(stream: View, b, y, z, edge):
    """Velocity of the gust, 90 degrees counter-clockwise from the stream; a sharp edge has the length `edge`."""
    behind = stream[b, FRONT] - stream[b, ALONG_Y] * y - stream[b, ALONG_Z] * z
    share = 0.0
    if stream[b, KIND] == SHARP_EDGED:
        share = ti.min(ti.max(behind / edge + 0.5, 0.0), 1.0)
    elif behind > 0.0:
        angle = 2.0 * math.pi * behind / stream[b, LENGTH]
        if stream[b, KIND] == SINUSOIDAL:
            share = ti.sin(angle)
        elif behind < stream[b, LENGTH]:
            share = 0.5 - 0.5 * ti.cos(angle)
    return stream[b, SPEED] * share


@ti.func
def gust_at(stream: View, b, y, z, edge):
    """Velocity of the gust at a point, along Y and Z."""
    across = 0.0
    if stream[b, KIND] > NONE:
        across = gust_across(stream, b, y, z, edge)
    return -stream[b, ALONG_Z] * across, stream[b, ALONG_Y] * across


@ti.func
def gust_at_octet(stream: View, b, y, z):
    """Velocity of the gust at eight points, along Y and Z."""
    across = Octet(0.0)
    if stream[b, KIND] > NONE:
        for lane in ti.static(range(8)):
            across[lane] = gust_across(stream, b, y[lane], z[lane], stream[b, EDGE])
    return across * -stream[b, ALONG_Z], across * stream[b, ALONG_Y]
