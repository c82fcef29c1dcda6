"""Paths through singularities, along them and along folds, and the published cuspidal line."""

import re

import arms
import numpy as np
import pytest
from paths import ALL_KINDS, check, cost_of, described, smooth

import urdf_ik


def singularity(arm: urdf_ik.Arm, q: np.ndarray, rng: np.random.Generator) -> np.ndarray | None:
    """A singular joint vector (n,) on the motion q (m, n), to the last digit; None where it meets none."""

    def determinant(q: np.ndarray) -> float:
        return float(np.linalg.det(arm.jacobian(q)))

    values = np.linalg.det(arm.jacobian(q))
    crossed = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    if not len(crossed):
        return None
    k = rng.choice(crossed)
    a, b = q[k], q[k + 1]
    for _ in range(80):
        middle = 0.5 * (a + b)
        a, b = (middle, b) if (determinant(middle) < 0.0) == (values[k] < 0.0) else (a, middle)
    return np.asarray(a)


@pytest.mark.parametrize("kind", ALL_KINDS)
def test_a_singularity_of_every_family_is_crossed(kind: str) -> None:
    """A motion through a singularity, exactly at a waypoint and 1e-9 to 1e-3 beside it."""
    rng = np.random.default_rng(len(kind))
    crossed = 0
    for seed in range(12):
        arm = described(kind, seed)
        q = smooth(arm, rng, size=0.4)
        singular = singularity(arm, q, rng)
        if singular is None:
            continue
        crossed += 1
        direction = q[-1] - q[0]
        direction *= 0.1 / np.abs(direction).max()
        for beside in (0.0, 10.0 ** rng.uniform(-9.0, -3.0)):
            aside = rng.normal(size=arm.dof)
            way = singular + np.linspace(-1.0, 1.0, 81)[:, None] * direction + beside * aside / np.linalg.norm(aside)
            if (way < arm.limits[:, 0]).any() or (way > arm.limits[:, 1]).any():
                continue
            plan = arm.follow(arm.fk(way), collisions=False)
            assert plan.found, (seed, beside, plan.explain())
            assert plan.cost <= cost_of(way) * (1.0 + 1e-5), (seed, beside)
        if crossed == 2:
            break
    assert crossed


def test_puma_along_its_straight_wrist() -> None:
    """Joint 5 stays at zero: each pose leaves joint 4 free, and the plan keeps its value from waypoint to waypoint."""
    arm = urdf_ik.load("puma_560")
    q = np.tile([0.2, -0.6, 0.4, 0.7, 0.0, 0.5], (21, 1))
    q[:, 0] += np.linspace(0.0, 0.3, 21)
    plan = arm.follow(arm.fk(q), start=q[0], collisions=False)
    check(arm, plan)
    assert np.array_equal(plan.q[0], q[0])
    assert np.abs(np.diff(plan.q, axis=0)).max() < 0.05


@pytest.mark.parametrize("bend", [0.0, 1e-8, 1e-6, 1e-4])
def test_zyyzyz_along_its_straight_elbow(bend: float) -> None:
    """The elbow stays within ``bend`` of straight while the other joints move; it may wave from side to side."""
    arm = urdf_ik.load("zyyzyz_6r")
    for waves in (0, 3):
        s = np.linspace(0.0, 1.0, 81)[:, None]
        q = np.array([0.3, 0.4, 0.0, 0.5, 0.8, -0.3]) + s * np.array([0.3, -0.2, 0.0, 0.1, 0.2, 0.1])
        q[:, 2] = bend * np.cos(waves * np.pi * s[:, 0])
        plan = arm.follow(arm.fk(q), collisions=False)
        check(arm, plan)
        # Where two solutions are one to within their resolution, the plan may pass through either.
        assert plan.cost <= cost_of(q) * (1.0 + 1e-5)


# FANUC's CRX-10iA/L as the code that comes with Elias and Wen, "Path planning and optimization for cuspidal 6R
# manipulators" (2025, rpiRobotics/cuspidal-path-planning) describes it: axes z x x y x y, 0.71, 0.54 and 0.15 m, joints
# without limits.
CRX_START = (2.0323, 1.2241, -1.1492, 2.8288, -2.9252, -0.3849)
CRX_END = (-2.6111, -0.6297, -1.5088, 1.8854, -0.4309, 2.5802)


def test_crx_published_cuspidal_line_keeps_four_of_twelve() -> None:
    """Twelve solutions at the start, four at the end; four of the start branches lead there, as is published.

    None of the four meets a singularity, so each keeps the sign of its determinant and its name.
    The eight others end in pairs where two solutions merge and are gone: four of them at each of two folds.
    """
    x, y, z = np.eye(3)
    steps = np.array([0 * z, 0 * z, 0.71 * z, 0 * z, 0.54 * y + 0.15 * x, 0 * z])
    points = np.cumsum(steps, axis=0)
    text = arms.from_screws("crx", "general", np.array([z, x, x, y, x, y]), points, points[-1]).urdf
    text = re.sub(r"<limit[^>]*/>", "", text.replace('type="revolute"', 'type="continuous"'))
    arm = urdf_ik.load(text, base="base", tip="tool")
    T = urdf_ik.line(arm.fk(CRX_START), arm.fk(CRX_END), 500)
    assert arm.ik(T[[0, -1]]).valid.sum(axis=1).tolist() == [12, 4]
    plan = arm.follow(T, collisions=False)
    check(arm, plan)
    ends = {other.branches[-1] for other in plan.alternatives}
    assert len(ends) == len(plan.alternatives) == 4
    assert ends == {other.branches[0] for other in plan.alternatives}
    signs = [np.sign(np.linalg.det(arm.jacobian(other.q[[0, -1]]))) for other in plan.alternatives]
    assert all(first == last for first, last in signs)
    leading = {k: len(arm.follow(T[:k], collisions=False).alternatives) for k in (206, 207, 365, 366, 500)}
    assert leading == {206: 12, 207: 8, 365: 8, 366: 4, 500: 4}
    stopped = arm.follow(T, start=CRX_START, collisions=False)
    assert (stopped.stops[0].waypoint, stopped.stops[0].cause) == (206, "jump")
    assert "its solutions end here" in stopped.explain()
