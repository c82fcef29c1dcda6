"""The contract of ``ik`` for any arm: complete, exact, nothing twice, empty out of reach, a batch as its poses.

A *planted* joint vector is the one that a test draws and whose pose, by Pinocchio, it asks for.
"""

import numpy as np
from cases import Case, assert_exact, closest_pair, flags, indistinct_pairs, nearest, rows
from numpy.typing import NDArray

Array = NDArray[np.float64]


def finds(case: Case, q: Array, apart: float = 1e-7) -> Array:
    """A planted joint vector is among its pose's solutions (k, n); all are exact, and no two closer than ``apart``."""
    target = case.oracle.pose(q)
    found = assert_exact(case, case.arm.ik(target), target)
    assert nearest(found, q) <= case.oracle.tolerance(q), (case.name, q.tolist())
    assert closest_pair(found) > apart, (case.name, q.tolist())
    return found


def holds(case: Case, poses: int, seed: int) -> None:
    """On random poses the planted joint vector is found, and the number of solutions is even.

    Solutions appear and vanish in pairs, so their number is even where none of them is singular.
    """
    for q in case.oracle.draw(np.random.default_rng(seed), poses):
        found = finds(case, q)
        assert len(found) % 2 == 0 or min(case.oracle.sigma_min(x) for x in found) < 1e-6, (case.name, q.tolist())


def holds_near_singularities(case: Case, singularities: int, seed: int, decades: int = 7) -> None:
    """At 1e-1 to 1e-decades rad from a singularity the planted joint vector is found."""
    rng = np.random.default_rng(seed)
    for _ in range(singularities):
        q0, joint = case.oracle.singular(rng)
        for k in range(1, decades + 1):
            q = q0.copy()
            q[joint] += 10.0**-k * rng.choice([-1.0, 1.0])
            finds(case, q, apart=1e-8)


def holds_on_singularities(case: Case, singularities: int, seed: int) -> None:
    """Exactly on a singularity there are solutions, all exact and none given twice; those marked are singular."""
    rng = np.random.default_rng(seed)
    for _ in range(singularities):
        q, _ = case.oracle.singular(rng)
        target = case.oracle.pose(q)
        solutions = case.arm.ik(target)
        found, marked = assert_exact(case, solutions, target), flags(solutions) != 0
        assert marked.any(), (case.name, q.tolist())
        assert all(case.oracle.sigma_min(x) < 1e-5 for x in found[marked]), (case.name, q.tolist())
        assert indistinct_pairs(case, found, target) == 0, (case.name, q.tolist())


def is_complete(case: Case, poses: int, seed: int, starts: int = 120) -> None:
    """Every solution that a multi-start Newton search on Pinocchio's model finds is there."""
    rng = np.random.default_rng(seed)
    for q in case.oracle.draw(rng, poses):
        target = case.oracle.pose(q)
        found, searched = rows(case.arm.ik(target)), case.oracle.solutions(target, rng, starts)
        assert len(found) >= len(searched) > 0, (case.name, q.tolist())
        assert all(nearest(found, x) <= 1e-5 for x in searched), (case.name, q.tolist())


def is_empty_out_of_reach(case: Case) -> None:
    """A pose 1 % beyond all links, or far away, has no solution: every column is NaN, and nothing is raised."""
    target = case.oracle.pose(np.zeros(case.oracle.dof))
    for factor in (1.01, 3.0, 1e3):
        target[:3, 3] = case.arm.chain.points[0] + np.array([0.0, factor * case.arm.chain.size, 0.0])
        solutions = case.arm.ik(target)
        assert len(assert_exact(case, solutions, target)) == 0, (case.name, factor)
        assert list(solutions) == [], (case.name, factor)


def batch_equals_single(case: Case, targets: Array) -> None:
    """A stack of poses (m, 4, 4) gives what each pose gives, column by column, with any number of threads."""
    batch, singles = case.arm.ik(targets), [case.arm.ik(target) for target in targets]
    np.testing.assert_array_equal(batch.q, [s.q for s in singles])
    np.testing.assert_array_equal(batch.valid, [s.valid for s in singles])
    np.testing.assert_array_equal(batch.singular, [s.singular for s in singles])
    threads = case.arm.ik(targets, threads=2)
    np.testing.assert_array_equal(threads.q, batch.q)
    np.testing.assert_array_equal(threads.valid, batch.valid)


def batch_equals_single_but_for_one(case: Case, seed: int) -> None:
    """80 random poses, one of them far out of reach, give what each gives alone, in a batch of any shape."""
    targets = case.oracle.poses(case.oracle.draw(np.random.default_rng(seed), 80))
    targets[7, :3, 3] += 100.0
    batch_equals_single(case, targets)
    batch, shaped = case.arm.ik(targets), case.arm.ik(targets.reshape(5, 8, 2, 4, 4))
    assert not batch.valid[7].any()
    np.testing.assert_array_equal(shaped.q, batch.q.reshape(5, 8, 2, *batch.q.shape[1:]))
    np.testing.assert_array_equal(shaped.valid, batch.valid.reshape(5, 8, 2, -1))


