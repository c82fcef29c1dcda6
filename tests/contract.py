"""The contract of ``ik`` on random poses of any arm: complete, exact, nothing twice, a batch as its poses."""

from __future__ import annotations

import numpy as np
from cases import Case, assert_exact, closest_pair, nearest, rows
from numpy.typing import NDArray

Array = NDArray[np.float64]


def holds(case: Case, poses: int, seed: int) -> None:
    """On random poses the planted one is found, all are exact, none comes twice, and their number is even."""
    for q in case.oracle.draw(np.random.default_rng(seed), poses):
        target = case.oracle.pose(q)
        found = assert_exact(case, case.arm.ik(target), target)
        assert nearest(found, q) <= case.oracle.tolerance(q), (case.name, q)
        assert closest_pair(found) > 1e-7, (case.name, q)
        assert len(found) % 2 == 0 or min(case.oracle.sigma_min(x) for x in found) < 1e-6, (case.name, q)


def holds_near_most_singularities(case: Case, singularities: int, seed: int) -> None:
    """At 1e-1 to 1e-7 rad from a singularity at least 99 % of the planted ones are found; all exact, none twice."""
    rng = np.random.default_rng(seed)
    lost, planted = [], 0
    for _ in range(singularities):
        q0, joint = case.oracle.singular(rng)
        for k in range(1, 8):
            q = q0.copy()
            q[joint] += 10.0**-k * rng.choice([-1.0, 1.0])
            target = case.oracle.pose(q)
            found = assert_exact(case, case.arm.ik(target), target)
            assert closest_pair(found) > 1e-8, (case.name, q)
            planted += 1
            if nearest(found, q) > case.oracle.tolerance(q):
                lost.append((k, q.tolist()))
    assert len(lost) <= 0.01 * planted, (case.name, lost)


def is_complete(case: Case, poses: int, seed: int) -> None:
    """The solutions are those of a multi-start Newton search on Pinocchio's model, or more."""
    rng = np.random.default_rng(seed)
    for q in case.oracle.draw(rng, poses):
        target = case.oracle.pose(q)
        found, searched = rows(case.arm.ik(target)), case.oracle.solutions(target, rng)
        assert len(found) >= len(searched) > 0, (case.name, q)
        assert all(nearest(found, x) <= 1e-5 for x in searched), (case.name, q)


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
    """The same of 80 random poses, one of them far out of reach."""
    targets = case.oracle.poses(case.oracle.draw(np.random.default_rng(seed), 80))
    targets[7, :3, 3] += 100.0
    batch_equals_single(case, targets)
    assert not case.arm.ik(targets).valid[7].any()
