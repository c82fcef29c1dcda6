"""The viewer as a tool: what is copied can be pasted; postures, ghosts, keys, the saved page."""

from __future__ import annotations

import io
import threading
import zipfile
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.errors import UrdfIkError
from urdf_ik.model import catalogue

pytest.importorskip("viser")

from PIL import Image  # noqa: E402  it comes with viser

from urdf_ik.show.viewer import Viewer  # noqa: E402
from urdf_ik.show.viewer import state as states  # noqa: E402
from urdf_ik.show.viewer.surroundings import points_beside  # noqa: E402
from urdf_ik.show.viewer.work import recording, typed_text  # noqa: E402

ARM = "zyyzyz_6r"
Q = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
SRDF = """<robot name="{name}"><group_state name="home" group="arm">{joints}</group_state>
<group_state name="half" group="arm"><joint name="joint_1" value="0.5"/></group_state></robot>"""


@pytest.fixture(scope="module")
def arm() -> urdf_ik.Arm:
    """An arm whose solutions are partly outside its limits."""
    return urdf_ik.load("puma_560")


@pytest.fixture
def viewer(arm: urdf_ik.Arm) -> Iterator[Viewer]:
    """A page that shows it."""
    with Viewer(arm, port=0) as shown:
        yield shown


def by_reader(widget: Any, value: Any) -> None:
    """What a reader of the page does: the widget has the value, and its functions hear of it."""
    widget.value = value
    for call in widget._impl.update_cb:
        call(SimpleNamespace(client_id=0, client=None, target=widget))


@pytest.mark.parametrize("form", ["q = {}", "{}", "[{}]", "np.array([{}])", '{{"q": [{}]}}'])
def test_joint_vectors_are_read_in_every_form(arm: urdf_ik.Arm, form: str) -> None:
    """Python, JSON, or only numbers."""
    kind, value = typed_text.read(form.format(", ".join(map(str, Q))), arm)
    assert kind == "q" and value.tolist() == Q.tolist()


def test_poses_are_read_in_every_form(arm: urdf_ik.Arm) -> None:
    """A matrix, a position with a quaternion, or with roll, pitch and yaw; each the pose of `urdf_ik.pose`."""
    T = urdf_ik.pose([0.4, 0.1, 0.3], rpy=[0.1, 0.2, 0.3])
    x, y, z, w = 0.0342708, 0.1060205, 0.1435722, 0.9833474
    texts = (
        f"T = {T.tolist()}",
        str(T.ravel().tolist()),
        f"0.4 0.1 0.3 {x} {y} {z} {w}",
        "pose = 0.4,0.1,0.3,0.1,0.2,0.3",
    )
    for text in texts:
        kind, value = typed_text.read(text, arm)
        assert kind == "pose"
        np.testing.assert_allclose(value, T, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1 2 3", "3 numbers given"),
        ("q = 1 2", "puma_560 has 6 joints"),
        ("a b", "'ab' is no number"),
        ("{}", "'q' or"),
    ],
)
def test_what_is_neither_is_refused_in_words(arm: urdf_ik.Arm, text: str, words: str) -> None:
    """The message says what would be valid."""
    with pytest.raises(UrdfIkError, match=words):
        typed_text.read(text, arm)


@pytest.mark.parametrize("form", typed_text.FORMS)
def test_what_is_copied_can_be_pasted(arm: urdf_ik.Arm, form: str) -> None:
    """Line by line in Python, by its names in JSON."""
    T = arm.fk(Q)
    text = typed_text.written(Q, T, form)
    parts = text.splitlines() if form == "Python" else [f'{{"{k}": {v}}}' for k, v in _halves(text)]
    for part, kind, expected in zip(parts, ("q", "pose"), (Q, T), strict=True):
        found, value = typed_text.read(part, arm)
        assert found == kind
        np.testing.assert_allclose(value, expected, atol=1e-8)


def _halves(text: str) -> list[tuple[str, str]]:
    import json

    return [(name, json.dumps(value)) for name, value in json.loads(text).items()]


def test_pasting_moves_the_arm_and_says_what_is_wrong(viewer: Viewer, arm: urdf_ik.Arm) -> None:
    """A joint vector moves arm and target, a pose the target; nonsense moves nothing, and is named."""
    by_reader(viewer.work.text, f"q = {Q.tolist()}")
    assert viewer.settle(30.0)
    np.testing.assert_allclose(viewer.state.q, Q)
    T = arm.fk(Q * 0.5)
    by_reader(viewer.work.text, f"pose = {T.tolist()}")
    assert viewer.settle(30.0)
    np.testing.assert_allclose(viewer.state.target, T, atol=1e-12)
    assert "q = [" in viewer.work.copied.content
    before = viewer.state
    by_reader(viewer.work.text, "1 2")
    assert viewer.settle(30.0) and viewer.state is before and "2 numbers given" in viewer.message


