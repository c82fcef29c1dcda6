"""The viewer as a tool: what is copied can be pasted; keys."""

from collections.abc import Iterator

import numpy as np
import pytest
from wire import WirePage, wait

import urdf_ik
from urdf_ik.errors import UrdfIkError

pytest.importorskip("viser")

from urdf_ik.show.viewer import Viewer, panels  # noqa: E402
from urdf_ik.show.viewer import state as states  # noqa: E402
from urdf_ik.show.viewer.surroundings import points_beside  # noqa: E402

Q = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])


@pytest.fixture(scope="module")
def arm() -> urdf_ik.Arm:
    """An arm whose solutions are partly outside its limits."""
    return urdf_ik.load("puma_560")


@pytest.fixture
def viewer(arm: urdf_ik.Arm) -> Iterator[Viewer]:
    """A page that shows it."""
    with Viewer(arm, port=0) as shown:
        yield shown


def test_joint_vectors_and_poses_are_read_in_every_form(arm: urdf_ik.Arm) -> None:
    """Python, or only numbers; a matrix, a position with a quaternion, or with roll, pitch and yaw."""
    for form in ("q = {}", "{}", "[{}]", "np.array([{}])"):
        kind, value = panels.read(form.format(", ".join(map(str, Q))), arm)
        assert kind == "q" and value.tolist() == Q.tolist()
    T = urdf_ik.pose([0.4, 0.1, 0.3], rpy=[0.1, 0.2, 0.3])
    x, y, z, w = 0.0342708, 0.1060205, 0.1435722, 0.9833474
    texts = (
        f"T = {T.tolist()}",
        str(T.ravel().tolist()),
        f"0.4 0.1 0.3 {x} {y} {z} {w}",
        "pose = 0.4,0.1,0.3,0.1,0.2,0.3",
    )
    for text in texts:
        kind, value = panels.read(text, arm)
        assert kind == "pose"
        np.testing.assert_allclose(value, T, atol=1e-6)
    for text, words in (("1 2 3", "3 numbers given"), ("q = 1 2", "6 joints"), ("a b", "no number")):
        with pytest.raises(UrdfIkError, match=words):
            panels.read(text, arm)


def test_what_is_copied_can_be_pasted(arm: urdf_ik.Arm) -> None:
    """Line by line."""
    lines = panels.written(Q, arm.fk(Q)).splitlines()
    for line, kind, expected in zip(lines, ("q", "pose"), (Q, arm.fk(Q)), strict=True):
        found, value = panels.read(line, arm)
        assert found == kind
        np.testing.assert_allclose(value, expected, atol=1e-8)


def test_pasting_moves_the_arm_and_says_what_is_wrong(viewer: Viewer, arm: urdf_ik.Arm) -> None:
    """A joint vector moves arm and target, a pose the target; nonsense moves nothing, and is named."""
    with WirePage(viewer) as page:
        page.change("Pose or q", f"q = {Q.tolist()}")
        wait(lambda: np.allclose(viewer.state.q, Q, rtol=0.0, atol=1e-12))
        T = arm.fk(Q * 0.5)
        page.change("Pose or q", f"pose = {T.tolist()}")
        wait(lambda: np.allclose(viewer.state.target, T, rtol=0.0, atol=1e-12))
        assert viewer.settle(30.0) and "q = [" in viewer.work.copied.content
        before = viewer.state
        page.change("Pose or q", "1 2")
        wait(lambda: "2 numbers given" in viewer.message)
        assert viewer.state is before


def test_the_keys_steps_go_round_the_solutions(arm: urdf_ik.Arm) -> None:
    """Next and previous, over those inside the limits, and back to the first one."""
    state = states.with_target(states.start(arm), arm.fk(Q))
    count = len(arm.ik(arm.fk(Q)).within_limits())
    first, seen = state.q, []
    for step in [1] * count + [-1] * count:
        state = states.with_next(state, step)
        seen.append(state.q)
        np.testing.assert_allclose(state.target, arm.fk(Q), atol=1e-12)
    assert len({tuple(q.round(6)) for q in seen}) == count
    np.testing.assert_allclose(seen[count - 1], first, atol=1e-9)
    np.testing.assert_allclose(seen[-1], first, atol=1e-9)


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
