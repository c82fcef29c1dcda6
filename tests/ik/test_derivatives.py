"""Derivatives of solutions against Pinocchio's Jacobians, and against solutions of targets and URDFs nearby."""

from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from arms import KINDS
from arms_few import BUILDS, few
from arms_seven import SEVEN
from cases import Array, Case, from_catalogue, member
from seven_joints import member as seven

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.ik.solutions import IKSolutions

STEP = 1e-5
TWISTS = np.vstack([np.eye(6), np.random.default_rng(9).normal(size=(3, 6))])


def drawn(case: Case, seed: int, m: int = 12) -> tuple[Array, Array]:
    """Joint vectors (m, n) of Pinocchio's and their poses, none of them near a singularity."""
    q = case.oracle.draw(np.random.default_rng(seed), 8 * m)
    q = q[[case.oracle.sigma_min(x) > 0.05 for x in q]][:m]
    return q, case.oracle.poses(q)


def moved(T: Array, twist: Array, step: float) -> Array:
    """Targets moved by a twist in base axes at their origins, as Pinocchio's exponential turns them."""
    out = T.copy()
    out[..., :3, 3] += step * twist[:3]
    out[..., :3, :3] = pin.exp3(step * twist[3:]) @ out[..., :3, :3]
    return out


def beside(s: IKSolutions, q: Array) -> Array:
    """The solution nearest to each column of q (m, B, n), NaN where that is NaN."""
    gaps = np.abs((s.q[:, None] - q[:, :, None] + np.pi) % (2.0 * np.pi) - np.pi)
    best = np.where(np.isnan(gaps), np.inf, gaps).max(axis=-1).argmin(axis=-1)
    found = np.take_along_axis(s.q, best[..., None], axis=1)
    return q + (found - q + np.pi) % (2.0 * np.pi) - np.pi


def regular(case: Case, s: IKSolutions) -> list[tuple[int, int]]:
    """Places of solutions whose Jacobian by Pinocchio is far from singular."""
    return [(i, b) for i, b in np.argwhere(s.valid) if case.oracle.sigma_min(s.q[i, b]) > 0.02]


def rounding(X: Array, J: Array) -> float:
    """What rounding may leave of X J - 1."""
    return 1e-13 * float(np.linalg.norm(X) * np.linalg.norm(J))


@pytest.mark.parametrize("kind", KINDS)
def test_every_branch_has_the_inverse_of_pinocchios_jacobian(kind: str) -> None:
    """With six joints dq_dT times the Jacobian is the identity, for every solution."""
    case = member(kind, 0)
    _, T = drawn(case, 1)
    s = case.arm.ik(T)
    X, places = s.dq_dT(), regular(case, s)
    assert len(places) > len(T)
    for place in places:
        J = case.oracle.jacobian(s.q[place])
        np.testing.assert_allclose(X[place] @ J, np.eye(6), atol=rounding(X[place], J))


@pytest.mark.parametrize("kind", SEVEN)
def test_seven_joints_hold_their_parameter(kind: str) -> None:
    """The tip follows the twist while the parameter stays; by the parameter alone the tip stays."""
    case = seven(kind, 0)
    q, T = drawn(case, 2)
    values = case.arm.redundancy_of(q)
    s = case.arm.ik(T, redundancy=values)
    X, slope = s.dq_dT(), s.dq_dredundancy()
    for i, b in regular(case, s):
        if np.linalg.norm(X[i, b]) > 30.0:
            continue
        J = case.oracle.jacobian(s.q[i, b])
        np.testing.assert_allclose(J @ X[i, b], np.eye(6), atol=rounding(X[i, b], J))
        np.testing.assert_allclose(J @ slope[i, b], np.zeros((6, 1)), atol=1e-9)
        for step, by in ((X[i, b] @ TWISTS[-1], 0.0), (slope[i, b, :, 0], 1.0)):
            ends = [case.arm.redundancy_of(s.q[i, b] + sign * STEP * step) for sign in (-1.0, 1.0)]
            change = (ends[1] - ends[0] + np.pi) % (2.0 * np.pi) - np.pi
            assert change / (2.0 * STEP) == pytest.approx(by, abs=1e-5)


