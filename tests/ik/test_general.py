"""Six revolute joints without a closed form: every solution by elimination, measured by Pinocchio."""

from collections.abc import Callable
from functools import lru_cache

import contract
import core_steps
import numpy as np
import pytest
from arms import DescribedArm, Y, Z, from_screws
from arms_general import crx_like, hc10_like, irb140_like, jaco_like, manseur_doty, unstructured
from cases import Case, assert_exact, closest_pair, described, nearest, rows, thinned
from numpy.typing import NDArray
from searches import folds

from urdf_ik import _core
from urdf_ik.ik.families.parts.elimination import elimination_arm

Array = NDArray[np.float64]

MAKERS: dict[str, Callable[[], DescribedArm]] = {
    **{f"random-{seed}": lambda seed=seed: unstructured(seed) for seed in range(8)},
    "manseur_doty": manseur_doty,
    "crx": crx_like,
    "hc10": hc10_like,
    "jaco": jaco_like,
    "irb140": irb140_like,
}
STRUCTURED = ("crx", "hc10", "jaco", "irb140")
ALL = tuple(MAKERS)


@lru_cache
def named(name: str) -> Case:
    """Load one of the arms."""
    return described(MAKERS[name]())


# ---------------------------------------------------------------- whole arms


@pytest.mark.parametrize("name", ALL)
def test_contract(name: str) -> None:
    """Solved by elimination, in sixteen columns with numbers for names; the contract holds."""
    structure = named(name).arm.structure
    assert structure.family == "6R general"
    assert structure.branches == tuple(f"solution {k}" for k in range(1, 17))
    assert structure.max_solutions == 16
    assert structure.imperfection == (0.0, 0.0)
    contract.holds(named(name), 60, 1)
    contract.batch_equals_single_but_for_one(named(name), 3)
    contract.is_empty_out_of_reach(named(name))


@pytest.mark.parametrize("name", thinned(["random-0", "random-1", "manseur_doty", *STRUCTURED], 3))
def test_no_solution_is_missing(name: str) -> None:
    """Every solution that a multi-start Newton search on Pinocchio's model finds is there."""
    contract.is_complete(named(name), 2, 2, starts=200)


def test_manseur_doty_published_pose_has_sixteen() -> None:
    """The published arm and pose of Manseur and Doty have sixteen real solutions, no two of them alike."""
    case = named("manseur_doty")
    target = np.eye(4)
    target[:3] = [
        [-0.760117, -0.641689, 0.102262, -1.140175],
        [0.133333, 0.0, 0.991071, 0.0],
        [-0.635959, 0.766965, 0.085558, 0.0],
    ]
    left, _, right = np.linalg.svd(target[:3, :3])
    target[:3, :3] = left @ right  # the published digits are a rotation to six places
    found = assert_exact(case, case.arm.ik(target), target)
    assert len(found) == 16
    assert closest_pair(found) > 1e-2


@pytest.mark.parametrize("name", ["random-0", "random-1", "random-2", *STRUCTURED])
def test_singularities(name: str) -> None:
    """Where Pinocchio's Jacobian is singular a solution is marked; 1e-1 to 1e-7 rad beside it none is lost."""
    contract.holds_near_singularities(named(name), 30, 5)
    contract.holds_on_singularities(named(name), 10, 6)


# ---------------------------------------------------------------- the elimination's parts


@pytest.mark.parametrize("name", ["random-0", "random-1", "manseur_doty", *STRUCTURED])
def test_the_elimination_alone_finds_nearly_all(name: str) -> None:
    """One variant alone: 98 of 100 poses keep all their solutions, and a certain count is never too small."""
    case = named(name)
    targets = case.oracle.poses(case.oracle.draw(np.random.default_rng(11), 100))
    setup = elimination_arm(case.arm.chain)
    counts = np.empty((len(setup.variant.first), len(targets)), np.uint8)
    certain = np.empty_like(counts)
    _core.try_elimination(setup, setup.variant, targets, counts, certain)
    complete = counts == case.arm.ik(targets).count
    assert complete.mean() >= 0.98
    assert complete[certain > 0].all()


