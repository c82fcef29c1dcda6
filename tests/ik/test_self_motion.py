"""The nearest joint vector of an arm with seven joints, and its solutions along the redundancy parameter."""

import numpy as np
import pytest
from arms_seven import random_seven
from cases import Array, Case, described, worst_error

import urdf_ik
from urdf_ik import ArgumentError

KINDS = ("S-R-S", "S-R-S, offset elbow", "one behind wrist, 1x2", "one before 2||3||4, 5x6")


@pytest.fixture(scope="module", params=KINDS)
def case(request: pytest.FixtureRequest) -> Case:
    """A random member of each kind, whose limits are random, too."""
    return described(random_seven(request.param, 4))


def inside(arm: urdf_ik.Arm, rng: np.random.Generator, m: int) -> Array:
    """Joint vectors (m, 7) inside the limits; a continuous joint within half a turn."""
    low, high = np.clip(arm.limits.T, -10.0, 10.0)
    low, high = (np.where(np.isinf(arm.limits[:, 0]), side * np.pi, each) for side, each in ((-1, low), (1, high)))
    return rng.uniform(low, high, (m, 7))


def least_distance(arm: urdf_ik.Arm, T: Array, q_ref: Array, values: Array) -> float:
    """Distance [rad] of the nearest solution inside the limits at these values, over every image, one by one."""
    q = arm.ik(T, redundancy=values).q.reshape(-1, 7)
    q = q[~np.isnan(q).any(axis=1)]
    images = q[:, None, :] + 2.0 * np.pi * np.arange(-3, 4)[:, None]
    within = (images >= arm.limits[:, 0] - 1e-9) & (images <= arm.limits[:, 1] + 1e-9)
    squares = np.where(within, (images - q_ref) ** 2, np.inf).min(axis=1, initial=np.inf)
    return float(np.sqrt(squares.sum(axis=1)).min(initial=np.inf))


def test_the_reference_itself_is_nearest_to_itself(case: Case) -> None:
    """A pose made of a joint vector inside the limits gives that joint vector back, turns included."""
    q = inside(case.arm, np.random.default_rng(0), 30)
    found = case.arm.ik_nearest(case.oracle.poses(q), q)
    assert found.q.shape == (30, 1, 7)
    np.testing.assert_allclose(found.q[:, 0], q, atol=1e-7)
    np.testing.assert_allclose(np.exp(1j * found.redundancy), np.exp(1j * case.arm.redundancy_of(q)), atol=1e-7)


@pytest.mark.parametrize("name", ["srs_7r", "panda"])
def test_round_joint_vectors_are_their_own_nearest(name: str) -> None:
    """Straight and right-angled arms, whose poses leave surfaces of solutions, find the joint vector again."""
    arm, rng = urdf_ik.load(name), np.random.default_rng(0)
    round_ones = rng.integers(-1, 2, (12, 7)) * (0.5 * np.pi)
    straight = np.zeros((4, 7))
    straight[1:, 3] = 1e-3, 1e-5, 1e-8
    for q in np.vstack([straight, round_ones]):
        (found,) = arm.ik_nearest(arm.fk(q), q, within_limits=False)
        assert np.abs(np.angle(np.exp(1j * (found.q - q)))).max() < 1e-5, q.tolist()
        np.testing.assert_allclose(arm.fk(found.q), arm.fk(q), atol=1e-9)
        curves = arm.intervals(arm.fk(q), within_limits=False)
        for k in range(min(len(curves), 20)):
            values, samples = curves.samples(k)
            assert len(values) == len(samples) and np.abs(arm.fk(samples) - arm.fk(q)).max() < 1e-5


def test_the_minimum_lies_between_the_values_of_the_grid(case: Case) -> None:
    """Values 1e-4 to either side are no nearer: the search does not stop at its first grid."""
    rng = np.random.default_rng(2)
    T = case.oracle.poses(inside(case.arm, rng, 6))
    q_ref = inside(case.arm, rng, 6)
    found = case.arm.ik_nearest(T, q_ref)
    for i in range(6):
        distance = np.linalg.norm(found.q[i, 0] - q_ref[i])
        beside = float(found.redundancy[i]) + np.array([-1e-4, -1e-6, 1e-6, 1e-4])
        assert least_distance(case.arm, T[i], q_ref[i], beside) >= distance - 1e-9


