"""At and near singularities and the edge of reach: isolated solutions are complete, continua are marked."""

import contract
import numpy as np
import pytest
from arms import KINDS
from cases import (
    ALL,
    MEMBERS_OF,
    RESIDUAL,
    Case,
    assert_exact,
    flags,
    from_catalogue,
    indistinct_pairs,
    named,
    nearest,
    rows,
    thinned,
    worst_error,
)
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from oracle import angle_distance

from urdf_ik.ik.solutions import Singular

Array = NDArray[np.float64]
DISTANCES = [10.0**-k for k in range(1, 9)]  # rad

# One kind of singularity each: the joint that is moved onto it, all others drawn. A spherical wrist's depends on
# joint 5 alone and, with 2 || 3, an elbow's on joint 3 alone; joint 2 leaves both as they are, so what it crosses is
# the shoulder's. On the arms with 2 || 3 || 4 the elbow depends on joint 3 alone, and joint 2 again leaves it.
KINDS_OF_SINGULARITY = {
    "wrist": (4, Singular.WRIST),
    "shoulder": (1, Singular.SHOULDER),
    "elbow": (2, Singular.ELBOW),
}
TYPED = ("zyyzyz_6r", "dh_6r", "ur5", "industrial", "industrial-lateral", "ur_like", "ur_like-negated-middle")


def on_singularity(case: Case, kind: str, rng: np.random.Generator) -> Array:
    """A joint vector on a singularity of one kind and, drawn at random, on no other."""
    joint, _ = KINDS_OF_SINGULARITY[kind]
    while True:
        q, _ = case.oracle.singular(rng, joint)
        others = np.linalg.svd(case.oracle.jacobian(q), compute_uv=False)[-2]
        if others < 1e-2:
            continue
        if kind != "elbow":
            return q
        # Joint 3 moves the shoulder's singularity as well; the elbow's stays when joint 2 moves.
        moved = q + [0.0, 0.7, 0.0, 0.0, 0.0, 0.0]
        if case.oracle.sigma_min(moved) < 1e-12:
            return q


def fold_direction(case: Case, q: Array) -> Array | None:
    """The direction (3,) in which the tip cannot move at a singular q, or None where that is mostly a rotation."""
    lost = np.linalg.svd(case.oracle.jacobian(q))[0][:3, -1]
    size = float(np.linalg.norm(lost))
    return lost / size if size > 0.1 else None


def shifted(target: Array, by: Array) -> Array:
    """The pose moved by a vector (3,) [m]."""
    out = target.copy()
    out[:3, 3] += by
    return out


@pytest.mark.parametrize("kind", KINDS_OF_SINGULARITY)
@pytest.mark.parametrize("name", TYPED)
def test_planted_near_each_singularity(name: str, kind: str) -> None:
    """At 1e-1 to 1e-8 rad from a wrist, shoulder or elbow singularity the planted solution is found, all are exact."""
    case, rng = named(name), np.random.default_rng(1)
    for _ in range(4):
        q0 = on_singularity(case, kind, rng)
        for distance in DISTANCES:
            q = q0.copy()
            q[KINDS_OF_SINGULARITY[kind][0]] += distance * rng.choice([-1.0, 1.0])
            contract.finds(case, q, apart=1e-8)


@pytest.mark.parametrize("kind", KINDS_OF_SINGULARITY)
@pytest.mark.parametrize("name", TYPED)
def test_exact_singularities_are_flagged(name: str, kind: str) -> None:
    """On a singularity there are solutions, all exact, and those whose Jacobian is singular carry that kind's flag.

    No solution is flagged whose Jacobian has full rank.
    """
    case, rng = named(name), np.random.default_rng(2)
    flag = KINDS_OF_SINGULARITY[kind][1]
    for _ in range(6):
        q = on_singularity(case, kind, rng)
        target = case.oracle.pose(q)
        solutions = case.arm.ik(target)
        found = assert_exact(case, solutions, target)
        marks = flags(solutions)
        assert (marks & flag).any(), (kind, q, found, marks)
        sigmas = np.array([case.oracle.sigma_min(x) for x in found])
        assert (sigmas[marks != 0] < 1e-5).all(), (q, sigmas, marks)
        assert (marks[sigmas < 1e-10] != 0).all(), (q, sigmas, marks)
        assert indistinct_pairs(case, found, target) == 0, (q, found)
        assert [int(one.singular) for one in solutions] == marks.tolist()


