"""Paths followed: all branches and turns, no jump, proven between the waypoints, and what stops a path."""

from __future__ import annotations

import numpy as np
import pytest
from lxml import etree

import urdf_ik
from urdf_ik.angles import TURN
from urdf_ik.motion.plan import Plan

SIX = ("zyyzyz_6r", "ur5", "puma_560", "dh_6r", "z1")
SEVEN = ("panda", "srs_7r")


def joint_path(arm: urdf_ik.Arm, m: int, seed: int, size: float = 0.3) -> np.ndarray:
    """A smooth joint motion inside the limits, (m, n)."""
    rng = np.random.default_rng(seed)
    low, high = np.clip(arm.limits.T, -2.5, 2.5)
    middle = rng.uniform(low + 0.25 * (high - low), high - 0.25 * (high - low))
    s = np.linspace(0.0, np.pi, m)[:, None]
    waves = sum(rng.normal(size=arm.dof) * size * np.sin((k + 1) * s + rng.uniform(0, 6)) for k in range(2))
    return np.clip(middle + waves, low, high)


def between(arm: urdf_ik.Arm, plan: Plan) -> float:
    """How far the tip strays from the straight segments while the joints move linearly, m."""
    s = np.linspace(0.1, 0.9, 5)[:, None]
    before = np.floor(plan.place[:-1] + 1e-9).astype(int)
    a, b = plan.poses[before, None, :3, 3], plan.poses[np.minimum(before + 1, len(plan.poses) - 1), None, :3, 3]
    p = arm.fk((1.0 - s) * plan.motion[:-1, None] + s * plan.motion[1:, None])[..., :3, 3]
    way = b - a
    share = ((p - a) * way).sum(axis=-1, keepdims=True) / np.maximum((way * way).sum(axis=-1, keepdims=True), 1e-300)
    return float(np.linalg.norm(p - a - np.clip(share, 0.0, 1.0) * way, axis=-1).max(initial=0.0))


def check(arm: urdf_ik.Arm, plan: Plan) -> None:
    """What every plan that was found keeps to."""
    assert plan.found, plan.explain()
    reference = urdf_ik.reference.Reference(arm.model, arm.base, arm.tip)
    assert np.abs(reference.pose(plan.q) - plan.poses).max() < 1e-8
    low, high = arm.limits.T
    assert (plan.q >= low - 1e-9).all()
    assert (plan.q <= high + 1e-9).all()
    assert between(arm, plan) < plan.tolerance[0] <= 4e-3
    whole = plan.place == np.round(plan.place)
    assert np.array_equal(plan.motion[whole], plan.q)


@pytest.mark.parametrize("name", SIX)
@pytest.mark.parametrize("seed", range(4))
def test_a_moved_joint_path_is_found_and_costs_no_more(name: str, seed: int) -> None:
    """A moved joint path is found and costs no more."""
    arm = urdf_ik.load(name)
    q = joint_path(arm, 60, seed)
    plan = arm.follow(arm.fk(q), collisions=False)
    check(arm, plan)
    assert plan.cost <= (np.diff(q, axis=0) ** 2).sum() * (1.0 + 1e-6)


@pytest.mark.parametrize("cost", ["l1", "l2", "max"])
def test_the_cost_is_what_was_asked_for(cost: str) -> None:
    """The cost is what was asked for."""
    arm = urdf_ik.load("ur5")
    plan = arm.follow(arm.fk(joint_path(arm, 40, 3)), cost=cost, collisions=False)
    steps = np.abs(np.diff(plan.q, axis=0))
    total = {"l1": steps.sum(), "l2": (steps**2).sum(), "max": steps.max(axis=1).sum()}[cost]
    assert plan.cost == pytest.approx(total, rel=1e-9)


def test_time_at_the_velocity_limits_is_a_cost() -> None:
    """Time at the velocity limits is a cost."""
    arm = urdf_ik.load("ur5")
    limits = {joint.name: joint.velocity for joint in arm.model.joints}
    v = np.array([limits[name] for name in arm.joint_names])
    plan = arm.follow(arm.fk(joint_path(arm, 40, 3)), cost="time", collisions=False)
    assert plan.cost == pytest.approx((np.abs(np.diff(plan.q, axis=0)) / v).max(axis=1).sum(), rel=1e-9)


