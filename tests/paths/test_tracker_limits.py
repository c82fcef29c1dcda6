"""A tracker keeps the limits of speed, of acceleration and of the joints, and stops before obstacles."""

import numpy as np
import pinocchio as pin
import pytest
from tracking import DT, EXACT, FEW, Q0, START, arm_of, gaps, middle, run, statuses, vectors

import urdf_ik


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


def test_distance_and_angle_to_the_target_are_reported() -> None:
    """``distance`` and ``angle`` are those from the tip to the target."""
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
    for k in range(12 if name in FEW else 60):  # a cycle of few joints towards a target far away takes milliseconds
        reachable = arm.fk(centre + half * rng.uniform(-1.0, 1.0, arm.dof))
        far = urdf_ik.pose(3.0 * rng.normal(size=3), rpy=rng.uniform(-3.0, 3.0, 3))
        targets += [reachable if k % 4 else far] * int(rng.integers(1, 40))
    first, second = (run(arm.tracker(centre, DT, velocity=limits), np.array(targets)) for _ in range(2))
    np.testing.assert_array_equal(vectors(first), vectors(second))
    found = vectors(first)[[step.status == "ok" for step in first]]
    wanted = np.array(targets)[[step.status == "ok" for step in first]]
    assert not len(found) or gaps(name, found, wanted).max() <= EXACT


def test_acceleration_is_limited() -> None:
    """Towards a far target the acceleration keeps its limit, and the arm comes to rest with little overshoot."""
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


def test_a_joint_limit_in_the_way() -> None:
    """The arm stops at a joint's limit, reports it, and continues when the target comes back."""
    arm = arm_of("zyyzyz_6r")
    Q = np.tile(Q0, (1600, 1))
    Q[:1000, 4] = 1.5 + 1.5 * (1.0 - np.abs(np.linspace(-1.0, 1.0, 1000)))
    Q[1000:, 4] = 1.5
    steps = run(arm.tracker(Q[0], DT), arm.fk(Q))
    assert steps[500].why == "limit"
    assert steps[500].q[4] == arm.limits[4, 1]
    np.testing.assert_allclose(steps[-1].q, Q[-1], atol=1e-9)


def test_seven_joints_keep_off_their_limits() -> None:
    """With a recentring rate, seven joints leave the ends of their ranges; with a rate of 0 they do not."""
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


def test_a_motion_into_an_obstacle_is_held() -> None:
    """The arm stops before an obstacle, and continues when the obstacle is removed."""
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
    assert not arm.cell.collisions.in_world(world).in_collision(steps[-1].q)
    world.remove("wall")
    assert run(tracker, np.repeat(T[-1:], 100, axis=0))[-1].status == "ok"
