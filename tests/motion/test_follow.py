"""Paths followed: all branches and turns, no jump, proven between the waypoints, and what stops a path."""

from __future__ import annotations

import re

import arms
import arms_closed_forms
import arms_general
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


def smooth(arm: urdf_ik.Arm, rng: np.random.Generator, size: float = 0.15) -> np.ndarray:
    """Joint vectors (600, n) of a smooth motion inside the limits, dense enough to keep to straight segments."""
    low, high = np.clip(arm.limits.T, -2.8, 2.8)
    middle = rng.uniform(low + 0.25 * (high - low), high - 0.25 * (high - low))
    s = np.linspace(0.0, np.pi, 600)[:, None]
    return np.clip(middle + rng.normal(size=arm.dof) * size * np.sin(s + rng.uniform(0.0, 6.0, arm.dof)), low, high)


def singularity(arm: urdf_ik.Arm, q: np.ndarray, rng: np.random.Generator) -> np.ndarray | None:
    """A singular joint vector (n,) on the motion q (m, n), to the last digit; None where it meets none."""

    def determinant(q: np.ndarray) -> float:
        return float(np.linalg.det(arm.jacobian(q)))

    values = np.linalg.det(arm.jacobian(q))
    crossed = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    if not len(crossed):
        return None
    k = rng.choice(crossed)
    a, b = q[k], q[k + 1]
    for _ in range(80):
        middle = 0.5 * (a + b)
        a, b = (middle, b) if (determinant(middle) < 0.0) == (values[k] < 0.0) else (a, middle)
    return np.asarray(a)


def described(kind: str, seed: int) -> urdf_ik.Arm:
    """A random member of a family of the tests, or one of their other arms."""
    if kind in arms.KINDS:
        arm = arms.random_arm(kind, seed, orthogonal=seed % 3 == 1, aligned=seed % 3 == 2)
    elif kind in arms_closed_forms.KINDS:
        arm = arms.random_arm(kind, seed, kinds=arms_closed_forms.KINDS, orthogonal=seed % 3 == 1)
    elif kind == "imperfect":
        arm = arms_general.near_member(list(arms.KINDS)[seed % len(arms.KINDS)], (1e-3, 1e-5, 1e-8)[seed % 3], seed)
    else:
        arm = arms_general.unstructured(seed)
    return urdf_ik.load(arm.urdf, base="base", tip="tool")


ALL_KINDS = (*arms.KINDS, *arms_closed_forms.KINDS, "general", "imperfect")


def cost_of(q: np.ndarray) -> float:
    """Sum of squares of the steps between joint vectors (m, n)."""
    return float((np.diff(q, axis=0) ** 2).sum())


@pytest.mark.parametrize("kind", ALL_KINDS)
def test_members_of_every_family_follow_a_moved_joint_path(kind: str) -> None:
    """Members of every family follow a moved joint path, and find none that costs more."""
    for seed in range(2):
        arm = described(kind, seed)
        q = smooth(arm, np.random.default_rng(seed))[::5]
        plan = arm.follow(arm.fk(q), collisions=False)
        assert plan.found, (seed, plan.explain())
        assert plan.cost <= cost_of(q) * (1.0 + 1e-6)


@pytest.mark.parametrize("kind", ALL_KINDS)
def test_a_singularity_of_every_family_is_crossed(kind: str) -> None:
    """A motion through a singularity, exactly at a waypoint and 1e-9 to 1e-3 beside it."""
    rng = np.random.default_rng(len(kind))
    crossed = 0
    for seed in range(12):
        arm = described(kind, seed)
        q = smooth(arm, rng, size=0.4)
        singular = singularity(arm, q, rng)
        if singular is None:
            continue
        crossed += 1
        direction = q[-1] - q[0]
        direction *= 0.1 / np.abs(direction).max()
        for beside in (0.0, 10.0 ** rng.uniform(-9.0, -3.0)):
            aside = rng.normal(size=arm.dof)
            way = singular + np.linspace(-1.0, 1.0, 81)[:, None] * direction + beside * aside / np.linalg.norm(aside)
            if (way < arm.limits[:, 0]).any() or (way > arm.limits[:, 1]).any():
                continue
            plan = arm.follow(arm.fk(way), collisions=False)
            assert plan.found, (seed, beside, plan.explain())
            assert plan.cost <= cost_of(way) * (1.0 + 1e-5), (seed, beside)
        if crossed == 2:
            break
    assert crossed


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


@pytest.mark.parametrize("bend", [0.0, 1e-8, 1e-6, 1e-4])
def test_along_a_fold(bend: float) -> None:
    """The elbow stays straight to within the bend while the other joints move; it may wave from side to side."""
    arm = urdf_ik.load("zyyzyz_6r")
    for waves in (0, 3):
        s = np.linspace(0.0, 1.0, 81)[:, None]
        q = np.array([0.3, 0.4, 0.0, 0.5, 0.8, -0.3]) + s * np.array([0.3, -0.2, 0.0, 0.1, 0.2, 0.1])
        q[:, 2] = bend * np.cos(waves * np.pi * s[:, 0])
        plan = arm.follow(arm.fk(q), collisions=False)
        check(arm, plan)
        # Where two solutions are one to within their resolution, the plan may pass through either.
        assert plan.cost <= cost_of(q) * (1.0 + 1e-5)


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