@pytest.mark.parametrize("name", SEVEN)
@pytest.mark.parametrize("seed", range(2))
def test_seven_joints_follow_a_moved_joint_path(name: str, seed: int) -> None:
    """Seven joints follow a moved joint path."""
    arm = urdf_ik.load(name)
    q = joint_path(arm, 60, seed)
    plan = arm.follow(arm.fk(q), collisions=False)
    check(arm, plan)
    assert plan.cost <= 1.5 * (np.diff(q, axis=0) ** 2).sum()


def test_through_the_wrist_singularity() -> None:
    """Joint 5 passes zero: the wrist changes its branch, and joints 4 and 6 need not turn."""
    arm = urdf_ik.load("puma_560")
    q = np.tile([0.2, -0.6, 0.4, 0.3, 0.0, 0.5], (41, 1))
    q[:, 4] = np.linspace(-0.4, 0.4, 41)  # the middle waypoint is singular exactly
    q[:, 0] += np.linspace(0.0, 0.2, 41)
    plan = arm.follow(arm.fk(q), collisions=False)
    check(arm, plan)
    assert plan.cost <= (np.diff(q, axis=0) ** 2).sum() * (1.0 + 1e-6)
    assert len(set(plan.branches)) > 1


def test_along_the_wrist_singularity() -> None:
    """Joint 5 stays at zero: each pose leaves joint 4 free, and its representative is carried along the path."""
    arm = urdf_ik.load("puma_560")
    q = np.tile([0.2, -0.6, 0.4, 0.7, 0.0, 0.5], (21, 1))
    q[:, 0] += np.linspace(0.0, 0.3, 21)
    plan = arm.follow(arm.fk(q), start=q[0], collisions=False)
    check(arm, plan)
    assert np.array_equal(plan.q[0], q[0])
    assert np.abs(np.diff(plan.q, axis=0)).max() < 0.05


def test_along_the_edge_of_reach() -> None:
    """The elbow stretches to within 1e-4 rad and bends again, on the same side and on the other."""
    arm = urdf_ik.load("zyyzyz_6r")
    base = np.array([0.3, 0.4, 0.0, 0.5, 0.8, -0.3])
    for other_side in (False, True):
        q = np.tile(base, (61, 1))
        bend = np.linspace(-0.5, 0.5, 61)
        q[:, 2] = 1e-4 + (bend if other_side else np.abs(bend))
        plan = arm.follow(arm.fk(q), collisions=False)
        check(arm, plan)
        assert plan.cost <= (np.diff(q, axis=0) ** 2).sum() * (1.0 + 1e-6)


def test_across_half_a_turn() -> None:
    """Joints pass pi without a jump where their limits allow it."""
    arm = urdf_ik.load("ur5")
    q = np.tile([3.0, -1.2, 1.1, 3.0, 1.2, -3.0], (41, 1)) + np.linspace(0.0, 0.6, 41)[:, None] * [1, 0, 0, 1, 0, -1]
    plan = arm.follow(arm.fk(q), start=q[0], end=q[-1], collisions=False)
    check(arm, plan)
    assert np.abs(plan.q - q).max() < 1e-6


def test_turns_that_run_into_a_limit() -> None:
    """The last joint turns once and a half: only one of its images has room for that."""
    arm = urdf_ik.load("ur5")
    q = np.tile([0.4, -1.2, 1.1, 0.3, 1.2, 0.0], (181, 1))
    q[:, 5] = np.linspace(-1.0, -1.0 + 3.0 * np.pi, 181) - 4.0
    assert abs(q[:, 5]).max() < 2.0 * np.pi
    plan = arm.follow(arm.fk(q), collisions=False)
    check(arm, plan)
    turned = plan.q[-1, 5] - plan.q[0, 5]
    assert turned == pytest.approx(3.0 * np.pi, abs=1e-6)
    with_room = q.copy()
    with_room[:, 5] = np.linspace(-1.0, -1.0 + 4.2 * np.pi, 181)
    stopped = arm.follow(arm.fk(with_room), collisions=False)
    assert not stopped.found
    assert arm.joint_names[5] in stopped.explain()
    assert "360" in stopped.explain()


