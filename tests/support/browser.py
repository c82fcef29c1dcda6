"""The browser of the viewer's tests: Chromium without a screen, drawing in software."""

from __future__ import annotations

import shutil

INSTALL = "the page is not tested: apt-get install chromium, and pip install playwright viser"
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SOFTWARE = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
PATIENCE = 240.0  # [s] pages are drawn without a GPU, on a machine that may have other work
