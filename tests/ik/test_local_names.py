"""Names of solutions where geometry gives none: the sign of Pinocchio's Jacobian lasts, the number is local."""

import arms_hollow
import numpy as np
import pytest
from paths import described, joint_path

import urdf_ik
from urdf_ik.ik.solutions import branch_names

SEEDS = range(4)


def sign_at(arm: urdf_ik.Arm, q: np.ndarray) -> str:
    """The sign of the determinant of Pinocchio's Jacobian, as a name says it."""
    return "+" if np.linalg.det(arm.cell.reference.jacobian(q)) > 0.0 else "-"


@pytest.mark.parametrize("seed", SEEDS)
def test_both_signs_have_as_many_solutions(seed: int) -> None:
    """Of every regular pose, all of whose solutions are known, half have each sign; Pinocchio's Jacobian says which."""
    arm = described("general", seed)
    s = arm.ik(arm.fk(np.random.default_rng(seed).uniform(-np.pi, np.pi, (30, 6))))
    regular = s.certain & (s.singular == 0).all(axis=-1)
    assert regular.sum() > 20
    for k in np.flatnonzero(regular):
        one = s[int(k)]
        names = [each.branch for each in one]
        assert [name.split(",")[0][-1] for name in names] == [sign_at(arm, each.q) for each in one]
        assert sum(name.startswith("determinant +, ") for name in names) * 2 == len(names)
        assert len(set(names)) == len(names)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_sign_lasts_and_the_number_does_not_say_more(seed: int) -> None:
    """Along a motion without a singularity the solution that is followed keeps its sign, whatever its number."""
    arm = described("general", seed)
    q = joint_path(arm, 400, seed, 2.0)
    determinants = np.linalg.det(arm.cell.reference.jacobian(q))
    first = np.sign(determinants[0])
    crossing = np.flatnonzero(np.sign(determinants) != first)
    q = q[: crossing[0] if len(crossing) else len(q)]
    names = arm.ik(arm.fk(q)).nearest(q).names[:, 0]
    assert {str(name).split(",")[0] for name in names} == {f"determinant {'+' if first > 0 else '-'}"}


@pytest.mark.parametrize("seed", SEEDS)
def test_a_plan_keeps_the_number_that_it_begins_with(seed: int) -> None:
    """The table of a plan without a change has one number, and at each waypoint the sign of Pinocchio's Jacobian."""
    arm = described("general", seed)
    plan = arm.follow(arm.fk(joint_path(arm, 30, seed)), collisions=False)
    assert plan.found and not plan.changes
    assert len({name.split(", ")[1] for name in plan.branches}) == 1
    assert [name.split(",")[0][-1] for name in plan.branches] == [sign_at(arm, q) for q in plan.q]
    first = arm.ik(plan.poses[0])
    assert plan.branches[0] in {one.branch for one in first}
    for other in plan.alternatives:
        assert len({name.split(", ")[1] for name in other.branches}) == 1


@pytest.mark.parametrize("kind", ["wrist, general", "2||3||4", "1||2||3", "2x3x4", "2x3x4, reversed"])
def test_roots_of_a_quartic_have_a_sign_that_lasts(kind: str) -> None:
    """Where a closed form numbers the roots of its quartic, Pinocchio's sign stands before; half have each."""
    arm = described(kind, 0)
    q = np.random.default_rng(3).uniform(-np.pi, np.pi, (20, 6))
    s = arm.ik(arm.fk(q))
    regular = np.flatnonzero((s.singular == 0).all(axis=-1))
    assert len(regular) > 10
    for k in regular:
        one = s[int(k)]
        assert [each.branch.split(",")[0] for each in one] == [f"determinant {sign_at(arm, each.q)}" for each in one]
        assert all("position " in each.branch for each in one)
        assert sum(each.branch.startswith("determinant +") for each in one) * 2 == len(one)


def test_three_joints_have_the_sign_of_their_position() -> None:
    """The determinant of the upper three rows of Pinocchio's Jacobian; on a motion without a zero it stays."""
    arm = urdf_ik.load("positioning_3r")
    q = np.random.default_rng(2).uniform(-2.5, 2.5, (50, 3))
    s = arm.ik(arm.fk(q)[:, :3, 3], task="position")
    for k in range(len(q)):
        for each in s[k]:
            det = np.linalg.det(arm.cell.reference.jacobian(each.q)[:3])
            if not each.singular:
                assert each.branch.startswith(f"determinant {'+' if det > 0.0 else '-'}, solution ")


def test_joints_that_drive_several_axes_have_a_sign() -> None:
    """A hollow wrist's numbers follow the sign of Pinocchio's Jacobian for its six joints."""
    arm = urdf_ik.load(arms_hollow.hollow("mirrored"), base="base", tip="tool")
    s = arm.ik(arm.fk(np.random.default_rng(4).uniform(-1.0, 1.0, (10, 6))))
    regular = [each for k in range(10) for each in s[k] if not each.singular]
    assert len(regular) > 20
    for each in regular:
        assert each.branch.startswith(f"determinant {sign_at(arm, each.q)}, solution ")


def test_names_of_geometry_stay() -> None:
    """Closed forms have the names that they had, and arms with fewer joints than a pose has numbers no sign."""
    for name in ("puma_560", "ur5", "scara_rrpr", "planar_2r"):
        arm = urdf_ik.load(name)
        s = arm.ik(arm.fk(np.full(arm.dof, 0.3)))
        assert tuple(s.names) == s.branches
        assert not any("determinant" in each for each in s.names)
    assert not branch_names.local(urdf_ik.load("puma_560").structure.branches)


def test_stops_have_the_names_of_the_first_waypoint() -> None:
    """Where a path is stopped, its branches are called as the solutions of the first waypoint are."""
    arm = described("general", 1)
    T = arm.fk(joint_path(arm, 2, 1))
    far = T[0].copy()
    far[:3, 3] += 100.0
    plan = arm.follow(np.stack([T[0], far]), collisions=False)
    assert not plan.found
    assert {stop.branch for stop in plan.stops} <= {one.branch for one in arm.ik(T[0])} | {"every branch"}