@pytest.mark.parametrize(
    ("turns", "given", "found"), [(8.0, False, True), (4.0, True, True), (8.0, True, False), (12.0, False, False)]
)
def test_limits_of_many_turns(turns: float, given: bool, found: bool) -> None:
    """A joint with 10.4 turns inside its limits is wound no further, nor from another turn than the start's."""
    model = etree.fromstring(urdf_ik.load("zyyzyz_6r").model.xml)
    (limit,) = model.xpath("joint[@name='joint_6']/limit")
    limit.set("lower", str(-5.2 * TURN))
    limit.set("upper", str(5.2 * TURN))
    arm = urdf_ik.load(etree.tostring(model).decode())
    q = np.tile([0.5, -0.7, -1.4, -1.8, 0.8, 1.6], (int(24 * turns), 1))
    q[:, 5] += np.linspace(0.0, turns * TURN, len(q))
    plan = arm.follow(arm.fk(q), start=q[0] if given else None, collisions=False)
    assert plan.found == found
    if not found:
        assert "joint_6 turns" in plan.explain()
        assert "limits" in plan.explain()
        return
    check(arm, plan)
    assert not given or np.array_equal(plan.q[0], q[0])
    for other in plan.alternatives:
        check(arm, other)


def test_coarse_waypoints_are_refined() -> None:
    """Coarse waypoints are refined."""
    arm = urdf_ik.load("ur5")
    T0 = arm.fk([0.3, -1.2, 1.4, -0.4, 1.2, 0.5])
    T1 = T0.copy()
    T1[:3, 3] += [-0.3, 0.3, 0.1]
    plan = arm.follow(urdf_ik.line(T0, T1, 5), collisions=False)
    check(arm, plan)
    assert len(plan.q) == 5
    assert len(plan.motion) > 5
    assert (np.diff(plan.place) > 0.0).all()


def test_a_start_and_an_end_are_kept() -> None:
    """A start and an end are kept."""
    arm = urdf_ik.load("zyyzyz_6r")
    q = joint_path(arm, 30, 5)
    T = arm.fk(q)
    for solution in arm.ik(T[0]).within_limits():
        plan = arm.follow(T, start=solution.q, collisions=False)
        assert not plan.found or np.array_equal(plan.q[0], solution.q)
    plan = arm.follow(T, end=q[-1], collisions=False)
    check(arm, plan)
    assert np.array_equal(plan.q[-1], q[-1])


def test_alternatives_are_the_best_from_each_branch() -> None:
    """Alternatives are the best from each branch."""
    arm = urdf_ik.load("ur5")
    plan = arm.follow(arm.fk(joint_path(arm, 30, 1, size=0.1)), collisions=False)
    assert plan.alternatives[0].cost == plan.cost
    starts = [each.branches[0] for each in plan.alternatives]
    assert len(set(starts)) == len(starts) > 1
    for each in plan.alternatives:
        check(arm, each)
        assert each.cost >= plan.cost


def test_a_waypoint_out_of_reach_is_named() -> None:
    """A waypoint out of reach is named."""
    arm = urdf_ik.load("ur5")
    T = arm.fk(joint_path(arm, 40, 1, size=0.1))
    T[23:, :3, 3] += [3.0, 0.0, 0.0]
    plan = arm.follow(T, collisions=False)
    assert not plan.found
    assert len(plan.q) == 0
    assert (plan.stops[0].branch, plan.stops[0].waypoint, plan.stops[0].cause) == ("every branch", 23, "reach")
    assert {stop.waypoint for stop in plan.stops} == {23}
    assert "reach" in plan.explain()


def test_a_limit_in_the_way_of_every_branch_is_named() -> None:
    """A limit in the way of every branch is named."""
    arm = urdf_ik.load("puma_560")
    q = np.tile([0.0, -0.6, 0.4, 0.3, 0.8, 0.5], (81, 1))
    low, high = arm.limits[0]
    q[:, 0] = np.linspace(0.0, high + 0.3, 81)
    plan = arm.follow(arm.fk(q), collisions=False)
    assert not plan.found
    own = [stop for stop in plan.stops if stop.cause == "limit"]
    assert own
    assert any(arm.joint_names[0] in stop.reason for stop in own)
    first_outside = int(np.argmax(q[:, 0] > high))
    assert first_outside in {stop.waypoint for stop in own}