@pytest.mark.parametrize("name", ["puma_560", "ur5", "srs_7r"])
@pytest.mark.parametrize("free", [False, True])
def test_solutions_of_targets_nearby_lie_where_the_derivative_says(name: str, free: bool) -> None:
    """Central differences of ik itself, by the pose and by the parameters, in both axes; with a free axis too."""
    case = from_catalogue(name)
    arm = case.arm.with_free_axis("z", at=[0.03, 0.0, 0.1]) if free else case.arm
    _, T = drawn(case, 3, 4)
    at: dict[str, Any] = {}
    if count := len(arm.solver.parameters):
        at["redundancy"] = np.full((len(T), count), 0.3)[..., 0 if count == 1 else slice(None)]
    s = arm.ik(T, **at)
    X, tip = s.dq_dT(), s.dq_dT(axes="tip")
    steady = np.linalg.norm(X, axis=(-2, -1)) < 60.0
    assert steady.sum() > 4
    for twist in TWISTS:
        ends = [beside(arm.ik(moved(T, twist, sign * STEP), **at), s.q) for sign in (-1.0, 1.0)]
        change = (ends[1] - ends[0]) / (2.0 * STEP)
        np.testing.assert_allclose(change[steady], (X @ twist)[steady], rtol=1e-5, atol=1e-4)
        R = np.swapaxes(T[:, :3, :3], 1, 2)
        body = np.concatenate([R @ twist[:3], R @ twist[3:]], axis=-1)
        np.testing.assert_allclose((tip @ body[:, None, :, None])[steady], (X @ twist[:, None])[steady], atol=1e-9)
    for k in range(count):
        shift = np.eye(count)[k] if count > 1 else 1.0
        ends = [beside(arm.ik(T, redundancy=at["redundancy"] + sign * STEP * shift), s.q) for sign in (-1.0, 1.0)]
        change = (ends[1] - ends[0]) / (2.0 * STEP)
        np.testing.assert_allclose(change[steady], s.dq_dredundancy()[..., k][steady], rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("name", [name for name, build in BUILDS.items() if build.task != "pose"])
def test_tasks_follow_the_part_that_they_fix(name: str) -> None:
    """The joints move so that the part of the twist that the task fixes is the one that was asked for."""
    case = few(name, 0)
    q = np.random.default_rng(4).uniform(-0.8, 0.8, (6, case.arm.dof))
    control = case.arm.solver.control
    target = control.target_of(case.arm.fk(q))
    s = case.arm.ik(target, task=case.arm.task)
    X, checked = s.dq_dT(), 0
    for i, b in np.argwhere(s.valid):
        J, own = case.oracle.jacobian(s.q[i, b]), s.q[i, b]
        if not np.linalg.norm(X[i, b]) < 40.0:
            continue
        checked += 1
        if control.aimed is not None:
            along = case.oracle.pose(own)[:3, :3] @ control.aimed
            keep = np.eye(3) - np.outer(along, along)
            parts = (np.hstack([np.eye(3), np.zeros((3, 3))]), np.hstack([np.zeros((3, 3)), keep]))
        elif control.plane is not None:
            parts = (np.hstack([control.plane.axes, np.zeros((2, 3))]),)
            if case.arm.task == "planar pose":
                parts += (np.hstack([np.zeros(3), control.plane.normal])[None],)
        else:
            parts = (np.hstack([np.eye(3), np.zeros((3, 3))]),)
        for part in parts:
            np.testing.assert_allclose(part @ J @ X[i, b], part, atol=1e-8)
    assert checked


def test_fewer_joints_follow_every_twist_that_they_can() -> None:
    """A SCARA's joint velocities come back from the twists that they give."""
    case = from_catalogue("scara_rrpr")
    q = np.random.default_rng(5).uniform(-1.0, 1.0, (5, 4))
    s = case.arm.ik(case.arm.fk(q))
    reference = Reference(case.arm.model, case.arm.base, case.arm.tip)
    J = reference.jacobian(np.where(s.valid[..., None], s.q, 0.0))
    product = s.dq_dT() @ J
    np.testing.assert_allclose(product[s.valid], np.broadcast_to(np.eye(4), product[s.valid].shape), atol=1e-10)


def test_missing_and_singular_solutions_have_no_derivative() -> None:
    """They are NaN, and all others finite: a wrist that is stretched, a pose out of reach."""
    case = from_catalogue("puma_560")
    stretched = case.oracle.pose(np.array([0.3, -0.5, 0.8, 0.4, 0.0, -0.2]))
    away = stretched.copy()
    away[0, 3] += 5.0
    for T in (stretched, away):
        s = case.arm.ik(T)
        lost = ~s.valid | (s.singular != 0)
        assert lost.any()
        np.testing.assert_array_equal(np.isnan(s.dq_dT()).all(axis=(-2, -1)), lost)
        np.testing.assert_array_equal(np.isnan(s.dq_dT()).any(axis=(-2, -1)), lost)


@pytest.mark.parametrize("name", ["puma_560", "panda"])
def test_solutions_of_changed_urdfs_lie_where_the_derivative_says(name: str) -> None:
    """A URDF whose numbers differ a little has its solutions where dq_dgeometry says, for every branch."""
    case = from_catalogue(name)
    _, T = drawn(case, 7, 3)
    at = {"redundancy": 0.4} if case.arm.solver.parameters else {}
    s = case.arm.ik(T, **at)
    fields = [(field, part) for field in ("xyz", "rpy", "axis") for part in range(3)]
    parameters = [
        (joint.name, *fields[k % 9])
        for k, joint in enumerate(2 * [joint for joint in case.arm.chain.tree if joint.name in case.arm.joint_names])
    ]
    change = s.dq_dgeometry(parameters)
    step = 1e-6
    for k, (joint, field, part) in enumerate(parameters):
        ends = []
        for sign in (-1.0, 1.0):
            other = urdf_ik.load(_changed(case.arm, joint, field, part, sign * step), case.arm.base, case.arm.tip)
            ends.append(beside(other.ik(T, **at), s.q))
        found = (ends[1] - ends[0]) / (2.0 * step)
        steady = np.linalg.norm(s.dq_dT(), axis=(-2, -1)) < 30.0
        assert steady.sum() > 4
        np.testing.assert_allclose(found[steady], change[..., k][steady], rtol=1e-4, atol=2e-4)


def _changed(arm: urdf_ik.Arm, joint: str, field: str, part: int, by: float) -> str:
    """The arm's URDF with one number of a joint changed."""
    from lxml import etree

    root = etree.fromstring(arm.model.xml)
    tag, attribute = ("axis", "xyz") if field == "axis" else ("origin", field)
    element = next(each for each in root.iter("joint") if each.get("name") == joint).find(tag)
    numbers = [float(each) for each in element.get(attribute, "0 0 0").split()]
    numbers[part] += by
    element.set(attribute, " ".join(map(repr, numbers)))
    return str(etree.tostring(root).decode())


def test_a_swivel_angle_is_no_parameter_to_change_the_urdf_at() -> None:
    """The angle is measured by axes that the URDF moves: the refusal names what holds a joint instead."""
    arm = urdf_ik.load("srs_7r")
    s = arm.ik(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]))
    with pytest.raises(urdf_ik.UnsupportedArm, match=r"with_redundancy\('joint_1'\)"):
        s.dq_dgeometry()
    held = arm.with_redundancy("joint_1")
    assert held.ik(held.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])).dq_dgeometry().shape[-2] == 7


def test_filtered_solutions_keep_their_derivatives() -> None:
    """Filters and single poses change nothing in a solution's derivative."""
    arm = urdf_ik.load("puma_560")
    q = np.array([[0.3, -0.5, 0.8, 0.4, 0.7, -0.2], [0.1, -0.4, 0.6, -0.4, 0.5, 0.2]])
    s = arm.ik(arm.fk(q))
    np.testing.assert_array_equal(s[1].dq_dT(), s.dq_dT()[1])
    nearest = s.nearest(q).dq_dT()
    for i in range(2):
        J = from_catalogue("puma_560").oracle.jacobian(q[i])
        np.testing.assert_allclose(nearest[i, 0] @ J, np.eye(6), atol=1e-9)
