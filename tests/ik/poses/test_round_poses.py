"""General arms at common poses: joints at multiples of 90 degrees, the tool straight down, folded elbows.

At these poses the elimination's determinant is zero for every value of the hidden joint, or has multiple roots.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import pytest
from arms import DescribedArm, X, Y, Z, from_screws
from arms_general import crx_like, hc10_like, irb140_like, jaco_like, unstructured
from cases import Case, assert_exact, described, thinned
from numpy.typing import NDArray
from oracle import angle_distance

Array = NDArray[np.float64]


def folding() -> DescribedArm:
    """Like Fanuc's CRX-10iA: upper arm and forearm are equally long, so at q3 = -90 degrees axis 5 meets axis 2."""
    points = [(0, 0, 0.245), (0, 0, 0.245), (0, 0, 0.785), (0.3, 0, 0.785), (0.54, 0, 0.785), (0.54, -0.15, 0.785)]
    return from_screws("folding", "1x2, 2||3, 3x4, 4x5, 5x6", [Z, Y, -Y, -X, -Y, -X], points, (0.7, -0.15, 0.785))


MAKERS: dict[str, Callable[[], DescribedArm]] = {
    "crx": crx_like,
    "folding": folding,
    "hc10": hc10_like,
    "irb140": irb140_like,
    "jaco": jaco_like,
    "random": lambda: unstructured(3),
}
NOISES = (0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2)
REGULAR = 0.01  # least singular value, lengths as shares of the size, of the joint vectors that must be found


@lru_cache
def named(name: str) -> Case:
    """Load one of the arms."""
    return described(MAKERS[name]())


def least_singular_values(case: Case, Q: Array) -> Array:
    """(m,) of the Jacobians at Q (m, 6), lengths as shares of the size."""
    J = case.arm.jacobian(Q).copy()
    J[:, :3] /= case.arm.chain.size
    return np.linalg.svd(J, compute_uv=False)[:, -1]


def round_vectors(rng: np.random.Generator, count: int) -> Array:
    """(count, 6) rad, joints at 0, +-90 and 180 degrees."""
    return rng.integers(-1, 3, (count, 6)) * (np.pi / 2.0)


def assert_found(case: Case, Q: Array) -> None:
    """Each joint vector is among the solutions of its pose."""
    solutions = case.arm.ik(case.arm.fk(Q))
    lost = np.nan_to_num(angle_distance(solutions.q, Q[:, None, :]), nan=np.inf).min(axis=1) > 1e-6
    assert not lost.any(), f"{lost.sum()} of {len(Q)} lost, the first at {Q[lost][0].tolist()}"


@pytest.mark.parametrize("noise", thinned(NOISES, 3))
@pytest.mark.parametrize("name", MAKERS)
def test_round_joint_vectors_are_found(name: str, noise: float) -> None:
    """Regular joint vectors with all joints at, or near, multiples of 90 degrees are found."""
    case, rng = named(name), np.random.default_rng(1)
    Q = round_vectors(rng, 500)
    Q = Q[least_singular_values(case, Q) > REGULAR][:60]
    assert_found(case, Q + noise * rng.uniform(-1.0, 1.0, Q.shape))


@pytest.mark.parametrize("name", thinned(MAKERS, 3))
def test_rounding_does_not_change_the_number(name: str) -> None:
    """A regular pose keeps its number of solutions when its entries change by a few units in the last place."""
    case, rng = named(name), np.random.default_rng(2)
    Q = np.vstack([round_vectors(rng, 300), rng.uniform(-np.pi, np.pi, (60, 6))])
    targets = case.arm.fk(Q)
    solutions = case.arm.ik(targets)
    answers = [solutions[k].to_array() for k in range(len(targets))]
    least = np.array([least_singular_values(case, found).min(initial=1.0) for found in answers])
    targets, counts = targets[least > REGULAR], solutions.count[least > REGULAR]
    assert len(targets) > 50
    for _ in range(3):
        moved = targets.copy()
        moved[:, :3] *= 1.0 + rng.integers(-3, 4, moved[:, :3].shape) * 2.0**-52
        assert np.array_equal(case.arm.ik(moved).count, counts)


@pytest.mark.parametrize("distance", thinned([1e-1, 1e-3, 1e-4, 1e-5, 1e-6], 3))
def test_folding_arm_near_its_folded_elbow_loses_nothing(distance: float) -> None:
    """Next to q3 = -90 degrees every joint vector is nearly singular, and every planted one is found.

    Only a clustered answer may hold a representative farther off: one that sixteen roundings of the pose lead to.
    """
    case, rng = named("folding"), np.random.default_rng(3)
    Q = rng.uniform(-np.pi, np.pi, (150, 6))
    Q[:, 2] = -np.pi / 2.0 + distance * rng.choice([-1.0, 1.0], len(Q))
    solutions = case.arm.ik(case.arm.fk(Q))
    J = case.arm.jacobian(Q)
    J[:, :3] /= case.arm.chain.size
    led = 16.0 * np.finfo(float).eps / np.linalg.svd(J, compute_uv=False)[:, -1]
    apart = np.nan_to_num(angle_distance(solutions.q, Q[:, None, :]), nan=np.inf).min(axis=1)
    assert ((apart < 1e-6) | (solutions.status == "clustered") & (apart < led)).all()
    assert (apart < 1e-6).sum() >= 149


