"""Streaming through singularities, along folds, and out of reach and back."""

import numpy as np
import pinocchio as pin
import pytest
from arms_general import unstructured
from cases import described
from tracking import DT, EXACT, Q0, Array, arm_of, run, statuses, vectors

import urdf_ik


def turned(T: Array, rotation: Array, about: Array) -> Array:
    """Poses (m, 4, 4) turned by a rotation (3, 3) about a point (m, 3) each."""
    out = T.copy()
    out[:, :3, :3] = rotation @ T[:, :3, :3]
    out[:, :3, 3] = about + (T[:, :3, 3] - about) @ rotation.T
    return out


def past_the_wrist(arm: urdf_ik.Arm, offset: float) -> tuple[Array, Array]:
    """Joint vector and poses that tilt the wrist through zero, or past it at an angle [rad]."""
    q0 = Q0 * [1, 1, 1, 1, 0.5, 1]
    Q = np.tile(q0, (160, 1))
    Q[:, 4] = np.linspace(0.35, -0.35, len(Q))
    axes, points, _ = arm.chain.placed(q0)
    T = turned(arm.fk(Q), pin.exp3(np.cross(axes[3], axes[4]) * offset), np.tile(points[4], (len(Q), 1)))
    return arm.ik_nearest(T[0], q0).q[0], T


@pytest.mark.parametrize("offset", [0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 3e-3, 1e-2])
def test_zyyzyz_past_its_straight_wrist(offset: float) -> None:
    """The error is no greater than the distance from the singularity, and the poses are exact again afterwards."""
    arm = arm_of("zyyzyz_6r")
    start, T = past_the_wrist(arm, offset)
    T = np.concatenate([T, np.repeat(T[-1:], 200, axis=0)])
    steps = run(arm.tracker(start, DT), T)
    assert max(step.angle for step in steps) <= 3.0 * offset + EXACT
    assert max(step.distance for step in steps) <= 3.0 * offset + EXACT
    assert {step.status for step in steps[160:][-20:]} == {"ok"}
    if offset == 0.0:
        assert statuses(steps) == {"ok": len(T)}


@pytest.mark.parametrize("joints", [[0.3, -0.5, 0.8, 0.4, 0.0, -0.2], [0.3, -0.5, 0.0, 0.4, 0.5, -0.2]])
def test_zyyzyz_leaves_a_straight_wrist_and_a_straight_elbow(joints: list[float]) -> None:
    """From an exactly straight wrist or elbow every pose nearby that has solutions is reached."""
    arm, q0 = arm_of("zyyzyz_6r"), np.array(joints)
    for axis in range(6):
        for sign in (-1.0, 1.0):
            twist = sign * 0.1 * np.eye(6)[axis]
            target = arm.fk(q0)
            target[:3, :3] = pin.exp3(twist[3:]) @ target[:3, :3]
            target[:3, 3] += twist[:3]
            if len(arm.ik(target).within_limits()):
                steps = run(arm.tracker(q0, DT), np.repeat(target[None], 600, axis=0))
                assert steps[-1].status == "ok", (axis, sign, steps[-1])


@pytest.mark.parametrize("way", [[2.0, 0.0, 0.0], [0.0, 0.0, 2.0], [1.0, 1.0, 1.0], [-3.0, 0.0, 0.0]])
def test_zyyzyz_out_of_reach_and_back(way: list[float]) -> None:
    """Beyond its reach the arm stretches and says why; it comes back with its elbow on the same side."""
    arm = arm_of("zyyzyz_6r")
    T = np.repeat(arm.fk(Q0)[None], 1200, axis=0)
    T[:800, :3, 3] += np.concatenate([np.linspace(0, 1, 400), np.linspace(1, 0, 400)])[:, None] * np.array(way)
    steps = run(arm.tracker(Q0, DT, velocity=3.0), T)
    assert {step.why for step in steps[395:405]} == {"reach"}
    assert (vectors(steps)[:, 2] > 0.0).all()
    assert steps[-1].status == "ok"
    np.testing.assert_allclose(steps[-1].q, Q0, atol=1e-9)


@pytest.mark.parametrize("least", [0.1, 1e-2, 1e-4, 0.0])
def test_zyyzyz_elbow_nearly_straight_stays_on_its_side(least: float) -> None:
    """A path whose elbow comes arbitrarily near to straight is followed on its own side of it."""
    arm = arm_of("zyyzyz_6r")
    t = np.linspace(0.0, 2.0 * np.pi, 1500)[:, None]
    Q = Q0 + 0.1 * np.sin(t * [1.0, 2.0, 0.0, 1.0, 1.0, 2.0])
    Q[:, 2] = least + 0.15 * (1.0 + np.cos(t[:, 0]))
    steps = run(arm.tracker(Q[0], DT), arm.fk(Q))
    assert (vectors(steps)[:, 2] > -1e-6).all()
    assert max(max(step.distance, step.angle) for step in steps) < 1e-6
    assert np.abs(vectors(steps) - Q)[-1].max() < 1e-6
    if least > 0.0:
        assert statuses(steps) == {"ok": len(Q)}


@pytest.mark.parametrize("seed", [1, 2, 3, 10, 19])
def test_general_arms_cross_no_fold_towards_far_targets(seed: int) -> None:
    """All singularities of a general arm are folds; towards any target it stays on its side of them."""
    arm = described(unstructured(seed)).arm
    rng = np.random.default_rng(seed)
    tracker = arm.tracker(rng.uniform(-2.0, 2.0, 6), DT, velocity=3.0)
    side = np.sign(np.linalg.det(arm.jacobian(tracker.q)))
    for _ in range(6):
        target = arm.fk(rng.uniform(-3.0, 3.0, 6))
        reached = vectors(run(tracker, np.repeat(target[None], 200, axis=0)))
        assert (np.sign(np.linalg.det(arm.jacobian(reached))) == side).all()
