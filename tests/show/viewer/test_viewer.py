"""The viewer without a browser: what it shows, where it listens, how it ends, what it answers to bad input."""

import os
import re
import select
import signal
import socket
import subprocess
import sys
import threading
import urllib.request

import numpy as np
import pytest
from chains import LIMIT, joint, robot
from wire import WirePage, wait

import urdf_ik
from urdf_ik import Arm, Singular, UrdfIkError
from urdf_ik.model import catalogue
from urdf_ik.show.viewer import guard, panels
from urdf_ik.show.viewer import state as states
from urdf_ik.show.viewer.playback import Latest
from urdf_ik.support import palette

pytest.importorskip("viser", reason="pip install viser")

from urdf_ik.show.viewer import Viewer  # noqa: E402

BARE = robot(
    joint("one", "revolute", "a", "b", axis="0 0 1", more=LIMIT.replace("3", "1")),
    joint("two", "continuous", "b", "c", "1 0 0", axis="0 0 1"),
    joint("end", "fixed", "c", "d", "0.7 0 0"),
)
LOST_MESH = BARE.replace(
    '<link name="b"/>',
    '<link name="b"><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>'
    '<visual><geometry><mesh filename="package://nowhere/b.stl"/></geometry></visual></link>',
)
PATIENCE = 120.0


@pytest.fixture(scope="module")
def arm() -> Arm:
    """The arm that most tests show."""
    return urdf_ik.load("zyyzyz_6r")


def test_it_starts_where_there_is_much_to_see(arm: Arm) -> None:
    """The first state has every branch inside the limits, the arm stands at one of them, the target at its tip."""
    state = states.start(arm)
    assert len(state.ghosts) == 8 and not any(ghost.outside for ghost in state.ghosts)
    assert state.chosen is not None and not state.reason
    assert np.abs(arm.fk(state.q) - state.target).max() < 1e-12


def test_ghosts_are_the_solutions_with_their_marks() -> None:
    """Every solution of random targets is a ghost; its marks are what limits, collision check and solver say."""
    arm = urdf_ik.load("puma_560")
    state = states.start(arm)
    rng = np.random.default_rng(3)
    seen: set[str] = set()
    for _ in range(60):
        T = arm.fk(rng.uniform(*np.clip(arm.limits.T, -np.pi, np.pi)))
        state = states.with_target(state, T)
        assert [ghost.branch for ghost in state.ghosts] == [one.branch for one in arm.ik(T)]
        for ghost in state.ghosts:
            assert np.abs(arm.fk(ghost.q) - T).max() < 1e-8
            out = bool(((ghost.q < arm.limits[:, 0] - 1e-9) | (ghost.q > arm.limits[:, 1] + 1e-9)).any())
            assert ghost.outside == out
            assert ghost.colliding == arm.cell.collisions.in_collision(ghost.q)
            seen.update(ghost.marks)
    q = state.q.copy()
    q[4] = 0.0  # the wrist is stretched
    ghosts = states.with_joints(state, q).ghosts
    assert any(ghost.singular & Singular.WRIST and "singular: wrist" in ghost.marks for ghost in ghosts)
    assert "limits" in seen


def test_the_arm_follows_the_target_to_the_nearest_solution(arm: Arm) -> None:
    """Small moves of the target are small moves of the arm, and it stands at a solution inside its limits."""
    state = states.start(arm)
    for _ in range(20):
        T = state.target.copy()
        T[:3, 3] += [0.002, -0.001, 0.001]
        after = states.with_target(state, T)
        assert after.chosen is not None and not after.ghosts[after.chosen].outside
        assert np.abs(after.q - state.q).max() < 0.05
        state = after


def test_a_target_out_of_reach_leaves_the_arm_and_says_why(arm: Arm) -> None:
    """No ghost, the arm where it was, and a reason with the number that is out of range."""
    state = states.start(arm)
    far = state.target.copy()
    far[0, 3] = 9.0
    after = states.with_target(state, far)
    assert after.ghosts == () and after.chosen is None
    assert np.array_equal(after.q, state.q)
    assert after.reason == arm.ik(far).explain() and "reach 2.1 m" in after.reason


