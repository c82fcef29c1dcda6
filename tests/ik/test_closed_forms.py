"""Families with three parallel axes at one end or a spherical middle, also reversed: names, and the contract of ik."""

from collections.abc import Sequence
from typing import Any

import contract
import numpy as np
import pytest
from arms import random_arm, serial_urdf
from arms_closed_forms import DEGENERATE, KINDS, PARALLEL_SHOULDER, SPHERICAL_MIDDLE, TWICE
from cases import Case, assert_exact, closest_pair, described, flags, indistinct_pairs, nearest, rows, thinned
from closed_forms import by_elimination, member, members, near_member
from numpy.typing import NDArray
from oracle import Oracle, angle_distance

import urdf_ik
from urdf_ik.ik.solutions import Singular


def family_of(kind: str) -> str:
    """The family's name for one of the kinds, after its cheapest relation."""
    if kind == "2x3x4, 4||5||6, reversed":
        return "6R 1||2||3 and 4x5"  # as good as the other way round, and tried first
    first, _, rest = kind.removesuffix(", reversed").partition(", ")
    relations = ("5x6", "5||6") if first == "2x3x4" else ("5x6", "5||6", "4x5", "4||5")
    wrist = next((f" and {relation}" for relation in relations if relation in rest), "")
    return f"6R {first}{wrist}{', reversed' if kind.endswith('reversed') else ''}"


@pytest.mark.parametrize("kind", KINDS)
def test_structure(kind: str) -> None:
    """The family is named after its cheapest relation, is exact, and has eight columns with names of their own."""
    for case in members(kind):
        structure = case.arm.structure
        assert structure.family == family_of(kind)
        assert len(set(structure.branches)) == structure.max_solutions == 8
        if kind.startswith("1||2||3"):
            assert sum("elbow up" in name for name in structure.branches) == 4
        assert max(structure.imperfection) < 1e-13
        assert structure.method.startswith("Closed form")


@pytest.mark.parametrize("kind", KINDS)
def test_out_of_reach(kind: str) -> None:
    """A pose 20 m off has no solution, and the reason says by how much; along parallel axes, at which of them."""
    case = member(kind)
    for q in case.oracle.draw(np.random.default_rng(9), 3):
        target = case.oracle.pose(q)
        if kind in PARALLEL_SHOULDER:
            target[:3, 3] += 20.0 * case.arm.chain.H[0]
            assert member(f"{kind}, reversed").arm.explain(target).startswith("seen from the tip, ")
        else:
            target[:3, 3] += [20.0, -15.0, 10.0]
        solutions = case.arm.ik(target)
        assert len(list(solutions)) == 0
        assert (" m from axis 1" if kind in PARALLEL_SHOULDER else " m") in solutions.explain()


@pytest.mark.parametrize("kind", DEGENERATE)
def test_arms_that_are_singular_everywhere(kind: str) -> None:
    """A fourth parallel axis, a wrist that meets or is parallel, two axes in line: samples of the continuum, marked."""
    case = described(random_arm(kind, 0, kinds=DEGENERATE))
    assert case.arm.structure.family == "6R singular everywhere"
    for q in case.oracle.draw(np.random.default_rng(11), 20):
        assert case.oracle.sigma_min(q) < 1e-12
        target = case.oracle.pose(q)
        solutions = case.arm.ik(target)
        found = assert_exact(case, solutions, target)
        assert len(found) > 1
        assert (flags(solutions) == Singular.OTHER).all()
        assert closest_pair(found) > 0.1


@pytest.mark.parametrize("kind", KINDS)
def test_random_poses(kind: str) -> None:
    """Planted joint vectors are found, all solutions are exact, none is given twice; a batch is its poses."""
    for case in members(kind):
        contract.holds(case, 40, 1)
    contract.batch_equals_single_but_for_one(member(kind), 4)


