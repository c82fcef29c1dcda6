"""Every family, on catalogue arms and on random members: the contract of ``ik``, branches, published numbers."""

import itertools

import contract
import numpy as np
import pytest
from arms import KINDS, random_arm, ur_like
from cases import (
    ALL,
    CATALOGUE,
    MEMBERS_OF,
    assert_exact,
    closest_pair,
    described,
    from_catalogue,
    named,
    nearest,
    rows,
    thinned,
)
from oracle import Oracle, angle_distance

import urdf_ik

# On these arms a path that avoids singularities stays in its column.
NAMED_BRANCHES = (
    "zyyzyz_6r",
    "dh_6r",
    "ur5",
    "industrial",
    "industrial-lateral",
    "ur_like-negated-middle",
    *MEMBERS_OF["wrist, 2||3"],
    *MEMBERS_OF["wrist, 2||3, 1x2"],
    *MEMBERS_OF["2||3||4, 5x6"],
)


@pytest.mark.parametrize("name", ALL)
def test_forward_kinematics_and_jacobian_agree_with_pinocchio(name: str) -> None:
    """Joint names, FK, Jacobian and every link's pose are Pinocchio's, one joint vector at a time and in a batch."""
    case = named(name)
    q = case.oracle.draw(np.random.default_rng(1), 12)
    assert case.arm.joint_names == case.oracle.names
    assert case.arm.dof == 6
    assert case.arm.limits.shape == (6, 2)
    poses = case.oracle.poses(q)
    np.testing.assert_allclose(case.arm.fk(q), poses, atol=1e-12)
    np.testing.assert_allclose([case.arm.fk(x) for x in q], poses, atol=1e-12)
    jacobians = np.array([case.oracle.jacobian(x) for x in q])
    np.testing.assert_allclose(case.arm.jacobian(q), jacobians, atol=1e-12)
    np.testing.assert_allclose([case.arm.jacobian(x) for x in q], jacobians, atol=1e-12)
    np.testing.assert_array_equal(case.arm.fk(q.reshape(2, 3, 2, 6)), case.arm.fk(q).reshape(2, 3, 2, 4, 4))
    assert case.arm.jacobian(q.reshape(3, 4, 6)).shape == (3, 4, 6, 6)
    np.testing.assert_allclose(case.arm.link_poses(q[0])[case.arm.tip], poses[0], atol=1e-12)


@pytest.mark.parametrize("name", ALL)
def test_contract(name: str) -> None:
    """Planted joint vectors are found, all solutions exact; a batch is its poses; out of reach there is nothing."""
    contract.holds(named(name), 40, 2)
    contract.batch_equals_single_but_for_one(named(name), 4)
    contract.is_empty_out_of_reach(named(name))


@pytest.mark.parametrize("name", thinned(ALL, 4))
def test_no_solution_is_missing(name: str) -> None:
    """Every solution that a multi-start Newton search on Pinocchio's model finds is there."""
    contract.is_complete(named(name), 2, 3)


