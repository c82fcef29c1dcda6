"""Kernels of Newton's method: convergence, the error as a twist, steps near a singularity."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from arms import rotation
from kernel_samples import ARMS, PI, numbers_of
from numpy.typing import NDArray

from urdf_ik._kernels import refine

Array = NDArray[np.float64]


def start_near(q: Array, distance: float) -> Array:
    """A joint vector at that distance [rad] from another."""
    direction = np.random.default_rng(5).normal(size=6)
    return q + distance * direction / np.linalg.norm(direction)


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("method", ["refine", "newton"])
def test_convergence_is_quadratic(name: str, method: str) -> None:
    """One step leaves an error that falls a hundredfold where the distance falls tenfold, down to rounding."""
    arm, chain = numbers_of(ARMS[name])
    q = np.array([0.4, -0.7, 1.1, 0.6, 0.9, -0.3])
    T = chain.fk(q)

    def left_after(rounds: int, distance: float) -> float:
        start = start_near(q, distance)
        steps = (rounds, 0.0, 60) if method == "refine" else (rounds,)
        return float(getattr(refine, method)(arm, T, start, *steps))

    errors = [left_after(1, distance) for distance in (1e-2, 1e-3, 1e-4, 1e-5)]
    for before, after in zip(errors, errors[1:], strict=False):
        assert 50.0 < before / after < 200.0
    assert errors[0] < 1e-3
    assert left_after(6, 0.1) < 3e-15


@pytest.mark.parametrize("name", ARMS)
def test_refine_never_ends_worse_than_it_began(name: str) -> None:
    """Whatever the start and the target, the vector returned has the error returned, and none larger than the start's.

    At singular vectors and for poses out of reach nothing becomes infinite.
    """
    arm, chain = numbers_of(ARMS[name])
    rng = np.random.default_rng(6)
    twist = np.empty(6)
    far = np.eye(4)
    far[:3, 3] = 10.0
    for start in (*rng.uniform(-PI, PI, (6, 6)), np.zeros(6), np.full(6, PI / 2.0)):
        for T in (chain.fk(rng.uniform(-PI, PI, 6)), chain.fk(start), far):
            q = start.copy()
            left = refine.refine(arm, T, q, 15, 1e-15, 60)
            assert np.isfinite(q).all()
            assert (np.abs(q) <= PI).all()
            assert left == refine.pose_error(T, chain.fk(q), 1.0 / chain.size, twist)
            assert left <= refine.pose_error(T, chain.fk(start), 1.0 / chain.size, twist)


def test_pose_error_is_the_twist() -> None:
    """For a small motion the error is Pinocchio's logarithm of the rotation, and the shift as a share of the size."""
    rng = np.random.default_rng(7)
    for angle in (1e-2, 1e-4, 1e-7):
        T, wanted = np.eye(4), np.eye(4)
        T[:3, :3], T[:3, 3] = rotation(rng.normal(size=3), 2.0), rng.normal(size=3)
        turn = rotation(rng.normal(size=3), angle)
        wanted[:3, :3], wanted[:3, 3] = turn @ T[:3, :3], T[:3, 3] + angle * rng.normal(size=3)
        twist = np.empty(6)
        worst = refine.pose_error(wanted, T, 0.5, twist)
        np.testing.assert_allclose(twist[:3], 0.5 * (wanted - T)[:3, 3], atol=1e-16)
        np.testing.assert_allclose(twist[3:], pin.log3(turn), atol=angle**3 + 1e-15)
        assert worst == np.abs(twist).max()


@pytest.mark.parametrize("angle", [1.8, 2.5, PI])
def test_pose_error_of_a_large_turn(angle: float) -> None:
    """From about a right angle on the sine falls again: such a turn counts as far off, half a turn above all."""
    T = np.eye(4)
    T[:3, :3] = rotation(np.array([1.0, -2.0, 0.5]), angle)
    assert refine.pose_error(T, np.eye(4), 1.0, np.empty(6)) == 2.0


@pytest.mark.parametrize("n", [5, 6, 7])
@pytest.mark.parametrize("damping", [1e-12, 1e-6, 1e-2, 1.0])
def test_damped_step_is_the_least_squares_solution(n: int, damping: float) -> None:
    """Householder's step is NumPy's least-squares solution of the matrix with the damping below it."""
    rng = np.random.default_rng(n)
    for _ in range(5):
        J, twist = rng.normal(size=(6, n)), rng.normal(size=6)
        if n == 7 and damping < 1e-2:
            continue  # nearly undetermined: the two solutions may differ along the free direction
        stacked = np.vstack([J, damping * np.eye(n)])
        expected = np.linalg.lstsq(stacked, np.concatenate([twist, np.zeros(n)]), rcond=None)[0]
        step = np.empty(n)
        refine.damped_step(J, twist, damping, step)
        np.testing.assert_allclose(step, expected, atol=1e-10 * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("damping", [1e-3, 1e-6])
def test_damped_step_at_a_singularity_is_bounded(damping: float) -> None:
    """On a Jacobian that lost rank the step solves what can be solved and keeps still along the lost direction."""
    rng = np.random.default_rng(8)
    left, _, right = np.linalg.svd(rng.normal(size=(6, 6)))
    J = left @ np.diag([2.0, 1.5, 1.0, 0.7, 0.5, 0.0]) @ right
    step = np.empty(6)
    refine.damped_step(J, J @ rng.normal(size=6), damping, step)
    assert abs(right[-1] @ step) < 1e-9
    refine.damped_step(J, left[:, -1], damping, step)
    assert np.abs(step).max() < 1e-15 / damping**2 + 1e-12


@pytest.mark.parametrize("sigma", [1e-2, 1e-4, 1e-8, 1e-12])
def test_least_stretch_near_singular(sigma: float) -> None:
    """Near a singularity it is the smallest singular value, and its direction the one that belongs to it."""
    rng = np.random.default_rng(9)
    for _ in range(10):
        left, _, right = np.linalg.svd(rng.normal(size=(6, 6)))
        J = left @ np.diag([*rng.uniform(0.3, 2.0, 5), sigma]) @ right
        x = np.empty(6)
        expected = np.linalg.svd(J, compute_uv=False)[-1]
        assert refine.least_stretch(J, x) == pytest.approx(expected, rel=1e-4, abs=1e-15)
        assert abs(abs(x @ right[-1]) - 1.0) < 1e-6


def test_least_stretch_is_no_less_than_the_least() -> None:
    """Of any matrix it is between the smallest singular value and thrice that; of a singular one, zero to rounding."""
    rng = np.random.default_rng(10)
    x = np.empty(6)
    for _ in range(200):
        J = rng.normal(size=(6, 6))
        least = np.linalg.svd(J, compute_uv=False)[-1]
        assert least * (1.0 - 1e-9) <= refine.least_stretch(J, x) <= 3.0 * least
    for J in (np.zeros((6, 6)), np.diag([1.0, 2.0, 0.0, 1.0, 1.0, 1.0]), np.ones((6, 6))):
        assert refine.least_stretch(J, x) < 1e-14


@pytest.mark.parametrize("sigma", [1e-4, 1e-8, 1e-12])
def test_least_stretch_across_its_first_guess(sigma: float) -> None:
    """A lost direction at right angles to the vector of ones, where the iteration begins, is found all the same."""
    J = np.eye(6)
    J[:2, :2] = [[1.0, 1.0], [1.0, 1.0 + 2.0 * sigma]]
    expected = np.linalg.svd(J, compute_uv=False)[-1]
    assert refine.least_stretch(J, np.empty(6)) == pytest.approx(expected, rel=1e-3)
