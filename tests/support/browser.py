"""The browser of the viewer's tests: Chromium without a screen, drawing in software."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

import urdf_ik

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


class View:
    """The camera of the only page as its browser reported it last; viser's own is also what a page was only told."""

    def __init__(self, server: Any) -> None:
        (client,) = server.get_clients().values()

        async def keep(camera: Any) -> None:  # async: before another message is read
            self._last = (camera.position, camera.wxyz, camera.fov)

        client.camera.on_update(keep)
        asyncio.run_coroutine_threadsafe(keep(client.camera), server.get_event_loop()).result(PATIENCE)

    def project(self, points: NDArray[np.float64], width: float, height: float) -> NDArray[np.float64]:
        """Where in a window [px] points (k, 3) [m] are drawn, and how far ahead of the camera [m]: (k, 3)."""
        position, wxyz, fov = self._last
        x, y, z = ((points - position) @ urdf_ik.pose(np.zeros(3), quat_wxyz=wxyz)[:3, :3]).T
        focal = 0.5 * height / np.tan(0.5 * fov)
        return np.column_stack([width / 2 + focal * x / z, height / 2 + focal * y / z, z])
