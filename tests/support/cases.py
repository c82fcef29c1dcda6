"""Loaded arms with their reference, and the checks that every answer must pass."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from arms import KINDS, DescribedArm, industrial, random_arm, ur_like
from numpy.typing import NDArray
from oracle import Oracle, angle_distance

import urdf_ik
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.model import catalogue

Array = NDArray[np.float64]

RESIDUAL = 1e-9  # m and rad: the contract of ik


@dataclass(frozen=True)
class Case:
    """An arm as this package loads it, and Pinocchio's model of the same URDF."""

    name: str
    arm: Any
    oracle: Oracle


def described(arm: DescribedArm) -> Case:
    """Load an arm that the tests made."""
    return Case(arm.name, urdf_ik.load(arm.urdf, base="base", tip="tool"), Oracle(arm.urdf))


@lru_cache
def from_catalogue(name: str) -> Case:
    """Load an arm by its catalogue name."""
    arm = urdf_ik.load(name)
    return Case(name, arm, Oracle(catalogue.resolve(name).path, arm.base, arm.tip))


@lru_cache
def member(kind: str, seed: int, orthogonal: bool = False, aligned: bool = False) -> Case:
    """Load a random member of a family."""
    return described(random_arm(kind, seed, orthogonal=orthogonal, aligned=aligned))


@lru_cache
def _made(name: str) -> Case:
    """Load one of the named arms that the tests describe."""
    makers: dict[str, Callable[[], DescribedArm]] = {
        "industrial": industrial,
        "industrial-lateral": lambda: industrial(b=0.1),
        "ur_like": ur_like,
        "ur_like-negated-middle": lambda: ur_like(signs=(1, 1, -1, 1, 1, 1)),
    }
    return described(makers[name]())


CATALOGUE = ("zyyzyz_6r", "dh_6r", "ur3", "ur5", "ur10")
MADE = ("industrial", "industrial-lateral", "ur_like", "ur_like-negated-middle")
# Oblique and at right angles, with exact and with rounded frames.
VARIANTS = ((0, False, False), (1, True, True), (2, True, False))


def named(name: str) -> Case:
    """The case behind one of ``ALL``."""
    if name in CATALOGUE:
        return from_catalogue(name)
    if name in MADE:
        return _made(name)
    return member(*_MEMBERS[name])


_MEMBERS = {
    random_arm(kind, seed, orthogonal=orthogonal, aligned=aligned).name: (kind, seed, orthogonal, aligned)
    for kind in KINDS
    for seed, orthogonal, aligned in VARIANTS
}
ALL = (*CATALOGUE, *MADE, *_MEMBERS)
MEMBERS_OF = {kind: tuple(name for name, key in _MEMBERS.items() if key[0] == kind) for kind in KINDS}


def thinned(values: Iterable[Any], every: int) -> list[Any]:
    """Parameters of a wide sweep: one in ``every`` is in the fast suite, the others are slow."""
    return [value if k % every == 0 else pytest.param(value, marks=pytest.mark.slow) for k, value in enumerate(values)]


def rows(solutions: IKSolutions) -> Array:
    """The valid solutions (k, n) of one pose."""
    return np.asarray(solutions.q, dtype=np.float64)[solutions.valid]


def flags(solutions: IKSolutions) -> NDArray[np.uint8]:
    """The singular flags (k,) of the valid solutions of one pose."""
    return np.asarray(solutions.singular, dtype=np.uint8)[solutions.valid]


def nearest(found: Array, q: Array) -> float:
    """Distance [rad] from q to the nearest of the solutions (k, n); infinite where there are none."""
    return float(angle_distance(found, q).min()) if len(found) else np.inf


def closest_pair(found: Array) -> float:
    """Distance [rad] between the two solutions that are closest together; infinite for fewer than two."""
    pairs = [angle_distance(found[i + 1 :], found[i]).min() for i in range(len(found) - 1)]
    return float(min(pairs, default=np.inf))


def indistinct_pairs(case: Case, found: Array, target: Array) -> int:
    """Number of pairs of solutions half way between which the arm still is in the pose: one solution, given twice."""
    count = 0
    for i, a in enumerate(found):
        for b in found[i + 1 :]:
            step = (b - a + np.pi) % (2.0 * np.pi) - np.pi
            count += bool(np.abs(step).max() < 1e-3 and case.oracle.error(a + 0.5 * step, target) < 1e-14)
    return count


def worst_error(case: Case, found: Array, target: Array) -> float:
    """Largest error [m or rad] of the solutions (k, n) against a pose, by Pinocchio."""
    return max((case.oracle.error(q, target) for q in found), default=0.0)


def assert_exact(case: Case, solutions: IKSolutions, target: Array) -> Array:
    """Every solution reaches the pose under Pinocchio, angles lie in (-pi, pi], empty columns are NaN. Returns them."""
    found = rows(solutions)
    assert np.isnan(np.asarray(solutions.q)[~np.asarray(solutions.valid)]).all()
    assert (found > -np.pi).all()
    assert (found <= np.pi).all()
    assert worst_error(case, found, target) <= RESIDUAL
    return found


def vectors(arm: Any, count: int, seed: int = 0) -> Array:
    """Joint vectors (count, n) inside the limits, without turns."""
    lower, upper = np.clip(arm.limits, -np.pi, np.pi).T
    return np.random.default_rng(seed).uniform(lower, upper, (count, arm.dof))
