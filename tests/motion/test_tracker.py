"""Streaming: exact where it says so, always within the limits, on one branch, and a reason where it is not there."""

from __future__ import annotations

import math
import pickle
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np
import pinocchio as pin
import pytest
from arms_general import crx_like, unstructured
from arms_mimic import linkage
from arms_seven import random_seven
from cases import described, from_catalogue, named
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.errors import ArgumentError, JointVectorError, PoseError, UnsupportedArm, VelocityError
from urdf_ik.motion import Step, Tracker
from urdf_ik.reference import Reference

Array = NDArray[np.float64]

DT = 0.004
EXACT = 1e-9  # m and rad, the contract of every answer
ROUNDING = 1e-12  # rad or m a cycle: what a speed times dt loses in a sum
Q0 = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])  # of zyyzyz_6r, regular
START = np.array([0.3, 0.6, 1.0, 0.4, 0.7, -0.2])  # the same, far from the shoulder's singularity too

SIX = ("zyyzyz_6r", "ur5", "industrial", "ur_like", "crx", "general")
OTHERS = ("srs_7r", "panda", "seven", "seven general", "scara_rrpr", "stanford_rrprrr")
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
    """Every step of following the targets, of which each is checked against the limits."""
    arm, before, steps = tracker.arm, tracker.q, []
    for target in targets:
        step = tracker.step(target)
        q = step.q
        assert (np.abs(q - before) <= tracker.velocity_limits * tracker.dt + ROUNDING).all()
        assert ((q >= arm.limits[:, 0]) & (q <= arm.limits[:, 1])).all()
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


def turned(T: Array, rotation: Array, about: Array) -> Array:
    """Poses (m, 4, 4) turned by a rotation (3, 3) about a point (m, 3) each."""
    out = T.copy()
    out[:, :3, :3] = rotation @ T[:, :3, :3]
    out[:, :3, 3] = about + (T[:, :3, 3] - about) @ rotation.T
    return out


# ------------------------------------------------------------------------------------------------ regular paths


@pytest.mark.parametrize("name", SIX)
@pytest.mark.parametrize("seed", range(4))
def test_six_joints_return_the_path(name: str, seed: int) -> None:
    """Of a regular path of the joints its poses give that path again, every one exact as Pinocchio sees it."""
    Q = regular_path(name, seed)
    T = reference(name).pose(Q)
    steps = run(arm_of(name).tracker(Q[0], DT), T)
    assert statuses(steps) == {"ok": len(Q)}
    assert np.abs(vectors(steps) - Q).max() < 1e-7
    assert gaps(name, vectors(steps), T).max() <= EXACT


@pytest.mark.parametrize("name", OTHERS)
def test_other_arms_are_exact(name: str) -> None:
    """Seven joints and slides: every pose of a regular path is reached, within the limits."""
    Q = regular_path(name, 1)
    T = reference(name).pose(Q)
    steps = run(arm_of(name).tracker(Q[0], DT), T)
    assert statuses(steps) == {"ok": len(Q)}
    assert gaps(name, vectors(steps), T).max() <= EXACT


@pytest.mark.parametrize("name", FEW)
def test_few_joints_return_the_path(name: str) -> None:
    """The same for arms that reach a part of all poses only."""
    Q = regular_path(name, 2)
    steps = run(arm_of(name).tracker(Q[0], DT), reference(name).pose(Q))
    assert statuses(steps) == {"ok": len(Q)}
    assert np.abs(vectors(steps) - Q).max() < 1e-7


def test_tasks_are_followed() -> None:
    """An arm of a task takes targets of that task; what the task leaves open does not count."""
    arm = arm_of("positioning_3r").for_task("position")
    Q = path(arm, 4)
    points = arm.fk(Q)[:, :3, 3]
    steps = [step for tracker in [arm.tracker(Q[0], DT)] for step in [tracker.step(point) for point in points]]
    assert statuses(steps) == {"ok": len(Q)}
    assert np.linalg.norm(arm.fk(vectors(steps))[:, :3, 3] - points, axis=1).max() <= EXACT
    with pytest.raises(PoseError, match="takes"):
        arm.tracker(Q[0], DT).step(np.eye(4))