def test_solutions_outside_the_limits_are_shown_and_explained() -> None:
    """Where every solution is outside the limits the ghosts stay, marked, and the reason names the joint."""
    arm = urdf_ik.load(BARE)
    state = states.start(arm)
    after = states.with_target(state, arm.fk([2.9, 0.5]))
    assert len(after.ghosts) == 2 and all(ghost.marks == ("limits",) for ghost in after.ghosts)
    assert np.array_equal(after.q, state.q)
    assert "none inside the joint limits" in after.reason and "'one'" in after.reason


def test_choosing_a_branch_moves_the_arm_only(arm: Arm) -> None:
    """The arm stands at the solution of the branch; target and ghosts are the same; an empty branch changes nothing."""
    state = states.start(arm)
    for k, ghost in enumerate(state.ghosts):
        after = states.with_branch(state, ghost.column)
        assert after.chosen == k and after.target is state.target and after.ghosts is state.ghosts
    assert states.with_branch(state, 99) is state


def test_seven_joints_have_a_redundancy_parameter() -> None:
    """Its value follows the joints, and setting it keeps the tip while the arm moves."""
    arm = urdf_ik.load("srs_7r")
    state = states.start(arm)
    assert state.redundancy == pytest.approx(float(arm.redundancy_of(state.q)), abs=1e-12)
    assert state.chosen is not None
    after = states.with_redundancy(state, state.redundancy + 0.1)
    assert after.chosen is not None and np.abs(after.q - state.q).max() > 1e-3
    assert np.abs(arm.fk(after.q) - state.target).max() < 1e-8


def test_the_intervals_stand_under_the_slider() -> None:
    """A picture of the intervals of the target, with a line at the present value; none for an arm of six joints."""
    arm = urdf_ik.load("srs_7r")
    state = states.start(arm)
    first = panels.intervals_picture(state)
    assert first is not None and first.shape[2] == 3
    moved = states.with_redundancy(state, 0.5)
    assert moved.intervals is state.intervals
    second = panels.intervals_picture(moved)
    changed = np.flatnonzero((first != second).any(axis=(0, 2)))  # columns of pixels: the line has moved, and no more
    assert 0 < len(changed) < 20
    assert states.with_joints(state, state.q + 0.05).intervals is not state.intervals
    assert panels.intervals_picture(states.start(urdf_ik.load("zyyzyz_6r"))) is None
    with Viewer(arm, port=0) as viewer:
        wait(lambda: viewer.panel.strip.visible)
        assert viewer.panel.strip.image.shape[1] > 200


@pytest.mark.parametrize("name", [name for name in catalogue.BUNDLED if name != "zyyzyz_6r"])
def test_every_bundled_arm_stands_at_a_solution(name: str) -> None:
    """Arms with any number of joints start at a solution of their own target; one that no solver takes says so."""
    arm = urdf_ik.load(name)
    state = states.start(arm)
    if not arm.structure.family:
        assert "no solver" in state.reason
    else:
        assert state.chosen is not None and not state.reason


def test_a_newer_request_takes_the_place_of_an_older_one() -> None:
    """While one is being done, only the last of each kind waits, and all kinds get their turn."""
    done: list[str] = []
    begun, go_on = threading.Event(), threading.Event()
    latest = Latest(lambda: None)

    def first() -> None:
        begun.set()
        go_on.wait(PATIENCE)
        done.append("first")

    latest.put("target", first)
    assert begun.wait(PATIENCE)
    for text in ("old", "older", "new"):
        latest.put("target", lambda text=text: done.append(text))
    latest.put("branch", lambda: done.append("branch"))
    go_on.set()
    assert latest.settle(PATIENCE)
    latest.close()
    assert done == ["first", "new", "branch"]


def test_the_page_is_served_where_it_says(viewer: Viewer) -> None:
    """On 127.0.0.1, at the printed port, and on no other interface."""
    assert re.fullmatch(rf"http://127\.0\.0\.1:{viewer.port}/[\w-]{{32}}/", viewer.url)
    with urllib.request.urlopen(viewer.url, timeout=PATIENCE) as answer:
        assert answer.status == 200
    with pytest.raises(OSError), socket.create_connection(("127.0.0.2", viewer.port), timeout=5.0):
        pass


