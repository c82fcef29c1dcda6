"""An arm: what belongs to it and what to the caller, its references, and the arms that it refuses to solve."""

import numpy as np
import pytest
from arms import DescribedArm, industrial, ur_like
from arms_seven import skew, sliding
from cases import described, from_catalogue, nearest, rows
from numpy.typing import NDArray
from oracle import Oracle, angle_distance

import urdf_ik
from urdf_ik.errors import PoseError, UnsupportedArm
from urdf_ik.show.shapes import stick

Array = NDArray[np.float64]
Q = np.array([0.3, 0.5, 0.9, 0.4, 0.8, -0.2])


def test_answers_do_not_follow_the_callers_array() -> None:
    """Overwriting the target after the call changes neither the solutions nor the pose that they belong to."""
    case = from_catalogue("zyyzyz_6r")
    for target in (case.oracle.pose(Q), urdf_ik.pose([3.0, 0.0, 0.0])):
        mine = target.copy()
        view = mine.view()
        view.setflags(write=False)
        for given in (mine, view):
            mine[:] = target
            solutions = case.arm.ik(given)
            q, text = solutions.q.copy(), solutions.explain()
            mine[:] = 9.0
            np.testing.assert_array_equal(solutions.q, q)
            np.testing.assert_array_equal(solutions.poses, target)
            assert solutions.explain() == text


@pytest.mark.parametrize("bad", [(0,), (1700,), (2999,), (2500, 700), (700, 1600, 2999)])
def test_the_first_bad_pose_is_named_whatever_thread_meets_it(bad: tuple[int, ...]) -> None:
    """With bad poses in several threads' shares the error still tells the first."""
    arm = from_catalogue("zyyzyz_6r").arm
    targets = np.tile(np.eye(4), (3000, 1, 1))
    targets[:, 2, 3] = 2.0
    for index in bad:
        targets[index, 0, 0] = np.nan
    for threads in (1, 2, 4):
        with pytest.raises(PoseError) as error:
            arm.ik(targets, threads=threads)
        assert error.value.index == (min(bad),)


@pytest.mark.parametrize("turns", [(0, 0), (1, -1), (-2, 1), (2, 0), (0, 2), (1, -4)], ids=str)
def test_reference_a_turn_away(turns: tuple[int, int]) -> None:
    """A reference counts modulo whole turns: near a free wrist the member nearest to it is the planted one.

    A joint with limits of +-2 pi, or a continuous one that has wound up, stands such turns away.
    """
    for name in ("zyyzyz_6r", "ur5"):
        case = from_catalogue(name)
        planted = Q.copy()
        planted[4] = 0.0
        reference = planted.copy()
        reference[[3, 5]] += 2.0 * np.pi * np.array(turns)
        found = rows(case.arm.ik(case.oracle.pose(planted), q_ref=reference))
        assert nearest(found, planted) < 1e-6, name


def test_unsupported_arm() -> None:
    """An arm of no family loads, moves and tells its axes; only asking for solutions raises, with a way out."""
    text = sliding(sliding(skew(6), 2, -1.0, 1.0), 5, -1.0, 1.0)
    arm, oracle = urdf_ik.load(text, "base", "tool"), Oracle(text)
    assert arm.joint_names == oracle.names
    for q in np.random.default_rng(2).uniform(-1.0, 1.0, (3, arm.dof)):
        np.testing.assert_allclose(arm.fk(q), oracle.pose(q), atol=1e-13)
        np.testing.assert_allclose(arm.jacobian(q), oracle.jacobian(q), atol=1e-13)
        np.testing.assert_allclose(arm.link_poses(q)["tool"], oracle.pose(q), atol=1e-13)
    for ask in (arm.ik, arm.explain):
        with pytest.raises(UnsupportedArm) as error:
            ask(np.eye(4))
        assert "two slides three joints apart (RPRRPR)" in str(error.value) and arm.name in str(error.value)
        assert "locked={" in str(error.value) or str(arm.structure) in str(error.value)


@pytest.mark.parametrize("described_arm", [ur_like(), industrial()], ids=lambda a: a.name)
def test_an_arm_that_is_solved_from_its_tool(described_arm: DescribedArm) -> None:
    """With base and tip swapped the arm still loads and moves; where a family takes it, its solutions are exact."""
    arm = urdf_ik.load(described_arm.urdf, "tool", "base")
    forward = described(described_arm)
    q = Q[::-1]
    target = np.linalg.inv(forward.oracle.pose(Q))
    np.testing.assert_allclose(arm.fk(q), target, atol=1e-13)
    assert arm.joint_names == forward.arm.joint_names[::-1]
    if not arm.structure.family:
        return
    found = rows(arm.ik(target))
    expected = rows(forward.arm.ik(np.linalg.inv(target)))
    assert len(found) == len(expected)
    for solution in found:
        assert forward.oracle.error(solution[::-1], np.linalg.inv(target)) < 1e-9
        assert float(angle_distance(expected, solution[::-1]).min()) < 1e-6


def test_the_stick_of_an_arm_runs_either_way() -> None:
    """Between any two links the drawn stick is the same bones: from the tool it runs backwards, and turned."""
    text = industrial().urdf
    forward, back = urdf_ik.load(text, "base", "tool"), urdf_ik.load(text, "tool", "base")
    bones = stick(forward.chain, Q)
    seen_from_tip = np.linalg.inv(Oracle(text).pose(Q))
    np.testing.assert_allclose(
        stick(back.chain, Q[::-1])[::-1], bones @ seen_from_tip[:3, :3].T + seen_from_tip[:3, 3], atol=1e-13
    )
