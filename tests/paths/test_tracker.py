"""Streaming: the poses of a regular path give that path again, exactly, whatever the arm and its task."""

from __future__ import annotations

import numpy as np
import pytest
from tracking import DT, EXACT, FEW, arm_of, gaps, path, reference, regular_path, run, statuses, vectors

import urdf_ik
from urdf_ik.errors import PoseError

SIX = ("zyyzyz_6r", "ur5", "industrial", "ur_like", "crx", "general")
OTHERS = ("srs_7r", "panda", "seven", "seven general", "scara_rrpr", "stanford_rrprrr")


@pytest.mark.parametrize("name", SIX)
@pytest.mark.parametrize("seed", range(4))
def test_six_joints_return_the_path(name: str, seed: int) -> None:
    """Of a regular path of the joints its poses give that path again, every one exact as Pinocchio sees it."""
    Q = regular_path(name, seed)
    T = reference(name).pose(Q)
    steps = run(arm_of(name).tracker(Q[0], DT), T)
    assert statuses(steps) == {"ok": len(Q)}
    assert np.abs(vectors(steps) - Q).max() < 1e-7
    assert gaps(name, vectors(steps), T).max() <= EXACT


@pytest.mark.parametrize("name", OTHERS)
def test_other_arms_are_exact(name: str) -> None:
    """Seven joints and slides: every pose of a regular path is reached, within the limits."""
    Q = regular_path(name, 1)
    T = reference(name).pose(Q)
    steps = run(arm_of(name).tracker(Q[0], DT), T)
    assert statuses(steps) == {"ok": len(Q)}
    assert gaps(name, vectors(steps), T).max() <= EXACT


@pytest.mark.parametrize("name", FEW)
def test_few_joints_return_the_path(name: str) -> None:
    """The same for arms that reach a part of all poses only."""
    Q = regular_path(name, 2)
    steps = run(arm_of(name).tracker(Q[0], DT), reference(name).pose(Q))
    assert statuses(steps) == {"ok": len(Q)}
    assert np.abs(vectors(steps) - Q).max() < 1e-7


def test_tasks_are_followed() -> None:
    """An arm with a task takes targets of that task, and ignores the rest of the pose."""
    arm = arm_of("positioning_3r").for_task("position")
    Q = path(arm, 4)
    points = arm.fk(Q)[:, :3, 3]
    steps = [step for tracker in [arm.tracker(Q[0], DT)] for step in [tracker.step(point) for point in points]]
    assert statuses(steps) == {"ok": len(Q)}
    assert np.linalg.norm(arm.fk(vectors(steps))[:, :3, 3] - points, axis=1).max() <= EXACT
    with pytest.raises(PoseError, match="takes"):
        arm.tracker(Q[0], DT).step(np.eye(4))


@pytest.mark.parametrize(("name", "task"), [("planar_2r", "planar position"), ("so100", "position and axis")])
def test_other_tasks_are_followed(name: str, task: str) -> None:
    """Tasks in a plane, and of an axis."""
    arm = urdf_ik.load(name)
    assert arm.task == task
    Q = path(arm, 5, span=0.3)
    targets = arm.solver.control.target_of(arm.fk(Q))
    tracker = arm.for_task(task).tracker(Q[0], DT)
    steps = [tracker.step(target) for target in targets]
    reached = arm.solver.control.target_of(arm.fk(vectors(steps)))
    assert statuses(steps) == {"ok": len(Q)}
    assert np.abs(reached - targets).max() <= EXACT


def test_turns_are_kept() -> None:
    """A joint that keeps turning keeps its turns: its angle is continuous beyond half a turn."""
    arm = arm_of("ur5")
    Q = np.tile([0.3, -1.2, 1.4, -0.5, 1.1, 0.0], (900, 1))
    Q[:, 0] = np.linspace(-3.5, 5.5, 900)
    steps = run(arm.tracker(Q[0], DT, velocity=4.0), arm.fk(Q))
    np.testing.assert_allclose(vectors(steps), Q, atol=1e-9)