def test_the_scene_follows_the_state(viewer: Viewer) -> None:
    """Bodies stand where the links are, ghosts where the solutions' links are, the others are scaled to nothing."""
    T = viewer.state.target.copy()
    T[:3, 3] += 0.03
    viewer.move_target(T)
    viewer.choose(viewer.state.ghosts[0].column)
    assert viewer.settle(PATIENCE)
    state, drawing = viewer.state, viewer.drawing
    poses = state.arm.link_poses(state.q)
    for link, handle in drawing.bodies:
        assert np.allclose(handle.position, poses[link][:3, 3])
    for link, handle in drawing.ghosts:
        places, shown = [poses[link]], []  # a link that is where another one is drawn is left out
        for k, ghost in enumerate(state.ghosts):
            there = state.arm.link_poses(ghost.q)[link]
            if k != state.chosen and not any(np.allclose(there, place, rtol=0.0, atol=1e-6) for place in places):
                places.append(there)
                shown.append(ghost.column)
                assert np.allclose(handle.batched_positions[ghost.column], there[:3, 3], atol=1e-6)
        assert np.flatnonzero(handle.batched_scales).tolist() == shown
    counts = [np.count_nonzero(handle.batched_scales) for _, handle in drawing.ghosts]
    assert (min(counts), max(counts)) == (0, 3)  # the tool is where it must be; two elbows, the wrist up or down
    assert viewer.panel.branches[0].label.startswith("● ")
    assert np.allclose(drawing.target.position, state.target[:3, 3])
    viewer.move_joint(0, state.q[0] + 0.2)
    assert viewer.settle(PATIENCE)
    assert [slider.value for slider in viewer.panel.sliders] == pytest.approx(viewer.state.q, abs=6e-4)
    assert np.allclose(drawing.target.position, viewer.state.target[:3, 3])


def test_a_page_drags_the_target(viewer: Viewer) -> None:
    """The target and the arm follow a page's handle; a place that is no number changes nothing."""
    T = viewer.state.target
    turn = viewer.drawing.target.wxyz.tolist()
    with WirePage(viewer) as page:
        for x in (0.01, float("nan"), 0.02):
            place = (T[:3, 3] + [x, 0.0, 0.0]).tolist()
            page.send("TransformControlsUpdateMessage", name="/target", wxyz=turn, position=place)
        wait(lambda: np.allclose(viewer.state.target[:3, 3], T[:3, 3] + [0.02, 0.0, 0.0], rtol=0.0, atol=1e-9))
        assert viewer.settle(PATIENCE)
    assert np.abs(viewer.state.arm.fk(viewer.state.q) - viewer.state.target).max() < 1e-8


@pytest.mark.parametrize(("name", "aspect"), [("zyyzyz_6r", None), ("planar_2r", 360 / 760), ("srs_7r", 0.9)])
def test_the_camera_sees_the_arm_beside_the_panel(name: str, aspect: float | None) -> None:
    """Frames of arm and ghosts are in the view: left of the panel, or in a narrow window above it."""
    arm = urdf_ik.load(name)
    with Viewer(arm, port=0) as viewer:
        state, fov = viewer.state, viewer.server.initial_camera.fov
        position, look_at = viewer.drawing.camera(state, fov, aspect)
        if aspect is None:
            assert np.allclose(position, viewer.server.initial_camera.position)
    ahead = (look_at - position) / np.linalg.norm(look_at - position)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    poses = arm.link_poses(np.stack([state.q, *(ghost.q for ghost in state.ghosts)]))
    points = np.concatenate([pose[:, :3, 3] for pose in poses.values()]) - position
    depth, half = points @ ahead, np.tan(0.5 * fov)
    assert (depth > 0.0).all()
    across, up = (points @ axis / (half * depth) for axis in (right, np.cross(right, ahead)))
    if aspect is None:  # -1.6 to 0.45 is what a usual window shows beside the panel
        assert across.min() > -1.5 and across.max() < 0.5 and np.abs(up).max() < 0.95
    else:
        assert np.abs(across).max() < aspect and up.min() > 0.0 and up.max() < 1.0


