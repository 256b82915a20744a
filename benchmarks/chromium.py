"""A real browser, if this machine has one."""

import contextlib
import shutil
from collections.abc import Iterator
from typing import Any

FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic"),
    *("--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"),
]
MISSING = "there is no chromium, or no playwright"


@contextlib.contextmanager
def browser() -> Iterator[Any]:
    """Playwright's handle of a headless Chromium; None without one, see `MISSING`."""
    path = shutil.which("chromium")
    try:
        from playwright.sync_api import sync_playwright  # noqa: PLC0415 - not everyone has it
    except ImportError:
        path = None
    if path is None:
        yield None
        return
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=path, args=FLAGS)
        try:
            yield opened
        finally:
            opened.close()