@pytest.mark.parametrize(("name", "task"), [("planar_2r", "planar position"), ("so100", "position and axis")])
def test_other_tasks_are_followed(name: str, task: str) -> None:
    """Tasks in a plane, and of an axis."""
    arm = urdf_ik.load(name)
    assert arm.task == task
    Q = path(arm, 5, span=0.3)
    targets = arm.control.target_of(arm.fk(Q))
    tracker = arm.for_task(task).tracker(Q[0], DT)
    steps = [tracker.step(target) for target in targets]
    reached = arm.control.target_of(arm.fk(vectors(steps)))
    assert statuses(steps) == {"ok": len(Q)}
    assert np.abs(reached - targets).max() <= EXACT


def test_turns_are_kept() -> None:
    """A joint that goes round and round keeps its turns: its angles are continuous beyond half a turn."""
    arm = arm_of("ur5")
    Q = np.tile([0.3, -1.2, 1.4, -0.5, 1.1, 0.0], (900, 1))
    Q[:, 0] = np.linspace(-3.5, 5.5, 900)
    steps = run(arm.tracker(Q[0], DT, velocity=4.0), arm.fk(Q))
    np.testing.assert_allclose(vectors(steps), Q, atol=1e-9)


# ------------------------------------------------------------------------------------------------ limits of speed


def test_a_far_target_is_approached_along_the_straight_way() -> None:
    """The tip goes straight towards a target that is too far for one cycle, at the limit of a joint, and gets there."""
    arm = arm_of("zyyzyz_6r")
    T0, T1 = arm.fk(START), arm.fk(START + [0.5, 0.3, 0.2, -0.4, 0.3, 0.5])
    tracker = arm.tracker(START, DT)
    steps = run(tracker, np.repeat(T1[None], 400, axis=0))
    tips = np.array([arm.fk(step.q)[:3, 3] for step in steps])
    way = (T1 - T0)[:3, 3] / np.linalg.norm((T1 - T0)[:3, 3])
    across = (tips - T0[:3, 3]) - ((tips - T0[:3, 3]) @ way)[:, None] * way
    assert steps[0].status == "limited"
    assert steps[0].why == "velocity"
    assert np.linalg.norm(across, axis=1).max() < 1e-3
    assert steps[-1].status == "ok"
    fastest = [np.abs(step.velocity / tracker.velocity_limits).max() for step in steps if step.status == "limited"]
    assert np.median(fastest) > 0.8
    np.testing.assert_allclose(steps[-1].q, START + [0.5, 0.3, 0.2, -0.4, 0.3, 0.5], atol=1e-9)


def test_what_is_missing_is_reported() -> None:
    """``distance`` and ``angle`` are those to the target."""
    arm = arm_of("zyyzyz_6r")
    T = arm.fk(Q0)
    T[:3, 3] += [0.3, 0.0, 0.0]
    step = arm.tracker(Q0, DT).step(T)
    P = arm.fk(step.q)
    assert step.distance == pytest.approx(np.linalg.norm(T[:3, 3] - P[:3, 3]), abs=1e-12)
    assert step.angle == pytest.approx(np.linalg.norm(pin.log3(P[:3, :3].T @ T[:3, :3])), abs=1e-12)


@pytest.mark.parametrize(
    "name", ["zyyzyz_6r", "ur5", "ur5_limited", "panda", *FEW, "stanford_rrprrr", "crx", "general"]
)
def test_random_targets_break_no_limit(name: str) -> None:
    """Targets anywhere never raise and never break a limit; the same targets give the same answers."""
    arm, rng = arm_of(name), np.random.default_rng(11)
    centre, half = middle(arm)
    limits = np.minimum(arm.tracker(centre, DT).velocity_limits, 3.0)
    targets = []
    for k in range(60):
        reachable = arm.fk(centre + half * rng.uniform(-1.0, 1.0, arm.dof))
        far = urdf_ik.pose(3.0 * rng.normal(size=3), rpy=rng.uniform(-3.0, 3.0, 3))
        targets += [reachable if k % 4 else far] * int(rng.integers(1, 40))
    first, second = (run(arm.tracker(centre, DT, velocity=limits), np.array(targets)) for _ in range(2))
    np.testing.assert_array_equal(vectors(first), vectors(second))
    found = vectors(first)[[step.status == "ok" for step in first]]
    wanted = np.array(targets)[[step.status == "ok" for step in first]]
    assert not len(found) or gaps(name, found, wanted).max() <= EXACT


