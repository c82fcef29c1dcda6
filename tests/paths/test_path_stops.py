"""Paths that are not found: out of reach, at a limit or in contact, named with the waypoint, branch by branch."""

import numpy as np
import pytest
from lxml import etree
from paths import described, joint_path, smooth

import urdf_ik
from urdf_ik.support.angles import TURN


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


@pytest.mark.parametrize("room", [0.01, 0.4])
def test_zyyzyz_no_motion_passes_the_gap_of_its_limits(room: float) -> None:
    """The last joint's limits leave a gap of twice ``room`` at half a turn: none of its images crosses the gap."""
    model = etree.fromstring(urdf_ik.load("zyyzyz_6r").model.xml)
    for limit in model.xpath("joint/limit"):
        limit.set("lower", str(-np.pi + room))
        limit.set("upper", str(np.pi - room))
    arm = urdf_ik.load(etree.tostring(model).decode())
    q = np.tile([0.5, -0.7, -1.4, -1.8, 0.8, 1.6], (120, 1))
    q[:, 5] += np.linspace(0.0, TURN, len(q))
    plan = arm.follow(arm.fk(q), collisions=False)
    assert not plan.found
    assert {stop.cause for stop in plan.stops} == {"limit"}
    assert all("joint_6" in stop.reason for stop in plan.stops)


@pytest.mark.parametrize("kind", ["wrist, general", "2||3||4", "general", "imperfect"])
def test_one_waypoint_out_of_reach_is_named(kind: str) -> None:
    """One waypoint out of reach, between others that are inside, is named."""
    arm = described(kind, 1)
    T = arm.fk(smooth(arm, np.random.default_rng(4))[::10])
    T[37, :3, 3] += [4.0 * arm.chain.size, 0.0, 0.0]
    plan = arm.follow(T, collisions=False)
    assert not plan.found
    assert (plan.stops[0].branch, plan.stops[0].waypoint, plan.stops[0].cause) == ("every branch", 37, "reach")


def test_contact_is_named_for_every_branch_that_meets_it_first() -> None:
    """Each branch's stop is the first contact on its way, also where other branches are cheaper."""
    arm = urdf_ik.load("zyyzyz_6r")
    T = arm.fk(joint_path(arm, 30, 4, size=0.2))
    free = arm.follow(T, collisions=False)
    world = urdf_ik.World()
    world.add("crate", urdf_ik.Box((0.3, 0.3, 0.3)), T[18])
    model = arm.cell.collisions.in_world(world)
    plan = arm.follow(T, world=world)
    assert not plan.found
    stops = {stop.branch: stop for stop in plan.stops}
    staying = [other for other in free.alternatives if len(set(other.branches)) == 1]
    assert staying
    for other in staying:
        stop = stops[other.branches[0]]
        assert stop.cause == "contact"
        assert stop.waypoint == np.flatnonzero(model.in_collision(other.q))[0]
        assert "crate" in stop.reason


def _into_a_table(depth: float) -> tuple[np.ndarray, urdf_ik.World]:
    """Waypoints of a tool that dips by a depth below a table's top and rises again, and the table."""
    first = np.eye(4)
    first[:3, :3], first[:3, 3] = np.diag([1.0, -1.0, -1.0]), (0.45, -0.3, 0.25)
    low, last = first.copy(), first.copy()
    low[:3, 3], last[:3, 3] = (0.45, 0.0, -depth), (0.45, 0.3, 0.25)
    world = urdf_ik.World()
    world.add("table", urdf_ik.Box((1.2, 1.2, 0.1)), urdf_ik.pose([0.85, 0.0, -0.05]))
    return np.concatenate([urdf_ik.line(first, low, 20), urdf_ik.line(low, last, 20)]), world


@pytest.mark.parametrize("name", ["zyyzyz_6r", "srs_7r"])
def test_a_closed_waypoint_ends_every_branch(name: str) -> None:
    """Where the plan says that every solution touches, coal agrees at other values; waypoints before it are clear."""
    arm = urdf_ik.load(name)
    arm = arm.with_free_axis("z") if name == "zyyzyz_6r" else arm
    T, world = _into_a_table(0.03)
    plan = arm.follow(T, world=world)
    assert not plan.found
    assert {(stop.branch, stop.cause) for stop in plan.stops} == {("every branch", "contact")}
    at = plan.stops[0].waypoint
    assert 0 < at < 20
    model = arm.cell.collisions.in_world(world)

    def clear(k: int) -> bool:
        solved = arm.ik(T[k], redundancy=np.linspace(-3.1, 3.1, 101)).within_limits()
        return not np.asarray(model.in_collision(solved.q[solved.valid])).all()

    assert clear(0)
    assert not clear(at)


def test_a_path_above_the_table_is_found() -> None:
    """The same path above the table is planned."""
    T, world = _into_a_table(-0.15)
    assert urdf_ik.load("zyyzyz_6r").with_free_axis("z").follow(T, world=world).found