def test_postures_come_from_the_srdf_beside(tmp_path: Path) -> None:
    """A group state that names every joint is one; one that leaves joints open is not; zero is always there."""
    file = tmp_path / "arm.urdf"
    file.write_bytes(catalogue.resolve(ARM).path.read_bytes())
    joints = "".join(f'<joint name="joint_{k + 1}" value="{value}"/>' for k, value in enumerate(Q))
    arm = urdf_ik.load(file)
    (tmp_path / "arm.srdf").write_text(SRDF.format(name=arm.model.name, joints=joints))
    named = states.postures(arm)
    assert named["home"].tolist() == Q.tolist() and named["zero"].tolist() == [0.0] * 6 and "half" not in named
    with Viewer(arm, port=0) as viewer:
        by_reader(viewer.work.postures, "home")
        assert viewer.settle(30.0)
        np.testing.assert_allclose(viewer.state.q, Q)


def test_ghosts_can_be_hidden(viewer: Viewer, arm: urdf_ik.Arm) -> None:
    """All, those inside the limits, or none; the list of branches stays whole."""
    viewer.move_target(arm.fk(Q))
    counts = {}
    for what in states.SHOWN:
        by_reader(viewer.work.ghosts.shown, what)
        assert viewer.settle(30.0)
        counts[what] = len(viewer.state.drawn)
        sizes = [handle.batched_scales for _, handle in viewer.drawing._ghosts]
        assert max((int((size > 0.0).sum()) for size in sizes), default=0) == counts[what] or not sizes
    inside = len(arm.ik(arm.fk(Q)).within_limits())
    assert counts["all"] == 7 and counts["inside the limits"] == inside - 1 and counts["none"] == 0
    assert sum(button.visible for button in viewer.panel.branches) == 8


def test_keys_go_round_the_solutions(viewer: Viewer, arm: urdf_ik.Arm) -> None:
    """Next and before, over those inside the limits, and back to the first one."""
    viewer.move_target(arm.fk(Q))
    assert viewer.settle(30.0)
    count = len(arm.ik(arm.fk(Q)).within_limits())
    first, seen = viewer.state.q, []
    for key in [viewer.work._keys[0]] * count + [viewer.work._keys[1]] * count:
        for call in key._impl.trigger_cb:
            call(SimpleNamespace(client_id=0, client=None, target=key))
        assert viewer.settle(30.0)
        seen.append(viewer.state.q)
        np.testing.assert_allclose(viewer.state.target, arm.fk(Q), atol=1e-12)
    assert len({tuple(q.round(6)) for q in seen}) == count
    np.testing.assert_allclose(seen[count - 1], first, atol=1e-9)
    np.testing.assert_allclose(seen[-1], first, atol=1e-9)


def test_the_saved_page_names_the_branches(viewer: Viewer, arm: urdf_ik.Arm) -> None:
    """Each solution that is drawn stands there in words, and the one that the arm stands at is said."""
    viewer.move_target(arm.fk(Q))
    assert viewer.settle(30.0)
    page = viewer.html(scene=True)
    legend = page[page.index('<ul id="branches"') :].partition("</ul>")[0]
    assert legend.count("<li>") == 1 + len(viewer.state.ghosts)
    assert all(ghost.branch in legend for ghost in viewer.state.ghosts) and legend.count("(the arm)") == 1


def test_the_camera_sees_the_path_and_the_table(arm: urdf_ik.Arm) -> None:
    """With waypoints and an obstacle beside the arm it stands farther away, and looks between them."""
    world = urdf_ik.World()
    world.add("table", urdf_ik.Box((0.1, 0.1, 0.1)), urdf_ik.pose([0.0, 1.5, 0.0]))
    with Viewer(arm, port=0) as alone, Viewer(arm, port=0, world=world) as beside:
        (_, middle), (_, other) = (
            shown.drawing.camera(shown.state, 1.3, None, points_beside(None, shown.state.world, arm.chain.size))
            for shown in (alone, beside)
        )
    assert other[1] > middle[1]


def press(widget: Any, value: str) -> None:
    """What a reader does with one button of a group."""
    widget.value = value
    for call in widget._impl.update_cb:
        call(SimpleNamespace(client_id=0, client=None, target=widget))


def test_single_ghosts_are_hidden_and_shown(viewer: Viewer, arm: urdf_ik.Arm) -> None:
    """The named branch is no longer drawn, its button says so, and the keys pass it over; then it is there again."""
    viewer.move_target(arm.fk(Q))
    assert viewer.settle(30.0)
    ghost = next(each for each in viewer.state.drawn if not each.outside)
    choice = viewer.work.ghosts
    by_reader(choice.branch, ghost.branch)
    press(choice.actions, "Hide")
    assert viewer.settle(30.0)
    assert ghost.branch not in [each.branch for each in viewer.state.drawn]
    assert "hidden" in viewer.panel.branches[ghost.column].label
    assert all(handle.batched_scales[ghost.column] == 0.0 for _, handle in viewer.drawing._ghosts)
    around = viewer.state
    for _ in range(8):
        around = states.with_next(around, 1)
        assert np.abs(around.q - ghost.q).max() > 1e-6
    press(choice.actions, "Show")
    assert viewer.settle(30.0) and ghost.branch in [each.branch for each in viewer.state.drawn]


