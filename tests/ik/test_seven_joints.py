"""Arms with seven joints: every solution at a value of the redundancy parameter, measured by Pinocchio."""

import numpy as np
import pytest
from arms import Y, Z, serial_urdf
from arms_seven import SEVEN, random_seven, skew, sliding
from cases import Array, Case, assert_exact, closest_pair, indistinct_pairs, nearest, rows
from oracle import Oracle, angle_distance
from scipy.optimize import least_squares
from searches import newton
from seven_joints import member, tolerance

import urdf_ik
from urdf_ik import UnsupportedArm
from urdf_ik.ik.families.parts.written import Numbers

# What each kind is solved as: the family, the joint that is given.
EXPECTED = {
    "S-R-S": ("7R S-R-S", "joint_4"),
    "S-R-S, offset elbow": ("7R S-R-S", "joint_4"),
    "one before wrist, 2||3": ("7R, joint 1 given: 6R spherical wrist, 2||3", "joint_1"),
    "one before wrist, 1x2": ("7R, joint 1 given: 6R spherical wrist, 1x2", "joint_1"),
    "one behind wrist, 1x2": ("7R, joint 7 given: 6R spherical wrist, 1x2, reversed", "joint_7"),
    "one before 2||3||4, 5x6": ("7R, joint 1 given: 6R 2||3||4 and 5x6", "joint_1"),
    "one behind 2||3||4, 5x6": ("7R, joint 7 given: 6R 2||3||4 and 5x6, reversed", "joint_7"),
}
SWIVELLING = ("S-R-S", "S-R-S, offset elbow")
# Oblique and at right angles, with exact and with rounded frames.
VARIANTS = ((0, False, False), (1, True, True), (2, True, False))


def draw(case: Case, seed: int, m: int) -> tuple[Array, Array, Array]:
    """Joint vectors (m, 7) over the whole torus, their poses by Pinocchio, their values of the parameter."""
    q = case.oracle.draw(np.random.default_rng(seed), m)
    return q, case.oracle.poses(q), case.arm.redundancy_of(q)


def numbers_of(case: Case) -> Numbers:
    """The numbers of the solver of an S-R-S arm."""
    arm: Numbers = case.arm.solver.require_member().solver.arm
    return arm


@pytest.mark.parametrize(("seed", "orthogonal", "aligned"), VARIANTS)
@pytest.mark.parametrize("kind", SEVEN)
def test_random_poses(kind: str, seed: int, orthogonal: bool, aligned: bool) -> None:
    """Each planted joint vector is found at its own parameter; all solutions are exact, have it, and differ."""
    case = member(kind, seed, orthogonal, aligned)
    family, joint = EXPECTED[kind]
    if not orthogonal:  # at right angles two neighbours more may meet or be parallel
        assert case.arm.structure.family == family
        assert case.arm.redundancy.joint == joint
    planted, targets, values = draw(case, seed, 40)
    batch = case.arm.ik(targets, redundancy=values)
    for i, (q, T, value) in enumerate(zip(planted, targets, values, strict=True)):
        found = assert_exact(case, batch[i], T)
        assert nearest(found, q) < tolerance(case, q)
        assert closest_pair(found) > 1e-8
        assert not indistinct_pairs(case, found, T)
        np.testing.assert_allclose(np.exp(1j * case.arm.redundancy_of(found)), np.exp(1j * value), atol=1e-9)


@pytest.mark.parametrize("kind", SEVEN)
def test_nothing_is_missing(kind: str) -> None:
    """What Newton's method finds from many starts is among the solutions at its value of the parameter."""
    case, rng = member(kind, 0), np.random.default_rng(3)
    for T in draw(case, 5, 2)[1]:
        starts = rng.uniform(-np.pi, np.pi, (60, 7))
        searched = newton(case.arm.fk, case.arm.jacobian, case.arm.chain.size, T, starts, 1e-3)
        assert len(searched) > 5
        for x in searched:
            assert nearest(rows(case.arm.ik(T, redundancy=case.arm.redundancy_of(x))), x) < 1e-5