@pytest.mark.parametrize("kind", ["wrist, 2||3", "2||3||4, 1x2, 5x6", "general", "imperfect"])
def test_each_branch_is_stopped_where_its_limit_is(kind: str) -> None:
    """The first joint turns the whole way and more: each branch ends where its own would leave the limits."""
    arm = described(kind, 2)
    low, high = arm.limits[0]
    low, high = (low, high) if np.isfinite(high - low) else (-3.0, 3.0)
    q = np.tile(smooth(arm, np.random.default_rng(1))[0], (int((high - low + 1.0) / 0.03), 1))
    turned = 0.03 * np.arange(len(q))
    q[:, 0] = q[0, 0] + turned
    plan = arm.follow(arm.fk(q), collisions=False)
    if not np.isfinite(arm.limits[0]).all():
        assert plan.found
        return
    assert not plan.found
    begins: dict[str, int] = {}
    for solution in arm.ik(arm.fk(q[0])).within_limits():
        images = solution.q[0] + 2.0 * np.pi * np.arange(-3, 4)
        inside = images[(images >= low - 1e-9) & (images <= high + 1e-9)]
        begins[solution.branch] = int((inside.min() + turned <= high + 1e-9).sum())
    own = {stop.branch: stop for stop in plan.stops if stop.branch != "every branch"}
    assert {name: stop.waypoint for name, stop in own.items()} == begins
    assert all(stop.cause == "limit" and arm.joint_names[0] in stop.reason for stop in own.values())


@pytest.mark.parametrize("kind", ["wrist, general", "2||3||4", "general", "imperfect"])
def test_one_waypoint_out_of_reach_is_named(kind: str) -> None:
    """One waypoint out of reach, those before and after it well inside."""
    arm = described(kind, 1)
    T = arm.fk(smooth(arm, np.random.default_rng(4))[::10])
    T[37, :3, 3] += [4.0 * arm.chain.size, 0.0, 0.0]
    plan = arm.follow(T, collisions=False)
    assert not plan.found
    assert (plan.stops[0].branch, plan.stops[0].waypoint, plan.stops[0].cause) == ("every branch", 37, "reach")


def test_contact_is_named_for_every_branch_that_meets_it_first() -> None:
    """Each branch's explanation names the first contact on its way, although other branches are cheaper."""
    arm = urdf_ik.load("zyyzyz_6r")
    T = arm.fk(joint_path(arm, 30, 4, size=0.2))
    free = arm.follow(T, collisions=False)
    world = urdf_ik.World()
    world.add("crate", urdf_ik.Box((0.3, 0.3, 0.3)), T[18])
    model = arm.collision_model.in_world(world)
    stops = {stop.branch: stop for stop in arm.follow(T, world=world).stops}
    for other in free.alternatives:
        if len(set(other.branches)) > 1:
            continue
        stop = stops[other.branches[0]]
        assert stop.cause == "contact"
        assert stop.waypoint == np.flatnonzero(model.in_collision(other.q))[0]
        assert "crate" in stop.reason


# FANUC's CRX-10iA/L as the code that comes with Elias and Wen, "Path planning and optimization for cuspidal 6R
# manipulators" (2025, rpiRobotics/cuspidal-path-planning) describes it: axes z x x y x y, 0.71, 0.54 and 0.15 m, joints
# without limits.
CRX_START = (2.0323, 1.2241, -1.1492, 2.8288, -2.9252, -0.3849)
CRX_END = (-2.6111, -0.6297, -1.5088, 1.8854, -0.4309, 2.5802)


def test_the_published_cuspidal_line() -> None:
    """Twelve solutions at the start, four at the end; four of the start branches lead there, as is published.

    The eight others end in pairs where two solutions merge and are gone: four of them at each of two folds.
    """
    x, y, z = np.eye(3)
    steps = np.array([0 * z, 0 * z, 0.71 * z, 0 * z, 0.54 * y + 0.15 * x, 0 * z])
    points = np.cumsum(steps, axis=0)
    text = arms_general.from_screws("crx", "general", np.array([z, x, x, y, x, y]), points, points[-1]).urdf
    text = re.sub(r"<limit[^>]*/>", "", text.replace('type="revolute"', 'type="continuous"'))
    arm = urdf_ik.load(text, base="base", tip="tool")
    T = urdf_ik.line(arm.fk(CRX_START), arm.fk(CRX_END), 500)
    assert arm.ik(T[[0, -1]]).valid.sum(axis=1).tolist() == [12, 4]
    plan = arm.follow(T, collisions=False)
    check(arm, plan)
    ends = {other.branches[-1] for other in plan.alternatives}
    assert ends == set(arm.structure.branches[:4])
    leading = {k: len(arm.follow(T[:k], collisions=False).alternatives) for k in (206, 207, 365, 366, 500)}
    assert leading == {206: 12, 207: 8, 365: 8, 366: 4, 500: 4}
    stopped = arm.follow(T, start=CRX_START, collisions=False)
    assert (stopped.stops[0].waypoint, stopped.stops[0].cause) == (206, "jump")
    assert "its solutions end here" in stopped.explain()


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
