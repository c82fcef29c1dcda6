"""Paths followed: all branches and turns, no jump, proven between the waypoints."""

import re

import numpy as np
import pytest
from lxml import etree
from paths import ALL_KINDS, check, cost_of, described, distance_to_box, joint_path, smooth

import urdf_ik
from urdf_ik.errors import UrdfError
from urdf_ik.model import catalogue
from urdf_ik.support.angles import TURN

SIX = ("zyyzyz_6r", "ur5", "puma_560", "dh_6r", "z1")


@pytest.mark.parametrize("name", SIX)
@pytest.mark.parametrize("seed", range(4))
def test_a_moved_joint_path_is_found_and_costs_no_more(name: str, seed: int) -> None:
    """The tip's path of a joint motion inside the limits is found, at the motion's cost or less."""
    arm = urdf_ik.load(name)
    q = joint_path(arm, 60, seed)
    plan = arm.follow(arm.fk(q), collisions=False)
    check(arm, plan)
    assert plan.cost <= (np.diff(q, axis=0) ** 2).sum() * (1.0 + 1e-6)


@pytest.mark.parametrize("kind", ALL_KINDS)
def test_members_of_every_family_follow_a_moved_joint_path(kind: str) -> None:
    """On members of every family the tip's path of a joint motion is found, at the motion's cost or less."""
    for seed in range(2):
        arm = described(kind, seed)
        q = smooth(arm, np.random.default_rng(seed))[::5]
        plan = arm.follow(arm.fk(q), collisions=False)
        assert plan.found, (seed, plan.explain())
        assert plan.cost <= cost_of(q) * (1.0 + 1e-6)


@pytest.mark.parametrize("cost", ["l1", "l2", "max", "time"])
def test_the_cost_is_what_was_asked_for(cost: str) -> None:
    """A plan's cost is the sum of its steps' lengths in the given metric; of time, at the URDF's velocity limits."""
    arm = urdf_ik.load("ur5")
    plan = arm.follow(arm.fk(joint_path(arm, 40, 3)), cost=cost, collisions=False)
    steps = np.abs(np.diff(plan.q, axis=0))
    limits = {joint.name: joint.velocity for joint in arm.model.joints}
    seconds = steps / [limits[name] for name in arm.joint_names]
    totals = {"l1": steps, "l2": steps**2, "max": steps.max(axis=1), "time": seconds.max(axis=1)}
    assert plan.cost == pytest.approx(totals[cost].sum(), rel=1e-9)


@pytest.mark.parametrize(
    ("name", "seed", "share"), [("panda", 0, 0.835), ("panda", 1, 0.911), ("srs_7r", 0, 0.895), ("srs_7r", 1, 1.052)]
)
def test_seven_joints_follow_a_moved_joint_path(name: str, seed: int, share: float) -> None:
    """The tip's path of a seven-joint motion is found, at the measured share of the motion's cost plus 3 %."""
    arm = urdf_ik.load(name)
    q = joint_path(arm, 60, seed)
    plan = arm.follow(arm.fk(q), collisions=False)
    check(arm, plan)
    assert plan.cost <= 1.03 * share * (np.diff(q, axis=0) ** 2).sum()


@pytest.mark.parametrize(
    ("turns", "given", "found"), [(8.0, False, True), (4.0, True, True), (8.0, True, False), (12.0, False, False)]
)
def test_zyyzyz_limits_of_10_turns_are_kept(turns: float, given: bool, found: bool) -> None:
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
    """Five waypoints of a line keep their places; the plan's motion has places between them."""
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
    """A plan begins at the given start, and ends at the given end, to the last bit."""
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
    """Alternatives start on different branches; none is cheaper than the plan."""
    arm = urdf_ik.load("ur5")
    plan = arm.follow(arm.fk(joint_path(arm, 30, 1, size=0.1)), collisions=False)
    assert plan.alternatives[0].cost == plan.cost
    starts = [each.branches[0] for each in plan.alternatives]
    assert len(set(starts)) == len(starts) > 1
    for each in plan.alternatives:
        check(arm, each)
        assert each.cost >= plan.cost


