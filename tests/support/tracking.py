"""Arms and paths for trackers, and the checks that every step of a tracker must pass."""

import math
from collections import Counter
from functools import lru_cache

import numpy as np
from arms_general import crx_like, unstructured
from arms_seven import random_seven
from cases import described, named
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.paths import Step, Tracker

Array = NDArray[np.float64]

DT = 0.004
EXACT = 1e-9  # m and rad, the contract of every answer
ROUNDING = 1e-12  # rad or m a cycle: what a speed times dt loses in a sum
Q0 = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])  # of zyyzyz_6r, regular
START = np.array([0.3, 0.6, 1.0, 0.4, 0.7, -0.2])  # the same, far from the shoulder's singularity too

FEW = ("planar_2r", "positioning_3r", "twodof", "so100", "scara_rrpr")


@lru_cache
def arm_of(name: str) -> urdf_ik.Arm:
    """An arm of the catalogue, or one that the tests describe."""
    made = {
        "crx": crx_like,
        "general": lambda: unstructured(3),
        "seven": lambda: random_seven("S-R-S", 1),
        "seven general": lambda: random_seven("one before 2||3||4, 5x6", 2),
    }
    if name in made:
        return described(made[name]()).arm  # type: ignore[no-any-return]
    if name in ("industrial", "ur_like"):
        return named(name).arm  # type: ignore[no-any-return]
    return urdf_ik.load(name)


@lru_cache
def reference(name: str) -> Reference:
    """Pinocchio's model of the same URDF."""
    arm = arm_of(name)
    return Reference(arm.model, arm.base, arm.tip)


def middle(arm: urdf_ik.Arm) -> tuple[Array, Array]:
    """Middle and half of the joints' ranges, at most half a turn."""
    lower, upper = np.clip(arm.limits, -math.pi, math.pi).T
    return 0.5 * (lower + upper), 0.5 * (upper - lower)


def path(arm: urdf_ik.Arm, seed: int, *, cycles: int = 600, span: float = 0.5, speed: float = 0.6) -> Array:
    """Joint vectors (cycles, n) of a smooth path inside the limits, at most so fast as a share of the speed limits."""
    rng = np.random.default_rng(seed)
    centre, half = middle(arm)
    t = np.linspace(0.0, 1.0, cycles)[:, None]
    waves = sum(rng.normal(size=arm.dof) * np.sin(2.0 * np.pi * (k * t + rng.random(arm.dof))) / k for k in (1, 2))
    Q: Array = centre + span * half * (rng.uniform(-1.0, 1.0, arm.dof) + 0.3 * waves) / 1.9
    most = np.abs(np.diff(Q, axis=0)).max(axis=0) / DT
    limits = np.minimum(arm.tracker(centre, DT).velocity_limits, 3.0)
    return Q[0] + (Q - Q[0]) * min(1.0, speed * float((limits / np.maximum(most, 1e-9)).min()))


def weakest(name: str, Q: Array) -> float:
    """Smallest singular value on a path, by Pinocchio's Jacobian, lengths as shares of the arm's size."""
    J = reference(name).jacobian(Q)
    J = np.concatenate([J[..., :3, :] / arm_of(name).chain.size, J[..., 3:, :]], axis=-2)
    J = J * np.where(arm_of(name).chain.prismatic, arm_of(name).chain.size, 1.0)
    return float(np.linalg.svd(J, compute_uv=False)[..., -1].min())


def regular_path(name: str, seed: int) -> Array:
    """The first path from a seed on that stays away from singularities."""
    for attempt in range(200):
        Q = path(arm_of(name), 1000 * seed + attempt)
        if weakest(name, Q) > 0.03:
            return Q
    raise AssertionError(name)


def gaps(name: str, q: Array, T: Array) -> Array:
    """(...) the greater of position [m] and angle [rad] between Pinocchio's poses and targets."""
    position, angle = reference(name).errors(q, T)
    return np.maximum(position, angle)


def run(tracker: Tracker, targets: Array) -> list[Step]:
    """The steps of following the targets; each step must keep the limits."""
    limits, before, steps = tracker.solver.limits, tracker.q, []
    for target in targets:
        step = tracker.step(target)
        q = step.q
        assert (np.abs(q - before) <= tracker.velocity_limits * tracker.dt + ROUNDING).all()
        assert ((q >= limits[:, 0]) & (q <= limits[:, 1])).all()
        assert (step.why is None) == (step.status == "ok")
        if step.status == "held":
            np.testing.assert_array_equal(q, before)
        steps.append(step)
        before = q
    return steps


def vectors(steps: list[Step]) -> Array:
    """(m, n)."""
    return np.array([step.q for step in steps])


def statuses(steps: list[Step]) -> Counter[str]:
    """How often each status came."""
    return Counter(step.status for step in steps)
