"""The browser of the viewer's tests: Chromium without a screen, drawing in software."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

INSTALL = "the page is not tested: apt-get install chromium, and pip install playwright viser"
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SOFTWARE = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
PATIENCE = 240.0  # [s] pages are drawn without a GPU, on a machine that may have other work


@contextmanager
def chromium() -> Iterator[Any]:
    """Chromium as the tests start it, until the block ends."""
    from playwright.sync_api import sync_playwright  # tests skip where it is not installed

    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, args=list(SOFTWARE))
        yield started
        started.close()
