"""The viewer as a tool: what can be copied, and what the camera sees."""

import json
from collections.abc import Iterator

import numpy as np
import pytest

import urdf_ik

pytest.importorskip("viser")

from urdf_ik.show.viewer import Viewer  # noqa: E402
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


def test_joint_vector_and_target_can_be_copied(viewer: Viewer, arm: urdf_ik.Arm) -> None:
    """As Python, with nine decimals."""
    viewer.move_target(arm.fk(Q))
    assert viewer.settle(30.0)
    lines = viewer.panel.copied.content.strip("`\n").splitlines()
    q, pose = (np.array(json.loads(line.partition("= ")[2])) for line in lines)
    np.testing.assert_allclose(q, viewer.state.q, atol=1e-8)
    np.testing.assert_allclose(pose, arm.fk(Q), atol=1e-8)


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
