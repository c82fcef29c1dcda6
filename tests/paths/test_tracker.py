"""Streaming: the poses of a regular path give that path again, exactly, whatever the arm and its task."""

import numpy as np
import pytest
from tracking import DT, EXACT, FEW, arm_of, gaps, path, reference, regular_path, run, statuses, vectors

import urdf_ik

SIX = ("zyyzyz_6r", "ur5", "industrial", "ur_like", "crx", "general")
OTHERS = ("srs_7r", "panda", "seven", "seven general", "scara_rrpr", "stanford_rrprrr")


@pytest.mark.parametrize("name", [*SIX, *OTHERS, *FEW])
@pytest.mark.parametrize("seed", range(2))
def test_the_path_is_returned(name: str, seed: int) -> None:
    """The poses of a regular path are reached exactly as Pinocchio sees it, by the same joint vectors unless free."""
    Q = regular_path(name, seed)
    T = reference(name).pose(Q)
    steps = run(arm_of(name).tracker(Q[0], DT), T)
    assert statuses(steps) == {"ok": len(Q)}
    if name not in OTHERS:
        assert np.abs(vectors(steps) - Q).max() < 1e-7
    if name not in FEW:
        assert gaps(name, vectors(steps), T).max() <= EXACT


@pytest.mark.parametrize(
    ("name", "task"),
    [("positioning_3r", "position"), ("planar_2r", "planar position"), ("so100", "position and axis")],
)
def test_tasks_are_followed(name: str, task: str) -> None:
    """An arm with a task takes targets of that task, and ignores the rest of the pose."""
    arm = urdf_ik.load(name).for_task(task)
    Q = path(arm, 5, span=0.3)
    targets = arm.solver.control.target_of(arm.fk(Q))
    tracker = arm.tracker(Q[0], DT)
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