@pytest.mark.parametrize(("seed", "waypoint"), [(0, 15), (1, 15), (3, 25)])
def test_an_obstacle_is_gone_round_by_another_branch(seed: int, waypoint: int) -> None:
    """A box at the elbow of the cheapest plan: the other plan stays clear of it, on other branches."""
    arm = urdf_ik.load("zyyzyz_6r")
    T = arm.fk(joint_path(arm, 30, seed, size=0.15))
    free = arm.follow(T)
    elbow, size = arm.link_poses(free.q[waypoint])["link_3"], 0.12
    assert distance_to_box(arm, size, elbow, free.motion) < 0.0
    world = urdf_ik.World()
    world.add("box", urdf_ik.Box((size, size, size)), elbow)
    plan = arm.follow(T, world=world)
    check(arm, plan)
    assert distance_to_box(arm, size, elbow, plan.motion) > 0.0
    assert plan.cost > 1.02 * free.cost
    assert set(plan.branches).isdisjoint(free.branches)


def test_ur5_last_joint_beyond_its_limits_reconfigures_once() -> None:
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
    """No joint steps farther than ``max_step``; no plan is found where that is too short for the waypoints."""
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
        ({"weights": [1.0, 2.0]}, "weights is"),
        ({"tolerance": 0.0}, "tolerance is 0.0"),
    ],
)
def test_settings_that_make_no_sense(options: dict[str, object], words: str) -> None:
    """An invalid setting raises ArgumentError that names it and its valid values."""
    arm = urdf_ik.load("zyyzyz_6r")
    T = arm.fk(joint_path(arm, 5, 0))
    with pytest.raises(urdf_ik.ArgumentError, match=words):
        arm.follow(T, **options)


def test_waypoints_that_make_no_sense() -> None:
    """NaN in a waypoint and a start outside the limits are refused."""
    arm = urdf_ik.load("zyyzyz_6r")
    T = arm.fk(joint_path(arm, 5, 0))
    T[3, 0, 3] = np.nan
    with pytest.raises(urdf_ik.PoseError, match="3"):
        arm.follow(T)
    outside = [9.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    with pytest.raises(urdf_ik.ArgumentError, match="outside the limits"):
        arm.follow(arm.fk(outside)[None], start=outside)


def test_a_plan_says_that_contacts_were_not_checked() -> None:
    """Missing meshes: one warning, and the plan's text and JSON say so; collisions="require" refuses them."""
    text = etree.tostring(etree.fromstring(catalogue.resolve("zyyzyz_6r").path.read_bytes())).decode()
    box = '<box size="0.5 0.5 0.04"/>'
    assert box in text
    whole = urdf_ik.load("zyyzyz_6r")
    T = urdf_ik.line(*whole.fk([[0.3, -0.5, 0.8, 0.4, 0.7, -0.2], [0.4, -0.5, 0.8, 0.4, 0.7, 0.0]]), 5)
    said = "contacts not checked: 1 mesh missing"
    missing = urdf_ik.load(text.replace(box, '<mesh filename="not_there.stl"/>'))
    with pytest.warns(UserWarning, match=said) as caught:
        plan = missing.follow(T)
    assert plan.found and len(caught) == 1
    for each in (plan, *plan.alternatives):
        assert said in str(each) and "not checked: 1 mesh missing" in each.to_json()
    with pytest.raises(UrdfError, match="not_there"):
        missing.follow(T, collisions="require")
    bare = urdf_ik.load(re.sub("<collision>.*?</collision>", "", text, flags=re.DOTALL)).follow(T)
    assert "contacts not checked: no collision shapes" in repr(bare)
    assert "not checked" not in repr(whole.follow(T, collisions="require"))
