"""Members of the families with three parallel axes at one end or a spherical middle, and checks of them alone."""

from functools import lru_cache
from typing import Any

import numpy as np
from arms import random_arm
from arms_closed_forms import KINDS
from arms_general import tilted
from cases import Case, assert_exact, described, indistinct_pairs, nearest, rows
from numpy.typing import NDArray

from urdf_ik.ik.families import general
from urdf_ik.kinematics.structure import analyse

Array = NDArray[np.float64]

# Oblique and at right angles, with exact and with rounded frames.
VARIANTS = ((0, False, False), (1, True, True), (2, True, False))


@lru_cache
def member(kind: str, seed: int = 0, orthogonal: bool = False, aligned: bool = False) -> Case:
    """Load a random member of one of the families."""
    return described(random_arm(kind, seed, orthogonal=orthogonal, aligned=aligned, kinds=KINDS))


@lru_cache
def near_member(kind: str, eps: float) -> Case:
    """Load a random member that is ``eps`` [rad, share of length] off its family."""
    return described(tilted(random_arm(kind, 0, kinds=KINDS), eps, 0))


def members(kind: str) -> list[Case]:
    """One member of a kind for each of ``VARIANTS``."""
    return [member(kind, *variant) for variant in VARIANTS]


def by_elimination(case: Case, target: Array) -> Array:
    """The solutions (k, 6) of one pose that the general elimination finds."""
    solver = general.TURNING.plan(analyse(case.arm.chain), case.arm.chain).solver
    Q, marks = np.empty((1, 16, 6)), np.empty((1, 16), np.uint8)
    assert solver.solve(np.ascontiguousarray(target[None]), None, Q, marks) == -1
    return Q[marks & 1 != 0]


def returns_its_reference(case: Case, singularities: int, seed: int) -> None:
    """Exactly on a singularity, the planted joint vector given as the reference is among the solutions.

    Where a curve of solutions stays in the pose up to rounding, the pose does not tell which of them was planted.
    """
    rng = np.random.default_rng(seed)
    for _ in range(singularities):
        q, _ = case.oracle.singular(rng)
        target = case.oracle.pose(q)
        found = assert_exact(case, case.arm.ik(target, q_ref=q), target)
        if not 3e-8 < case.oracle.curvature(q) < 1e-5:
            assert nearest(found, q) <= 3.0 * case.oracle.singular_tolerance(q), (case.name, q)


def agrees_with_elimination(case: Case, poses: int, seed: int) -> None:
    """Both solvers find the same joint vectors, away from singularities."""
    compared = 0
    for q in case.oracle.draw(np.random.default_rng(seed), poses):
        target = case.oracle.pose(q)
        found, others = rows(case.arm.ik(target)), by_elimination(case, target)
        if min(case.oracle.sigma_min(x) for x in found) < 1e-2:
            continue
        compared += 1
        assert len(found) >= len(others), (case.name, q)
        assert all(nearest(found, x) < 1e-6 for x in others), (case.name, q)
    assert compared > 0


def at_quarter_turns(case: Case, poses: int, seed: int) -> None:
    """With all joints at multiples of a quarter turn from where neighbouring axes lie in a plane: exact solutions."""
    arm: Any = case.arm.solver.require_member().solver.arm
    from_tip = arm.kind == "reversed"
    offset = (arm.solver if from_tip else arm).ideal.offset
    offset = offset[::-1] if from_tip else offset
    rng = np.random.default_rng(seed)
    for quarters in rng.integers(-2, 3, (poses, 6)):
        target = case.oracle.pose(0.5 * np.pi * quarters - offset)
        found = assert_exact(case, case.arm.ik(target), target)
        assert len(found) > 0, (case.name, quarters)
        assert indistinct_pairs(case, found, target) == 0, (case.name, quarters)


def has_a_clean_edge(case: Case, seed: int) -> None:
    """Two solutions that meet on a fold both exist 1e-6 m to one side of it, and neither to the other."""
    rng, checked = np.random.default_rng(seed), 0
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
