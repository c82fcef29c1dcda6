"""Paths of arms with two redundancy parameters: no dearer than with one held, by Pinocchio, and a minimum nearby."""

import numpy as np
import pytest

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.paths import Plan


def seam(count: int = 12) -> np.ndarray:
    """Most of a circle on the workpiece, the torch pointing down."""
    places = [[0.1 * np.cos(a), 0.1 * np.sin(a), 0.02] for a in np.linspace(0.0, 4.0, count)]
    return np.array([urdf_ik.pose(place, rpy=[np.pi, 0.0, np.pi]) for place in places])


def check(arm: urdf_ik.Arm, plan: Plan) -> None:
    """At the waypoints by Pinocchio, inside the limits, and proven within the tolerance between."""
    assert plan.found, plan.explain()
    reference = Reference(arm.model, arm.base, arm.tip, locked=dict(arm.chain.locked))
    if arm.solver.free_axis is None:
        assert np.abs(reference.pose(plan.q) - plan.poses).max() < 1e-8
    else:
        assert max(off.max() for off in arm.solver.free_axis.apart(reference.pose(plan.q), plan.poses)) < 1e-8
    low, high = arm.limits.T
    assert (plan.motion >= low - 1e-9).all()
    assert (plan.motion <= high + 1e-9).all()


def test_a_positioner_of_two_axes() -> None:
    """Both axes together are cheaper than either of them, and much cheaper than the arm alone."""
    cell, path = urdf_ik.load("positioner_6r", base="workpiece", tip="torch"), seam()
    plan = cell.follow(path)
    check(cell, plan)
    held = [
        urdf_ik.load("positioner_6r", base="workpiece", tip="torch", locked=locked).follow(path).cost
        for locked in ({"tilt": 0.0}, {"turn": 0.0}, {"tilt": 0.0, "turn": 0.0})
    ]
    assert plan.cost < 0.99 * min(held)
    assert [each.cost for each in plan.alternatives] == sorted(each.cost for each in plan.alternatives)
    # Nothing beside it is cheaper: other values of both parameters, on the same branch.
    rng = np.random.default_rng(0)
    values = cell.redundancy_of(plan.q)
    for size in (1e-3, 1e-2):
        for _ in range(20):
            moved = values + size * np.cumsum(rng.normal(size=values.shape), axis=0) / 3.0
            near = np.array(
                [cell.ik(T, redundancy=v).nearest(q).q[0] for T, v, q in zip(path, moved, plan.q, strict=True)]
            )
            assert (np.diff(near, axis=0) ** 2).sum() > plan.cost * (1.0 - 1e-4)


def test_seven_joints_with_a_free_axis() -> None:
    """No dearer than with the axis fixed; given ends are kept."""
    fixed = urdf_ik.load("srs_7r")
    free = fixed.with_free_axis("z")
    q = np.array([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])
    start = fixed.fk(q)
    end = start.copy()
    end[:3, 3] += [0.05, -0.1, 0.05]
    path = urdf_ik.line(start, end, 10)
    before, plan = fixed.follow(path, collisions=False), free.follow(path, collisions=False)
    check(free, plan)
    assert plan.cost <= before.cost * (1.0 + 1e-9)
    plan = free.follow(path, start=q, collisions=False)
    check(free, plan)
    np.testing.assert_array_equal(plan.q[0], q)


@pytest.mark.parametrize("cost", ["l1", "max"])
def test_other_costs_hold_all_but_one(cost: str) -> None:
    """A plan is found, and one of both parameters keeps its value."""
    cell = urdf_ik.load("positioner_6r", base="workpiece", tip="torch")
    plan = cell.follow(seam(6), cost=cost, collisions=False)
    check(cell, plan)
    assert min(np.ptp(plan.q[:, 0]), np.ptp(plan.q[:, 1])) < 1e-12
