"""The tools of the viewer's page in a real browser, by what a person sees: text, pixels, files that are saved.

The arms have no shapes, so that the page is quickly drawn in software.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import CHROMIUM, INSTALL, PATIENCE, ViewerPage, changed, chromium
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.model import catalogue

pytest.importorskip("playwright.sync_api", reason=INSTALL)
pytest.importorskip("viser", reason=INSTALL)

from PIL import Image, ImageSequence  # noqa: E402  it comes with viser

from urdf_ik.show.viewer import Viewer  # noqa: E402
from urdf_ik.show.viewer.work import recording  # noqa: E402

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason=INSTALL)

WIDTH, HEIGHT, PANEL = 900, 700, 420
Q = np.array([0.4, -0.3, 0.9, 0.5, 0.8, -0.2])


def bare(name: str) -> urdf_ik.Arm:
    """An arm of the catalogue without its shapes."""
    text = catalogue.resolve(name).path.read_text()
    return urdf_ik.load(re.sub(r"<(visual|collision)>.*?</\1>", "", text, flags=re.DOTALL))


class Shown(ViewerPage):
    """A viewer, its page, and what a person does there."""

    def __init__(self, viewer: Viewer, browser: Any) -> None:
        super().__init__(viewer, browser, (WIDTH, HEIGHT), PANEL)

    def folder(self, name: str) -> None:
        """Open or close a folder of the panel."""
        self.page.get_by_text(name, exact=True).first.click()

    def field(self, label: str) -> Any:
        """The field that stands beside a label."""
        row = self.page.get_by_text(label, exact=True).locator("xpath=ancestor::div[contains(@class, 'Flex-root')][1]")
        return row.locator("input:visible")

    def choose(self, label: str, option: str) -> None:
        """Take an option of a dropdown."""
        self.field(label).click()
        self.page.get_by_role("option", name=option, exact=True).locator("visible=true").first.click()


def pink(scene: NDArray[np.int_]) -> int:
    """Pixels in the colour of the measure's line."""
    return int((np.abs(scene - (230, 0, 120)).max(axis=-1) < 30).sum())


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """One browser for all tests."""
    with chromium() as started:
        yield started


@pytest.fixture
def shown(browser: Any) -> Iterator[Shown]:
    """An arm of six joints in a page of its own, at a pose with eight solutions."""
    with Viewer(bare("zyyzyz_6r"), port=0) as viewer:
        viewer.move_target(viewer.state.arm.fk(Q))
        assert viewer.settle(PATIENCE)
        opened = Shown(viewer, browser)
        yield opened
        opened.page.close()


def test_a_pasted_joint_vector_is_there_to_be_copied(shown: Shown) -> None:
    """What is typed into the field moves the arm; the text below it says the same vector, in Python and in JSON."""
    shown.folder("Paste, copy, postures")
    field = shown.field("Pose or q")
    field.fill(f"q = {Q.tolist()}")
    field.press("Enter")
    shown.page.get_by_text(f"q = {Q.tolist()}").first.wait_for()
    np.testing.assert_allclose(shown.viewer.state.q, Q)
    shown.choose("Copy as", "JSON")
    shown.page.get_by_text(f'{{"q": {Q.tolist()}').first.wait_for()
    field.fill("1 2 three")
    field.press("Enter")
    shown.page.get_by_text("'three' is no number").wait_for()
    np.testing.assert_allclose(shown.viewer.state.q, Q)


def test_a_hidden_ghost_is_not_seen_and_a_pinned_one_stays(shown: Shown) -> None:
    """All hidden, one shown again is seen alone; pinned, it stands there when the target has gone out of reach."""
    state, page = shown.viewer.state, shown.page
    assert state.chosen is not None
    elbow = "elbow up" if "elbow down" in state.ghosts[state.chosen].branch else "elbow down"
    ghost = next(each for each in state.drawn if elbow in each.branch)
    shown.folder("Ghosts")
    page.get_by_role("button", name="Hide", exact=True).click()
    hidden = page.get_by_role("button", name=re.compile(r"hidden\)$"))
    shown.wait(lambda: hidden.count() == len(state.ghosts), "all are marked as hidden")
    alone = shown.pixels()
    shown.choose("Branch", ghost.branch)
    page.get_by_role("button", name="Show", exact=True).click()
    shown.wait(lambda: hidden.count() == len(state.ghosts) - 1, "one is shown again")
    its = changed(shown.pixels(), alone)
    page.get_by_role("button", name="Pin", exact=True).click()
    page.get_by_role("button", name=re.compile(r"pinned\)$")).wait_for()
    far = state.target.copy()
    far[0, 3] = 30.0
    shown.viewer.move_target(far)
    page.get_by_text("No solution").wait_for()
    with_it = shown.pixels()
    page.get_by_role("button", name="Unpin", exact=True).click()
    shown.wait(lambda: not shown.viewer.state.pinned, "it is free again")
    without = shown.pixels()
    # The target's handles, which a page may draw anew between two pictures, have gone with it.
    its &= ~changed(alone, without)
    assert its.sum() > 300
    assert (changed(with_it, without) & its).sum() > 0.7 * its.sum()


def test_keys_go_to_the_next_solution_and_back(shown: Shown) -> None:
    """N marks another branch as the one where the arm stands, P the first one again."""
    marked = shown.page.get_by_role("button", name=re.compile("^● "))
    shown.wait(lambda: marked.count() == 1, "the arm stands at a solution")
    first = marked.inner_text()
    shown.page.mouse.click(60, 60)
    shown.page.keyboard.press("n")
    shown.wait(lambda: marked.count() == 1 and marked.inner_text() != first, "another branch is marked")
    shown.page.keyboard.press("p")
    shown.wait(lambda: marked.count() == 1 and marked.inner_text() == first, "the first one is marked again")


