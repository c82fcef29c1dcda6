"""An arm beyond its solutions: Pinocchio's configurations, the nearest solution, refused arguments."""

import numpy as np
import pinocchio as pin
import pytest
from arms_mimic import LINKAGES, linkage
from cases import from_catalogue

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference

ARMS = ("zyyzyz_6r", "planar_2r", "positioning_3r", "stanford_rrprrr", "srs_7r")


def within(arm: urdf_ik.Arm, seed: int, m: int) -> np.ndarray:
    """Joint vectors (m, n) inside the limits, or within +-3 where a joint has no limits."""
    lower, upper = np.clip(arm.limits, -3.0, 3.0).T
    return np.random.default_rng(seed).uniform(lower, upper, (m, arm.dof))


@pytest.mark.parametrize("name", [*ARMS, "ur5"])
def test_configurations_of_pinocchio_are_those_of_its_own_model(name: str) -> None:
    """Pinocchio's forward kinematics of ``to_pinocchio(q)`` is the arm's, and ``from_pinocchio`` gives q again."""
    arm = from_catalogue(name).arm
    model = pin.buildModelFromXML(arm.model.xml.decode())
    data = model.createData()
    Q = within(arm, 1, 6).reshape(2, 3, arm.dof)
    configurations = arm.to_pinocchio(Q)
    assert configurations.shape == (2, 3, model.nq)
    np.testing.assert_allclose(arm.from_pinocchio(configurations), Q, rtol=0.0, atol=1e-12)
    for q, q_pin in zip(Q.reshape(-1, arm.dof), configurations.reshape(-1, model.nq), strict=True):
        pin.framesForwardKinematics(model, data, q_pin)
        base, tip = (data.oMf[model.getFrameId(link)] for link in (arm.base, arm.tip))
        np.testing.assert_allclose((base.inverse() * tip).homogeneous, arm.fk(q), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_the_nearest_of_any_arm_is_where_it_came_from(name: str) -> None:
    """Asked for the pose of a joint vector inside the limits, near it, every arm finds that joint vector."""
    arm = from_catalogue(name).arm
    Q = within(arm, 2, 4)
    found = arm.ik_nearest(arm.fk(Q), Q)
    assert found.q.shape == (4, 1, arm.dof) and found.valid.all()
    np.testing.assert_allclose(found.q[:, 0], Q, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("name", LINKAGES)
def test_mimic_joints_follow_in_pinocchios_configuration(name: str) -> None:
    """In ``to_pinocchio`` mimic joints follow their drivers: Pinocchio's tip is the arm's."""
    arm = urdf_ik.load(linkage(name, 0), base="base", tip="tool")
    reference = Reference(arm.model, arm.base, arm.tip)
    model, data = reference.pin_model, reference.pin_model.createData()
    for q in np.random.default_rng(4).uniform(-1.0, 1.0, (5, arm.dof)):
        q_pin = arm.to_pinocchio(q)
        np.testing.assert_allclose(arm.from_pinocchio(q_pin), q, rtol=0.0, atol=1e-12)
        pin.framesForwardKinematics(model, data, q_pin)
        base, tip = (data.oMf[model.getFrameId(link)] for link in (arm.base, arm.tip))
        np.testing.assert_allclose((base.inverse() * tip).homogeneous, arm.fk(q), rtol=0.0, atol=1e-12)