@pytest.mark.parametrize("kind", ["S-R-S, offset elbow", "one behind wrist, 1x2", "one before 2||3||4, 5x6"])
def test_poses_and_values_broadcast(kind: str) -> None:
    """Every pose at every value, one at many, many at one, with threads: equal to single calls to the last bit."""
    arm = member(kind, 0).arm
    _, targets, _ = draw(member(kind, 0), 1, 70)
    values = np.linspace(-3.0, 3.0, 5)
    table = arm.ik(targets[:, None], redundancy=values)
    assert table.q.shape == (70, 5, len(table.branches), 7)
    np.testing.assert_array_equal(table.redundancy, np.broadcast_to(values, (70, 5)))
    np.testing.assert_array_equal(table.poses[3, 2], targets[3])
    for i, k in ((0, 0), (3, 4), (69, 2)):
        alone = arm.ik(targets[i], redundancy=values[k])
        np.testing.assert_array_equal(alone.q, table.q[i, k])
        np.testing.assert_array_equal(alone.singular, table.singular[i, k])
        assert alone.redundancy == values[k]
    np.testing.assert_array_equal(arm.ik(targets[3], redundancy=values).q, table.q[3])
    np.testing.assert_array_equal(arm.ik(targets, redundancy=values[1]).q, table.q[:, 1])
    np.testing.assert_array_equal(arm.ik(targets[:, None], redundancy=values, threads=2).q, table.q)
    np.testing.assert_array_equal(arm.ik(targets[0]).q, arm.ik(targets[0], redundancy=arm.redundancy.default).q)
    np.testing.assert_array_equal(arm.ik(targets).redundancy, np.full(70, arm.redundancy.default))
    assert arm.ik(targets[:0], redundancy=values[:0]).q.shape == (0, len(table.branches), 7)


@pytest.mark.parametrize("kind", ["S-R-S", "one behind wrist, 1x2"])
def test_turned_values_are_the_same_solutions(kind: str) -> None:
    """A value a turn further is the same posture, given in (-pi, pi]."""
    case = member(kind, 0)
    q, T, value = (each[0] for each in draw(case, 2, 1))
    further = case.arm.ik(T, redundancy=value + 2.0 * np.pi)
    found = assert_exact(case, further, T)
    assert nearest(found, q) < 1e-6
    np.testing.assert_allclose(found, rows(case.arm.ik(T, redundancy=value)), atol=1e-9)


@pytest.mark.parametrize("kind", SWIVELLING)
@pytest.mark.parametrize(("seed", "orthogonal", "aligned"), VARIANTS)
def test_the_swivel_turns_the_arms_plane(kind: str, seed: int, orthogonal: bool, aligned: bool) -> None:
    """As documented: the angle about the line SW from the normal of its plane with axis 1 to axis 4's direction."""
    case = member(kind, seed, orthogonal, aligned)
    q, _, values = draw(case, 4, 30)
    for vector, value in zip(q, values, strict=True):
        J = case.oracle.jacobian(vector)
        axis_1, axis_4 = J[3:, 0], J[3:, 3]
        S, W = crossing(case, vector, (0, 1)), crossing(case, vector, (4, 5))
        line = (W - S) / np.linalg.norm(W - S)
        normal = np.cross(axis_1, line)
        normal /= np.linalg.norm(normal)
        angle = np.arctan2(np.cross(line, normal) @ axis_4, normal @ axis_4)
        assert abs((angle - value + np.pi) % (2.0 * np.pi) - np.pi) < 1e-8


def crossing(case: Case, q: Array, joints: tuple[int, int]) -> Array:
    """The point (3,) where the axes of two joints meet, from Pinocchio's Jacobian."""
    J, tip = case.oracle.jacobian(q), case.oracle.pose(q)[:3, 3]
    directions = [J[3:, j] for j in joints]
    points = [tip + np.cross(J[3:, j], J[:3, j]) for j in joints]
    across = [np.eye(3) - np.outer(h, h) for h in directions]
    return np.linalg.solve(sum(across), sum(a @ p for a, p in zip(across, points, strict=True)))


