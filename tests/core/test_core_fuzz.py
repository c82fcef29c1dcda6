"""The compiled solvers on arms and targets at random, degenerate ones on purpose: nothing wrong is marked valid."""

import zlib
from typing import Any

import numpy as np
import pytest
from arms import KINDS, random_arm
from arms_degenerate import planted, random_degenerate
from arms_few import BUILDS, SLIDES, axes_and_points, few_urdf
from arms_general import unstructured
from arms_seven import SEVEN, random_seven

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UrdfIkError

Array = np.typing.NDArray[np.float64]

# Of positions [m] in every direction, and of what rotations are off by.
LENGTHS = (0.0, 5e-324, 1e-300, 1e-18, 1e-6, 0.3, 1.0, 3.0, 1e3, 1e8, 1e100, 1e154, 1e300)
OFF = (0.0, 1e-16, 1e-13, 1e-9, 1e-6)
VALUES = (0.0, -0.0, np.pi, -np.pi, 1e-300, 1e-9, 7.0, 1e6, 1e15, 1e300)
CONTRACT = 1e-9


def arm_of(family: str, seed: int) -> urdf_ik.Arm:
    """A random member of what is named."""
    rng = np.random.default_rng([seed, zlib.crc32(family.encode())])
    kind = rng.choice
    if family == "degenerate":
        text = random_degenerate(rng)
    elif family == "six":
        text = random_arm(str(kind(list(KINDS))), seed, orthogonal=bool(seed % 2), aligned=bool(seed % 3)).urdf
    elif family == "seven":
        text = random_seven(str(kind(list(SEVEN))), seed, orthogonal=bool(seed % 2)).urdf
    elif family == "general":
        text = unstructured(seed).urdf
    else:
        builds = BUILDS | SLIDES
        build = builds[str(kind(list(builds)))]
        text = few_urdf(build.kinds, *axes_and_points(build, rng), rng)
    return urdf_ik.load(text, "base", "tool")


def targets(arm: urdf_ik.Arm, rng: np.random.Generator) -> Array:
    """Poses in reach, beside it, and anywhere: (m, 4, 4)."""
    reached = arm.fk(planted(arm, rng, 8))
    anywhere = np.tile(np.eye(4), (len(LENGTHS), 1, 1))
    for T, length in zip(anywhere, LENGTHS, strict=True):
        R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        R = np.eye(3)[rng.permutation(3)] * rng.choice([-1.0, 1.0], 3) if rng.random() < 0.5 else R
        T[:3, :3] = R * np.linalg.det(R)
        T[:3, 3] = length * np.array([rng.choice([-1.0, 0.0, 1.0]), rng.choice([-1.0, -0.0]), rng.uniform(-1.0, 1.0)])
    beside = reached.copy()
    beside[:, :3, 3] += rng.choice([1e-15, 1e-12, 1e-9, 1e-6]) * rng.normal(size=(len(beside), 3))
    T = np.concatenate([reached, beside, anywhere])
    T[:, :3, :3] += rng.choice(OFF) * rng.normal(size=(len(T), 3, 3))
    return np.ascontiguousarray(T)


def assert_sound(arm: urdf_ik.Arm, reference: Reference, solutions: Any, T: Array) -> None:
    """What is marked valid is finite and reaches its pose; what is not holds no numbers."""
    q, valid = np.asarray(solutions.q), np.asarray(solutions.valid)
    assert np.isnan(q[~valid]).all()
    assert np.isfinite(q[valid]).all()
    assert (np.abs(q[valid][:, ~arm.chain.prismatic]) <= np.pi).all()
    wanted = np.broadcast_to(T[:, None], (*valid.shape, 4, 4))[valid]
    # Of a rotation that is off, the nearest one is reached.
    u, _, v = np.linalg.svd(wanted[:, :3, :3])
    off = reference.pose(q[valid]) - wanted
    off[:, :3, :3] = reference.pose(q[valid])[:, :3, :3] - u @ v
    scale = np.maximum(max(arm.chain.size, 1.0), np.abs(wanted[:, :3, 3]).max(axis=1, initial=0.0))
    assert (np.abs(off[:, :3, 3]) <= CONTRACT * scale[:, None]).all()
    assert (np.abs(off[:, :3, :3]) <= CONTRACT).all()