@pytest.mark.parametrize("name", thinned(ALL, 3))
def test_any_singularity(name: str) -> None:
    """Where the determinant of Pinocchio's Jacobian changes sign, and 1e-1 to 1e-8 rad beside it."""
    contract.holds_on_singularities(named(name), 8, 3)
    contract.holds_near_singularities(named(name), 8, 3, decades=8)


@pytest.mark.parametrize("name", ALL)
def test_reference_member_of_a_continuum(name: str) -> None:
    """With the planted joint vector as reference, exactly singular poses give that very joint vector back."""
    case, rng = named(name), np.random.default_rng(4)
    for _ in range(6):
        q, _ = case.oracle.singular(rng)
        target = case.oracle.pose(q)
        solutions = case.arm.ik(target, q_ref=q)
        found = assert_exact(case, solutions, target)
        assert nearest(found, q) <= case.oracle.singular_tolerance(q), (q, found)


@pytest.mark.parametrize("name", ["zyyzyz_6r", "dh_6r", "industrial"])
def test_wrist_representative(name: str) -> None:
    """With axes 4 and 6 in one line, the representative has q4 = 0; with a reference it is the nearest member."""
    case, rng = named(name), np.random.default_rng(5)
    for _ in range(5):
        q = on_singularity(case, "wrist", rng)
        target = case.oracle.pose(q)
        solutions = case.arm.ik(target)
        wrist = (flags(solutions) & Singular.WRIST) != 0
        assert wrist.any()
        np.testing.assert_allclose(rows(solutions)[wrist, 3], 0.0, atol=1e-9)
        reference = q + rng.uniform(-0.4, 0.4, 6) * [0, 0, 0, 1, 0, 1]
        near = case.arm.ik(target, q_ref=reference)
        found = assert_exact(case, near, target)
        # The members: axes 4 and 6 turn by the same amount, against each other or together.
        turns = np.linspace(-np.pi, np.pi, 2001)
        members = q + turns[:, None] * [0, 0, 0, 1, 0, -1]
        if case.oracle.error(members[500], target) > RESIDUAL:
            members = q + turns[:, None] * [0, 0, 0, 1, 0, 1]
        assert worst_error(case, members[::400], target) < 1e-9

        def gap(x: Array, reference: Array = reference) -> Array:
            return np.linalg.norm((x - reference + np.pi) % (2.0 * np.pi) - np.pi, axis=-1)

        assert gap(found).min() <= gap(members).min() + 1e-6


@pytest.mark.parametrize("name", ["zyyzyz_6r", "dh_6r", "industrial"])
def test_shoulder_representative(name: str) -> None:
    """With the wrist's centre on axis 1 the representative has q1 = 0, and reaches the pose."""
    case, rng = named(name), np.random.default_rng(6)
    for _ in range(5):
        q = on_singularity(case, "shoulder", rng)
        target = case.oracle.pose(q)
        solutions = case.arm.ik(target)
        found = assert_exact(case, solutions, target)
        shoulder = (flags(solutions) & Singular.SHOULDER) != 0
        assert shoulder.any()
        np.testing.assert_allclose(found[shoulder, 0], 0.0, atol=1e-9)


@pytest.mark.parametrize("turn", [0.0, 0.4, -2.5])
def test_zyyzyz_straight_up_is_marked_singular_three_ways(turn: float) -> None:
    """Straight up the article's arm has an exact solution marked as singular in wrist, shoulder and elbow at once.

    With the planted joint vector as the reference, that vector is returned.
    """
    case = from_catalogue("zyyzyz_6r")
    q = np.array([turn, 0.0, 0.0, 0.0, 0.0, 0.0])
    target = case.oracle.pose(q)
    solutions = case.arm.ik(target)
    found = assert_exact(case, solutions, target)
    assert len(found) > 0
    everything = Singular.WRIST | Singular.SHOULDER | Singular.ELBOW
    assert (flags(solutions) & everything == everything).any()
    assert indistinct_pairs(case, found, target) == 0
    assert nearest(rows(case.arm.ik(target, q_ref=q)), q) <= 1e-6