@pytest.mark.parametrize("kind", SWIVELLING)
@pytest.mark.parametrize("seed", range(3))
def test_branch_names_mean_what_they_say(kind: str, seed: int) -> None:
    """At swivel zero an elbow that is up lies on the side of SW that axis 1 points to; flips share the elbow."""
    case = member(kind, seed, True)
    _, targets, _ = draw(case, 8, 20)
    for T in targets:
        for one in case.arm.ik(T, redundancy=0.0):
            J, tip = case.oracle.jacobian(one.q), T[:3, 3]
            S, W = crossing(case, one.q, (0, 1)), crossing(case, one.q, (4, 5))
            h = J[3:, 3]
            at_elbow = tip + np.cross(h, J[:3, 3]) - S
            at_elbow -= h * (h @ at_elbow)
            above = at_elbow @ (J[3:, 0] - (J[3:, 0] @ (W - S)) * (W - S) / ((W - S) @ (W - S)))
            assert ("elbow up" in one.branch) == (above > 0.0)


@pytest.mark.parametrize("distance", [0.0, 1e-9, 1e-7, 1e-5, 1e-3, 1e-1])
@pytest.mark.parametrize("where", ["elbow stretched", "elbow folded", "shoulder", "wrist", "on axis 1", "all"])
@pytest.mark.parametrize("seed", range(4))
def test_near_singularities(where: str, distance: float, seed: int) -> None:
    """Stretched, folded, aligned, or above the base: exact and marked, none given twice, planted found if isolated."""
    kind = SWIVELLING[seed % 2]
    case = member(kind, seed, True, seed == 3)
    numbers = numbers_of(case)
    straight = -numbers.zero_4
    for q in case.oracle.draw(np.random.default_rng(seed), 4):
        if where in ("elbow stretched", "all"):
            q[3] = straight + distance
        if where == "elbow folded":
            q[3] = straight + np.pi + distance
        if where in ("shoulder", "all"):
            q[1] = -numbers.shoulder.shift + distance
        if where in ("wrist", "all"):
            q[5] = -numbers.wrist.shift + distance
        if where == "on axis 1":
            q = above_the_base(case, q)
            if q is None:
                continue
            q[1] += distance
        T = case.oracle.pose(q)
        value = float(case.arm.redundancy_of(q))
        solutions = case.arm.ik(T, redundancy=value)
        found = assert_exact(case, solutions, T)
        assert len(found)
        assert closest_pair(found) > 1e-8
        singular = np.asarray(solutions.singular)[solutions.valid]
        if distance > 1e-4:
            assert nearest(found, q) < tolerance(case, q)
        elif where.startswith("elbow"):
            assert nearest(found, q) < 1e-5
        if distance <= 1e-7:
            bits = {"elbow stretched": 2, "elbow folded": 2, "shoulder": 1, "wrist": 4, "on axis 1": 1, "all": 7}[where]
            assert any(marks & bits for marks in singular)