def test_no_limit_is_no_jump() -> None:
    """Without limits of speed a step of the target to another place is followed on the branch that the arm is on."""
    arm = arm_of("zyyzyz_6r")
    rng = np.random.default_rng(3)
    for _ in range(20):
        q1 = START + rng.uniform(-0.25, 0.25, 6)
        step = arm.tracker(START, DT, velocity=np.inf).step(arm.fk(q1))
        assert step.status == "ok"
        np.testing.assert_allclose(step.q, q1, atol=1e-8)


# ------------------------------------------------------------------------------------------------ singularities


def past_the_wrist(arm: urdf_ik.Arm, offset: float) -> tuple[Array, Array]:
    """Joint vector and poses that tilt the wrist through zero, or past it at an angle [rad]."""
    q0 = Q0 * [1, 1, 1, 1, 0.5, 1]
    Q = np.tile(q0, (160, 1))
    Q[:, 4] = np.linspace(0.35, -0.35, len(Q))
    axes, points, _ = arm.chain.placed(q0)
    T = turned(arm.fk(Q), pin.exp3(np.cross(axes[3], axes[4]) * offset), np.tile(points[4], (len(Q), 1)))
    return arm.ik_nearest(T[0], q0).q[0], T


@pytest.mark.parametrize("offset", [0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 3e-3, 1e-2])
def test_through_a_wrist_singularity(offset: float) -> None:
    """Bounded speed, an error no greater than the distance from the singularity, and exact again afterwards."""
    arm = arm_of("zyyzyz_6r")
    start, T = past_the_wrist(arm, offset)
    T = np.concatenate([T, np.repeat(T[-1:], 200, axis=0)])
    steps = run(arm.tracker(start, DT), T)
    assert max(step.angle for step in steps) <= 3.0 * offset + EXACT
    assert max(step.distance for step in steps) <= 3.0 * offset + EXACT
    assert {step.status for step in steps[160:][-20:]} == {"ok"}
    if offset == 0.0:
        assert statuses(steps) == {"ok": len(T)}


@pytest.mark.parametrize("joints", [[0.3, -0.5, 0.8, 0.4, 0.0, -0.2], [0.3, -0.5, 0.0, 0.4, 0.5, -0.2]])
def test_a_singular_start_is_left(joints: list[float]) -> None:
    """From a wrist, or an elbow, that is exactly straight every pose nearby that has solutions is reached."""
    arm, q0 = arm_of("zyyzyz_6r"), np.array(joints)
    for axis in range(6):
        for sign in (-1.0, 1.0):
            twist = sign * 0.1 * np.eye(6)[axis]
            target = arm.fk(q0)
            target[:3, :3] = pin.exp3(twist[3:]) @ target[:3, :3]
            target[:3, 3] += twist[:3]
            if len(arm.ik(target).within_limits()):
                steps = run(arm.tracker(q0, DT), np.repeat(target[None], 600, axis=0))
                assert steps[-1].status == "ok", (axis, sign, steps[-1])


@pytest.mark.parametrize("way", [[2.0, 0.0, 0.0], [0.0, 0.0, 2.0], [1.0, 1.0, 1.0], [-3.0, 0.0, 0.0]])
def test_out_of_reach_and_back(way: list[float]) -> None:
    """Beyond its reach the arm stretches and says why; it comes back with its elbow where it was."""
    arm = arm_of("zyyzyz_6r")
    T = np.repeat(arm.fk(Q0)[None], 1200, axis=0)
    T[:800, :3, 3] += np.concatenate([np.linspace(0, 1, 400), np.linspace(1, 0, 400)])[:, None] * np.array(way)
    steps = run(arm.tracker(Q0, DT, velocity=3.0), T)
    assert {step.why for step in steps[395:405]} == {"reach"}
    assert (vectors(steps)[:, 2] > 0.0).all()
    assert steps[-1].status == "ok"
    np.testing.assert_allclose(steps[-1].q, Q0, atol=1e-9)


def test_far_out_of_reach_the_arm_comes_to_rest() -> None:
    """A target that stays out of reach: held, stretched towards it, until one comes that is in reach."""
    arm = arm_of("zyyzyz_6r")
    T = arm.fk(Q0)
    T[:3, 3] *= 3.0
    tracker = arm.tracker(Q0, DT, velocity=3.0)
    steps = run(tracker, np.repeat(T[None], 600, axis=0))
    assert (steps[-1].status, steps[-1].why) == ("held", "reach")
    assert arm.manipulability(steps[-1].q) < 1e-3
    assert run(tracker, np.repeat(arm.fk(Q0)[None], 600, axis=0))[-1].status == "ok"