def test_the_distance_of_two_frames_stands_in_the_page(shown: Shown) -> None:
    """Between base and tip it is the tip's distance, and changes with the arm; a line is drawn."""
    arm = shown.viewer.state.arm
    before = pink(shown.pixels())
    shown.folder("Measure")
    shown.choose("From", arm.base)
    shown.choose("To", arm.tip)

    def moved(scale: float) -> None:
        T = arm.fk(scale * Q)
        shown.viewer.move_target(T)
        shown.page.get_by_text(f"{np.linalg.norm(T[:3, 3]):.4f} m").wait_for()

    for scale in (0.5, 1.0):
        moved(scale)
        shown.catch_up()
        shown.wait(lambda: pink(shown.shot()) > before + 300, "a line is drawn")


def test_the_camera_comes_back_to_arm_and_table_by_a_key(browser: Any) -> None:
    """After the view was turned away, F shows the arm, the path and all corners of the table in the free part."""
    arm, world = bare("zyyzyz_6r"), urdf_ik.World()
    half = np.array([0.4, 0.9, 0.05])
    world.add("table", urdf_ik.Box(2.0 * half), urdf_ik.pose([1.4, 0.6, 0.2]))
    line = urdf_ik.line(arm.fk(Q), arm.fk(Q) @ urdf_ik.pose([0.0, 0.2, 0.0]), 10)
    with Viewer(arm, port=0, world=world, plan=arm.follow(line, world=None)) as viewer:
        shown = Shown(viewer, browser)
        corners = [1.4, 0.6, 0.2] + half * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        links = [pose[:3, 3] for pose in arm.link_poses(viewer.state.q).values()]
        points = np.concatenate([corners, links, line[:, :3, 3]])

        def is_away() -> bool:
            # Each round turns it again: a new page is framed once, maybe after the first round.
            shown.client.camera.position, shown.client.camera.look_at = (50.0, 0.0, 0.0), (60.0, 0.0, 0.0)
            return bool((shown.project(points)[:, 2] < 0.0).all())

        def is_framed() -> bool:
            drawn = shown.project(points)
            return bool((drawn > 0.0).all() and (drawn[:, :2] < (WIDTH, HEIGHT)).all())

        shown.wait(is_away, "the page looks away")
        shown.page.mouse.click(60, 60)
        shown.page.keyboard.press("f")
        shown.wait(is_framed, "the page shows arm, path and table")
        shown.page.close()


def test_a_recording_is_saved_with_moving_frames(shown: Shown, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Begun, the arm moved, ended: an animated GIF whose frames differ; then a zip of PNG files."""
    monkeypatch.setattr(recording, "_PATIENCE", PATIENCE)
    page = shown.page
    shown.folder("Record")

    def recorded() -> Path:
        page.get_by_role("button", name="Record", exact=True).click()
        page.get_by_role("button", name="Stop and save").wait_for()
        shown.wait(lambda: shown.viewer.recorder.count >= 2, "two frames are seen")
        shown.viewer.move_joint(0, 1.5 - shown.viewer.state.q[0])
        count = shown.viewer.recorder.count
        shown.wait(lambda: shown.viewer.recorder.count >= count + 3, "frames of the other posture are seen")
        with page.expect_download() as download:
            page.get_by_role("button", name="Stop and save").click()
        file = tmp_path / str(download.value.suggested_filename)
        download.value.save_as(file)
        page.get_by_role("button", name="Record", exact=True).wait_for()
        return file

    file = recorded()
    assert file.suffix == ".gif"
    with Image.open(file) as moving:
        frames = [np.array(each.convert("RGB"), dtype=np.int_) for each in ImageSequence.all_frames(moving)]
    count = len(frames)
    assert count >= 2 and frames[0].shape == (480, 640, 3)
    assert (np.abs(frames[-1] - frames[0]).max(axis=-1) > 24).sum() > 300
    shown.choose("As", "PNG files (zip)")
    with zipfile.ZipFile(recorded()) as archive:
        assert len(archive.namelist()) >= 4
        assert Image.open(archive.open(archive.namelist()[-1])).size == (640, 480)


def test_intervals_stand_under_the_slider_of_seven_joints(browser: Any) -> None:
    """A bar for each interval that the arm's own search finds, with its branch and causes as words."""
    arm = bare("srs_7r")
    with Viewer(arm, port=0) as viewer:
        shown = Shown(viewer, browser)
        strip = shown.page.get_by_role("img", name="Values at which each branch has solutions")
        strip.wait_for()
        shown.catch_up()
        intervals = arm.intervals(viewer.state.target)
        words = strip.locator("title").evaluate_all("all => all.map(e => e.textContent)")
        assert len(set(words)) == len(intervals) > 0  # one that goes through half a turn has a bar at either side
        assert {each.branch for each in intervals} == {each.partition(":")[0] for each in words}

        def is_large() -> bool:
            box = strip.bounding_box()
            return box is not None and box["width"] > 200 and box["height"] > 20

        shown.wait(is_large, "the strip is large enough to be read")
        shown.page.close()


def test_a_moving_arm_sends_its_shapes_once(browser: Any) -> None:
    """With two megabytes of meshes on the arm, a move of the target sends places: less than a hundredth of that."""
    import trimesh

    arm = urdf_ik.load("zyyzyz_6r")
    with Viewer(arm, port=0) as viewer:
        ball = trimesh.creation.icosphere(subdivisions=6)  # 2.0 MB as vertices and faces of 4 bytes
        viewer.server.scene.add_mesh_simple("/robot/tip/ball", ball.vertices, ball.faces)
        assert 4 * (ball.vertices.size + ball.faces.size) > 1_400_000
        shown = Shown(viewer, browser)
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
