"""Copies: arms, solutions, worlds, plans and errors can be pickled and copied, and read-only arrays stay read-only."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik import errors

Q = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
ARM = urdf_ik.load("zyyzyz_6r")
WAYS: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda value: pickle.loads(pickle.dumps(value)), "deepcopy": copy.deepcopy, "copy": copy.copy
}  # fmt: skip


def obstacles() -> urdf_ik.World:
    """A world with a ball beside the arm."""
    world = urdf_ik.World()
    world.add("ball", urdf_ik.Sphere(0.3), urdf_ik.pose([2.4, 0.0, 1.6]))
    return world


@pytest.mark.parametrize("way", WAYS)
def test_arms_answer_as_before(way: str) -> None:
    """A copied arm gives the same solutions: as loaded, with a tool, with a locked joint, with a free axis."""
    tool = ARM.with_tool(urdf_ik.pose([0, 0, 0.1]), [urdf_ik.Box((0.1, 0.1, 0.1))])
    for arm in (ARM, tool, ARM.with_free_axis("z"), urdf_ik.load("zyyzyz_6r", locked={"joint_1": 0.2})):
        again = WAYS[way](arm)
        T = arm.fk(np.full(arm.dof, 0.3))
        np.testing.assert_array_equal(again.ik(T).q, arm.ik(T).q)
        assert not again.limits.flags.writeable and not again.chain.H.flags.writeable


@pytest.mark.parametrize("way", WAYS)
def test_solutions_are_what_they_were(way: str) -> None:
    """The same joint vectors, which nobody may write to; the copy still knows its limits and its turns."""
    T = ARM.fk(Q)
    for found in (ARM.ik(T), ARM.ik(np.stack([T, T])), urdf_ik.load("planar_2r").ik(np.eye(4))):
        again = WAYS[way](found)
        np.testing.assert_array_equal(again.q, found.q)
        np.testing.assert_array_equal(again.within_limits().turns().q, found.within_limits().turns().q)
        assert str(again) == str(found) and not again.q.flags.writeable


@pytest.mark.parametrize("way", WAYS)
def test_worlds_and_collision_models_keep_their_obstacles(way: str) -> None:
    """Names, distances, and the pairs that may touch."""
    world = obstacles()
    assert WAYS[way](world).names == ("ball",)
    model = ARM.cell.collisions.in_world(world).allow("link_1", "ball")
    again = WAYS[way](model)
    assert dict(again.allowed_pairs) == dict(model.allowed_pairs) and again.checked_pairs == model.checked_pairs
    assert again.distance(Q) == model.distance(Q) and again.world.names == ("ball",)


@pytest.mark.parametrize("way", WAYS)
def test_plans_are_what_they_were(way: str) -> None:
    """The same joint vectors and alternatives."""
    T = ARM.fk(Q)
    plan = ARM.follow(urdf_ik.line(T, ARM.fk(Q + 0.02), 4), world=obstacles())
    again = WAYS[way](plan)
    np.testing.assert_array_equal(again.q, plan.q)
    assert [other.cost for other in again.alternatives] == [other.cost for other in plan.alternatives]


@pytest.mark.parametrize("way", WAYS)
def test_errors_are_copied_with_their_fields(way: str) -> None:
    """As they come out of another process."""
    for error in (
        errors.UrdfError("p", source="s", line=3, element="e", hint="h"), errors.ChainError("c", ["a"]),
        errors.PoseError("p", (1,)), errors.MissingPackage("m"),
    ):  # fmt: skip
        again = WAYS[way](error)
        assert type(again) is type(error) and str(again) == str(error) and vars(again) == vars(error)