@pytest.mark.parametrize("least", [0.1, 1e-2, 1e-4, 0.0])
def test_along_the_edge_of_a_fold(least: float) -> None:
    """A path whose elbow comes as near to straight as one likes is followed on its own side of it."""
    arm = arm_of("zyyzyz_6r")
    t = np.linspace(0.0, 2.0 * np.pi, 1500)[:, None]
    Q = Q0 + 0.1 * np.sin(t * [1.0, 2.0, 0.0, 1.0, 1.0, 2.0])
    Q[:, 2] = least + 0.15 * (1.0 + np.cos(t[:, 0]))
    steps = run(arm.tracker(Q[0], DT), arm.fk(Q))
    assert (vectors(steps)[:, 2] > -1e-6).all()
    assert max(max(step.distance, step.angle) for step in steps) < 1e-6
    assert np.abs(vectors(steps) - Q)[-1].max() < 1e-6
    if least > 0.0:
        assert statuses(steps) == {"ok": len(Q)}


def test_an_elbow_that_would_have_to_turn_over_does_not() -> None:
    """The poses of a path through the straight elbow are followed exactly, on the side where the arm began."""
    arm = arm_of("zyyzyz_6r")
    Q = np.tile(Q0, (400, 1))
    Q[:, 2] = np.linspace(0.3, -0.3, 400)
    steps = run(arm.tracker(Q[0], DT), arm.fk(Q))
    assert (vectors(steps)[:, 2] > -1e-6).all()
    assert max(step.distance for step in steps) < 1e-4
    assert steps[-1].status == "ok"


# ------------------------------------------------------------------------------------------------ joint limits


def test_a_joint_limit_in_the_way() -> None:
    """At a joint's limit the arm stays inside it, says so, and goes on when the target comes back."""
    arm = arm_of("zyyzyz_6r")
    Q = np.tile(Q0, (1600, 1))
    Q[:1000, 4] = 1.5 + 1.5 * (1.0 - np.abs(np.linspace(-1.0, 1.0, 1000)))
    Q[1000:, 4] = 1.5
    steps = run(arm.tracker(Q[0], DT), arm.fk(Q))
    assert steps[500].why == "limit"
    assert steps[500].q[4] == arm.limits[4, 1]
    np.testing.assert_allclose(steps[-1].q, Q[-1], atol=1e-9)


def test_seven_joints_keep_off_their_limits() -> None:
    """Where the pose leaves them free, seven joints leave the ends of their ranges; at a rate of 0 they do not."""
    arm = arm_of("panda")
    centre, half = middle(arm)
    q0 = centre + half * [0.0, 0.2, 0.0, 0.1, 0.95, 0.1, 0.0]
    t = np.linspace(0.0, 8.0 * np.pi, 3000)
    T = np.repeat(arm.fk(q0)[None], len(t), axis=0)
    T[:, 2, 3] += 0.05 * np.sin(t)
    ends = [run(arm.tracker(q0, DT, recentring=rate), T)[-1] for rate in (0.0, 5.0)]
    shares = [np.abs((step.q - centre) / half).max() for step in ends]
    assert shares[0] > shares[1] + 0.01
    assert all(step.status == "ok" for step in ends)


# ------------------------------------------------------------------------------------------------ acceleration


def test_acceleration_is_limited() -> None:
    """A target far away: no acceleration above the limit, no overshoot worth the name, and at rest at the end."""
    arm = arm_of("zyyzyz_6r")
    target = START + [0.5, 0.3, 0.2, -0.4, 0.3, 0.5]
    tracker = arm.tracker(START, DT, acceleration=5.0)
    steps = run(tracker, np.repeat(arm.fk(target)[None], 800, axis=0))
    q = np.concatenate([[START, START], vectors(steps)])
    assert (np.abs(np.diff(q, 2, axis=0)) / DT**2).max() <= 5.0 * (1.0 + 1e-6)
    assert np.abs(steps[-1].q - target).max() < 1e-9
    assert np.abs(steps[-1].velocity).max() < 1e-9
    assert steps[-1].status == "ok"
    assert steps[0].why in ("velocity", "acceleration")
    beyond = (vectors(steps) - target) * np.sign(target - START)
    assert beyond.max() < 0.05


