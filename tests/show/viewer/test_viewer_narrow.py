"""The viewer's page in a narrow window, in a browser of its own: no label is cut off."""

from __future__ import annotations

import re

import pytest
from browser import CHROMIUM, INSTALL, ViewerPage, chromium

import urdf_ik
from urdf_ik.model import catalogue

pytest.importorskip("playwright.sync_api", reason=INSTALL)
pytest.importorskip("viser", reason=INSTALL)

from urdf_ik.show.viewer import Viewer  # noqa: E402

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason=INSTALL)

WIDTH, HEIGHT = 360, 740
MEASURE = """all => all.map(e => [
    e.textContent, e.scrollWidth - e.clientWidth, e.scrollHeight - e.clientHeight, e.getBoundingClientRect().right])"""


def test_a_narrow_window_shows_whole_labels() -> None:
    """On a telephone no label is cut off or reaches beyond the page, and the panel is as wide as the page."""
    text = catalogue.resolve("zyyzyz_6r").path.read_text()
    bare = re.sub(r"<visual>.*?</visual>", "", text, flags=re.DOTALL)  # lines and frames are quickly drawn
    with Viewer(urdf_ik.load(bare), port=0) as viewer, chromium() as browser:
        seen = ViewerPage(viewer, browser, (WIDTH, HEIGHT), 0)
        page = seen.page
        page.get_by_role("button", name="Save the scene as HTML").wait_for()
        labels = page.locator(".mantine-Button-label")

        def cut_off() -> list[str]:
            return [
                label
                for label, beyond, below, right in labels.evaluate_all(MEASURE)
                if not (beyond <= 1 and below <= 1 and right <= WIDTH)
            ]

        assert labels.count() >= len(viewer.state.ghosts) == 8
        seen.wait(lambda: not cut_off(), "no label is cut off")
        panel = "e => e.closest('.mantine-ScrollArea-root').offsetWidth"
        joints = page.get_by_text("Joints").first
        seen.wait(lambda: joints.evaluate(panel) == WIDTH, "the panel is as wide as the page")