@pytest.mark.parametrize(
    ("name", "other"),
    [(name, "elbow") for name in TYPED] + [(name, "shoulder") for name in TYPED if not name.startswith("ur")],
)
def test_doubly_singular(name: str, other: str) -> None:
    """On the wrist's singularity and another one at once, the planted joint vector is returned and carries both flags.

    It is given as the reference: of a continuum, other members need not be doubly singular.
    """
    case, rng = named(name), np.random.default_rng(7)
    both = Singular.WRIST | KINDS_OF_SINGULARITY[other][1]
    for _ in range(4):
        q = on_singularity(case, other, rng)
        q[4] = on_singularity(case, "wrist", rng)[4]  # which leaves the other singularity where it is
        target = case.oracle.pose(q)
        assert len(assert_exact(case, case.arm.ik(target), target)) > 0
        solutions = case.arm.ik(target, q_ref=q)
        found = assert_exact(case, solutions, target)
        assert nearest(found, q) <= 1e-6, (q, found)
        at = int(angle_distance(found, q).argmin())
        assert flags(solutions)[at] & both == both, (q, found, flags(solutions))


@pytest.mark.parametrize(
    "name", ["ur3", "ur5", "ur10", "ur_like", "ur_like-negated-middle", *MEMBERS_OF["2||3||4, 5x6"]]
)
def test_ur_wrists_at_and_near_q5_zero_have_solutions(name: str) -> None:
    """With 2 || 3 || 4, poses of q5 on the wrist's singularity, exactly and within 1e-8, have exact solutions.

    On Universal Robots' arms that is q5 = 0, where EAIK has no valid solution for 4 percent of poses.
    """
    case, rng = named(name), np.random.default_rng(8)
    for _ in range(15):
        q, _ = case.oracle.singular(rng, 4)
        for offset in (0.0, 1e-8, -1e-7):
            near = q + offset * np.eye(6)[4]
            target = case.oracle.pose(near)
            found = assert_exact(case, case.arm.ik(target), target)
            assert len(found) > 0, near
            assert offset == 0.0 or nearest(found, near) <= case.oracle.tolerance(near), near


# Not dh_6r folded: its links are of one length, so that its fold puts the wrist on axis 2, where joint 2 is free.
EDGES = [(name, 0) for name in ("zyyzyz_6r", "dh_6r", "ur5", "industrial", "industrial-lateral")]
EDGES += [(name, 1) for name in ("zyyzyz_6r", "ur5", "industrial", "industrial-lateral")]


@pytest.mark.parametrize(("name", "folded"), EDGES, ids=[f"{name}-{('straight', 'folded')[k]}" for name, k in EDGES])
def test_edge_of_reach(name: str, folded: int) -> None:
    """At the edge of reach elbow up and down merge into one solution; 1e-6 m inside there are two, outside none."""
    case, rng = named(name), np.random.default_rng(9)
    # Half a turn apart. Rounding says whether a draw meets one at pi, and on which side of zero one at zero lies.
    elbow = float(on_singularity(case, "elbow", rng)[2])
    elbows = sorted((elbow, elbow + np.pi), key=lambda angle: round(angle % (2 * np.pi), 9) % round(2 * np.pi, 9))
    checked = 0
    for q in case.oracle.draw(rng, 40):
        q[2] = elbows[folded]
        direction = fold_direction(case, q)
        if direction is None or np.linalg.svd(case.oracle.jacobian(q), compute_uv=False)[-2] < 1e-2:
            continue
        target = case.oracle.pose(q)
        solutions = case.arm.ik(target)
        found = assert_exact(case, solutions, target)
        merged = int(np.count_nonzero(flags(solutions) & Singular.ELBOW))
        assert merged >= 1
        assert indistinct_pairs(case, found, target) == 0
        assert nearest(found, q) <= case.oracle.singular_tolerance(q)
        counts = []
        for sign in (-1.0, 1.0):
            moved = shifted(target, sign * 1e-6 * direction)
            counts.append(len(assert_exact(case, case.arm.ik(moved), moved)))
        assert sorted(counts) == [len(found) - merged, len(found) + merged], (q, len(found), merged, counts)
        checked += 1
        if checked == 4:
            return
    assert checked