def test_a_smooth_path_is_followed_with_limited_acceleration() -> None:
    """From rest, and with accelerations below the limit, the path is followed exactly."""
    arm = arm_of("zyyzyz_6r")
    t = np.arange(1, 1000)[:, None] * DT
    Q = Q0 + 0.2 * (1.0 - np.cos(t * [1.0, 1.5, 1.0, 2.0, 1.0, 2.0]))
    steps = run(arm.tracker(Q0, DT, acceleration=3.0), arm.fk(Q))
    assert statuses(steps) == {"ok": len(Q)}
    np.testing.assert_allclose(vectors(steps), Q, atol=1e-8)


def test_limits_are_approached_with_braking() -> None:
    """With limited acceleration a joint stops at its limit, not beyond, and brakes no harder than it may."""
    arm = arm_of("zyyzyz_6r")
    Q = np.tile(Q0, (600, 1))
    Q[:, 4] = np.minimum(0.7 + 3.0 * DT * np.arange(600), 3.0)
    tracker = arm.tracker(Q0, DT, acceleration=10.0)
    steps = run(tracker, arm.fk(Q))
    q = np.concatenate([[Q0, Q0], vectors(steps)])
    assert (np.abs(np.diff(q, 2, axis=0)) / DT**2).max() <= 10.0 * (1.0 + 1e-6)


# ------------------------------------------------------------------------------------------------ collision


def test_a_motion_into_an_obstacle_is_held() -> None:
    """An obstacle in the way holds the arm in front of it; when it is moved away, the arm goes on."""
    arm = arm_of("ur5")
    q0 = np.array([0.0, -1.2, 1.4, -0.5, 1.1, 0.0])
    tip = arm.fk(q0)[:3, 3]
    world = urdf_ik.World()
    world.add("wall", urdf_ik.Box((0.02, 2.0, 2.0)), urdf_ik.pose([tip[0] + 0.15, 0.0, 0.0]))
    T = np.repeat(arm.fk(q0)[None], 150, axis=0)
    T[:, 0, 3] += np.linspace(0.0, 0.2, 150)
    tracker = arm.tracker(q0, 0.02, world=world, margin=0.005)
    assert tracker.step(T[0]).status == "ok"
    steps = run(tracker, T)
    assert (steps[-1].status, steps[-1].why) == ("held", "collision")
    assert steps[-1].distance > 0.01
    assert not arm.collision_model.in_world(world).in_collision(steps[-1].q)
    world.remove("wall")
    assert run(tracker, np.repeat(T[-1:], 100, axis=0))[-1].status == "ok"


# ------------------------------------------------------------------------------------------------ the interface


def test_answers_are_copies() -> None:
    """Nothing that a caller does to an answer changes the tracker, or another answer."""
    arm = arm_of("zyyzyz_6r")
    tracker = arm.tracker(Q0, DT)
    step = tracker.step(arm.fk(Q0))
    q = step.q
    q[:] = 9.0
    np.testing.assert_allclose(step.q, Q0, atol=1e-12)
    np.testing.assert_allclose(tracker.q, Q0, atol=1e-12)
    tracker.q[:] = 9.0
    assert tracker.step(arm.fk(Q0)).status == "ok"
    with pytest.raises(TypeError):
        pickle.dumps(tracker)


def test_poses_of_any_kind() -> None:
    """A pinocchio.SE3, a list of rows and an array of another layout are poses."""
    arm = arm_of("zyyzyz_6r")
    T = arm.fk(Q0 + 1e-3)
    for pose in (pin.SE3(T), T.tolist(), np.asfortranarray(T), T.astype(np.float32).astype(np.float64)):
        step = arm.tracker(Q0, DT).step(pose)
        assert step.status == "ok"
        np.testing.assert_allclose(step.q, Q0 + 1e-3, atol=1e-6)


def test_reset_begins_anew() -> None:
    """After a reset the tracker is where it was put, at the speed that it was given."""
    arm = arm_of("zyyzyz_6r")
    tracker = arm.tracker(Q0, DT)
    tracker.step(arm.fk(Q0 + 0.001))
    tracker.reset(Q0 + 0.1, velocity=np.full(6, 0.01))
    np.testing.assert_array_equal(tracker.q, Q0 + 0.1)
    np.testing.assert_array_equal(tracker.velocity, np.full(6, 0.01))
    assert tracker.step(arm.fk(Q0 + 0.1)).status == "ok"


