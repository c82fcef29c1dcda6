"""What the Jacobian says, against NumPy's linear algebra on Pinocchio's Jacobian and against formulas of textbooks."""

from __future__ import annotations

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
from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics import velocity
from urdf_ik.support.tolerances import DEFAULT

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


# ---------------------------------------------------------------- singular directions


def test_gains_and_directions(arm: urdf_ik.Arm) -> None:
    """Each motion gives its twist with its gain; gains fall; directions are at right angles without units."""
    Q = drawn(arm, 2, 3)
    L = arm.chain.size
    found = velocity.singular_directions(arm.chain, Q)
    n, k = arm.dof, min(arm.dof, 6)
    assert found.twists.shape == (2, 3, 6, 6) and found.motions.shape == (2, 3, n, n)
    J = Reference(arm.model, arm.base, arm.tip).jacobian(Q)
    moved = np.einsum("...ij,...kj->...ki", J, found.motions)
    expected = found.gains[..., :k, None] * found.twists[..., :k, :]
    np.testing.assert_allclose(moved[..., :k, :], expected, atol=1e-13)
    np.testing.assert_allclose(moved[..., k:, :], 0.0, atol=1e-13)
    assert np.all(np.diff(found.gains) <= 0)
    np.testing.assert_array_equal(found.gains[..., :k], found.motion_gains[..., :k])
    assert found.idle[..., k:].all() and found.lost[..., k:].all()
    units = np.array([L, L, L, 1, 1, 1])
    twists = found.twists / units
    np.testing.assert_allclose(
        twists @ np.swapaxes(twists, -1, -2), np.broadcast_to(np.eye(6), (2, 3, 6, 6)), atol=1e-13
    )
    motions = found.motions / np.where(arm.chain.prismatic, L, 1.0)
    np.testing.assert_allclose(
        motions @ np.swapaxes(motions, -1, -2), np.broadcast_to(np.eye(n), (2, 3, n, n)), atol=1e-13
    )


def test_straight_wrist() -> None:
    """With q5 = 0, axes 4 and 6 are one: turning them against each other does nothing, and one turn is lost."""
    arm = urdf_ik.load("zyyzyz_6r")
    found = velocity.singular_directions(arm.chain, [0.3, -0.5, 0.8, 0.4, 0.0, -0.2])
    (idle,) = found.motions[found.idle]
    np.testing.assert_allclose(np.abs(idle), [0, 0, 0, math.sqrt(0.5), 0, math.sqrt(0.5)], atol=1e-12)
    assert idle[3] * idle[5] < 0
    (lost,) = found.twists[found.lost]
    # No joint velocity gives a part of it: at right angles to what any gives.
    J = scaled(arm, np.array([0.3, -0.5, 0.8, 0.4, 0.0, -0.2]), arm.chain.size)
    without_unit = lost / np.array([*[arm.chain.size] * 3, 1, 1, 1])
    np.testing.assert_allclose(without_unit @ J, 0.0, atol=1e-14)
    assert found.gains[-1] < 1e-15 < 1e-3 < found.gains[-2]
    near = velocity.singular_directions(arm.chain, [0.3, -0.5, 0.8, 0.4, 0.01, -0.2])
    assert not near.idle.any() and len(near.twists[near.lost]) == 0
    assert velocity.singular_directions(arm.chain, [0.3, -0.5, 0.8, 0.4, 0.01, -0.2], tolerance=0.1).idle.any()


