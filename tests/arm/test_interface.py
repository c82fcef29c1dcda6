"""An arm beyond its solutions: Pinocchio's configurations, the nearest solution, pickling, refused references."""

import pickle
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from arms_mimic import LINKAGES, linkage
from cases import from_catalogue

import urdf_ik
from urdf_ik import ArgumentError, PoseError
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


def test_what_users_hold_is_the_same_in_another_process() -> None:
    """Solutions, plans, locks, closest postures and errors are pickled, as multiprocessing and Dask send them."""
    arm = from_catalogue("ur5").arm
    q = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
    T = arm.fk(q)
    held = (arm.ik(T), arm.ik_closest(T), arm.follow(arm.fk(q + 0.02 * np.eye(6)[0] * np.arange(5)[:, None]), start=q))
    for one, other in zip(held, pickle.loads(pickle.dumps(held)), strict=True):
        np.testing.assert_array_equal(one.q, other.q)
    assert pickle.loads(pickle.dumps(urdf_ik.freeze(arm))).verify(arm).passed
    with pytest.raises(PoseError, match=r"pose \[1\]: entry \[0, 0\] is nan") as caught:
        arm.ik(np.stack([T, np.full((4, 4), np.nan)]))
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.index) == (str(caught.value), (1,))


@pytest.mark.parametrize(
    ("q_ref", "words"),
    [(np.zeros(5), "6 joints.*shoulder_pan_joint"), (np.full(6, np.nan), "is nan"),
     ("x", "array of numbers"), (np.zeros((2, 6)), r"q_ref has the shape \(2, 6\) and the poses \(\)")],
)  # fmt: skip
def test_references_that_do_not_fit_are_refused(q_ref: Any, words: str) -> None:
    """The error says the shape or the value, and the joints that are needed."""
    arm = from_catalogue("ur5").arm
    T = arm.fk(np.full(6, 0.3))
    with pytest.raises(ArgumentError, match=words):
        arm.ik(T).nearest(q_ref)
    with pytest.raises(ArgumentError, match=words):
        arm.ik_nearest(T, q_ref)