def test_folding_arm_at_its_folded_elbow_is_marked_singular() -> None:
    """At q3 = -90 degrees the arm is singular whatever the other joints do: one of the answers is marked."""
    case, rng = named("folding"), np.random.default_rng(4)
    Q = rng.uniform(-np.pi, np.pi, (150, 6))
    Q[:, 2] = -np.pi / 2.0
    solutions = case.arm.ik(case.arm.fk(Q))
    assert (solutions.singular > 0).any(axis=1).all()


@pytest.mark.parametrize(("name", "elbow", "turn"), [("crx", 0.5 * np.pi, 1.0), ("hc10", 0.0, -1.0)])
@pytest.mark.parametrize("last", [0.0, 0.5 * np.pi, np.pi])
def test_two_axes_in_line_where_three_ranks_are_lost_are_a_continuum(
    name: str, elbow: float, turn: float, last: float
) -> None:
    """With the arm straight up axes 1 and 4 are one line, and turning both keeps the pose. Three ranks are lost."""
    case, q = named(name), np.array([0.0, 0.0, elbow, 0.0, 0.0, last])
    J = case.arm.jacobian(q)
    J[:3] /= case.arm.chain.size
    assert np.linalg.svd(J, compute_uv=False)[3] < 1e-9
    T = case.arm.fk(q)
    for away in (-0.3, 0.02, 1.0):
        assert np.allclose(case.arm.fk(q + away * np.array([1.0, 0.0, 0.0, turn, 0.0, 0.0])), T, rtol=0.0, atol=1e-12)
    s = case.arm.ik(T)
    assert s.status == "continuum"
    assert_exact(case, s, T)


# The flange's axes at q = 0 in the maker's URDF of the CRX-10iA/L.
FLANGE = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])


def straight_down(case: Case, position: Array) -> Array:
    """The pose (4, 4) in which the flange points straight down at a position (3,) [m]."""
    target = np.eye(4)
    target[:3, :3] = np.diag([1.0, -1.0, -1.0]) @ FLANGE.T @ case.arm.fk(np.zeros(6))[:3, :3]
    target[:3, 3] = position
    return target


def test_crx_straight_down_in_front_keeps_twelve() -> None:
    """Fanuc's CRX-10iA/L has twelve solutions with the flange straight down 0.74 m in front of it."""
    case = named("crx")
    target = straight_down(case, np.array([0.74, 0.0, 0.52]))
    assert len(assert_exact(case, case.arm.ik(target), target)) == 12


def test_crx_folded_elbow_keeps_eight() -> None:
    """Fanuc's CRX-10iA/L has eight solutions at q3 = -90 degrees with all other joints at multiples of 90 degrees."""
    case = named("crx")
    target = case.oracle.pose(np.radians([180.0, 90.0, -90.0, 90.0, -90.0, 90.0]))
    assert len(assert_exact(case, case.arm.ik(target), target)) == 8


@pytest.mark.parametrize("place", range(6))
def test_crx_straight_down_on_a_grid_is_complete(place: int) -> None:
    """Every regular solution that multi-start Newton finds on Pinocchio's model is there."""
    case, rng = named("crx"), np.random.default_rng([5, place])
    position = np.array([0.05, 0.05, 0.05]) * rng.integers([6, -10, 0], [18, 10, 14])
    target = straight_down(case, position)
    solutions = case.arm.ik(target)
    found = assert_exact(case, solutions, target)
    for q in case.oracle.solutions(target, rng, starts=150):
        if case.oracle.sigma_min(q) > REGULAR:
            assert angle_distance(found, q).min(initial=np.inf) < 1e-6


def test_coaxial_axes_1_and_2_are_never_certain() -> None:
    """Axes 1 and 2 coincide: every pose leaves their difference free, and no count of solutions is certain."""
    points = [(0, 0, 0), (0, 0, 0), (0, 0, 0.5), (0.3, 0, 0.5), (0.5, 0.1, 0.5), (0.6, -0.15, 0.7)]
    case = described(from_screws("coaxial", "1 = 2", [Z, Z, -Y, -X, -Y, -X], points, (0.7, -0.15, 0.9)))
    solutions = case.arm.ik(case.arm.fk(np.random.default_rng(7).uniform(-3.0, 3.0, (5, 6))))
    assert (solutions.singular > 0).any(axis=1).all()
    assert not solutions.certain.any()
