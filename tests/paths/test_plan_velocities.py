"""Joint velocities of plans, against differences of the plan's own joint vectors."""

import numpy as np
import pytest

import urdf_ik
from urdf_ik.errors import ArgumentError
from urdf_ik.model.poses import to_rotvec

COUNT = 401


@pytest.mark.parametrize("name", ["zyyzyz_6r", "scara_rrpr"])
def test_they_are_the_differences_of_a_finely_sampled_line(name: str) -> None:
    """Along a line at constant speed in one second, central differences of q come within their own error."""
    arm = urdf_ik.load(name)
    q0 = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]) if arm.dof == 6 else np.array([0.3, 0.5, 0.1, 0.2])
    T0, T1 = arm.fk(q0), arm.fk(q0 + 0.03)
    plan = arm.follow(urdf_ik.line(T0, T1, COUNT))
    assert plan.found
    turn = T0[:3, :3] @ to_rotvec(np.linalg.inv(T0) @ T1)
    twist = np.concatenate([T1[:3, 3] - T0[:3, 3], turn])
    dt = 1.0 / (COUNT - 1)
    np.testing.assert_allclose(plan.velocities(twist)[1:-1], (plan.q[2:] - plan.q[:-2]) / (2.0 * dt), atol=1e-4)


def test_a_redundancy_parameters_rate_moves_the_joints_alone() -> None:
    """Along a path of equal poses, the rate of the parameter gives joint velocities that leave the tip where it is."""
    arm = urdf_ik.load("panda")
    T = arm.fk([0.1, 0.3, 0.0, -1.5, 0.0, 1.8, 0.4])
    plan = arm.follow(urdf_ik.line(T, T @ urdf_ik.pose([0.0, 0.0, 0.02]), 5))
    assert plan.found
    still = np.zeros(6)
    np.testing.assert_array_equal(plan.velocities(still), np.zeros((5, 7)))
    swing = plan.velocities(still, [1.0])
    assert (np.abs(swing).max(axis=-1) > 0.1).all()
    np.testing.assert_allclose((arm.jacobian(plan.q) @ swing[..., None])[..., 0], np.zeros((5, 6)), atol=1e-9)
    with pytest.raises(ArgumentError, match="1 redundancy parameters"):
        plan.velocities(still, [1.0, 2.0])