def test_a_box_across_the_path_is_named() -> None:
    """A box across the path is named."""
    arm = urdf_ik.load("zyyzyz_6r")
    q = joint_path(arm, 30, 4, size=0.2)
    T = arm.fk(q)
    if not arm.collision_model.has_geometry:
        pytest.fail("the bundled arm has collision shapes")
    world = urdf_ik.World()
    world.add("crate", urdf_ik.Box((0.3, 0.3, 0.3)), T[18])
    plan = arm.follow(T, world=world)
    assert not plan.found
    assert any(stop.cause == "contact" and "crate" in stop.reason for stop in plan.stops)


def test_reconfigurations_are_as_few_as_possible() -> None:
    """The last joint would have to turn beyond its limits: one change of turn is enough."""
    arm = urdf_ik.load("ur5")
    q = np.tile([0.4, -1.2, 1.1, 0.3, 1.2, 0.0], (181, 1))
    q[:, 5] = np.linspace(-6.0, -6.0 + 4.5 * np.pi, 181)
    plan = arm.follow(arm.fk(q), reconfigure=True, collisions=False)
    assert plan.found
    assert len(plan.changes) == 1
    change = plan.changes[0]
    assert 0 < change.waypoint < 181
    assert np.abs(np.diff(plan.q, axis=0)).max(axis=1).argmax() == change.waypoint - 1


def test_no_step_is_larger_than_allowed() -> None:
    """No step is larger than allowed."""
    arm = urdf_ik.load("ur5")
    q = joint_path(arm, 40, 6)
    most = np.abs(np.diff(q, axis=0)).max(axis=0) * 1.01
    plan = arm.follow(arm.fk(q), max_step=most, collisions=False)
    check(arm, plan)
    assert (np.abs(np.diff(plan.q, axis=0)) <= most * (1.0 + 1e-6)).all()
    assert not arm.follow(arm.fk(q), max_step=most / 50.0, collisions=False).found


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"start": [0.0] * 6}, "start is no solution of waypoint 0"),
        ({"cost": "cheap"}, "'l1', 'l2', 'max', 'time'"),
        ({"max_step": -1.0}, "max_step is -1.0"),
        ({"margin": -0.1}, "margin of -0.1"),
        ({"weights": [1.0, 2.0]}, "weights is"),
        ({"tolerance": 0.0}, "tolerance is 0.0"),
        ({"margins": np.nan}, "margins=nan"),
    ],
)
def test_settings_that_make_no_sense(options: dict[str, object], words: str) -> None:
    """Settings that make no sense."""
    arm = urdf_ik.load("zyyzyz_6r")
    T = arm.fk(joint_path(arm, 5, 0))
    with pytest.raises(urdf_ik.PathError, match=words.replace("(", r"\(")):
        arm.follow(T, **options)


def test_waypoints_that_make_no_sense() -> None:
    """Waypoints that make no sense."""
    arm = urdf_ik.load("zyyzyz_6r")
    T = arm.fk(joint_path(arm, 5, 0))
    with pytest.raises(urdf_ik.PathError, match="no waypoint"):
        arm.follow(T[:0])
    with pytest.raises(urdf_ik.PathError, match="shape"):
        arm.follow(T[None])
    T[3, 0, 3] = np.nan
    with pytest.raises(urdf_ik.PoseError, match="3"):
        arm.follow(T)
    outside = arm.fk([9.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    if (np.abs(arm.limits) < 9.0).all():
        with pytest.raises(urdf_ik.PathError, match="outside the limits"):
            arm.follow(outside[None], start=[9.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_a_single_waypoint_is_a_path() -> None:
    """A single waypoint is a path."""
    arm = urdf_ik.load("zyyzyz_6r")
    plan = arm.follow(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]), collisions=False)
    assert plan.found
    assert plan.cost == 0.0
    assert len(plan.alternatives) > 1