def test_batch_and_single_agree(case: Case) -> None:
    """One reference for all poses, one for each, one by one, on two threads: the same answers, with their branch."""
    rng = np.random.default_rng(3)
    q = inside(case.arm, rng, 5)
    T = case.oracle.poses(q)
    table = case.arm.ik_nearest(T.reshape(5, 1, 4, 4), q[0])
    assert table.q.shape == (5, 1, 1, 7)
    for i in range(5):
        alone = case.arm.ik_nearest(T[i], q[0])
        np.testing.assert_allclose(alone.q, table.q[i, 0], atol=1e-9)
        assert alone.names[0] == table[i, 0].names[0]
        assert alone.names[0] in case.arm.structure.branches
        assert alone.branches == ("nearest",)
    np.testing.assert_array_equal(case.arm.ik_nearest(T, q, threads=2).q, case.arm.ik_nearest(T, q).q)


def test_nearest_without_a_solution(case: Case) -> None:
    """Out of reach there is no solution and a reason; arguments that do not fit are refused."""
    far = urdf_ik.pose([50.0, 0.0, 0.0])
    found = case.arm.ik_nearest(far, np.zeros(7))
    assert not found
    assert "nor at other values" in str(found.explain())
    with pytest.raises(ArgumentError, match="7"):
        case.arm.ik_nearest(far, np.zeros(6))
    with pytest.raises(ArgumentError, match="one a pose"):
        case.arm.ik_nearest(np.stack([far, far]), np.zeros((3, 7)))


WEIGHTS = np.array([4.0, 1.0, 0.5, 2.0, 1.0, 0.25, 1.0])


@pytest.mark.parametrize(("metric", "weights"), [("l2", None), ("l2", WEIGHTS), ("max", None), ("max", WEIGHTS)])
def test_nothing_nearer_is_found_by_dense_sampling(case: Case, metric: str, weights: np.ndarray | None) -> None:
    """No value of 1000 has a nearer solution inside the limits; the answer is exact and inside."""
    arm, rng = case.arm, np.random.default_rng(4)
    values = np.linspace(-np.pi, np.pi, 1000)
    q = inside(arm, rng, 5)
    T, q_ref = case.oracle.poses(q), inside(arm, rng, 5)
    found = arm.ik_nearest(T, q_ref, metric=metric, weights=weights)
    factors = np.ones(7) if weights is None else weights

    def distance(apart: np.ndarray) -> np.ndarray:
        return np.sqrt((factors * apart**2).sum(-1)) if metric == "l2" else (factors * np.abs(apart)).max(axis=-1)

    assert found.valid.all()
    for i in range(5):
        assert worst_error(case, found.q[i], T[i]) < 1e-9
        assert (np.abs(found.q[i] - np.clip(found.q[i], *arm.limits.T)) <= 1e-9).all()
        s = arm.ik(T[i], redundancy=values).turns()
        each = np.nan_to_num(distance(s.q - q_ref[i]), nan=np.inf).min(axis=1)
        assert distance(found.q[i, 0] - q_ref[i]) <= each.min() + 1e-9


def test_bounds_are_kept_where_some_value_keeps_them(case: Case) -> None:
    """A bound on one joint that excludes the nearest solution, but not the planted one, is kept."""
    rng = np.random.default_rng(5)
    q = inside(case.arm, rng, 6)
    T = case.oracle.poses(q)
    within = np.full(7, 0.7)
    q_ref = q + rng.uniform(-0.6, 0.6, q.shape)
    for joint in (1, 3):
        tight = within.copy()
        near = q_ref.copy()
        near[:, joint] = q[:, joint]
        tight[joint] = 0.02
        found = case.arm.ik_nearest(T, near, within=tight)
        kept = found.valid[:, 0]
        assert (np.abs(found.q[kept, 0] - near[kept]) <= tight + 1e-8).all()
        # Branches that exist for less than a step of the search's first grid may be missed.
        around = case.arm.redundancy_of(q)[:, None] + 2.0 * np.pi / 256.0 * np.array([-1.0, 1.0])
        beside = case.arm.ik(T[:, None], redundancy=around).q
        apart = np.abs(np.angle(np.exp(1j * (beside - q[:, None, None])))).max(axis=-1)
        lasting = (np.nan_to_num(apart, nan=np.inf).min(axis=-1) < 0.5).all(axis=1)
        assert kept[lasting].all() and kept.sum() >= 5
    nothing = case.arm.ik_nearest(T[0], q[0] + 0.5, within=1e-3)
    assert not nothing and "none as near to the reference as asked" in nothing.explain()