def above_the_base(case: Case, q: Array) -> Array | None:
    """``q`` with joints 2 and 3 turned until the wrist lies on axis 1, where they can bring it there."""
    axis = case.oracle.jacobian(np.zeros(7))[3:, 0]

    def aside(angles: Array) -> Array:
        p = np.concatenate([[0.0], angles, q[3:]])
        return np.cross(axis, crossing(case, p, (4, 5)) - crossing(case, p, (0, 1)))

    found = least_squares(aside, q[1:3], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    return np.concatenate([q[:1], found.x, q[3:]]) if found.cost < 1e-24 else None


def test_srs_straight_shoulder_and_wrist_stay_near_the_reference() -> None:
    """Where only the sum of two joints counts, the free one is zero, or near ``q_ref``."""
    case = member("S-R-S", 1, True, True)
    numbers = numbers_of(case)
    q = np.array([0.4, -numbers.shoulder.shift, 0.7, 1.1, -0.3, -numbers.wrist.shift, 0.9])
    T, value = case.oracle.pose(q), float(case.arm.redundancy_of(q))
    at_zero = assert_exact(case, case.arm.ik(T, redundancy=value), T)
    assert np.abs(at_zero[:, 0]).min() < 1e-12
    assert np.abs(at_zero[:, 4]).min() < 1e-12
    at_q = assert_exact(case, case.arm.ik(T, q, redundancy=value), T)
    assert nearest(at_q, q) < 1e-9


@pytest.mark.parametrize("kind", ["S-R-S", "one before wrist, 2||3"])
def test_out_of_reach(kind: str) -> None:
    """Out of reach there is no solution and no exception, and the reason holds a number."""
    arm = member(kind, 0).arm
    far = urdf_ik.pose([100.0, 0.0, 0.0])
    solutions = arm.ik(far, redundancy=0.3)
    assert not solutions
    assert "0.3" in solutions.explain() or "m from" in solutions.explain()
    assert solutions.explain() == arm.explain(far, 0.3)
    batch = arm.ik(np.stack([far, far]), redundancy=[0.3, 0.4])
    assert batch.explain() == f"pose [0]: {arm.explain(far, 0.3)}\npose [1]: {arm.explain(far, 0.4)}"
    assert arm.explain(far) == arm.explain(far, arm.redundancy.default)


def test_none_inside_the_limits_is_said_of_one_value() -> None:
    """A posture of a Panda that needs another value of joint 7: the words name the joint and where to look."""
    arm, rng = urdf_ik.load("panda"), np.random.default_rng(0)
    planted = (q for q in rng.uniform(*arm.limits.T, (60, 7)))
    q = next(q for q in planted if (s := arm.ik(arm.fk(q))).count and not s.within_limits().count)
    words = arm.ik(arm.fk(q)).within_limits().explain()
    assert "at this value of 'panda_joint7', none inside the joint limits" in words and "arm.intervals(T)" in words
    assert arm.ik(arm.fk(q), redundancy=q[6]).within_limits().count


@pytest.mark.parametrize(("joint", "given"), [(1, "joint_1"), (7, "joint_7")])
def test_a_lift(joint: int, given: str) -> None:
    """A sliding first or last joint is the parameter, in metres; its range is the joint's limits."""
    kind = "one before 2||3||4, 5x6" if joint == 1 else "one behind wrist, 1x2"
    text = sliding(random_seven(kind, 0).urdf, joint, 0.0, 0.8)
    arm, oracle = urdf_ik.load(text, "base", "tool"), Oracle(text)
    assert (arm.redundancy.joint, arm.redundancy.unit, arm.redundancy.range) == (given, "m", (0.0, 0.8))
    assert arm.redundancy.default == 0.4
    assert "0.8000 m" in str(arm.redundancy)
    rng = np.random.default_rng(0)
    for q in rng.uniform(-np.pi, np.pi, (20, 7)):
        q[joint - 1] = rng.uniform(0.0, 0.8)
        T = oracle.pose(q)
        found = rows(arm.ik(T, redundancy=arm.redundancy_of(q)))
        assert max(oracle.error(x, T) for x in found) < 1e-9
        assert min(np.abs(x[joint - 1] - q[joint - 1]) + angle_distance(x, q) for x in found) < 1e-6
    reached = arm.intervals(T, within_limits=False).merged()
    assert len(reached)
    assert (reached >= 0.0).all()
    assert (reached <= 0.8).all()


def test_general_arms_hold_the_end_that_is_solved_more_surely() -> None:
    """Seven skew axes: the six others are eliminated, planted joint vectors are found, all are exact."""
    text = skew(7)
    arm, oracle = urdf_ik.load(text, "base", "tool"), Oracle(text)
    assert arm.structure.family.endswith("given: 6R general")
    case = Case("7R", arm, oracle)
    for q in oracle.draw(np.random.default_rng(1), 20):
        T = oracle.pose(q)
        found = assert_exact(case, arm.ik(T, redundancy=arm.redundancy_of(q)), T)
        assert nearest(found, q) < tolerance(case, q)


def test_more_than_nine_joints_ask_for_locked_ones() -> None:
    """Ten joints load and move; asking for solutions names them all, and shows the call that holds one."""
    text = skew(10)
    arm, oracle = urdf_ik.load(text, "base", "tool"), Oracle(text)
    assert arm.redundancy is None
    q = np.linspace(-1.0, 1.0, 10)
    np.testing.assert_allclose(arm.fk(q), oracle.pose(q), atol=1e-13)
    for ask in (arm.ik, arm.explain, arm.intervals, lambda T: arm.ik_nearest(T, q)):
        with pytest.raises(UnsupportedArm) as error:
            ask(np.eye(4))
        assert all(name in str(error.value) for name in arm.joint_names)
        assert "urdf_ik.load(..., locked={'joint_1': 0.0})" in str(error.value)
    seven = urdf_ik.load(text, "base", "tool", locked={"joint_3": 0.4, "joint_5": 0.1, "joint_6": -0.2})
    q[[2, 4, 5]] = 0.4, 0.1, -0.2
    rest = np.delete(q, [2, 4, 5])
    found = rows(seven.ik(oracle.pose(q), redundancy=seven.redundancy_of(rest)))
    assert nearest(found, rest) < 1e-6


def test_an_empty_answer_tells_where_there_are_solutions() -> None:
    """Out of reach at one value of the last joint, the reason names the values with solutions."""
    case = member("one behind wrist, 1x2", 0)
    explained = 0
    for q, T in zip(*draw(case, 12, 12)[:2], strict=True):
        intervals = case.arm.intervals(T, within_limits=False).merged()
        values = np.linspace(-3.1, 3.1, 40)
        for value in values[case.arm.ik(T, redundancy=values).count == 0][:2]:
            text = case.arm.ik(T, redundancy=value).explain()
            assert f"{value:.6g} rad" in text
            assert all(f"{low:.4f} to {high:.4f} rad" in text for low, high in intervals)
            assert ((intervals[:, 0] <= q[6] + 1e-6) & (q[6] - 1e-6 <= intervals[:, 1])).any() or (
                (intervals[:, 0] <= q[6] + 2 * np.pi) & (q[6] + 2 * np.pi <= intervals[:, 1])
            ).any()
            explained += 1
    assert explained


def test_srs_equal_links_folded_wrist_in_the_shoulder_is_marked() -> None:
    """Equal links folded fully leave no line to swivel about: an exact solution, marked, and no exception."""
    origins = [((0, 0, 0.3), (0, 0, 0)), *[((0, 0, 0), (0, 0, 0))] * 2, ((0, 0, 0.4), (0, 0, 0))]
    origins += [((0, 0, 0.4), (0, 0, 0)), *[((0, 0, 0), (0, 0, 0))] * 2, ((0, 0, 0.1), (0, 0, 0))]
    text = serial_urdf("folded", origins, [Z, Y, Z, Y, Z, Y, Z, None])
    case = Case("folded", urdf_ik.load(text, "base", "tool"), Oracle(text))
    assert case.arm.structure.family == "7R S-R-S"
    for q in case.oracle.draw(np.random.default_rng(0), 10):
        q[3] = np.pi
        T = case.oracle.pose(q)
        for value in (0.0, 1.0, float(case.arm.redundancy_of(q))):
            solutions = case.arm.ik(T, redundancy=value)
            assert len(assert_exact(case, solutions, T))
            assert all(one.singular & urdf_ik.Singular.ELBOW for one in solutions)
