"""Paths with a free axis of the tip: never dearer than with it fixed, and as cheap as brute force, by Pinocchio."""

import numpy as np
import pytest
from paths import joint_path

import urdf_ik
from urdf_ik import ArgumentError
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.paths import Plan

AT = (0.02, -0.01, 0.08)


def random_line(arm: urdf_ik.Arm, seed: int, count: int = 25) -> np.ndarray:
    """A straight line from the pose of random joint vectors, turning on the way."""
    rng = np.random.default_rng(seed)
    start = arm.fk(rng.uniform(*np.clip(arm.limits.T, -1.5, 1.5)))
    end = start @ urdf_ik.pose([0.0, 0.0, 0.0], rpy=rng.uniform(-0.4, 0.4, 3))
    end[:3, 3] = start[:3, 3] + rng.uniform(-0.15, 0.15, 3)
    return urdf_ik.line(start, end, count)


def check(arm: urdf_ik.Arm, plan: Plan) -> None:
    """By Pinocchio point and axis are where they must be at the waypoints, and between them within the tolerance."""
    assert plan.found, plan.explain()
    assert arm.solver.free_axis is not None
    reference = Reference(arm.model, arm.base, arm.tip)
    far, off = arm.solver.free_axis.apart(reference.pose(plan.q), plan.poses)
    assert max(far.max(), off.max()) < 1e-8
    low, high = arm.limits.T
    assert (plan.motion >= low - 1e-9).all()
    assert (plan.motion <= high + 1e-9).all()
    for share in (0.2, 0.5, 0.8):
        q = plan.motion[:-1] + share * np.diff(plan.motion, axis=0)
        place = plan.place[:-1] + share * np.diff(plan.place)
        first = np.minimum(np.floor(place).astype(int), len(plan.poses) - 2)
        ideal = np.array(
            [
                urdf_ik.line(plan.poses[k], plan.poses[k + 1], 1001)[round(1000 * (p - k))]
                for k, p in zip(first, place, strict=True)
            ]
        )
        far, off = arm.solver.free_axis.apart(reference.pose(q), ideal)
        assert far.max() < plan.tolerance[0] + 1e-4
        assert off.max() < plan.tolerance[1] + 1e-3


@pytest.mark.parametrize("at", [None, AT])
@pytest.mark.parametrize("name", ["ur5", "puma_560"])
def test_it_never_costs_more_than_with_the_axis_fixed(name: str, at: tuple[float, ...] | None) -> None:
    """Where the path is found with the rotation fixed it is found with it free, and costs no more."""
    fixed = urdf_ik.load(name)
    free = fixed.with_free_axis("z", at)
    saved = 0.0
    for seed in range(5):
        path = random_line(fixed, seed)
        before, plan = fixed.follow(path, collisions=False), free.follow(path, collisions=False)
        assert plan.found >= before.found
        if plan.found:
            check(free, plan)
            assert plan.cost <= before.cost
            saved += float(np.isfinite(before.cost) and plan.cost < 0.95 * before.cost)
    assert saved


@pytest.mark.parametrize("seed", [0, 2])
def test_brute_force_finds_nothing_cheaper(seed: int) -> None:
    """Dynamic programming over 900 rotations at every waypoint is cheaper by less than a per cent."""
    free = urdf_ik.load("ur5").with_free_axis("z")
    path = random_line(free, seed, 12)
    plan = free.follow(path, collisions=False)
    check(free, plan)
    values = np.linspace(-np.pi, np.pi, 900, endpoint=False)
    solutions = free.ik(path[:, None], redundancy=values).within_limits()
    around = (np.arange(900)[:, None] + np.arange(-60, 61)) % 900
    best = np.inf
    for column in range(solutions.q.shape[-2]):
        q = solutions.q[:, :, column]
        cost = np.where(np.isnan(q[0, :, 0]), np.inf, 0.0)
        for before, here in zip(q[:-1], q[1:], strict=True):
            step = here[:, None] - before[around]
            step -= 2.0 * np.pi * np.round(step / (2.0 * np.pi))
            cost = np.nan_to_num(cost[around] + (step**2).sum(axis=-1), nan=np.inf).min(axis=1)
        best = min(best, float(cost.min()))
    assert plan.cost <= 1.01 * best


def test_given_ends_are_kept() -> None:
    """A start and an end that reach their waypoints but for the rotation; one that does not is refused."""
    free = urdf_ik.load("ur5").with_free_axis("z")
    q = joint_path(free, 30, 3)
    path = free.fk(q)
    start, end = q[0].copy(), q[-1].copy()
    start[5] += 0.4
    end[5] -= 0.2
    plan = free.follow(path, start=start, end=end, collisions=False)
    check(free, plan)
    assert np.array_equal(plan.q[0], start)
    assert np.array_equal(plan.q[-1], end)
    start[4] += 0.1
    with pytest.raises(ArgumentError, match="no solution of waypoint 0"):
        free.follow(path, start=start, collisions=False)


def test_puma_two_turns_of_the_workpiece_need_no_motion() -> None:
    """Two turns of the workpiece under the tool, as around a pipe: the free wrist stays where it is."""
    fixed = urdf_ik.load("puma_560")
    free = fixed.with_free_axis("z")
    here = fixed.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
    path = np.array([here @ urdf_ik.pose([0.0, 0.0, 0.0], rotvec=[0.0, 0.0, a]) for a in np.linspace(0.0, 12.0, 60)])
    plan = free.follow(path, collisions=False)
    check(free, plan)
    assert plan.cost < 1e-9
    assert fixed.follow(path, collisions=False).cost > 1.0
