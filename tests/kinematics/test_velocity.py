"""What the Jacobian says, against NumPy's linear algebra on Pinocchio's Jacobian and against formulas of textbooks."""

import math

import numpy as np
import pytest
from arms import serial_urdf
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference

Array = NDArray[np.float64]
PI = math.pi
ARMS = ("planar_2r", "positioning_3r", "scara_rrpr", "stanford_rrprrr", "zyyzyz_6r", "srs_7r", "tiago")
ROWS = {"all": slice(0, 6), "translation": slice(0, 3), "rotation": slice(3, 6)}


def drawn(arm: urdf_ik.Arm, *batch: int) -> Array:
    """Joint vectors (*batch, n)."""
    return np.random.default_rng(7).uniform(-1.5, 1.5, (*batch, arm.dof))


@pytest.fixture(scope="module", params=ARMS)
def arm(request: pytest.FixtureRequest) -> urdf_ik.Arm:
    """Arms of two to seven joints, with and without prismatic ones."""
    return urdf_ik.load(request.param)


# ---------------------------------------------------------------- manipulability


@pytest.mark.parametrize("part", ROWS)
def test_manipulability_is_the_root_of_the_determinant(arm: urdf_ik.Arm, part: str) -> None:
    """It is sqrt(det(J J^T)), or sqrt(det(J^T J)) where there are fewer joints than rows, in batch as one by one."""
    Q = drawn(arm, 3, 4)
    J = Reference(arm.model, arm.base, arm.tip).jacobian(Q)[..., ROWS[part], :]
    Jt = np.swapaxes(J, -1, -2)
    gram = J @ Jt if J.shape[-2] <= J.shape[-1] else Jt @ J
    expected = np.sqrt(np.maximum(np.linalg.det(gram), 0.0))
    found = arm.manipulability(Q, part)
    assert found.shape == (3, 4)
    # The determinant squares the rounding of a structural zero.
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=3e-8)
    assert found[1, 2] == arm.manipulability(Q[1, 2], part)


@given(one=st.floats(-3, 3), two=st.floats(-3, 3))
def test_manipulability_of_two_links(one: float, two: float) -> None:
    """Yoshikawa 1985: l1 l2 |sin q2| for the two-link arm's translation."""
    w = urdf_ik.load("planar_2r").manipulability([one, two], "translation")
    np.testing.assert_allclose(w, 0.066 * 0.130 * abs(math.sin(two)), atol=1e-16)


def test_manipulability_of_the_puma() -> None:
    """Corke, Robotics, Vision and Control: 0.0786 at q_n; zero with the wrist straight."""
    puma = urdf_ik.load("puma_560")
    nominal = [0, PI / 4, PI, 0, PI / 4, 0]
    np.testing.assert_allclose(puma.manipulability(nominal), 0.0786, atol=5e-5)
    np.testing.assert_allclose(puma.manipulability(nominal, "translation"), 0.1112, atol=5e-5)
    assert puma.manipulability([0, PI / 4, PI, 0, 0, 0]) < 1e-16


def test_arm_without_joints() -> None:
    """Nothing moves, and nothing raises."""
    arm = urdf_ik.load(serial_urdf("fixed", [((0, 0, 1), (0, 0, 0))], [None]), "base", "tool")
    assert arm.manipulability(np.zeros(0)) == 0
