"""An arm on a rail, one with a positioner that carries the workpiece, and two arms of one URDF: by Pinocchio."""

import numpy as np
import pinocchio as pin
import pytest
from cases import vectors
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import ChainError
from urdf_ik.arm import with_positioner
from urdf_ik.cell.pinocchio_reference import Reference

Array = NDArray[np.float64]


def check(arm: urdf_ik.Arm, seed: int = 0) -> None:
    """Planted joint vectors are found at their own values; every solution is exact."""
    reference = Reference(arm.model, arm.base, arm.tip, locked=dict(arm.chain.locked))
    q = vectors(arm, 40, seed)
    T = reference.pose(q)
    found = arm.ik(T, redundancy=arm.redundancy_of(q) if arm.solver.parameters else None)
    position, rotation = reference.errors(found.q, T[:, None])
    assert np.nanmax(position) < 1e-9
    assert np.nanmax(rotation) < 1e-9
    assert np.nanmax(np.nanmin(np.abs(np.exp(1j * found.q) - np.exp(1j * q[:, None])).max(axis=2), axis=1)) < 1e-6


def test_the_rail_is_what_is_free() -> None:
    """The first joint slides and is the parameter, in metres; moving it and the target together changes no other."""
    arm = urdf_ik.load("rail_6r")
    assert arm.redundancy is not None
    assert (arm.redundancy.joint, arm.redundancy.unit, arm.redundancy.range) == ("rail", "m", (-1.5, 1.5))
    check(arm)
    T = arm.fk(vectors(arm, 1)[0])
    moved = T.copy()
    moved[1, 3] += 0.5
    one, other = arm.ik(T, redundancy=-0.2), arm.ik(moved, redundancy=0.3)
    np.testing.assert_allclose(one.q[:, 1:], other.q[:, 1:], atol=1e-9)
    q = vectors(arm, 1, 7)[0]
    np.testing.assert_allclose(arm.ik_nearest(arm.fk(q), q).q[0], q, atol=1e-8)
    named = urdf_ik.load("rail_6r", redundancy="joint_6")
    assert named.redundancy is not None
    assert named.redundancy.joint == "joint_6"
    check(named)


def test_a_path_longer_than_the_reach_runs_along_the_rail() -> None:
    """Two metres of straight line, of which the arm alone reaches less than half."""
    arm = urdf_ik.load("rail_6r")
    start = urdf_ik.pose([0.6, -1.0, 0.8], rpy=[0.0, np.pi / 2.0, 0.0])
    path = urdf_ik.line(start, urdf_ik.pose([0.6, 1.0, 0.8], rpy=[0.0, np.pi / 2.0, 0.0]), 40)
    plan = arm.follow(path)
    assert plan.found, plan.explain()
    reference = Reference(arm.model, arm.base, arm.tip)
    assert np.abs(reference.pose(plan.q) - path).max() < 1e-8
    assert np.ptp(plan.q[:, 0]) > 0.5
    assert not urdf_ik.load("rail_6r", locked={"rail": 0.0}).follow(path).found


def test_poses_in_the_workpiece() -> None:
    """The chain from the workpiece to the torch: two parameters, and the tip in the workpiece is Pinocchio's."""
    arm = urdf_ik.load("positioner_6r", base="workpiece", tip="torch")
    assert arm.dof == 8
    assert [each.joint for each in arm.solver.parameters] == ["turn", "tilt"]
    check(arm)
    model = pin.buildModelFromUrdf(str(arm.model.path))
    data = model.createData()
    q = vectors(arm, 10, 1)
    for x in q:
        pin.framesForwardKinematics(model, data, arm.to_pinocchio(x))
        part, torch = (data.oMf[model.getFrameId(name, pin.FrameType.BODY)] for name in ("workpiece", "torch"))
        np.testing.assert_allclose(arm.fk(x), part.actInv(torch).homogeneous, atol=1e-13)
    held = urdf_ik.load("positioner_6r", base="workpiece", tip="torch", locked={"tilt": 0.4})
    assert [each.joint for each in held.solver.parameters] == ["turn"]
    check(held)


def test_the_other_arm_stands_where_it_is() -> None:
    """Its joint vector moves its links as Pinocchio has them, and makes contacts; the chosen arm stays the same."""
    left, right = urdf_ik.load("dual_6r"), urdf_ik.load("dual_6r", tip="right_tool0")
    check(left)
    check(right)
    T = urdf_ik.pose([0.5, 0.0, 0.9], rpy=[0.0, np.pi / 2.0, 0.0])
    ours = left.ik(T).within_limits().collision_free().to_array()
    theirs = right.ik(T).within_limits().collision_free().to_array()
    held = dict(zip(right.joint_names, map(float, theirs[0]), strict=True))
    crossed = left.with_locked(held)
    assert crossed.joint_names == left.joint_names
    assert dict(crossed.chain.locked) == held
    reference = Reference(crossed.model, crossed.base, crossed.tip, locked=held)
    links, expected = crossed.link_poses(ours[0]), reference.link_poses(ours[0])
    assert max(np.abs(links[name] - expected[name]).max() for name in links) < 1e-12
    np.testing.assert_allclose(links["right_tool0"], T, atol=1e-9)
    np.testing.assert_array_equal(crossed.ik(T).q, left.ik(T).q)
    assert (left.clearance(ours) > 0.0).all()
    assert (np.asarray(crossed.clearance(ours)) == 0.0).all()
    back = crossed.with_locked(dict.fromkeys(right.joint_names, 0.0))
    np.testing.assert_allclose(back.clearance(ours), left.clearance(ours), atol=1e-9)
    assert urdf_ik.load("dual_6r", locked=held).chain.locked == tuple(held.items())


def test_joints_that_cannot_be_held() -> None:
    """A joint that there is not, and one that is fixed."""
    arm = urdf_ik.load("dual_6r")
    for name in ("elbow", "left_mount"):
        with pytest.raises(ChainError, match="cannot be locked"):
            arm.with_locked({name: 0.0})


def test_a_positioner_of_another_file() -> None:
    """Poses in the frame of its tip, by Pinocchio on the joined URDF and from the two files' own poses."""
    table, arm = urdf_ik.load("planar_2r"), urdf_ik.load("puma_560")
    at = urdf_ik.pose([0.5, 0.1, 0.2], rpy=[0.1, -0.3, 0.7])
    cell = with_positioner(arm, table, at, name="table")
    assert (cell.base, cell.tip, cell.dof) == ("table_tool0", "tool0", 8)
    assert cell.joint_names == ("table_joint_2", "table_joint_1", *arm.joint_names)
    check(cell)
    q = vectors(cell, 10)
    carried = at @ table.fk(q[:, 1::-1])
    np.testing.assert_allclose(carried @ cell.fk(q), arm.fk(q[:, 2:]), atol=1e-12)
    with pytest.raises(urdf_ik.ArgumentError, match="twice"):
        with_positioner(cell, table, at, name="table")
