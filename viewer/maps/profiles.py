"""A map's metric along either key through one case, as two charts next to the map."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..charts import HEIGHT
from ..colours import RUNS
from .picture import Array, Profile

WIDTH = 290
HINT = "Point at a cell to plot the metric along either key."


class Profiles:
    """The charts of one browser.

    Args:
        gui: what adds them.
    """

    def __init__(self, gui: Any) -> None:
        self._gui = gui
        panel = gui.add_panel()
        self._tab = panel.add_tab("Profiles")
        panel.dock_right()
        panel.set_width(WIDTH)
        with self._tab:
            self._told = gui.add_html("")
        self._charts: list[Any] = []
        self._drawn: list[str] = []

    def show(self, profiles: Sequence[Profile], names: dict[str, str], metric: str, case: str) -> None:
        """Draw the profiles, each over its key.

        Args:
            names: of the keys, with their units.
            metric: its name, with its unit.
            case: through which they go.
        """
        self._told.content = f'<div data-profiles style="padding:4px;font-size:12px">{case or HINT}</div>'
        if self._drawn != [metric, *(one.key for one in profiles)]:
            self._make(profiles, names, metric)
        for chart, one in zip(self._charts, profiles, strict=True):
            chart.data = _known(one)

    def _make(self, profiles: Sequence[Profile], names: dict[str, str], metric: str) -> None:
        for chart in self._charts:
            chart.remove()
        line = {"label": metric, "stroke": RUNS[0], "width": 1.8, "points": {"show": True, "size": 4}}
        with self._tab:
            self._charts = [
                self._gui.add_uplot(
                    _known(one),
                    ({"label": names[one.key]}, line),
                    title=f"over {names[one.key]}",
                    scales={"x": {"time": False, "range": _ends(one)} | ({"distr": 3, "log": 10} if one.log else {})},
                    axes=({"size": 26, "space": 40}, {"size": 46, "space": 17}),
                    legend={"show": False},
                    height=int(1.6 * HEIGHT),
                    padding=(8, 14, 0, 0),
                )
                for one in profiles
            ]
        self._drawn = [metric, *(one.key for one in profiles)]


def _known(profile: Profile) -> tuple[Array, Array]:
    """The cases with a metric; uPlot finds no range for data that start with NaN."""
    there = np.isfinite(profile.values)
    return profile.places[there], profile.values[there]


def _ends(profile: Profile) -> tuple[float, float]:
    """Ends of the axis of a key; those of a single value lie around it, since uPlot fails without a range."""
    low, high = float(profile.places.min()), float(profile.places.max())
    spare = 0.5 * (abs(low) or 1.0) if low == high else 0.0
    return low - spare, high + spare
