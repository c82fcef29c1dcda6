"""The viewer's page in a real browser: Chromium without a screen, drawing in software, against a running viewer.

What the page does is read from the viewer's state; that it shows it, from pixels that change. URDF_IK_SCREENSHOT=FILE
keeps a picture of the page.
"""

import io
import os
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from browser import CHROMIUM, INSTALL, PATIENCE, ViewerPage, chromium
from numpy.typing import NDArray

import urdf_ik

pytest.importorskip("playwright.sync_api", reason=INSTALL)
pytest.importorskip("viser", reason=INSTALL)

from PIL import Image  # noqa: E402  it comes with viser

from urdf_ik.show.viewer import Viewer  # noqa: E402

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=INSTALL)]

WIDTH, HEIGHT, PANEL = 900, 560, 420
ARM = "zyyzyz_6r"


class Seen(ViewerPage):
    """A viewer and the page that shows it."""

    def restart(self, home: NDArray[np.float64]) -> None:
        """Put the arm where it was at first, and wait until the page shows that."""
        if self.viewer.state.arm.name != ARM:
            self.viewer.open(ARM)
            self.catch_up()
            self.wait_for_view()
        for index, value in enumerate(home):
            self.viewer.move_joint(index, value)
        assert self.viewer.settle(PATIENCE)
        values = "all => all.map(each => Number(each.getAttribute('aria-valuenow')))"
        thumbs = self.page.get_by_role("slider")
        self.wait(lambda: thumbs.evaluate_all(values) == home.round(3).tolist(), "the sliders are at home")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """One browser for all tests."""
    with chromium() as started:
        yield started


@pytest.fixture(scope="module")
def opened(browser: Any) -> Iterator[Seen]:
    """One viewer for the tests of an arm with shapes."""
    with Viewer(urdf_ik.load(ARM), port=0) as viewer:
        yield Seen(viewer, browser, (WIDTH, HEIGHT), PANEL)


@pytest.fixture(scope="module")
def home(opened: Seen) -> NDArray[np.float64]:
    """Where the arm stands at first."""
    return opened.viewer.state.q


@pytest.fixture
def seen(opened: Seen, home: NDArray[np.float64]) -> Seen:
    """The page, showing the arm as it is at first."""
    opened.restart(home)
    return opened


def test_the_arm_and_its_ghosts_appear(seen: Seen) -> None:
    """All eight branches are listed with their marks, the arm and seven ghosts are drawn."""
    seen.page.get_by_text("8 solutions").wait_for()
    for ghost in seen.viewer.state.ghosts:
        seen.page.get_by_role("button", name=ghost.branch).wait_for()
    whole = seen.pixels()
    if picture := os.environ.get("URDF_IK_SCREENSHOT"):
        Image.open(io.BytesIO(seen.page.screenshot())).quantize(160).save(picture, optimize=True)
    far = seen.viewer.state.target.copy()
    far[0, 3] = 50.0
    seen.viewer.move_target(far)
    seen.differs(whole, 1000)
    without_ghosts = seen.pixels()
    seen.viewer.drawing.root.visible = False
    seen.differs(without_ghosts, 1000)
    seen.viewer.drawing.root.visible = True


def test_dragging_the_target_moves_the_ghosts(seen: Seen) -> None:
    """A pull at the handle of the target's z axis moves the target along it, the solutions and the arm with it."""
    before, first = seen.viewer.state, seen.pixels()
    length = 0.3 * before.arm.chain.size  # of the handles
    start, along = before.target[:3, 3], before.target[:3, :3]

    def drawn() -> NDArray[np.float64]:
        """Where the target is, and places on its three handles [px]."""
        here = seen.viewer.state.target[:3, 3]
        return seen.project(np.stack([here, *(here + 0.6 * length * along.T)]))[:, :2]

    # The axis that is seen longest: one that points at the camera cannot be pulled.
    axis = int(np.argmax(np.linalg.norm(drawn()[1:] - drawn()[0], axis=1)))

    def is_pulled() -> bool:
        """Pull; the first time, unless the mouse missed the handle."""
        centre, *ends = drawn()
        pull = (ends[axis] - centre) / np.linalg.norm(ends[axis] - centre)
        seen.page.mouse.move(*ends[axis])
        seen.page.mouse.down()
        for step in range(1, 9):
            seen.page.mouse.move(*(ends[axis] - 6.0 * step * pull))
        seen.page.mouse.up()
        seen.page.wait_for_timeout(2000)
        seen.catch_up()
        return bool(np.linalg.norm(seen.viewer.state.target[:3, 3] - start) > 0.02)

    seen.wait(is_pulled, "the target is dragged")
    after = seen.viewer.state
    moved = after.target[:3, 3] - start
    assert np.allclose(np.cross(moved, along[:, axis]), 0.0, atol=1e-4)
    assert after.ghosts
    for ghost in after.ghosts:
        assert np.abs(after.arm.fk(ghost.q) - after.target).max() < 1e-8
    assert after.chosen is not None
    seen.differs(first, 500)


def test_a_slider_moves_the_arm_and_the_target(seen: Seen) -> None:
    """The first joint's slider pushed to its end turns the arm there, and the target with it."""
    before, first = seen.viewer.state, seen.pixels()
    thumb = seen.page.get_by_role("slider").first
    thumb.focus()
    thumb.press("End")
    seen.wait(lambda: abs(seen.viewer.state.q[0] - seen.viewer.panel.sliders[0].max) < 1e-9, "the slider moves")
    assert seen.viewer.settle(PATIENCE)
    after = seen.viewer.state
    assert np.array_equal(after.q[1:], before.q[1:])
    assert np.abs(after.arm.fk(after.q) - after.target).max() < 1e-12
    assert np.allclose(seen.viewer.drawing.target.position, after.target[:3, 3])
    seen.differs(first, 500)


def test_the_catalogue_brings_seven_joints_and_their_slider(seen: Seen) -> None:
    """A name chosen from the list replaces the arm; the redundancy slider turns the elbow and leaves the tip."""
    page = seen.page
    chosen = page.locator(".mantine-Select-input:visible")
    if not chosen.count():
        page.get_by_text("Another arm").click()
    chosen.click()
    page.get_by_role("option", name="srs_7r", exact=True).click()
    seen.wait(lambda: seen.viewer.state.arm.name == "srs_7r", "the arm of the catalogue is shown")
    page.get_by_text("srs_7r").first.wait_for()
    first, before = seen.pixels(), seen.viewer.state
    assert isinstance(before.redundancy, float)
    thumb = page.get_by_role("slider").first
    seen.wait(lambda: thumb.get_attribute("aria-valuenow") == f"{round(before.redundancy, 3):g}", "the slider is there")
    seen.wait(lambda: seen.viewer.panel.strip.visible, "the intervals are drawn")
    thumb.focus()
    for _ in range(150):
        thumb.press("ArrowRight")
    wanted = before.redundancy + 0.15
    seen.wait(lambda: abs(seen.viewer.state.redundancy - wanted) < 1e-3, "the redundancy parameter follows")
    seen.catch_up()
    after = seen.viewer.state
    assert np.array_equal(after.target, before.target) and np.abs(after.q - before.q).max() > 0.01
    assert np.abs(after.arm.fk(after.q) - after.target).max() < 1e-8
    seen.differs(first, 200)