@pytest.mark.parametrize("kind", thinned(KINDS, 4))
def test_many_members(kind: str) -> None:
    """Over many arms, with all signs and proportions, the same holds."""
    for seed in range(10, 22):
        contract.holds(member(kind, seed, bool(seed % 2), bool(seed // 2 % 2)), 6, seed)


@pytest.mark.parametrize("kind", thinned(KINDS, 4))
def test_singularities(kind: str) -> None:
    """At 1e-1 to 1e-8 rad from any every planted one is found, on one there are marked solutions and the reference.

    Where a curve of solutions stays in the pose up to rounding, the pose does not tell which of them was planted.
    """
    for case in members(kind):
        contract.holds_near_singularities(case, 10, 2, decades=8)
        contract.holds_on_singularities(case, 8, 3)
        rng = np.random.default_rng(3)
        for _ in range(8):
            q, _ = case.oracle.singular(rng)
            target = case.oracle.pose(q)
            found = assert_exact(case, case.arm.ik(target, q_ref=q), target)
            if not 3e-8 < case.oracle.curvature(q) < 1e-5:
                assert nearest(found, q) <= 3.0 * case.oracle.singular_tolerance(q), (case.name, q)


@pytest.mark.parametrize("kind", thinned(KINDS, 3))
def test_quarter_turns(kind: str) -> None:
    """At quarter turns from where neighbouring axes lie in a plane several joints are free at once: exact solutions."""
    for case in members(kind)[1:]:
        arm: Any = case.arm.solver.require_member().solver.arm
        from_tip = arm.kind == "reversed"
        offset = (arm.solver if from_tip else arm).ideal.offset
        offset = offset[::-1] if from_tip else offset
        for quarters in np.random.default_rng(4).integers(-2, 3, (30, 6)):
            target = case.oracle.pose(0.5 * np.pi * quarters - offset)
            found = assert_exact(case, case.arm.ik(target), target)
            assert len(found) > 0, (case.name, quarters)
            assert indistinct_pairs(case, found, target) == 0, (case.name, quarters)


@pytest.mark.parametrize("kind", thinned(KINDS, 19))
def test_agrees_with_the_elimination(kind: str) -> None:
    """The general elimination finds the same solutions, away from singularities."""
    case, compared = member(kind), 0
    for q in case.oracle.draw(np.random.default_rng(5), 10):
        target = case.oracle.pose(q)
        found, others = rows(case.arm.ik(target)), by_elimination(case, target)
        if min(case.oracle.sigma_min(x) for x in found) < 1e-2:
            continue
        compared += 1
        assert len(found) >= len(others), (case.name, q)
        assert all(nearest(found, x) < 1e-6 for x in others), (case.name, q)
    assert compared > 0


@pytest.mark.parametrize("kind", thinned(KINDS, 4))
def test_no_solution_is_missing(kind: str) -> None:
    """A multi-start Newton search on Pinocchio's model finds no further solution."""
    contract.is_complete(member(kind), 2, 6)


@pytest.mark.parametrize("kind", [*PARALLEL_SHOULDER, *SPHERICAL_MIDDLE])
def test_edge_of_reach(kind: str) -> None:
    """Two solutions that meet on a fold both exist 1e-6 m to one side of it, and neither to the other."""
    case, rng, checked = member(kind), np.random.default_rng(7), 0
    for _ in range(30):
        q, _ = case.oracle.singular(rng)
        left, sigmas, _ = np.linalg.svd(case.oracle.jacobian(q))
        lost = left[:3, -1]
        if np.linalg.norm(lost) < 0.1 or sigmas[-2] < 0.05 or case.oracle.curvature(q) < 0.02:
            continue
        counts = []
        for side in (-1e-6, 1e-6):
            target = case.oracle.pose(q)
            target[:3, 3] += side * lost / np.linalg.norm(lost)
            found = assert_exact(case, case.arm.ik(target), target)
            counts.append(sum(nearest(x[None], q) < 0.03 for x in found))
        assert sorted(counts) == [0, 2], (case.name, q, counts)
        checked += 1
    assert checked >= 3, case.name


@pytest.mark.parametrize("kind", thinned(KINDS, 5))
@pytest.mark.parametrize("eps", [1e-12, 1e-6, 1e-3])
def test_imperfect_members(kind: str, eps: float) -> None:
    """Off by 1e-12 to 1e-3 the contract holds, with the method of the nearest family or with elimination."""
    contract.holds(near_member(kind, eps), 15, 8)


@pytest.mark.parametrize("seed", range(4))
def test_the_cheapest_family_comes_first(seed: int) -> None:
    """An arm with a spherical wrist that asks for a quartic is solved by its spherical middle, without one."""
    case = described(random_arm("2x3x4, 4x5x6", seed, orthogonal=bool(seed % 2), kinds=TWICE))
    assert case.arm.structure.family.removesuffix(", reversed") == "6R 2x3x4 and 5x6"
    contract.holds(case, 30, 10)
    contract.holds_near_singularities(case, 8, 11, decades=8)
    contract.is_complete(case, 1, 12)


def elbowed(first: Sequence[float], elbow: Sequence[float], last: Sequence[float], axes: str) -> Case:
    """Three axes that meet, on a joint ``first`` away, and two joints behind them, like a humanoid's arm."""
    origins = [((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), (first, (0.0, 0.0, 0.0)), *[((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))] * 2]
    origins += [(elbow, (0.0, 0.0, 0.0)), (last, (0.0, 0.0, 0.0)), ((0.0, 0.0, 0.14), (0.0, 0.0, 0.0))]
    directions = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    urdf = serial_urdf("elbowed", origins, [*(directions[axis] for axis in axes), None])
    return Case("elbowed", urdf_ik.load(urdf, base="base", tip="tool"), Oracle(urdf))


def nearly_round(rng: np.random.Generator, count: int) -> NDArray[np.float64]:
    """Joint vectors with some joints near a multiple of a right angle, where several singularities meet."""
    q = rng.choice([0.0, 0.5 * np.pi, -0.5 * np.pi, np.pi], (count, 6))
    elsewhere = rng.random((count, 6)) < rng.choice([0.2, 0.5, 0.8], (count, 1))
    q = np.where(elsewhere, rng.uniform(-np.pi, np.pi, (count, 6)), q)
    return q + rng.normal(size=(count, 6)) * 10.0 ** rng.uniform(-8.5, -2.0, (count, 1))


@pytest.mark.parametrize(
    ("first", "elbow", "last", "axes"),
    [
        ((-0.11, 0.0, -0.14), (0.0, -0.015, 0.15), (0.0, 0.015, 0.0), "zxyzxz"),
        ((0.14, 0.03, 0.0), (0.0, 0.0, 0.11), (0.0, 0.0, 0.26), "xyxzyx"),
    ],
)
def test_solutions_where_singularities_meet(
    first: Sequence[float], elbow: Sequence[float], last: Sequence[float], axes: str
) -> None:
    """Where two singularities meet, what one leaves open does not hide the solutions of the other: none is lost."""
    case = elbowed(first, elbow, last, axes)
    assert "2x3x4" in case.arm.structure.family
    q = nearly_round(np.random.default_rng(3), 4000)
    s = case.arm.ik(case.oracle.poses(q))
    weakest = np.array([case.oracle.sigma_min(x) for x in q])
    apart = np.where(s.valid, angle_distance(s.q, q[:, None]), np.inf).min(axis=1)
    # A pose's rounding moves its solution by the rounding over the smallest singular value.
    regular = weakest > 1e-9
    rounded = 1e-6 + 1e-11 / np.maximum(weakest, 1e-9)
    assert (apart <= rounded)[regular].all(), q[regular & (apart > rounded)]
