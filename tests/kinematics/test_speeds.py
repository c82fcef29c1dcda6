"""The greatest speeds of the joints, as Pinocchio reads them."""

import numpy as np
import pytest
from arms_mimic import LINKAGES, linkage

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference

TEXT = """<robot name="two"><link name="base"/><link name="a"/><link name="b"/><link name="c"/>
<joint name="j1" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="{}" effort="1"/></joint>
<joint name="j2" type="continuous"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/></joint>
<joint name="j3" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="1 0 0"/>
<limit lower="0" upper="1" velocity="0.25" effort="1"/></joint></robot>"""


@pytest.mark.parametrize("name", ["zyyzyz_6r", "ur5", "panda", "scara_rrpr"])
def test_they_are_pinocchios(name: str) -> None:
    """One a joint, in the order of the joint vector."""
    arm = urdf_ik.load(name)
    model = Reference(arm.model, arm.base, arm.tip).pin_model
    expected = [model.velocityLimit[model.joints[model.getJointId(joint)].idx_v] for joint in arm.joint_names]
    np.testing.assert_array_equal(arm.solver.velocity_limits, expected)
    assert not arm.solver.velocity_limits.flags.writeable


@pytest.mark.parametrize(("written", "read"), [("2.5", 2.5), ("0", np.inf)])
def test_what_is_not_given_is_infinite(written: str, read: float) -> None:
    """A joint without a limit has no greatest speed, nor has one whose speed was left at zero."""
    arm = urdf_ik.load(TEXT.format(written))
    np.testing.assert_array_equal(arm.solver.velocity_limits, [read, np.inf, 0.25])
    held, back = urdf_ik.load(TEXT.format(written), locked={"j2": 0.3}), urdf_ik.load(TEXT.format(written), "c", "base")
    np.testing.assert_array_equal(held.solver.velocity_limits, [read, 0.25])
    np.testing.assert_array_equal(back.solver.velocity_limits, [0.25, np.inf, read])


@pytest.mark.parametrize("name", LINKAGES)
def test_no_axis_is_faster_than_its_own_limit(name: str) -> None:
    """At the greatest speed of each joint no joint of the URDF that follows it exceeds its own, and one reaches it."""
    arm = urdf_ik.load(linkage(name, 0), "base", "tool")
    allowed = {joint.name: joint.velocity for joint in arm.model.joints}
    for joint, speed in zip(arm.joint_names, arm.solver.velocity_limits, strict=True):
        followed = [each for each in arm.chain.followers if each.driver == joint and each.multiplier]
        shares = [speed / allowed[joint], *(speed * abs(each.multiplier) / allowed[each.name] for each in followed)]
        assert max(shares) == pytest.approx(1.0)