@pytest.mark.parametrize("kind", KINDS)
def test_folds_of_every_family(kind: str) -> None:
    """Two solutions that merge are returned as one; 1e-6 m to one side there are both, to the other side neither."""
    checked = 0
    for name in MEMBERS_OF[kind]:
        case, rng = named(name), np.random.default_rng(10)
        for _ in range(6):
            q, _ = case.oracle.singular(rng)
            direction = fold_direction(case, q)
            if direction is None or np.linalg.svd(case.oracle.jacobian(q), compute_uv=False)[-2] < 1e-2:
                continue
            target = case.oracle.pose(q)
            sides = [shifted(target, sign * 1e-6 * direction) for sign in (-1.0, 1.0)]
            answers = [assert_exact(case, case.arm.ik(side), side) for side in sides]
            # A fold, seen by Newton from the fold: one side has the pair, the other has nothing near.
            near = [int((angle_distance(found, q) < 0.03).sum()) for found in answers]
            if sorted(near) != [0, 2]:
                # No fold within a step of 1e-6: a continuum, or a curvature that wants a smaller step.
                assert case.oracle.curvature(q) < 0.1, (name, q, near)
                continue
            solutions = case.arm.ik(target)
            found = assert_exact(case, solutions, target)
            assert indistinct_pairs(case, found, target) == 0, (name, q, found)
            assert nearest(found, q) <= case.oracle.singular_tolerance(q), (name, q, found)
            assert flags(solutions)[angle_distance(found, q).argmin()], (name, q, found)
            checked += 1
    assert checked >= 3


angles = st.floats(-np.pi, np.pi, allow_nan=False)
special = st.sampled_from([0.0, np.pi / 2, -np.pi / 2, np.pi])
tiny = st.builds(lambda k, sign: sign * 10.0**-k, st.floats(1.0, 12.0), st.sampled_from([-1.0, 0.0, 1.0]))
near_special = st.builds(lambda value, offset: value + offset, special, tiny)
joint_vectors = st.lists(angles | near_special, min_size=6, max_size=6).map(np.array)
all_near_special = st.lists(near_special, min_size=6, max_size=6).map(np.array)


def assert_planted(case: Case, q: Array) -> None:
    """The contract at any joint vector: exact, not empty, and the planted one unless it is one of a continuum."""
    target = case.oracle.pose(q)
    found = assert_exact(case, case.arm.ik(target), target)
    assert len(found) > 0
    # Within 1e-9 of rank deficiency the pose no longer tells which member of the continuum was planted.
    assert nearest(found, q) <= case.oracle.tolerance(q) or case.oracle.sigma_min(q) < 1e-9


@pytest.mark.parametrize(
    "name", thinned(["zyyzyz_6r", "dh_6r", "ur5", "industrial-lateral", "ur_like-negated-middle"], 3)
)
@given(q=joint_vectors)
def test_drawn_joint_vectors(name: str, q: Array) -> None:
    """Some joints at, or 1e-1 to 1e-12 rad from, quarter turns: solutions are exact, and the planted one is found."""
    assert_planted(named(name), q)


@pytest.mark.parametrize("name", ["zyyzyz_6r", "dh_6r", "ur5", "industrial"])
@given(q=all_near_special)
def test_drawn_joint_vectors_near_several_singularities(name: str, q: Array) -> None:
    """All joints at, or 1e-1 to 1e-12 rad from, quarter turns, so that singularities coincide: no solution is lost."""
    assert_planted(named(name), q)


@given(index=st.integers(0, 3), q=st.lists(angles, min_size=6, max_size=6).map(np.array), inside=st.floats(-12.0, -1.0))
def test_drawn_near_the_edge_of_reach(index: int, q: Array, inside: float) -> None:
    """With the elbow 1e-12 to 1e-1 rad from straight, the edge of reach, the planted solution is found."""
    case = named(("zyyzyz_6r", "ur5", "ur_like", "ur_like-negated-middle")[index])
    q[2] = 10.0**inside
    assert_planted(case, q)
