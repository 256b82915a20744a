"""The picture of a case's motion, as `taichiflap preview` draws it, over the scene at the push of a button."""

import functools
import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taichiflap.case.case import Case, held_case

TITLE = "Motion"
HINT = "path, angle of attack and speeds of the prescribed motion over a beat"
RESOLUTION = 130
"""Dots an inch."""
WIDTH = 760
"""Of the window, pixels."""

_drawing = threading.Lock()
"""Styles of matplotlib are of the whole process."""


@functools.lru_cache(maxsize=4)
def picture(text: str) -> NDArray[np.uint8]:
    """The picture of a case, given as TOML: rows, columns and RGB."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - slow to import, and rarely asked for

    from taichiflap.plots.preview import preview  # noqa: PLC0415

    with _drawing:
        figure = preview(held_case(text, TITLE))
        figure.set_dpi(RESOLUTION)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()


class Motion:
    """A button among the controls of a browser that shows the picture in a window of its own, or takes it away.

    Args:
        client: viser's handle of the browser.
        case: whose motion it is.
    """

    def __init__(self, client: Any, case: Case) -> None:
        self._gui = client.gui
        self._text = case.to_toml()
        self.window: Any = None
        self._turning = threading.Lock()
        self.button = self._gui.add_button(TITLE, hint=HINT)
        self.button.on_click(lambda _: self.turn())

    def turn(self) -> None:
        """Show the picture if it is not shown, else take it away."""
        with self._turning:
            if self.window is not None:
                self.window.remove()
                self.window = None
                return
            drawn = picture(self._text)
            self.window = self._gui.add_panel()
            with self.window.add_tab(TITLE):
                self._gui.add_image(drawn, format="png")
            self.window.float(x=60, y=60, width=WIDTH)