@pytest.mark.parametrize("kind", KINDS)
def test_many_members_of_a_family(kind: str) -> None:
    """On many arms of a family, with all signs and proportions, planted joint vectors are found and all are exact."""
    for seed in range(10, 26):
        case = described(random_arm(kind, seed, orthogonal=bool(seed % 2), aligned=bool(seed // 2 % 2)))
        contract.holds(case, 6, seed)


@pytest.mark.parametrize("name", NAMED_BRANCHES)
def test_branch_columns_are_stable(name: str) -> None:
    """Along a path of joint vectors that crosses no singularity, the path's solution stays in one column."""
    case = named(name)
    rng = np.random.default_rng(5)
    longest = 0
    for q in case.oracle.draw(rng, 6):
        direction = rng.normal(size=6)
        direction /= np.linalg.norm(direction)
        columns: list[int] = []
        for step in range(120):
            here = q + 0.02 * step * direction
            if case.oracle.sigma_min(here) < 5e-3:
                break  # a singularity may follow: the columns are free to change behind it
            solutions = case.arm.ik(case.oracle.pose(here))
            columns.append(int(np.nanargmin(angle_distance(np.asarray(solutions.q), here))))
        assert len(set(columns)) <= 1, (q, direction, columns)
        longest = max(longest, len(columns))
    assert longest > 20


@pytest.mark.parametrize("signs", list(itertools.product((1, -1), repeat=3)))
def test_signs_of_the_parallel_axes(signs: tuple[int, int, int]) -> None:
    """Any of the three parallel axes may point the other way, the middle one alone included."""
    contract.holds(described(ur_like(signs=(1, *signs, 1, 1))), 25, 6)


@pytest.mark.parametrize("name", ["zyyzyz_6r", "ur5", "industrial"])
def test_angles_at_a_half_turn(name: str) -> None:
    """Joint vectors made of 0, +-pi/2 and +-pi give angles in (-pi, pi] and exact solutions, singular or not."""
    case = named(name)
    values = np.array([0.0, np.pi / 2, -np.pi / 2, np.pi, -np.pi])
    for q in values[np.random.default_rng(7).integers(0, 5, (60, 6))]:
        target = case.oracle.pose(q)
        assert len(assert_exact(case, case.arm.ik(target), target)) > 0, q


def test_zyyzyz_back_facing_shoulder_has_the_opposite_theta2() -> None:
    """The article's arm has eight solutions; the four with the shoulder at the back have theta2 of the opposite sign.

    The published formula gives the back-facing shoulder the theta2 of the front-facing one, which misses the pose.
    """
    case = from_catalogue("zyyzyz_6r")
    for q in np.array([[0.3, 0.5, 0.9, 0.4, 0.8, -0.2], [-2.0, -0.4, 1.3, 1.1, -0.6, 0.5]]):
        target = case.oracle.pose(q)
        solutions = list(case.arm.ik(target))
        assert len(solutions) == 8
        assert all(case.oracle.error(s.q, target) < 1e-12 for s in solutions)
        front = [s for s in solutions if "shoulder front" in s.branch]
        back = [s for s in solutions if "shoulder back" in s.branch]
        assert len(front) == len(back) == 4
        for s in back:
            # No shoulder offset: turning axis 1 by half a turn mirrors axes 2 and 3.
            mirrored = np.array([s.q[0] + np.pi, -s.q[1], -s.q[2]])
            partners = [f for f in front if angle_distance(f.q[:3], mirrored) < 1e-9]
            assert len(partners) == 2
            as_published = s.q.copy()
            as_published[1] = partners[0].q[1]
            assert case.oracle.error(as_published, target) > 1e-2


def test_zyyzyz_front_shoulder_faces_the_wrist() -> None:
    """On the article's arm, shoulder front has joint 1 turned towards the wrist's centre, as theta1 = atan2(y, x)."""
    case = from_catalogue("zyyzyz_6r")
    for q in case.oracle.draw(np.random.default_rng(11), 10):
        for one in case.arm.ik(case.oracle.pose(q)):
            # Upper arm 1 m, forearm to the wrist's centre 1.1 m, both along z at q = 0.
            ahead = np.sin(one.q[1]) + 1.1 * np.sin(one.q[1] + one.q[2])
            assert ("shoulder front" in one.branch) == (ahead > 0.0)


def test_zyyzyz_wrist_5_mrad_from_straight_keeps_eight() -> None:
    """At |sin q5| = 5e-3, which the published code treats as singular, the article's arm has eight exact solutions."""
    case = from_catalogue("zyyzyz_6r")
    q = np.array([0.3, 0.5, 0.9, 0.4, 5e-3, -0.2])
    target = case.oracle.pose(q)
    solutions = case.arm.ik(target)
    found = assert_exact(case, solutions, target)
    assert len(found) == 8
    assert nearest(found, q) < 1e-9
    assert not np.asarray(solutions.singular).any()


def test_dh_6r_example_target_has_eight() -> None:
    """The DH arm reaches its example target with exactly eight joint vectors, all within the limits."""
    case = from_catalogue("dh_6r")
    target = urdf_ik.pose([0.5, 0.11, 0.26], quat_xyzw=[0.0, 0.0, 0.8, 0.6])
    found = assert_exact(case, case.arm.ik(target), target)
    assert len(found) == len(case.arm.ik(target).within_limits()) == 8
    assert closest_pair(found) > 0.1
    assert len(case.oracle.solutions(target, np.random.default_rng(8))) == 8


@pytest.mark.parametrize("name", CATALOGUE)
def test_branch_names(name: str) -> None:
    """Arms with shoulder, elbow and wrist have eight columns, each with a name of its own that says all three."""
    branches = named(name).arm.structure.branches
    assert len(branches) == len(set(branches)) == 8
    for words in itertools.product(
        ("shoulder front", "shoulder back"), ("elbow up", "elbow down"), ("noflip", "wrist flip")
    ):
        assert sum(all(word in branch for word in words) for branch in branches) == 1, words


def test_base_and_tip_may_be_any_links() -> None:
    """Base and tip moved to other links across fixed joints: the same solutions."""
    described_arm = random_arm("wrist, 2||3", 3)
    whole, inner = described(described_arm), urdf_ik.load(described_arm.urdf, base="link_1", tip="link_9")
    oracle = Oracle(described_arm.urdf, "link_1", "link_9")
    for q in oracle.draw(np.random.default_rng(10), 10):
        found = rows(inner.ik(oracle.pose(q)))
        others = rows(whole.arm.ik(whole.oracle.pose(q)))
        assert len(found) == len(others)
        assert all(nearest(others, x) < 1e-6 for x in found)
