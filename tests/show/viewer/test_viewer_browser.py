"""The viewer's page in a real browser: Chromium without a screen, drawing in software, against a running viewer.

What the page does is read from the viewer's state; that it shows it, from pixels that change. URDF_IK_SCREENSHOT=FILE
keeps a picture of the page.
"""

import http.server
import io
import os
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import CHROMIUM, INSTALL, PATIENCE, ViewerPage, changed, chromium
from numpy.typing import NDArray

import urdf_ik

pytest.importorskip("playwright.sync_api", reason=INSTALL)
pytest.importorskip("viser", reason=INSTALL)

from PIL import Image  # noqa: E402  it comes with viser

from urdf_ik.show.viewer import Viewer  # noqa: E402

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=INSTALL)]

WIDTH, HEIGHT, PANEL = 900, 560, 420
Q = np.array([0.4, -0.3, 0.9, 0.5, 0.8, -0.2])
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


def shades(scene: NDArray[np.int_]) -> int:
    """Pixels in another colour than the upper right corner."""
    return int(changed(scene, np.broadcast_to(scene[0, -1], scene.shape)).sum())


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


@contextmanager
def served(text: str) -> Iterator[str]:
    """The address on this machine of a page, as a notebook has one; other frames may not show local servers."""

    class Page(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(http.HTTPStatus.OK)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(text.encode())

        def log_message(self, *args: Any, **named: Any) -> None:
            pass

    with http.server.HTTPServer(("127.0.0.1", 0), Page) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def test_a_notebook_holds_the_page(seen: Seen) -> None:
    """What a notebook is given draws the arm and its panel within another page."""
    text = f"<html><body>{seen.viewer._repr_html_()}</body></html>"
    with served(text) as address, seen.away() as page:
        page.goto(address)
        seen.wait(lambda: len(page.frames) == 2, "the page holds the viewer's")
        page.frames[1].get_by_text("8 solutions").wait_for()
        seen.wait(lambda: shades(seen.shot()) > 5000, "arm and panel are drawn")


def test_a_notebook_without_its_viewer_holds_a_picture(seen: Seen) -> None:
    """Where the address does not answer, the arm and its solutions are drawn in the page's place."""
    shown = seen.viewer._repr_html_().replace(f":{seen.viewer.port}/", ":9/")  # a port that nobody listens on
    with served(f"<html><body>{shown}</body></html>") as address, seen.away() as page:
        page.goto(address)
        page.get_by_text("The page itself needs the viewer").wait_for()
        assert page.locator("object polyline").count() == len(seen.viewer.state.ghosts) + 1
        box = page.locator("object svg").bounding_box()
    assert box is not None and box["width"] > 100 and box["height"] > 100


def test_the_scene_is_saved_as_a_page_that_needs_no_viewer(seen: Seen, tmp_path: Path) -> None:
    """The file that the page offers draws the arm by itself."""
    with seen.page.expect_download() as download:
        seen.page.get_by_role("button", name="Save the scene as HTML").click()
    file = tmp_path / download.value.suggested_filename
    download.value.save_as(file)
    assert file.name == f"{ARM}.html"
    asked: list[str] = []
    with seen.away() as page:
        page.goto("about:blank")

        def note(request: Any) -> None:
            asked.append(request.url)

        page.on("request", note)
        page.goto(file.as_uri())
        seen.wait(lambda: shades(seen.shot()) > 5000, "the arm is drawn")
        page.remove_listener("request", note)
    assert not [url for url in asked if url.startswith(("http:", "https:", "ws:"))]


def test_keys_go_to_the_next_solution_and_back(seen: Seen) -> None:
    """N marks another branch as the one where the arm stands, P the first one again."""
    marked = seen.page.get_by_role("button", name=re.compile("^● "))
    seen.wait(lambda: marked.count() == 1, "the arm stands at a solution")
    first = marked.inner_text()
    seen.page.mouse.click(60, 60)
    seen.page.keyboard.press("n")
    seen.wait(lambda: marked.count() == 1 and marked.inner_text() != first, "another branch is marked")
    seen.page.keyboard.press("p")
    seen.wait(lambda: marked.count() == 1 and marked.inner_text() == first, "the first one is marked again")


def test_a_moving_arm_sends_its_shapes_once(browser: Any) -> None:
    """With two megabytes of meshes on the arm, a move of the target sends places: less than a hundredth of that."""
    import trimesh

    arm = urdf_ik.load("zyyzyz_6r")
    with Viewer(arm, port=0) as viewer:
        ball = trimesh.creation.icosphere(subdivisions=6)  # 2.0 MB as vertices and faces of 4 bytes
        viewer.server.scene.add_mesh_simple("/robot/tip/ball", ball.vertices, ball.faces)
        assert 4 * (ball.vertices.size + ball.faces.size) > 1_400_000
        shown = ViewerPage(viewer, browser, (WIDTH, HEIGHT), PANEL)
        sent: list[int] = []

        def listen(socket: Any) -> None:
            socket.on("framereceived", lambda data: sent.append(len(data)))

        shown.page.on("websocket", listen)
        shown.enter()
        shown.catch_up()
        shown.wait(lambda: sum(sent) > 1_400_000, "the shapes have come")
        sent.clear()
        moves = 10
        for k in range(moves):
            viewer.move_target(arm.fk(Q + 0.02 * k))
            shown.catch_up()
        assert 0 < sum(sent) < moves * 20_000
        shown.page.close()