def test_threads_with_a_tracker_each() -> None:
    """Trackers in several threads at once answer as they do one after the other."""
    arm = arm_of("zyyzyz_6r")
    paths = [path(arm, seed, cycles=300) for seed in range(6)]

    def follow(Q: Array) -> Array:
        return vectors(run(arm.tracker(Q[0], DT), arm.fk(Q)))

    with ThreadPoolExecutor(3) as pool:
        for together, alone in zip(pool.map(follow, paths), map(follow, paths), strict=True):
            np.testing.assert_array_equal(together, alone)


def test_velocity_limits_come_from_the_urdf() -> None:
    """Left out, the limits are those that the URDF states; one number is for all joints."""
    case = from_catalogue("ur5")
    stated = {joint.name: joint.velocity for joint in case.arm.model.joints}
    tracker = case.arm.tracker(np.zeros(6), DT)
    np.testing.assert_array_equal(tracker.velocity_limits, [stated[name] for name in case.arm.joint_names])
    np.testing.assert_array_equal(case.arm.tracker(np.zeros(6), DT, velocity=0.5).velocity_limits, np.full(6, 0.5))


@pytest.mark.parametrize("dt", [0.0, -0.1, math.nan, math.inf, "fast", None])
def test_a_cycle_has_a_length(dt: object) -> None:
    """A cycle of no length, or of none that is a number, is refused in words."""
    with pytest.raises(ArgumentError, match="dt="):
        arm_of("zyyzyz_6r").tracker(Q0, dt)  # type: ignore[arg-type]


def test_a_start_that_does_not_fit_is_refused() -> None:
    """A start of another size, not finite, or outside the limits."""
    arm = arm_of("zyyzyz_6r")
    for bad, words in (
        (Q0[:5], "6"),
        (np.stack([Q0, Q0]), "one joint vector"),
        (Q0 * np.nan, "finite"),
        (Q0 + [0, 0, 0, 0, 5, 0], "'joint_5' is at 5.7, outside"),
    ):
        with pytest.raises(JointVectorError, match=words):
            arm.tracker(bad, DT)


def test_limits_that_make_no_sense_are_refused() -> None:
    """Speeds of zero, below it, not a number, or too few of them; rates and margins below zero."""
    arm = arm_of("zyyzyz_6r")
    for bad in (0.0, -1.0, math.nan, [1.0, 2.0], "fast"):
        with pytest.raises(VelocityError, match="velocity"):
            arm.tracker(Q0, DT, velocity=bad)
        with pytest.raises(VelocityError, match="acceleration"):
            arm.tracker(Q0, DT, acceleration=bad)
    with pytest.raises(ArgumentError, match="recentring"):
        arm.tracker(Q0, DT, recentring=-1.0)
    with pytest.raises(ArgumentError, match="margin"):
        arm.tracker(Q0, DT, margin=-1.0)


def test_what_is_no_pose_is_refused_and_moves_nothing() -> None:
    """NaN, a reflection, a batch, words: PoseError, and the tracker stands where it stood."""
    arm = arm_of("zyyzyz_6r")
    tracker = arm.tracker(Q0, DT)
    tracker.step(arm.fk(Q0))
    q = tracker.q
    for bad in (
        np.full((4, 4), np.nan),
        np.diag([1.0, 1.0, -1.0, 1.0]),
        np.eye(3),
        np.stack([np.eye(4)] * 2),
        "pose",
        None,
    ):
        with pytest.raises(PoseError):
            tracker.step(bad)
        np.testing.assert_array_equal(tracker.q, q)
    assert tracker.step(arm.fk(Q0)).status == "ok"


def test_arms_that_are_not_tracked_say_why() -> None:
    """Joints that mimic others, and more than seven joints."""
    arm = urdf_ik.load(linkage("any axes", 0), base="base", tip="tool")
    with pytest.raises(UnsupportedArm, match="mimic"):
        arm.tracker(np.zeros(arm.dof), DT)


def test_a_tracker_names_its_arm() -> None:
    """What a notebook shows of it."""
    assert repr(arm_of("zyyzyz_6r").tracker(Q0, 0.01)) == "<Tracker of 'zyyzyz_6r': 100 cycles a second>"
