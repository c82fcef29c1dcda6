"""Batches of poses: memory that is used again, and threads."""

import numpy as np
import pytest

import urdf_ik
from urdf_ik.errors import ArgumentError


@pytest.fixture(scope="module")
def arm() -> urdf_ik.Arm:
    """A six-joint arm."""
    return urdf_ik.load("zyyzyz_6r")


def _poses(arm: urdf_ik.Arm, seed: int, shape: tuple[int, ...] = (40,)) -> np.ndarray:
    return arm.fk(np.random.default_rng(seed).uniform(-3.0, 3.0, (*shape, arm.dof)))


@pytest.mark.parametrize("shape", [(40,), (5, 8), (0,), (1,)])
def test_out_gives_the_same_answer_in_the_same_memory(arm: urdf_ik.Arm, shape: tuple[int, ...]) -> None:
    """What an earlier call returned is overwritten with the answer that a call without it gives."""
    earlier, T = arm.ik(_poses(arm, 1, shape)), _poses(arm, 2, shape)
    memory, expected = earlier.q, arm.ik(T)
    solved = arm.ik(T, out=earlier)
    assert solved is earlier
    assert solved.q is memory
    np.testing.assert_array_equal(solved.q, expected.q)
    np.testing.assert_array_equal(solved.valid, expected.valid)
    np.testing.assert_array_equal(solved.poses, T)


def test_out_holds_for_tasks_and_redundancy_parameters() -> None:
    """Targets of a task and values of a redundancy parameter take memory, too."""
    planar = urdf_ik.load("planar_2r")
    xy = np.array([[0.3, 0.4], [0.5, 0.1]])
    earlier = planar.ik(xy, task="planar position")
    q = earlier.q.copy()
    again = planar.ik(xy[::-1], task="planar position", out=earlier)
    assert again is earlier
    np.testing.assert_array_equal(again.q, q[::-1])
    seven = urdf_ik.load("srs_7r")
    T = _poses(seven, 3)
    earlier = seven.ik(T, redundancy=0.3)
    again = seven.ik(T, redundancy=np.linspace(-1.0, 1.0, len(T)), out=earlier)
    np.testing.assert_array_equal(again.redundancy, np.linspace(-1.0, 1.0, len(T)))
    np.testing.assert_array_equal(again.q, seven.ik(T, redundancy=np.linspace(-1.0, 1.0, len(T))).q)
    assert seven.ik(T[0], redundancy=0.3).redundancy.shape == ()


def test_auto_threads_answer_as_one(arm: urdf_ik.Arm) -> None:
    """One thread for each processor gives the answer of one thread to the last bit."""
    T = _poses(arm, 5, (5000,))
    np.testing.assert_array_equal(arm.ik(T, threads="auto").q, arm.ik(T).q)
    with pytest.raises(ArgumentError, match="from 1 to 1024, or 'auto'"):
        arm.ik(T, threads="two")  # type: ignore[arg-type]


@pytest.mark.parametrize("count", [1, 7, 8, 9, 100])
def test_a_batch_answers_as_its_poses_do(arm: urdf_ik.Arm, count: int) -> None:
    """The answer of a batch is that of its poses, and begins at a cache line."""
    T = _poses(arm, 6, (count,))
    solved = arm.ik(T)
    np.testing.assert_array_equal(solved.q, [arm.ik(each).q for each in T])
    np.testing.assert_array_equal(solved.valid, [arm.ik(each).valid for each in T])
    assert solved.q.ctypes.data % 64 == 0
    assert not solved.q.flags.writeable