def test_all_sixteen_colours_are_seen() -> None:
    """The contrast to a white page, as WCAG 2.1 measures it, is 1.9 or more."""

    def luminance(colour: tuple[float, ...]) -> float:
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in colour]
        return float(np.dot(linear, [0.2126, 0.7152, 0.0722]))

    shades = palette.colours(16)
    assert len(set(shades)) == 16
    assert all(1.05 / (luminance(colour) + 0.05) >= 1.9 for colour in shades)


def test_another_arm_takes_the_place(viewer: Viewer) -> None:
    """Sliders and branches are those of the new arm; what was asked of the old one is forgotten."""
    viewer.open("srs_7r")
    assert viewer.settle(PATIENCE) and viewer.state.arm.name == "srs_7r"
    assert len(viewer.panel.sliders) == 7 and len(viewer.panel.redundancies) == 1
    viewer.open(BARE.encode())
    assert viewer.settle(PATIENCE) and viewer.state.arm.name == "r"
    assert len(viewer.panel.sliders) == 2 and not viewer.panel.redundancies
    assert not viewer.drawing.has_shapes and viewer.drawing.lines


def test_what_is_wrong_with_an_arm_is_said_and_the_old_one_stays(viewer: Viewer, arm: Arm) -> None:
    """A name that the catalogue lacks gives the nearest; a broken URDF its line; an ambiguous tip the candidates."""
    broken = BARE.replace('parent link="b"', 'parent link="x"').encode()
    forked = BARE.replace("</robot>", '<link name="e"/>' + joint("f", "fixed", "c", "e", "1 0 0") + "</robot>").encode()
    for source, answer in (
        ("zyyzyz", "nearest: zyyzyz_6r"),
        ("no/such.urdf", "no/such.urdf"),
        (broken, "link 'x' is not declared"),
        (forked, "candidates: c, d, e"),
        (b"", "empty"),
    ):
        viewer.open(source)
        assert viewer.settle(PATIENCE)
        assert answer in viewer.message
        assert viewer.state.arm is arm


def test_shapes_that_cannot_be_read_are_named() -> None:
    """An arm without shapes is drawn as lines; one whose mesh is missing is drawn without it, and says so."""
    with Viewer(urdf_ik.load(BARE), port=0) as viewer:
        assert not viewer.drawing.has_shapes and "drawn as frames and lines" in viewer.message
        assert "no link has a collision shape" in viewer.state.note
        viewer.move_joint(0, 0.4)
        assert viewer.settle(PATIENCE)
        points = viewer.drawing.lines[0].points
        assert np.allclose(points[-1, 1], viewer.state.target[:3, 3], atol=1e-6)
        viewer.open(LOST_MESH.encode())
        assert viewer.settle(PATIENCE)
        assert viewer.drawing.has_shapes and "package://nowhere/b.stl" in viewer.message
        assert "frames and lines are drawn, too" in viewer.message and viewer.drawing.lines


def test_a_port_in_use_is_refused_and_a_free_one_found(arm: Arm, monkeypatch: pytest.MonkeyPatch) -> None:
    """A port that was asked for and is taken is an error with its number; without one the next free port is taken."""
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(UrdfIkError, match=f"port {port}: Address already in use"):
            Viewer(arm, port=port)
        monkeypatch.setattr(guard, "DEFAULT_PORT", port)
        with Viewer(arm) as viewer:
            assert viewer.port > port and f":{viewer.port}/" in viewer.url


def test_ctrl_c_ends_it_cleanly() -> None:
    """The command prints its true address, serves the page, and ends with status 0 and nothing on stderr."""
    command = [sys.executable, "-m", "urdf_ik.cli", "view", "zyyzyz_6r", "--port", "0"]
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
        # Tests that run in the background of a script have to ignore Ctrl-C, and so are their children.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as running:
        assert running.stdout is not None and running.stderr is not None
        try:
            ready, _, _ = select.select([running.stdout], [], [], PATIENCE)
            assert ready, "nothing was printed"
            line = running.stdout.readline()
            found = re.search(r"http://127\.0\.0\.1:\d+/[\w-]+/", line)
            assert found is not None, line
            with urllib.request.urlopen(found[0], timeout=PATIENCE) as answer:
                assert answer.status == 200
            running.send_signal(signal.SIGINT)
            out, err = running.communicate(timeout=PATIENCE)
        finally:
            running.kill()
    assert (running.returncode, out, err) == (0, "", "")