def test_stretched_planar_arm() -> None:
    """A straight two-link arm cannot move along itself."""
    arm = urdf_ik.load("planar_2r_unit")
    table = velocity.singular_directions(arm.chain, [0.0, 0.0], length=1.0)
    assert table.lost.sum() == 4
    # Nothing lost has a part across the arm with the turn that goes with it; along the arm all is lost.
    along = np.array([1.0, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(np.linalg.norm(table.twists[table.lost] @ along), 1.0, atol=1e-14)
    assert not table.idle.any()


# ---------------------------------------------------------------- joint velocities


def test_undamped_velocities_are_the_pseudoinverse(arm: urdf_ik.Arm) -> None:
    """Without damping: NumPy's pseudoinverse; a twist that the arm can do is done."""
    Q = drawn(arm, 5)
    L = arm.chain.size
    twists = np.random.default_rng(3).normal(size=(5, 6))
    units = np.array([L, L, L, 1, 1, 1])
    expected = np.einsum("...ij,...j->...i", np.linalg.pinv(scaled(arm, Q, L)), twists / units)
    expected = expected * np.where(arm.chain.prismatic, L, 1.0)
    found = velocity.joint_velocities(arm.chain, Q, twists, damping=0)
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-10)
    J = Reference(arm.model, arm.base, arm.tip).jacobian(Q)
    possible = np.einsum("...ij,...j->...i", J, np.random.default_rng(4).normal(size=(5, arm.dof)))
    done = np.einsum("...ij,...j->...i", J, velocity.joint_velocities(arm.chain, Q, possible, damping=0))
    np.testing.assert_allclose(done, possible, atol=1e-10)


@pytest.mark.parametrize("weighted", [False, True])
def test_damped_velocities_minimise_what_they_should(arm: urdf_ik.Arm, weighted: bool) -> None:
    """The normal equations J^T (J qd - V) + damping^2 W qd = 0 hold, in the Jacobian without units."""
    rng = np.random.default_rng(5)
    weights = rng.uniform(0.2, 5, arm.dof)
    weights = weights / weights.mean() if weighted else np.ones(arm.dof)
    Q, V, L = drawn(arm, 4), rng.normal(size=(4, 6)), arm.chain.size
    rates = velocity.joint_velocities(arm.chain, Q, V, damping=0.3, weights=7.0 * weights if weighted else None)
    x = rates / np.where(arm.chain.prismatic, L, 1.0)
    J = scaled(arm, Q, L)
    rest = np.einsum("...ij,...j->...i", J, x) - V / np.array([L, L, L, 1, 1, 1])
    np.testing.assert_allclose(np.einsum("...ij,...i->...j", J, rest) + 0.09 * weights * x, 0.0, atol=1e-12)


def test_damping_by_the_smallest_singular_value() -> None:
    """Far from singularities there is none; at one, the velocities stay bounded where the exact ones explode."""
    arm = urdf_ik.load("zyyzyz_6r")
    twist = np.array([0.1, 0.2, -0.1, 0.3, 0.5, 0.2])
    q = np.array([0.3, -0.5, 0.8, 0.4, 0.0, -0.2])
    for bend in (0.0, 1e-12, 1e-6, 1e-3):
        q[4] = bend
        assert np.abs(velocity.joint_velocities(arm.chain, q, twist)).max() <= np.linalg.norm(twist) / DEFAULT.damping
    q[4] = 1e-6
    assert np.abs(velocity.joint_velocities(arm.chain, q, twist, damping=0)).max() > 1e4
    # Continuous across the border where the damping begins.
    bends = np.linspace(0.0, 1.0, 2001)
    Q = np.tile(q, (len(bends), 1))
    Q[:, 4] = bends
    smallest = velocity.singular_directions(arm.chain, Q).gains[:, -1]
    assert smallest[0] < DEFAULT.damped < smallest[-1]
    rates = velocity.joint_velocities(arm.chain, Q, twist)
    free = smallest >= DEFAULT.damped
    exact = velocity.joint_velocities(arm.chain, Q[free], twist, damping=0)
    np.testing.assert_allclose(rates[free], exact, rtol=1e-10, atol=1e-12)
    assert np.abs(np.diff(rates, axis=0)).max() < 0.1 * np.abs(rates).max()


def test_heavy_joints_move_less() -> None:
    """Of a redundant arm the heavy joint moves less, and the twist is still done."""
    arm = urdf_ik.load("srs_7r")
    q, twist = drawn(arm), [0.1, 0, 0.2, 0, 0.3, 0]
    light = velocity.joint_velocities(arm.chain, q, twist, damping=0)
    heavy = velocity.joint_velocities(arm.chain, q, twist, damping=0, weights=[1, 1, 1000, 1, 1, 1, 1])
    assert abs(heavy[2]) < 0.02 * abs(light[2])
    np.testing.assert_allclose(arm.jacobian(q) @ heavy, twist, atol=1e-12)


def test_speed_limits_keep_the_direction() -> None:
    """No joint is faster than its limit, one is as fast, and the tip moves the way it should; slow ones stay."""
    arm = urdf_ik.load("stanford_rrprrr")
    Q, twist = (
        np.array([[0.3, 0.9, 0.7, 0.2, 0.5, 0.1]] * 2),
        np.array([[1.0, 0, 0.5, 0, 2.0, 0], [1e-3, 0, 0, 0, 0, 0]]),
    )
    limits = np.array([1, 1, 0.2, 1.5, 1.5, 2])
    free = velocity.joint_velocities(arm.chain, Q, twist)
    held = velocity.joint_velocities(arm.chain, Q, twist, limits=limits)
    np.testing.assert_allclose((np.abs(held[0]) / limits).max(), 1.0, rtol=1e-12)
    np.testing.assert_allclose(held[0] / held[0, 1], free[0] / free[0, 1], rtol=1e-12)
    np.testing.assert_array_equal(held[1], free[1])


def test_part_of_a_twist() -> None:
    """Three joints give any velocity of the tip when its turning does not matter."""
    arm = urdf_ik.load("positioning_3r")
    Q, v = drawn(arm, 4, 1), np.random.default_rng(2).normal(size=(3, 3))
    rates = velocity.joint_velocities(arm.chain, Q, v, part="translation", damping=0)
    assert rates.shape == (4, 3, 3)
    done = np.einsum("aij,abj->abi", arm.jacobian(Q[:, 0])[:, :3], rates)
    np.testing.assert_allclose(done, np.broadcast_to(v, (4, 3, 3)), atol=1e-10)


def test_arm_without_joints() -> None:
    """Nothing moves, every twist is lost, and nothing raises."""
    arm = urdf_ik.load(serial_urdf("fixed", [((0, 0, 1), (0, 0, 0))], [None]), "base", "tool")
    assert arm.manipulability(np.zeros(0)) == 0
    assert velocity.condition_number(arm.chain, np.zeros((2, 0))).tolist() == [np.inf, np.inf]
    assert velocity.joint_velocities(arm.chain, np.zeros((2, 0)), np.ones(6)).shape == (2, 0)
    assert velocity.singular_directions(arm.chain, np.zeros(0)).lost.all()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"twist": np.ones(5)}, ["(5,)", "6"]),
        ({"twist": [0, 0, np.nan, 0, 0, 0]}, ["twist[2]", "finite"]),
        ({"twist": np.ones((3, 6)), "q": np.zeros((2, 6))}, ["(2,)", "(3,)", "broadcast"]),
        ({"part": "linear"}, ["'linear'", "translation"]),
        ({"damping": -0.1}, ["damping=-0.1", "at least 0"]),
        ({"length": 0.0}, ["length=0.0", "at least 1e-12"]),
        ({"weights": [1, 1, 0, 1, 1, 1]}, ["weights", "'joint_3'", "0.0"]),
        ({"limits": [1, np.inf, 1, 1, 1, 1]}, ["limits", "'joint_2'", "inf"]),
    ],
)
def test_refusals(options: dict[str, object], words: list[str]) -> None:
    """What makes no sense is refused with its name and value, and with what would be valid."""
    arm = urdf_ik.load("zyyzyz_6r")
    given = {"q": np.zeros(6), "twist": np.ones(6), **options}
    with pytest.raises(ArgumentError) as caught:
        velocity.joint_velocities(arm.chain, given.pop("q"), given.pop("twist"), **given)  # type: ignore[arg-type]
    assert all(word in str(caught.value) for word in words), str(caught.value)
