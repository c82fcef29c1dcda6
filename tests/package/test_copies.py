"""Copies: arms, solutions, worlds, plans and errors can be pickled and copied, and read-only arrays stay read-only."""

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


@pytest.fixture(params=["pickle", "deepcopy"])
def copied(request: pytest.FixtureRequest) -> Callable[[Any], Any]:
    """A function that copies."""
    return copy.deepcopy if request.param == "deepcopy" else lambda value: pickle.loads(pickle.dumps(value))


def test_arms_and_solutions_answer_as_before(copied: Callable[[Any], Any]) -> None:
    """As loaded, with a tool, with a locked joint, with a free axis: the same solutions, which nobody may write to."""
    tool = ARM.with_tool(urdf_ik.pose([0, 0, 0.1]), [urdf_ik.Box((0.1, 0.1, 0.1))])
    for arm in (ARM, tool, ARM.with_free_axis("z"), urdf_ik.load("zyyzyz_6r", locked={"joint_1": 0.2})):
        again, T = copied(arm), arm.fk(np.full(arm.dof, 0.3))
        found = arm.ik(np.stack([T, T]))
        np.testing.assert_array_equal(again.ik(np.stack([T, T])).q, found.q)
        assert not again.limits.flags.writeable and not again.chain.H.flags.writeable
        kept = copied(found)
        np.testing.assert_array_equal(kept.within_limits().turns().q, found.within_limits().turns().q)
        assert str(kept) == str(found) and not kept.q.flags.writeable


def test_worlds_and_plans_are_what_they_were(copied: Callable[[Any], Any]) -> None:
    """Names, distances, the pairs that may touch; joint vectors and alternatives."""
    world = urdf_ik.World()
    world.add("ball", urdf_ik.Sphere(0.3), urdf_ik.pose([2.4, 0.0, 1.6]))
    model = ARM.cell.collisions.in_world(world).allow("link_1", "ball")
    again = copied(model)
    assert dict(again.allowed_pairs) == dict(model.allowed_pairs) and again.checked_pairs == model.checked_pairs
    assert again.distance(Q) == model.distance(Q) and again.world.names == ("ball",)
    plan = ARM.follow(urdf_ik.line(ARM.fk(Q), ARM.fk(Q + 0.02), 4), world=world)
    np.testing.assert_array_equal(copied(plan).q, plan.q)
    assert [other.cost for other in copied(plan).alternatives] == [other.cost for other in plan.alternatives]


def test_errors_come_out_of_another_process_with_their_fields(copied: Callable[[Any], Any]) -> None:
    """Their constructors differ; the copy has the same text and fields."""
    for error in (
        errors.UrdfError("p", source="s", line=3, element="e", hint="h"), errors.ChainError("c", ["a"]),
        errors.PoseError("p", (1,)), errors.MissingPackage("m"),
    ):  # fmt: skip
        again = copied(error)
        assert type(again) is type(error) and str(again) == str(error) and vars(again) == vars(error)