def self_inversive_roots(coefficients: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """The roots (n,) that the core finds of a polynomial (n + 1,), from the constant up."""
    numbers = np.column_stack([coefficients.real, coefficients.imag]).reshape(1, -1)
    found = core_steps.step(f"self_inversive_roots_{len(coefficients) - 1}", numbers)[0].reshape(-1, 2)
    return found[:, 0] + 1j * found[:, 1]


@pytest.mark.parametrize("degree", [4, 16])
def test_self_inversive_roots_are_the_planted_ones(degree: int) -> None:
    """Planted roots, on the unit circle or in pairs mirrored at it, come back from their polynomial's coefficients."""
    rng = np.random.default_rng(15)
    for on_circle in range(0, degree + 1, 2):
        pairs = (degree - on_circle) // 2
        # Well apart in angle: clustered roots are ill-conditioned, whatever the method.
        angles = 2.0 * np.pi * (np.arange(on_circle + pairs) + rng.uniform(-0.2, 0.2)) / (on_circle + pairs)
        angles = rng.permutation(angles)
        inside = np.exp(-rng.uniform(0.1, 0.5, pairs)) * np.exp(1j * angles[on_circle:])
        planted = np.concatenate([np.exp(1j * angles[:on_circle]), inside, 1.0 / np.conj(inside)])
        coefficients = np.poly(planted)[::-1]
        coefficients *= np.exp(0.5j * np.angle(np.conj(coefficients[0]) / coefficients[-1]))
        np.testing.assert_allclose(coefficients, np.conj(coefficients[::-1]), atol=1e-10 * abs(coefficients).max())
        z = self_inversive_roots(coefficients)
        distance = np.abs(planted[:, None] - z[None, :])
        assert sorted(distance.argmin(axis=1)) == list(range(degree))
        assert distance.min(axis=1).max() < 1e-9


def test_parallel_axes_2_3_4_and_5_6_lose_no_planted_vector() -> None:
    """The elimination is not set up with a determinant that lacks half of this arm's solutions."""
    axes = np.array([Z, Y, Y, Y, -Z, -Z])
    ends = [[0.61, 0, 0.18], [1.18, 0.17, 0.18], [1.18, 0.17, 0.06], [1.18, 0.29, 0.06]]
    points = np.array([[0, 0, 0.18], [0, 0, 0.18], *ends])
    case = described(from_screws("5||6", "2||3||4 and 5||6", axes, points, (1.18, 0.29, 0.06)))
    assert case.arm.structure.is_general
    Q = np.random.default_rng(6).uniform(-np.pi, np.pi, (60, 6))
    solutions = case.arm.ik(case.oracle.poses(Q))
    for i, q in enumerate(Q):
        assert nearest(rows(solutions[i]), q) < 1e-6


@pytest.mark.parametrize("name", ["jaco", "irb140"])
def test_a_pair_that_the_tolerance_may_make_real_is_in_each_certain_answer(name: str) -> None:
    """At a fold whose target lies 1e-12 beyond: no solution is real there, and the fold still keeps the pose."""
    arm = named(name).arm
    for q in folds(arm, 100, np.random.default_rng(0)):
        U, _, V = np.linalg.svd(arm.jacobian(q))
        slope = U[:, -1] @ (arm.jacobian(q + 1e-4 * V[-1]) - arm.jacobian(q - 1e-4 * V[-1])) @ V[-1] / 2e-4
        target = arm.fk(q)
        target[:3, 3] -= 1e-12 * np.sign(slope) * U[:3, -1]
        turn = -1e-12 * np.sign(slope) * U[3:, -1]
        target[:3, :3] += np.cross(turn, target[:3, :3], axisb=0, axisc=0)
        answer = arm.ik(target)
        assert abs(slope) < 0.01 or not answer.certain or nearest(rows(answer), q) < 1e-4, (q.tolist(), answer.status)
