"""The browser of the viewer's tests: Chromium without a screen, drawing in software; and a viewer's page in it.

A page comes to know what the viewer did, and the viewer what the page did, when the machine has time for it. What a
test asserts of one after it did something with the other, it therefore waits for.
"""

from __future__ import annotations

import asyncio
import io
import itertools
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import urdf_ik

if TYPE_CHECKING:
    from urdf_ik.show.viewer import Viewer

INSTALL = "the page is not tested: apt-get install chromium, and pip install playwright viser"
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SOFTWARE = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
TWO_FRAMES = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
PATIENCE = 240.0  # [s] pages are drawn without a GPU, on a machine that may have other work


@contextmanager
def chromium() -> Iterator[Any]:
    """Chromium as the tests start it, until the block ends."""
    from playwright.sync_api import sync_playwright  # tests skip where it is not installed

    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, args=list(SOFTWARE))
        yield started
        started.close()


def changed(first: NDArray[np.int_], second: NDArray[np.int_]) -> NDArray[np.bool_]:
    """Which pixels (h, w) differ by more than rounding and smoothing do."""
    return np.asarray(np.abs(first - second).max(axis=-1) > 24)


class ViewerPage:
    """A viewer and its page, as a person sees it.

    Attributes:
        viewer: the viewer.
        page: the page, of a window of ``size``.
        client: the page as viser knows it.
    """

    def __init__(self, viewer: Viewer, browser: Any, size: tuple[int, int], panel: int) -> None:
        """Open a page of ``size`` [px], and let it show the viewer; ``panel`` px at its right hide the scene."""
        self.viewer, self.size, self._panel = viewer, size, panel
        self.page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        self.page.set_default_timeout(1000.0 * PATIENCE)
        self._marks = itertools.count()
        self.enter()

    def enter(self) -> None:
        """Let the page show the viewer; no other page may."""
        clients = self.viewer.server.get_clients
        gone = set(clients())
        self.page.goto(self.viewer.url)
        self.wait(lambda: len(clients()) == 1 and not gone & set(clients()), "the page connects, and no other is there")
        self.page.add_style_tag(content=".mantine-Notification-root { display: none }")  # that it is drawn in software
        (self.client,) = clients().values()

        async def keep(camera: Any) -> None:  # async: before another message is read
            self._view = (camera.position, camera.wxyz, camera.fov)

        self.client.camera.on_update(keep)
        loop = self.viewer.server.get_event_loop()
        asyncio.run_coroutine_threadsafe(keep(self.client.camera), loop).result(PATIENCE)
        self.catch_up()
        self.wait_for_view()

    def wait(self, what: Callable[[], Any], why: str) -> None:
        """Let the page run until ``what()`` is true."""
        end = time.monotonic() + PATIENCE
        while not what():
            assert time.monotonic() < end, f"waited {PATIENCE:g} s in vain: {why}"
            self.page.wait_for_timeout(100)

    def catch_up(self) -> None:
        """Wait until the viewer has done what it was asked for, and the page has read all that this changed."""
        assert self.viewer.settle(PATIENCE)
        name = f"mark-{next(self._marks)}"
        mark = self.viewer.server.gui.add_html(f'<i id="{name}"></i>')  # messages are read in their order
        self.page.locator(f"#{name}").wait_for(state="attached")
        mark.remove()

    def wait_for_view(self) -> None:
        """Wait until the page sees what the viewer wants it to see."""
        self.page.evaluate(TWO_FRAMES)  # in which it may go to its first view
        self.client.local_storage.get_item("", PATIENCE)  # its answer comes after what the page reported before

        def is_seen() -> bool:
            camera = self.client.camera
            return bool(np.allclose(self._view[0], self.viewer.view(camera.fov, camera.aspect)[0]))

        self.wait(is_seen, "the page sees the arm")

    def shot(self) -> NDArray[np.int_]:
        """The scene (h, w, 3), without the panel, as it is drawn next."""
        from PIL import Image  # viser brings it

        self.page.evaluate(TWO_FRAMES)
        area = {"x": 0, "y": 0, "width": self.size[0] - self._panel, "height": self.size[1]}
        return np.array(Image.open(io.BytesIO(self.page.screenshot(clip=area))).convert("RGB"), dtype=np.int_)

    def still(self) -> NDArray[np.int_]:
        """The scene (h, w, 3), without the panel, when nothing moves any more."""
        last = np.zeros((self.size[1], self.size[0] - self._panel, 3), dtype=np.int_)

        def rests() -> bool:
            nonlocal last
            self.page.wait_for_timeout(200)
            before, last = last, self.shot()
            return int(changed(before, last).sum()) < 20

        self.wait(rests, "the scene comes to rest")
        return last

    def pixels(self) -> NDArray[np.int_]:
        """The scene (h, w, 3), without the panel, when it shows all that the viewer was asked for."""
        self.catch_up()
        return self.still()

    def differs(self, first: NDArray[np.int_], pixels: int) -> None:
        """Wait until so many pixels of the scene are others than those of ``first``."""
        self.wait(lambda: changed(first, self.shot()).sum() > pixels, f"{pixels} pixels change")

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where in the window [px] points (k, 3) [m] are drawn, and how far ahead of the camera [m]: (k, 3).

        The camera is the browser's, as it was reported last; viser's own is also what the page was only told.
        """
        position, wxyz, fov = self._view
        width, height = self.size
        x, y, z = ((points - position) @ urdf_ik.pose(np.zeros(3), quat_wxyz=wxyz)[:3, :3]).T
        focal = 0.5 * height / np.tan(0.5 * fov)
        return np.column_stack([width / 2 + focal * x / z, height / 2 + focal * y / z, z])