ROUND = np.array([0.0, 0.5 * np.pi, -0.5 * np.pi, np.pi])
NOISES = (0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-4, 1e-2)  # rad


def ends(case: Case, rng: np.random.Generator) -> list[list[float]]:
    """Values [rad] of each joint at which the arm is singular whatever the others do: ends of elbows and wrists.

    Six joints. They are searched for with Pinocchio's Jacobian, so that no formula of any family enters.
    """
    found: list[list[float]] = [[] for _ in range(case.oracle.dof)]
    for joint, values in enumerate(found):
        for _ in range(12):
            try:
                q, _ = case.oracle.singular(rng, joint, attempts=1)
            except AssertionError:
                continue
            other = case.oracle.draw(rng, 1)[0]
            other[joint] = q[joint]
            if case.oracle.sigma_min(other) < 1e-12 and all(abs(q[joint] - x) > 1e-9 for x in values):
                values.append(float(q[joint]))
    return found


def corners(case: Case, rng: np.random.Generator, m: int) -> Array:
    """Joint vectors (7 m, n) as people teach them, each with every noise of ``NOISES``.

    By turns all joints at quarter turns; one to three joints at their ends, the others anywhere or at quarter turns;
    and of the last kind one joint moved to where the arm is singular by all of them together.
    """
    n = case.oracle.dof
    singular = ends(case, rng) if n == 6 else [[] for _ in range(n)]
    candidates = [joint for joint, values in enumerate(singular) if values]
    out = []
    for k in range(m):
        q = ROUND[rng.integers(0, 4, n)]
        if k % 4 > 0:
            q = np.where(rng.random(n) < (0.7 if k % 2 else 0.0), q, case.oracle.draw(rng, 1)[0])
            for joint in rng.permutation(candidates)[: rng.integers(1, 4)]:
                q[joint] = rng.choice(singular[joint])
        if k % 4 == 3 and n == 6:
            q = case.oracle.singular(rng, at=q)[0]
        out += [q + noise * rng.choice([-1.0, 0.0, 1.0], n) for noise in NOISES]
    return np.array(out)


def round_vectors(n: int, slides: NDArray[np.bool_], rng: np.random.Generator, m: int) -> Array:
    """Joint vectors (7 m, n) at quarter turns and decimetres, some with joints anywhere, with every noise."""
    out = []
    for k in range(m):
        q = np.where(slides, 0.1 * rng.integers(-3, 4, n), ROUND[rng.integers(0, 4, n)])
        q = np.where((k % 2 > 0) & (rng.random(n) < 0.4), rng.uniform(-1.0, 1.0, n), q)
        out += [q + noise * rng.choice([-1.0, 0.0, 1.0], n) for noise in NOISES]
    return np.array(out)


def holds_at_corners(case: Case, poses: int, seed: int) -> None:
    """At corners there are solutions, all exact; the planted one is found where the pose decides it."""
    for q in corners(case, np.random.default_rng(seed), poses):
        target = case.oracle.pose(q)
        solutions = case.arm.ik(target)
        found = assert_exact(case, solutions, target)
        assert len(found) > 0, (case.name, q.tolist())
        assert solutions.explain() == "", (case.name, q.tolist())
        assert indistinct_pairs(case, found, target) == 0, (case.name, q.tolist())
        tolerance = case.oracle.tolerance(q)
        if tolerance < 1e-3:
            assert nearest(found, q) <= tolerance, (case.name, q.tolist())
        elif case.oracle.sigma_min(q) < 1e-12:
            # Off the structure a double root may lie in a valley that is flat to rounding; the answer then says so.
            assert flags(solutions).any() or not solutions.certain, (case.name, q.tolist())


def holds_at_round_poses(case: Case, poses: int, seed: int) -> None:
    """Positions in steps of 5 cm, the tip along the base's axes: what multi-start Newton finds is there, all exact."""
    rng = np.random.default_rng(seed)
    for _ in range(poses):
        target = case.oracle.pose(ROUND[rng.integers(0, 4, case.oracle.dof)])
        target[:3, 3] = 0.05 * np.round(target[:3, 3] / 0.05)
        turned = np.eye(3)[rng.permutation(3)] * rng.choice([-1.0, 1.0], 3)
        target[:3, :3] = turned * np.linalg.det(turned)
        found = assert_exact(case, case.arm.ik(target), target)
        for x in case.oracle.solutions(target, rng, 40):
            if case.oracle.sigma_min(x) > 1e-3:
                assert nearest(found, x) <= 1e-5, (case.name, target.tolist(), x.tolist())
