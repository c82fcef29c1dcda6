"""Paths of arms with seven joints: narrow windows, obstacles, given ends, the least sum of squares."""

import numpy as np
import pytest
from paths import check, distance_to_box, joint_path

import urdf_ik


def narrow_path(arm: urdf_ik.Arm, seed: int, room: float = 4e-3) -> tuple[np.ndarray, np.ndarray]:
    """A joint path (m, 7) with two joints near limits, one on each side of the self-motion."""
    rng = np.random.default_rng(seed)
    low, high = arm.limits.T
    while True:
        q = rng.uniform(low + 0.3 * (high - low), high - 0.3 * (high - low))
        a, b = rng.choice(7, 2, replace=False)
        q[a], q[b] = high[a] - room, low[b] + room
        idle = np.linalg.svd(arm.jacobian(q))[2][-1]
        # Both joints move the same way with a speed that counts, and the others are well inside.
        if idle[a] * idle[b] > 0.05 and np.linalg.svd(arm.jacobian(q))[1][5] > 0.05:
            break
    move = np.linalg.pinv(arm.jacobian(q)) @ np.array([0.01, 0.005, -0.01, 0.0, 0.0, 0.0])
    path = q + np.linspace(0.0, 0.1, 6)[:, None] * move
    return path, arm.fk(path)


@pytest.mark.parametrize("seed", range(4))
def test_a_window_narrower_than_the_grid_is_found(seed: int) -> None:
    """Near two joint limits the parameter may vary by less than a step of the first grid; the plan is found."""
    arm = urdf_ik.load("panda")
    _, T = narrow_path(arm, seed)
    check(arm, arm.follow(T, collisions=False))


@pytest.mark.parametrize("name", ["panda", "srs_7r"])
def test_given_ends_are_kept(name: str) -> None:
    """A start and an end, whose values of the parameter are on no grid."""
    arm = urdf_ik.load(name)
    q = joint_path(arm, 50, 3)
    plan = arm.follow(arm.fk(q), start=q[0], end=q[-1], collisions=False)
    check(arm, plan)
    assert np.array_equal(plan.q[0], q[0])
    assert np.array_equal(plan.q[-1], q[-1])


@pytest.mark.parametrize("seed", [2, 10])
def test_the_way_keeps_a_margin_from_an_obstacle(seed: int) -> None:
    """A box where the elbow would be: another plan, which keeps the margin that was asked for, and costs more."""
    arm = urdf_ik.load("srs_7r")
    T = arm.fk(joint_path(arm, 30, seed, size=0.15))
    free = arm.follow(T)
    elbow, size, margin = arm.link_poses(free.q[15])["link_4"], 0.1, 0.01
    assert distance_to_box(arm, size, elbow, free.motion) < 0.0
    world = urdf_ik.World()
    world.add("box", urdf_ik.Box((size, size, size)), elbow)
    plan = arm.follow(T, world=world, margin=margin)
    check(arm, plan)
    assert distance_to_box(arm, size, elbow, plan.motion) >= margin
    assert plan.cost > free.cost


@pytest.mark.parametrize("name", ["srs_7r", "panda"])
def test_steps_that_are_too_short_for_the_path_are_named(name: str) -> None:
    """Waypoints farther apart than the joints may step: each branch says so, from any start and from a given one."""
    arm = urdf_ik.load(name)
    q = joint_path(arm, 12, 1, size=0.15)
    for start in (None, q[0]):
        plan = arm.follow(arm.fk(q), start=start, max_step=1e-3, collisions=False)
        assert not plan.found
        assert {(stop.waypoint, stop.cause) for stop in plan.stops} == {(1, "limit")}
        assert "max_step" in plan.explain()


@pytest.mark.parametrize("count", [1, 2, 5])
def test_waypoints_that_stay_where_they_are(count: int) -> None:
    """One waypoint, or the same one several times: the arm does not move."""
    for name in ("srs_7r", "zyyzyz_6r"):
        arm = urdf_ik.load(name)
        T = np.repeat(arm.fk(joint_path(arm, 3, 1))[:1], count, axis=0)
        plan = arm.follow(T, collisions=False)
        check(arm, plan)
        assert len(plan.q) == count
        assert np.abs(np.diff(plan.q, axis=0)).max(initial=0.0) < 1e-9
