"""A tracker's targets, its answers, and the inputs that it refuses."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from arms_mimic import linkage
from cases import from_catalogue
from tracking import DT, Q0, Array, arm_of, path, run, vectors

import urdf_ik
from urdf_ik.errors import ArgumentError, PoseError, UnsupportedArm


def test_reset_begins_anew() -> None:
    """After a reset the tracker is where it was put, at the speed that it was given."""
    arm = arm_of("zyyzyz_6r")
    tracker = arm.tracker(Q0, DT)
    tracker.step(arm.fk(Q0 + 0.001))
    tracker.reset(Q0 + 0.1, velocity=np.full(6, 0.01))
    np.testing.assert_array_equal(tracker.q, Q0 + 0.1)
    np.testing.assert_array_equal(tracker.velocity, np.full(6, 0.01))
    assert tracker.step(arm.fk(Q0 + 0.1)).status == "ok"


def test_threads_with_a_tracker_each() -> None:
    """Trackers in several threads at once answer as they do one after the other."""
    arm = arm_of("zyyzyz_6r")
    paths = [path(arm, seed, cycles=300) for seed in range(6)]

    def follow(Q: Array) -> Array:
        return vectors(run(arm.tracker(Q[0], DT), arm.fk(Q)))

    with ThreadPoolExecutor(3) as pool:
        for together, alone in zip(pool.map(follow, paths), map(follow, paths), strict=True):
            np.testing.assert_array_equal(together, alone)


def test_velocity_limits_come_from_the_urdf() -> None:
    """Left out, the limits are those that the URDF states; one number is for all joints."""
    case = from_catalogue("ur5")
    stated = {joint.name: joint.velocity for joint in case.arm.model.joints}
    tracker = case.arm.tracker(np.zeros(6), DT)
    np.testing.assert_array_equal(tracker.velocity_limits, [stated[name] for name in case.arm.joint_names])
    np.testing.assert_array_equal(case.arm.tracker(np.zeros(6), DT, velocity=0.5).velocity_limits, np.full(6, 0.5))


def test_a_start_that_does_not_fit_is_refused() -> None:
    """A start of another size, not finite, or outside the limits."""
    arm = arm_of("zyyzyz_6r")
    for bad, words in (
        (Q0[:5], "6"),
        (np.stack([Q0, Q0]), "one joint vector"),
        (Q0 * np.nan, "finite"),
        (Q0 + [0, 0, 0, 0, 5, 0], "'joint_5' is at 5.7, outside"),
    ):
        with pytest.raises(ArgumentError, match=words):
            arm.tracker(bad, DT)


def test_an_invalid_pose_is_refused_and_moves_nothing() -> None:
    """NaN, a reflection, a batch: PoseError, and the tracker keeps its state."""
    arm = arm_of("zyyzyz_6r")
    tracker = arm.tracker(Q0, DT)
    tracker.step(arm.fk(Q0))
    q = tracker.q
    for bad in (np.full((4, 4), np.nan), np.diag([1.0, 1.0, -1.0, 1.0]), np.stack([np.eye(4)] * 2)):
        with pytest.raises(PoseError):
            tracker.step(bad)
        np.testing.assert_array_equal(tracker.q, q)
    assert tracker.step(arm.fk(Q0)).status == "ok"


def test_arms_that_are_not_tracked_say_why() -> None:
    """Joints that mimic others, and more than seven joints."""
    arm = urdf_ik.load(linkage("any axes", 0), base="base", tip="tool")
    with pytest.raises(UnsupportedArm, match="mimic"):
        arm.tracker(np.zeros(arm.dof), DT)