@pytest.mark.parametrize("family", ["degenerate", "six", "seven", "general", "few"])
def test_nothing_wrong_is_valid(family: str) -> None:
    """Targets in reach or far beyond all that makes sense: sound answers, the same alone, in a batch and in threads."""
    for seed in range(12):
        assert_answers_are_sound(family, seed)


def assert_answers_are_sound(family: str, seed: int) -> None:
    """For one arm."""
    arm, rng = arm_of(family, seed), np.random.default_rng(seed)
    reference = Reference(arm.model, arm.base, arm.tip)
    T = targets(arm, rng)
    options: dict[str, Any] = {}
    if arm.redundancy is not None:
        options["redundancy"] = rng.choice(VALUES, len(T)) * rng.choice([0.0, 1.0, rng.uniform()], len(T))
    try:
        whole = arm.ik(T, **options)
    except UrdfIkError:
        return
    assert_sound(arm, reference, whole, T)
    shared = arm.ik(np.tile(T, (6, 1, 1)), threads=2, **{name: np.tile(each, 6) for name, each in options.items()})
    np.testing.assert_array_equal(shared.q[: len(T)], whole.q)
    np.testing.assert_array_equal(shared.q[-len(T) :], whole.q)
    for i in rng.permutation(len(T))[:4]:
        alone = arm.ik(T[i].copy(), **{name: each[i] for name, each in options.items()})
        np.testing.assert_array_equal(alone.q, whole.q[i])
    q_ref = rng.choice([0.0, 1e-300, 3.2, -1e4, 1e12, 1e300], arm.dof)
    near = arm.ik(T, q_ref, **options)
    assert_sound(arm, reference, near, T)


@pytest.mark.parametrize("family", ["degenerate", "six", "seven"])
def test_a_tracker_stays_finite(family: str) -> None:
    """Targets that jump about, in reach or not, are followed at bounded speed by joint vectors inside the limits."""
    for seed in range(6):
        assert_tracking_is_bounded(family, seed)


def assert_tracking_is_bounded(family: str, seed: int) -> None:
    """For one arm."""
    arm, rng = arm_of(family, 100 + seed), np.random.default_rng(seed)
    lower, upper = np.maximum(arm.limits[:, 0], -3.0), np.minimum(arm.limits[:, 1], 3.0)
    tracker = arm.tracker(rng.uniform(lower, upper), dt=0.01)
    for T in targets(arm, rng):
        if not np.isfinite(T[:3, 3]).all() or np.abs(T[:3, 3]).max() > 1e12:
            continue
        before = tracker.q
        try:
            step = tracker.step(T)
        except UrdfIkError:
            continue
        assert np.isfinite(step.q).all()
        assert (step.q >= arm.limits[:, 0] - CONTRACT).all()
        assert (step.q <= arm.limits[:, 1] + CONTRACT).all()
        assert (np.abs(step.q - before) <= 0.01 * np.minimum(arm.solver.velocity_limits, 1e3) + CONTRACT).all()


@pytest.mark.parametrize("family", ["six", "seven", "few"])
def test_a_path_is_sound(family: str) -> None:
    """A short path from a pose in reach: its joint vectors reach the waypoints, or the plan says that there is none."""
    for seed in range(4):
        assert_a_plan_reaches_its_waypoints(family, seed)


def assert_a_plan_reaches_its_waypoints(family: str, seed: int) -> None:
    """For one arm."""
    arm, rng = arm_of(family, 200 + seed), np.random.default_rng(seed)
    q = rng.uniform(np.maximum(arm.limits[:, 0], -2.0), np.minimum(arm.limits[:, 1], 2.0))
    start = arm.fk(q)
    end = start.copy()
    end[:3, 3] += 0.01 * rng.normal(size=3)
    waypoints = urdf_ik.line(start, end, 6)
    try:
        plan = arm.follow(waypoints)
    except UrdfIkError:
        return
    if plan.found:
        assert np.abs(arm.fk(plan.q)[:, :3, 3] - waypoints[:, :3, 3]).max() <= CONTRACT * max(arm.chain.size, 1.0)
