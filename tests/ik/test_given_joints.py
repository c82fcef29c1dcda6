"""Joints that are given by name: any of seven, and two of eight, by Pinocchio."""

import numpy as np
import pytest
from arms_seven import random_seven, skew
from lxml import etree
from numpy.typing import NDArray
from oracle import Oracle

import urdf_ik
from urdf_ik import ArgumentError, ChainError, UnsupportedArm

Array = NDArray[np.float64]
KINDS = ("S-R-S", "one before wrist, 1x2", "one behind 2||3||4, 5x6")


def check(arm: urdf_ik.Arm, oracle: Oracle, seed: int, count: int) -> None:
    """Planted joint vectors are found at their own values; all solutions are exact and have those values."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.5, 1.5, (count, arm.dof))
    T, values = oracle.poses(q), arm.redundancy_of(q)
    found = arm.ik(T, redundancy=values)
    apart = np.abs(np.exp(1j * found.q) - np.exp(1j * q[:, None])).max(axis=2)
    assert np.nanmax(np.nanmin(apart, axis=1)) < 1e-6
    for k in range(count):
        solutions = found[k].to_array()
        assert max(oracle.error(x, T[k]) for x in solutions) < 1e-9
        own = arm.redundancy_of(solutions, T[k])
        np.testing.assert_allclose(np.exp(1j * own), np.exp(1j * np.broadcast_to(values[k], own.shape)), atol=1e-9)
        np.testing.assert_array_equal(arm.ik(T[k], redundancy=values[k]).q, found.q[k])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("joint", range(1, 8))
def test_any_of_seven_joints(kind: str, joint: int) -> None:
    """Every joint may be the parameter, except one whose motion of the tip no other joints can undo."""
    text = random_seven(kind, 0).urdf
    if (kind, joint) == ("S-R-S", 4):
        # The elbow follows from the pose: holding it leaves six joints that are singular everywhere.
        with pytest.raises(UnsupportedArm, match="joint_4 given"):
            urdf_ik.load(text, "base", "tool", redundancy="joint_4")
        return
    arm = urdf_ik.load(text, "base", "tool", redundancy=f"joint_{joint}")
    assert arm.redundancy is not None
    assert (arm.redundancy.kind, arm.redundancy.joint) == ("locked joint", f"joint_{joint}")
    assert f"with joint {joint} given" in arm.structure.reason
    check(arm, Oracle(text), joint, 5)


def test_a_middle_joint_at_many_values() -> None:
    """A batch over poses and values, near a reference, and without solutions."""
    text = random_seven("one before wrist, 1x2", 0).urdf
    arm = urdf_ik.load(text, "base", "tool").with_redundancy("joint_3")
    oracle = Oracle(text)
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (4, 7))
    T = oracle.poses(q)
    values = np.linspace(-1.0, 1.0, 6)
    grid = arm.ik(T[:, None], redundancy=values, threads=2)
    assert grid.q.shape[:2] == (4, 6)
    near = arm.ik(T[0], q[0], redundancy=arm.redundancy_of(q[0])).nearest(q[0]).q[0]
    np.testing.assert_allclose(near, q[0], atol=1e-8)
    far = urdf_ik.pose([50.0, 0.0, 0.0])
    assert not arm.ik(far)
    assert "'joint_3' at" in arm.ik(far, redundancy=0.5).explain()


def test_eight_and_nine_joints() -> None:
    """Eight and nine joints have two and three parameters; joints named by the user are among them."""
    for n in (8, 9):
        text = skew(n)
        arm, oracle = urdf_ik.load(text, "base", "tool"), Oracle(text)
        assert len(arm.solver.parameters) == n - 6
        check(arm, oracle, n, 4)
    text = skew(8)
    arm = urdf_ik.load(text, "base", "tool", redundancy=("joint_2", "joint_1"))
    assert {each.joint for each in arm.solver.parameters} == {"joint_1", "joint_2"}
    check(arm, Oracle(text), 1, 3)
    middle = urdf_ik.load(text, "base", "tool", redundancy="joint_4")
    assert middle.solver.parameters[0].joint == "joint_4"
    check(middle, Oracle(text), 2, 2)


def test_names_that_cannot_be_given() -> None:
    """Unknown joints, a joint given twice, too many joints, and arms without redundancy are refused."""
    seven = urdf_ik.load("srs_7r")
    with pytest.raises(ChainError, match="'elbow' cannot be the redundancy parameter"):
        seven.with_redundancy("elbow")
    with pytest.raises(ArgumentError, match="leave 1 values free"):
        seven.with_redundancy("joint_1", "joint_2")
    with pytest.raises(ArgumentError, match="leave 0 values free"):
        urdf_ik.load("puma_560", redundancy="joint_1")
    with pytest.raises(ArgumentError, match="once"):
        urdf_ik.load(skew(8), "base", "tool", redundancy=("joint_1", "joint_1"))
    with pytest.raises(ArgumentError, match="free axis"):
        seven.with_redundancy("joint_3").with_free_axis("z")
    with pytest.raises(ArgumentError, match="no task is called 'poses'; tasks: 'pose', "):
        urdf_ik.arm.assemble(seven.model, seven.chain, task="poses")


def test_the_reason_says_why_that_end() -> None:
    """The cheaper solver decides which end is held."""
    reason = urdf_ik.load(random_seven("one behind 2||3||4, 5x6", 0).urdf, "base", "tool").structure.reason
    assert "with joint 7 given, whose others are solved in closed form" in reason


def test_limits_that_stand_for_none_leave_the_redundancy_parameter_where_postures_are() -> None:
    """Of a first joint up to 1e15 rad the middle would be 5e14, an angle without a digit: solutions missed by 15 mm."""
    arm = urdf_ik.load("panda")
    model = etree.fromstring(arm.model.xml)
    name = arm.redundancy.joint  # type: ignore[union-attr]
    (limit,) = model.xpath(f"joint[@name='{name}']/limit")
    limit.set("upper", "1e15")
    wide = urdf_ik.load(etree.tostring(model).decode(), arm.base, arm.tip)
    assert wide.redundancy is not None and wide.redundancy.default == 0.0
    T = wide.fk([0.3, 0.2, -0.4, -1.9, 0.5, 1.6, 0.0])
    reached = wide.fk(wide.ik(T).to_array())
    assert len(reached) and np.abs(reached - T).max() < 1e-9
    with pytest.raises(ArgumentError, match="up to 1e"):
        wide.ik(T, redundancy=5e14)
