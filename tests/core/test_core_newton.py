"""Steps of the core: Newton's method: convergence, the error as a twist, steps near a singularity."""

import core_steps
import numpy as np
import pinocchio as pin
import pytest
from arms import rotation
from core_samples import ARMS, PI, step, written
from numpy.typing import NDArray

Array = NDArray[np.float64]


def pose_error(wanted: Array, T: Array, inverse_size: float) -> tuple[Array, float]:
    """The twist (6,) from one pose to another, and its size."""
    *twist, size = step("pose_error", *wanted.ravel(), *T.ravel(), inverse_size)
    return np.array(twist), size


def damped_step(J: Array, twist: Array, damping: float) -> Array:
    """The step (n,) for a Jacobian (6, n); in blocks the same."""
    name, numbers = f"least_squares_{J.shape[1]}", np.array([[*J.T.ravel(), *twist, damping]])
    alone = core_steps.step(name, numbers)[0, :-1]
    if J.shape[1] < 7:
        together = core_steps.step(name, numbers, side_by_side=True)[0, :-1]
        # Rounding of J counts by this much along what a singular J all but loses.
        rounding = 1e-15 * np.linalg.norm(twist) / (np.linalg.svd(J, compute_uv=False)[-1] ** 2 + damping**2)
        np.testing.assert_allclose(together, alone, atol=1e-9 * max(1.0, np.abs(alone).max()) + rounding)
    return alone


def weakest(J: Array) -> tuple[float, Array]:
    """The smallest singular value of a matrix (6, 6), and its direction (6,)."""
    value, *direction = step("weakest", *J.T.ravel())
    return value, np.array(direction)


def start_near(q: Array, distance: float) -> Array:
    """A joint vector at that distance [rad] from another."""
    direction = np.random.default_rng(5).normal(size=6)
    return q + distance * direction / np.linalg.norm(direction)


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("damped", [True, False])
def test_convergence_is_quadratic(name: str, damped: bool) -> None:
    """One step leaves an error that falls a hundredfold where the distance falls tenfold, down to rounding."""
    arm, chain = written(ARMS[name])
    q = np.array([0.4, -0.7, 1.1, 0.6, 0.9, -0.3])
    T = chain.fk(q)

    def left_after(rounds: int, distance: float) -> float:
        start = start_near(q, distance)
        return core_steps.polish(arm, T, start, damped, rounds)

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
    arm, chain = written(ARMS[name])
    rng = np.random.default_rng(6)
    far = np.eye(4)
    far[:3, 3] = 10.0
    for start in (*rng.uniform(-PI, PI, (6, 6)), np.zeros(6), np.full(6, PI / 2.0)):
        for T in (chain.fk(rng.uniform(-PI, PI, 6)), chain.fk(start), far):
            q = start.copy()
            left = core_steps.polish(arm, T, q, True, 15)
            assert np.isfinite(q).all()
            assert (np.abs(q) <= PI).all()
            assert abs(left - pose_error(T, chain.fk(q), 1.0 / chain.size)[1]) < 1e-14
            assert left <= pose_error(T, chain.fk(start), 1.0 / chain.size)[1] + 1e-14


def test_pose_error_is_the_twist() -> None:
    """For a small motion the error is Pinocchio's logarithm of the rotation, and the shift as a share of the size."""
    rng = np.random.default_rng(7)
    for angle in (1e-2, 1e-4, 1e-7):
        T, wanted = np.eye(4), np.eye(4)
        T[:3, :3], T[:3, 3] = rotation(rng.normal(size=3), 2.0), rng.normal(size=3)
        turn = rotation(rng.normal(size=3), angle)
        wanted[:3, :3], wanted[:3, 3] = turn @ T[:3, :3], T[:3, 3] + angle * rng.normal(size=3)
        twist, worst = pose_error(wanted, T, 0.5)
        np.testing.assert_allclose(twist[:3], 0.5 * (wanted - T)[:3, 3], atol=1e-16)
        np.testing.assert_allclose(twist[3:], pin.log3(turn), atol=angle**3 + 1e-15)
        assert worst == np.abs(twist).max()


