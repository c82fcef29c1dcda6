"""Paths through waypoints at which every solution touches something."""

import numpy as np
import pytest

import urdf_ik

DOWN = np.diag([1.0, -1.0, -1.0])


def _into_a_table(depth: float) -> tuple[np.ndarray, urdf_ik.World]:
    """Waypoints of a tool that dips by a depth below a table's top and rises again, and the table."""
    first = np.eye(4)
    first[:3, :3], first[:3, 3] = DOWN, (0.45, -0.3, 0.25)
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
