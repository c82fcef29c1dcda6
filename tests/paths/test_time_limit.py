"""A time limit ends a search with the best plan so far, and the plan says what was not looked at."""

from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik.support import watch


def line_of(arm: urdf_ik.Arm, q: list[float], count: int = 12) -> np.ndarray:
    """A straight line of 0.1 m from the pose of a joint vector."""
    first = arm.fk(q)
    last = first.copy()
    last[1, 3] += 0.1
    path: np.ndarray = urdf_ik.line(first, last, count)
    return path


def ends_at(monkeypatch: pytest.MonkeyPatch, words: str) -> tuple[dict[str, Any], list[str]]:
    """Settings under which the time limit passes as soon as ``progress`` is called with these words; and its calls."""
    said: list[str] = []
    monkeypatch.setattr(watch, "monotonic", lambda: 1e9 if said and words in said[-1] else 0.0)
    return {"time_limit": 1.0, "progress": said.append}, said


@pytest.mark.parametrize("name", ["ur5", "srs_7r"])
def test_no_time_is_not_no_way(name: str) -> None:
    """Where the limit ends a search without a plan, no branch is said to be closed."""
    arm = urdf_ik.load(name)
    plan = arm.follow(line_of(arm, [0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1][: arm.dof]), time_limit=0.0)
    assert not plan.found
    assert [stop.cause for stop in plan.stops] == ["time"]
    assert "time limit" in plan.unlooked
    assert "time limit" in plan.explain()
    assert "time limit" in str(plan)
    assert "not looked at" in plan.to_json()


def test_a_plan_without_obstacles_is_no_plan_among_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """The way without obstacles, which guides the search, is never what the limit returns."""
    arm = urdf_ik.load("srs_7r")
    path = line_of(arm, [0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])
    alone = arm.follow(path, collisions=False)
    # A ball where the elbow is half way.
    elbow = arm.link_poses(alone.q[6])["link_4"][:3, 3]
    world = urdf_ik.World()
    world.add("ball", urdf_ik.Sphere(0.05), urdf_ik.pose(elbow))
    free = arm.ik(path[6], redundancy=arm.redundancy_of(alone.q[6])).nearest(alone.q[6]).collision_free(world)
    assert not free.valid.any()
    settings, said = ends_at(monkeypatch, "around the obstacles")
    plan = arm.follow(path, world=world, **settings)
    assert "around the obstacles" in said[-1]
    assert not plan.found
    assert plan.stops[0].cause == "time"