def test_a_pinned_ghost_stays_where_it_is(viewer: Viewer, arm: urdf_ik.Arm) -> None:
    """The target moves on, the pinned solution does not; unpinned it is gone."""
    viewer.move_target(arm.fk(Q))
    assert viewer.settle(30.0)
    choice, ghost = viewer.work.ghosts, viewer.state.ghosts[3]
    by_reader(choice.branch, ghost.branch)
    press(choice.actions, "Pin")
    viewer.move_target(arm.fk(0.5 * Q))
    assert viewer.settle(30.0)
    assert [each.q.tolist() for each in viewer.state.pinned] == [ghost.q.tolist()]
    places = arm.link_poses(ghost.q)
    link, handle = viewer.drawing._pinned[-1]
    np.testing.assert_allclose(handle.batched_positions[ghost.column], places[link][:3, 3], atol=1e-6)
    assert handle.batched_scales.tolist() == [float(k == ghost.column) for k in range(8)]
    assert "(pinned)" in viewer.html(scene=True) and "pinned" in viewer.panel.branches[ghost.column].label
    press(choice.actions, "Unpin")
    assert viewer.settle(30.0) and not viewer.state.pinned and not handle.batched_scales.any()


def test_a_measure_is_that_of_the_two_frames(viewer: Viewer, arm: urdf_ik.Arm) -> None:
    """From the base to the tip: the distance, the way in the base and the turn of the tip's pose; a line along it."""
    measure = viewer.work.measure
    by_reader(measure.ends[0], arm.base)
    assert not measure.line.visible
    by_reader(measure.ends[1], arm.tip)
    for q in (Q, 0.5 * Q):
        by_reader(viewer.work.text, f"q = {q.tolist()}")
        assert viewer.settle(30.0)
        T = arm.fk(q)
        x, y, z = T[:3, 3]
        angle = np.rad2deg(np.arccos(np.clip(0.5 * (np.trace(T[:3, :3]) - 1.0), -1.0, 1.0)))
        words = measure.words.content
        assert f"{np.linalg.norm(T[:3, 3]):.4f} m" in words and f"{angle:.2f} deg" in words
        assert f"x {x:.4f}, y {y:.4f}, z {z:.4f} m" in words
        np.testing.assert_allclose(measure.line.points[0], [np.zeros(3), T[:3, 3]], atol=1e-6)
    by_reader(measure.ends[1], "-")
    assert not measure.line.visible and not measure.words.content


def test_the_last_choice_of_a_measure_is_the_one_that_is_shown(
    viewer: Viewer, arm: urdf_ik.Arm, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A page's answers run side by side: one that was held up half way does not write over what was chosen after it."""
    measure, held, going_on = viewer.work.measure, threading.Event(), threading.Event()
    places = arm.link_poses
    by_reader(measure.ends[0], arm.base)

    def slow(q: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        held.set()
        assert going_on.wait(30.0)
        return places(q)

    monkeypatch.setattr(type(arm), "link_poses", lambda _, q: slow(q))
    # A value that is set calls the functions that hear of it.
    chosen = threading.Thread(target=setattr, args=(measure.ends[1], "value", arm.tip))
    unchosen = threading.Thread(target=setattr, args=(measure.ends[1], "value", "-"))
    chosen.start()
    assert held.wait(30.0)
    unchosen.start()
    unchosen.join(0.3)  # as far as it comes while the other one is held up
    going_on.set()
    for thread in (chosen, unchosen):
        thread.join(30.0)
    assert not measure.line.visible and not measure.words.content


def test_a_recording_keeps_frames_and_their_times() -> None:
    """A GIF has every frame, in its colours, for as long as it was seen; a zip has each as a PNG."""
    shades = (0, 120, 240)
    frames = [
        (0.5 * k, recording.reduced(np.full((30, 40, 3), shade, dtype=np.uint8))) for k, shade in enumerate(shades)
    ]
    moving = Image.open(io.BytesIO(recording.written(frames, recording.KINDS[0])))
    assert moving.n_frames == 3
    for k, shade in enumerate(shades):
        moving.seek(k)
        assert moving.info["duration"] == 500
        assert np.abs(np.array(moving.convert("RGB"), dtype=int) - shade).max() <= 4
    with zipfile.ZipFile(io.BytesIO(recording.written(frames, recording.KINDS[1]))) as archive:
        assert archive.namelist() == ["0000.png", "0001.png", "0002.png"]
        assert np.array(Image.open(archive.open("0002.png")).convert("RGB"))[0, 0].tolist() == [240] * 3
