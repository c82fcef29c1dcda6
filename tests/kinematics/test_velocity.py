"""What the Jacobian says, against NumPy's linear algebra on Pinocchio's Jacobian and against formulas of textbooks."""

import math

import numpy as np
import pytest
from arms import serial_urdf
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import DHTable
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.kinematics import velocity

Array = NDArray[np.float64]
PI = math.pi
ARMS = ("planar_2r", "positioning_3r", "scara_rrpr", "stanford_rrprrr", "zyyzyz_6r", "srs_7r", "tiago")
ROWS = {"all": slice(0, 6), "translation": slice(0, 3), "rotation": slice(3, 6)}


def drawn(arm: urdf_ik.Arm, *batch: int) -> Array:
    """Joint vectors (*batch, n)."""
    return np.random.default_rng(7).uniform(-1.5, 1.5, (*batch, arm.dof))


def scaled(arm: urdf_ik.Arm, q: Array, length: float) -> Array:
    """Pinocchio's Jacobian without units."""
    J = Reference(arm.model, arm.base, arm.tip).jacobian(q)
    J = np.concatenate([J[..., :3, :] / length, J[..., 3:, :]], axis=-2)
    return J * np.where(arm.chain.prismatic, length, 1.0)


@pytest.fixture(scope="module", params=ARMS)
def arm(request: pytest.FixtureRequest) -> urdf_ik.Arm:
    """Arms of two to seven joints, with and without prismatic ones."""
    return urdf_ik.load(request.param)


# ---------------------------------------------------------------- manipulability and condition


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


@pytest.mark.parametrize("part", ROWS)
@pytest.mark.parametrize("length", [None, 0.25])
def test_condition_is_numpys(arm: urdf_ik.Arm, part: str, length: float | None) -> None:
    """The ratio of the singular values of the Jacobian without units; infinite where the arm's structure loses one."""
    Q = drawn(arm, 6)
    J = scaled(arm, Q, length or arm.chain.size)[..., ROWS[part], :]
    s = np.linalg.svd(J, compute_uv=False)
    found = velocity.condition_number(arm.chain, Q, part, length)
    lost = s[:, -1] < 1e-14
    assert np.all(found[lost] > 1e13)
    np.testing.assert_allclose(found[~lost], s[~lost, 0] / s[~lost, -1], rtol=1e-9)


def test_condition_does_not_depend_on_the_unit_of_length() -> None:
    """An arm written in millimetres has the condition of the same arm in metres, prismatic joints and all."""
    rows = np.array([(-90, 0, 0.4, 0), (90, 0, 0.15, 0), (0, 0, 0, 0), (-90, 0.1, 0, 0), (90, 0, 0, 0), (0, 0, 0.2, 0)])
    q = np.array([0.3, 0.8, 0.5, -0.4, 0.7, 0.1])
    found = []
    for unit in (1.0, 1000.0):
        table = DHTable.from_array(
            rows * [1, unit, unit, 1], "standard", joint_types="RRPRRR", limits=[(-180, 180)] * 6, degrees=True
        )
        found.append(velocity.condition_number(table.chain(), q * [1, 1, unit, 1, 1, 1]))
    np.testing.assert_allclose(found[1], found[0], rtol=1e-10)


def test_isotropic_arm() -> None:
    """Salisbury and Craig 1982: two links with l1 = sqrt(2) l2 are isotropic at q2 = 135 deg."""
    table = DHTable.from_array([(0, math.sqrt(2), 0, 0), (0, 1, 0, 0)], "standard")
    np.testing.assert_allclose(velocity.condition_number(table.chain(), [0.4, 0.75 * PI], "translation"), 1, atol=1e-14)
    assert velocity.condition_number(table.chain(), [0.4, 0.0], "translation") == np.inf


def test_arm_without_joints() -> None:
    """Nothing moves, and nothing raises."""
    arm = urdf_ik.load(serial_urdf("fixed", [((0, 0, 1), (0, 0, 0))], [None]), "base", "tool")
    assert arm.manipulability(np.zeros(0)) == 0
    assert velocity.condition_number(arm.chain, np.zeros((2, 0))).tolist() == [np.inf, np.inf]