@pytest.mark.parametrize("angle", [1.8, 2.5, PI])
def test_pose_error_of_a_large_turn(angle: float) -> None:
    """From about a right angle on the sine falls again: such a turn counts as far off, half a turn above all."""
    T = np.eye(4)
    T[:3, :3] = rotation(np.array([1.0, -2.0, 0.5]), angle)
    assert pose_error(T, np.eye(4), 1.0)[1] == 2.0


@pytest.mark.parametrize("n", [5, 6, 7])
@pytest.mark.parametrize("damping", [1e-12, 1e-6, 1e-2, 1.0])
def test_damped_step_is_the_least_squares_solution(n: int, damping: float) -> None:
    """The step is NumPy's least-squares solution of the matrix with the damping below it."""
    rng = np.random.default_rng(n)
    for _ in range(5):
        J, twist = rng.normal(size=(6, n)), rng.normal(size=6)
        if n == 7 and damping < 1e-2:
            continue  # nearly undetermined: the two solutions may differ along the free direction
        stacked = np.vstack([J, damping * np.eye(n)])
        expected = np.linalg.lstsq(stacked, np.concatenate([twist, np.zeros(n)]), rcond=None)[0]
        tolerance = 1e-10 * max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(damped_step(J, twist, damping), expected, atol=tolerance)


@pytest.mark.parametrize("damping", [1e-3, 1e-6])
def test_damped_step_at_a_singularity_is_bounded(damping: float) -> None:
    """On a Jacobian that lost rank the step solves what can be solved and keeps still along the lost direction."""
    rng = np.random.default_rng(8)
    left, _, right = np.linalg.svd(rng.normal(size=(6, 6)))
    J = left @ np.diag([2.0, 1.5, 1.0, 0.7, 0.5, 0.0]) @ right
    assert abs(right[-1] @ damped_step(J, J @ rng.normal(size=6), damping)) < 1e-9
    assert np.abs(damped_step(J, left[:, -1], damping)).max() < 1e-15 / damping**2 + 1e-12


@pytest.mark.parametrize("sigma", [1e-2, 1e-4, 1e-8, 1e-12])
def test_weakest_direction_near_singular(sigma: float) -> None:
    """Near a singularity it is the smallest singular value, and its direction the one that belongs to it."""
    rng = np.random.default_rng(9)
    for _ in range(10):
        left, _, right = np.linalg.svd(rng.normal(size=(6, 6)))
        J = left @ np.diag([*rng.uniform(0.3, 2.0, 5), sigma]) @ right
        expected = np.linalg.svd(J, compute_uv=False)[-1]
        least, x = weakest(J)
        assert least == pytest.approx(expected, rel=1e-4, abs=1e-15)
        assert abs(abs(x @ right[-1]) - 1.0) < 1e-6


def test_weakest_direction_is_no_less_than_the_least() -> None:
    """Of any matrix it is between the smallest singular value and thrice that; of a singular one, zero to rounding."""
    rng = np.random.default_rng(10)
    for _ in range(200):
        J = rng.normal(size=(6, 6))
        least = np.linalg.svd(J, compute_uv=False)[-1]
        assert least * (1.0 - 1e-9) <= weakest(J)[0] <= 3.0 * least
    for J in (np.zeros((6, 6)), np.diag([1.0, 2.0, 0.0, 1.0, 1.0, 1.0]), np.ones((6, 6))):
        assert weakest(J)[0] < 1e-14


@pytest.mark.parametrize("sigma", [1e-4, 1e-8, 1e-12])
def test_weakest_direction_across_its_first_guess(sigma: float) -> None:
    """A lost direction at right angles to the vector of ones, where the iteration begins, is found all the same."""
    J = np.eye(6)
    J[:2, :2] = [[1.0, 1.0], [1.0, 1.0 + 2.0 * sigma]]
    expected = np.linalg.svd(J, compute_uv=False)[-1]
    assert weakest(J)[0] == pytest.approx(expected, rel=1e-3)
