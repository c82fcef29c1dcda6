"""A time limit ends a search with the best plan so far, and the plan says what was not looked at."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik.support import watch
from urdf_ik.support.angles import shortest


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


@pytest.mark.parametrize(("name", "q"), [("ur5", [0.3, -1.2, 1.4, -1.7, -1.5, 0.2]),
                                         ("srs_7r", [0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])])  # fmt: skip
def test_a_search_that_comes_to_its_end_is_the_one_without_a_limit(name: str, q: list[float]) -> None:
    """A limit that does not pass changes nothing, and says nothing."""
    arm = urdf_ik.load(name)
    path = line_of(arm, q)
    plan, said = arm.follow(path), list[str]()
    limited = arm.follow(path, time_limit=1e6, progress=said.append)
    assert plan.found
    assert np.array_equal(limited.q, plan.q)
    assert (limited.unlooked, plan.unlooked) == ("", "")
    assert said
    assert [each.cost for each in limited.alternatives] == [each.cost for each in plan.alternatives]


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


def test_the_best_plan_so_far_is_returned(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a free axis, the plan that holds it is known before those that turn about it."""
    fixed = urdf_ik.load("ur5")
    free = fixed.with_free_axis("z")
    path = line_of(fixed, [0.3, -1.2, 1.4, -1.7, -1.5, 0.2])
    settings, said = ends_at(monkeypatch, "following way")
    plan = free.follow(path, **settings)
    assert plan.found
    assert "following way 1" in plan.unlooked
    assert "following way 1" in said[-1]
    held = fixed.follow(path)
    assert plan.cost == pytest.approx(held.cost)
    assert plan.cost > free.follow(path).cost
    rotation = plan.poses[:, :3, :3].transpose(0, 2, 1) @ free.fk(plan.q)[:, :3, :3]
    assert np.abs(shortest(np.arccos(np.clip(rotation[:, 2, 2], -1.0, 1.0)))).max() < 1e-7


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
