"""Interval inclusion through the closed forms: what the status of an exact arm's pose says.

The planted joint vector is a solution by construction: an answer that says that it is complete has it.
"""

from functools import lru_cache

import numpy as np
import pytest
from arms import random_arm
from arms_general import ur_with_right_angles
from cases import Case, described, from_catalogue
from numpy.typing import NDArray
from oracle import angle_distance
from searches import folds

import urdf_ik

Array = NDArray[np.float64]

KINDS = ("wrist, 2||3", "wrist, 2||3, 1x2", "wrist, 1x2", "wrist, 1||2", "2||3||4, 5x6", "2||3||4, 1x2, 5x6")
DISTANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 0.0)


@lru_cache
def exact(kind: str, seed: int = 0) -> Case:
    """Load a random member of a family."""
    return described(random_arm(kind, seed))


def near_singular(case: Case, count: int) -> Array:
    """Joint vectors at all distances from singular ones."""
    rng = np.random.default_rng(5)
    at = folds(case.arm, count, rng)
    away = rng.normal(size=at.shape)
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    return np.concatenate([at + distance * away for distance in DISTANCES])


def round_vectors(count: int) -> Array:
    """Multiples of a right angle."""
    return np.random.default_rng(6).choice([-0.5 * np.pi, 0.0, 0.5 * np.pi, np.pi], (count, 6))


def lacks(case: Case, q: Array) -> NDArray[np.bool_]:
    """Poses that say that no solution is missing and lack the planted vector.

    A solution stands for it if half way between the two the arm keeps the pose to 1e-10 m and rad.
    """
    T = case.oracle.poses(q)
    s = case.arm.ik(T)
    apart = np.where(s.valid, angle_distance(s.q, q[:, None]), np.inf)
    nearest = s.q[np.arange(len(q)), apart.argmin(axis=1)]
    middle = q + 0.5 * np.nan_to_num(np.remainder(nearest - q + np.pi, 2.0 * np.pi) - np.pi)
    error = np.abs(case.oracle.poses(middle) - T).max(axis=(1, 2))
    return s.certain & ((apart.min(axis=1) > 1e-3) | (error > 1e-10))


@pytest.mark.parametrize("kind", KINDS)
def test_random_poses_are_proven(kind: str) -> None:
    """Of an exact arm all but one in a thousand are complete, and have what was planted."""
    case = exact(kind)
    q = case.oracle.draw(np.random.default_rng(1), 4000)
    s = case.arm.ik(case.oracle.poses(q))
    assert not lacks(case, q).any()
    assert np.mean(s.status == "complete") >= 0.999


@pytest.mark.parametrize("kind", KINDS)
def test_singular_poses_are_decided(kind: str) -> None:
    """Nearly all have a status; those that say complete or clustered have what was planted, or stand for it."""
    case = exact(kind)
    q = near_singular(case, 60)
    s = case.arm.ik(case.oracle.poses(q))
    assert not lacks(case, q).any(), q[lacks(case, q)]
    assert np.mean(s.status == "incomplete") <= 0.1


@pytest.mark.parametrize("kind", KINDS)
def test_round_poses_do_not_lie(kind: str) -> None:
    """Right angles leave joints free, and bring folds together."""
    case = exact(kind)
    q = round_vectors(300)
    assert not lacks(case, q).any(), q[lacks(case, q)]


def test_two_folds_at_once_are_counted() -> None:
    """A UR5 with its arm straight and its wrist as near to joint 1 as it can be: four roots at one joint vector."""
    case = from_catalogue("ur5")
    q = 0.5 * np.pi * np.array([(0, k, 0, m, n, 0) for k in (1, 3) for m in (1, 3) for n in (1, 3)])
    values = np.linalg.svd(case.arm.jacobian(q), compute_uv=False)
    assert (values[:, 4] < 1e-9).all() and (values[:, 3] > 0.01).all()  # two ranks are lost
    s = case.arm.ik(case.oracle.poses(q))
    assert (s.status == "clustered").all()
    assert not lacks(case, q).any()
    for n, pose in enumerate(case.oracle.poses(q)):
        # Poses beside this one have their solutions beside those that were returned.
        rng = np.random.default_rng(n)
        for away in rng.normal(size=(40, 6)) * 1e-3:
            solution = case.arm.ik(case.oracle.poses(q[n : n + 1] + away)[0])
            known = s[n].to_array()
            apart = angle_distance(known[:, None], solution.to_array()[None])
            assert apart.min(axis=0).max() < 0.3, pose


@pytest.mark.parametrize("quarter", [1.57079632679, 1.5707963, 1.5708])
def test_folds_behind_short_lever_arms_are_decided(quarter: float) -> None:
    """With rounded right angles an aligned wrist is a short lever arm, and the fold behind it is hardly known."""
    case = described(ur_with_right_angles(quarter))
    q = round_vectors(400)
    assert not lacks(case, q).any(), q[lacks(case, q)]
    assert np.mean(case.arm.ik(case.oracle.poses(q)).status == "incomplete") <= 0.035


@pytest.mark.parametrize("beyond", [1e-13, 3e-13, 1e-12])
def test_two_roots_that_are_hardly_not_real_stand_as_one_solution(beyond: float) -> None:
    """An elbow that misses its reach by less than the tolerance is returned straight, and keeps the pose."""
    arm = ur_with_right_angles(0.5 * np.pi)
    case = described(arm)
    q = np.array([0.3, -0.7, 0.0, 0.4, 0.9, 0.2])
    second, fourth = (urdf_ik.load(arm.urdf, base="base", tip=f"link_{k}").fk(q[:k])[:3] for k in (2, 4))
    outwards, axis = fourth[:, 3] - second[:, 3], second[:, 2]
    outwards -= (outwards @ axis) * axis
    T = case.oracle.poses(q[None])[0]
    T[:3, 3] += beyond * outwards / np.linalg.norm(outwards)
    s = case.arm.ik(T)
    assert s.status == "clustered"
    straight = angle_distance(s.to_array(), q) < 1e-4
    assert np.count_nonzero(straight) == 1
    assert np.abs(case.oracle.poses(s.to_array()[straight]) - T).max() < 1e-10


@pytest.mark.parametrize("kind", KINDS)
def test_the_fast_path_claims_no_more_than_inclusion(kind: str) -> None:
    """A rotation that is off by 2e-12 takes the pose to the inclusion, which proves whatever the margins proved."""
    case = exact(kind, 1)
    q = np.concatenate([case.oracle.draw(np.random.default_rng(2), 2000), near_singular(case, 40)])
    T = case.oracle.poses(q)
    off = T.copy()
    off[:, :3, :3] *= 1.0 + 2e-12
    margins, inclusion = case.arm.ik(T), case.arm.ik(off)
    proven = (inclusion.status == "complete") | (inclusion.status == "clustered")
    assert not ((margins.status == "complete") & ~proven & (margins.count == inclusion.count)).any()


@pytest.mark.parametrize("kind", KINDS)
def test_out_of_reach_is_proven(kind: str) -> None:
    """A pose that the links cannot reach has no solution, and says so; one at the very end of reach does not lie."""
    case = exact(kind)
    q = case.oracle.draw(np.random.default_rng(3), 50)
    T = case.oracle.poses(q)
    T[:, :3, 3] += 9.0 * np.array([0.6, 0.64, 0.48])
    s = case.arm.ik(T)
    assert not s.valid.any()
    assert (s.status == "complete").all()
