"""Intervals of the redundancy parameter: they hold solutions, end for a reason, and none is missing."""

import re
from pathlib import Path

import numpy as np
import pytest
from arms import serial_urdf
from arms_seven import random_seven
from cases import Array, Case, described, worst_error

import urdf_ik
from urdf_ik.ik.redundancy import Interval

KINDS = ("S-R-S", "S-R-S, offset elbow", "one behind wrist, 1x2", "one before 2||3||4, 5x6")
TINY = 1e-7
"""rad: how far inside and outside an end is looked."""


@pytest.fixture(scope="module", params=KINDS)
def case(request: pytest.FixtureRequest) -> Case:
    """A random member of each kind, whose limits are random, too."""
    return described(random_seven(request.param, 4))


def near_limits(arm: urdf_ik.Arm, rng: np.random.Generator, m: int) -> Array:
    """Joint vectors (m, n) with one joint within 2 % of its range from a limit, where intervals are narrow."""
    low, high = np.clip(arm.limits.T, -np.pi, np.pi)
    q = rng.uniform(low, high, (m, arm.dof))
    joint, upper = rng.integers(arm.dof, size=m), rng.integers(2, size=m) == 1
    away = 0.02 * rng.uniform(size=m) * (high - low)[joint]
    q[np.arange(m), joint] = np.where(upper, high[joint] - away, low[joint] + away)
    return q


def test_every_planted_joint_vector_is_in_an_interval(case: Case) -> None:
    """The value of a joint vector inside the limits lies in an interval of its pose."""
    arm = case.arm
    q = near_limits(arm, np.random.default_rng(1), 60)
    for T, value in zip(case.oracle.poses(q), arm.redundancy_of(q), strict=True):
        assert any(value in interval for interval in arm.intervals(T))


def test_ends_are_ends(case: Case) -> None:
    """1e-7 inside each end there is an exact solution within the limits, 1e-7 outside none on that branch."""
    arm = case.arm
    looked = 0
    for q in near_limits(arm, np.random.default_rng(2), 12):
        T = case.oracle.pose(q)
        for interval in arm.intervals(T):
            for end, value, sign in zip(interval.ends, (interval.low, interval.high), (1.0, -1.0), strict=True):
                if end.cause in ("none", "range") or interval.width < 4.0 * TINY:
                    continue
                looked += 1
                inside, outside = (arm.ik(T, redundancy=value + sign * TINY * side) for side in (1.0, -1.0))
                there = inside.within_limits()
                assert there.valid.any()
                assert worst_error(case, there.to_array(), T) < 1e-9
                if end.cause == "limit":
                    # Of those that come near the limit, the joint is inside it on one side and outside on the other.
                    joint = arm.joint_names.index(str(end.joint))
                    limit = arm.limits[joint, int(bool(end.upper))]
                    apart = [
                        np.abs(np.angle(np.exp(1j * (s.to_array()[:, joint] - limit)))).min(initial=np.inf)
                        for s in (inside, outside)
                    ]
                    assert max(apart) < 1e-3
                else:
                    assert outside.count < inside.count
    assert looked > 20


def test_a_scan_finds_nothing_more(case: Case) -> None:
    """At 3,000 values there is a solution inside the limits exactly where the intervals say so."""
    arm = case.arm
    values = np.linspace(-np.pi, np.pi, 3001)[1:]
    for q in near_limits(arm, np.random.default_rng(3), 6):
        T = case.oracle.pose(q)
        count = arm.ik(T, redundancy=values).within_limits().count
        covering = covered(list(arm.intervals(T)), values)
        edge = np.zeros(len(values), dtype=np.bool_)
        for interval in arm.intervals(T):
            for end in (interval.low, interval.high):
                edge |= np.abs(np.angle(np.exp(1j * (values - end)))) < 1e-6
        np.testing.assert_array_equal(count[~edge], covering[~edge])


def test_calibrated_srs_round_poses_agree_with_a_scan() -> None:
    """A scan agrees where wrist and shoulder are aligned on the way: curves all but meet, or close after two turns.

    Origins of an S-R-S arm are off by 1e-4 m. Straight elbows are left out: the edge of reach is as near as that.
    """
    rng = np.random.default_rng(3)

    def moved(found: re.Match[str]) -> str:
        return f'<origin xyz="{" ".join(repr(float(x) + 1e-4 * rng.normal()) for x in found[1].split())}"'

    text = Path(urdf_ik.load("srs_7r").model.source).read_text()
    arm = urdf_ik.load(re.sub(r'<origin xyz="([^"]*)"', moved, text))
    values = np.linspace(-np.pi, np.pi, 361)[1:]
    turns = 0
    for _ in range(25):
        q = rng.choice(np.pi / 4 * np.arange(-3, 4), 7)
        q[rng.choice([1, 5])], q[3] = 0.0, rng.choice([-1.5, -0.5, 0.5, 1.5])
        T = arm.fk(q)
        for within in (False, True):
            found, s = list(arm.intervals(T, within_limits=within)), arm.ik(T, redundancy=values)
            count = s.within_limits().count if within else s.count
            beside = ((s.singular != 0) & s.valid).any(axis=-1)
            for end in (end for interval in found for end in (interval.low, interval.high)):
                beside |= np.abs(np.angle(np.exp(1j * (values - end)))) < 1e-5
            np.testing.assert_array_equal(count[~beside], covered(found, values)[~beside])
            assert all(interval.low <= interval.high <= interval.low + 2.0 * np.pi + 1e-9 for interval in found)
            turns += sum(interval.width > 6.28 for interval in found)
    assert turns > 10


@pytest.mark.parametrize(("axis", "lower", "upper"), [("z", -1.0, 2.5), ([0.0, 0.0, -1.0], -2.5, 0.5)])
def test_a_tip_that_turns_about_the_last_axis(axis: str | list[float], lower: float, upper: float) -> None:
    """A scan finds solutions where the intervals are, and the last joint's limits end them."""
    limit = 'lower="-4.642575810304916" upper="4.642575810304916"'
    text = Path(urdf_ik.load("puma_560").model.source).read_text()
    assert limit in text
    arm = urdf_ik.load(text.replace(limit, f'lower="{lower}" upper="{upper}"')).with_free_axis(axis)
    assert arm.solver.free_axis is not None
    rng = np.random.default_rng(8)
    T = arm.fk(rng.uniform(*arm.limits.T, (30, 6))) @ arm.solver.free_axis.rotation(rng.uniform(-3.0, 3.0, 30))
    values = np.linspace(-np.pi, np.pi, 721)[1:]
    found = arm.intervals(T)
    for each, pose in ((found[i], T[i]) for i in range(30)):
        assert each and {end.joint for interval in each for end in interval.ends} == {arm.joint_names[5]}
        count = arm.ik(pose, redundancy=values).within_limits().count
        np.testing.assert_array_equal(count, covered(list(each), values))


def covered(intervals: list[Interval], values: Array) -> Array:
    """(k,) how many intervals hold each of the values."""
    return np.array([sum(value in interval for interval in intervals) for value in values])


@pytest.mark.parametrize("kind", ["one behind wrist, 1x2", "S-R-S"])
def test_loops_narrower_than_the_grid_are_found(kind: str) -> None:
    """At the edge of a branch's reach an interval may be narrower than a step of the grid; it is found."""
    case = described(random_seven(kind, 4))
    arm, rng = case.arm, np.random.default_rng(4)
    narrow = 0
    for q in rng.uniform(-np.pi, np.pi, (300, 7)):
        T = case.oracle.pose(q)
        found = arm.intervals(T, within_limits=False)
        value = float(arm.redundancy_of(q))
        holding = sum(value in interval for interval in found)
        assert holding == int(arm.ik(T, redundancy=value).count)
        narrow += any(interval.width < 0.1 for interval in found)
    assert narrow > 3


def test_batch_is_its_poses(case: Case) -> None:
    """A batch holds what its poses hold one by one, whatever its shape; what is not a single pose is refused."""
    arm = case.arm
    T = case.oracle.poses(near_limits(arm, np.random.default_rng(5), 6)).reshape(2, 3, 4, 4)
    batch = arm.intervals(T)
    assert batch.shape == (2, 3)
    assert batch.count.shape == (2, 3)
    assert arm.intervals(T[0, :0]).count.shape == (0,)
    for i, j in np.ndindex(2, 3):
        alone = arm.intervals(T[i, j])
        assert [str(interval) for interval in batch[i, j]] == [str(interval) for interval in alone]
    with pytest.raises(urdf_ik.ArgumentError, match="single pose"):
        len(batch)
    with pytest.raises(urdf_ik.ArgumentError, match="more than one pose"):
        batch[0]


def test_best_is_best_by_dense_sampling(case: Case) -> None:
    """Of 3,000 values none has a solution farther from its limits, or of greater manipulability, beyond 1e-6."""
    arm = case.arm
    values = np.linspace(-np.pi, np.pi, 3001)[1:]
    for q in near_limits(arm, np.random.default_rng(6), 4):
        T = case.oracle.pose(q)
        everything = arm.ik(T, redundancy=values).within_limits()
        for by in ("limits", "manipulability"):
            best = arm.intervals(T).best(by)
            assert best.scores(by).max() >= np.nanmax(everything.scores(by)) - 1e-6


def test_out_of_reach_there_is_no_interval(case: Case) -> None:
    """Out of reach there is no interval, and no nearest or best solution."""
    found = case.arm.intervals(urdf_ik.pose([50.0, 0.0, 0.0]))
    assert len(found) == 0
    assert found.merged().shape == (0, 2)
    assert not found.best("limits")
    assert not found.nearest(np.zeros(7))


def test_free_axis() -> None:
    """A puma whose tool may turn: planted rotations are in an interval, and the nearest one is found again."""
    arm = urdf_ik.load("puma_560")
    free = arm.with_free_axis("z", at=(0.02, 0.0, 0.1))
    rng = np.random.default_rng(7)
    q = near_limits(arm, rng, 40)
    turned = rng.uniform(-np.pi, np.pi, 40)
    T = arm.fk(q) @ free.solver.free_axis.rotation(-turned)
    for pose, value in zip(T, turned, strict=True):
        assert any(value in interval for interval in free.intervals(pose))
    nearest = free.ik_nearest(T, q)
    np.testing.assert_allclose(nearest.q[:, 0], q, atol=1e-6)


def test_panda_elbow_down_has_a_gap_of_7_mrad() -> None:
    """Between two folds 0.007 rad apart the Panda has no solution with the elbow down; on both sides it has four."""
    arm = urdf_ik.load("panda")
    q = [2.255491088, -0.609099922, -2.229986609, -2.66782153, 1.876617404, 3.324392526, -1.920173338]
    T = arm.fk(q)
    found = [each for each in arm.intervals(T, within_limits=False) if -1.6 in each or -1.61 in each or -1.59 in each]
    values = np.linspace(-1.65, -1.55, 1001)
    count = arm.ik(T, redundancy=values).count
    assert set(count.tolist()) == {0, 4}
    np.testing.assert_array_equal(count, covered(found, values))


def test_xarm7_frames_three_folds_within_30_urad_are_told_apart() -> None:
    """A curve of solutions turns back, on again, and back within 3e-5 rad of the parameter; a scan agrees."""
    quarter = 1.5708
    turns = (0.0, -quarter, quarter, quarter, quarter, quarter, -quarter)
    wrist = ((0, 0, 0), (0.076, 0.097, 0))
    places = ((0, 0, 0.267), (0, 0, 0), (0, -0.293, 0), (0.0525, 0, 0), (0.0775, -0.3425, 0), *wrist)
    origins = [(place, (turn, 0.0, 0.0)) for place, turn in zip(places, turns, strict=True)]
    arm = urdf_ik.load(serial_urdf("seven", origins, [(0, 0, 1)] * 7))
    q = [-5.48752245, -0.69419653, -5.26039287, 2.74160097, -4.7911878, 2.86849077, -6.26434053]
    T = arm.fk(q)
    value = float(arm.redundancy_of(q))
    found = list(arm.intervals(T, within_limits=False))
    values = value + 1e-6 * np.linspace(-3.0, 30.0, 1001)
    s = arm.ik(T, redundancy=values)
    count, expected = s.count, covered(found, values)
    assert {0, 2, 4} <= set(count.tolist())
    # At a value so near to a fold that the arm keeps the pose to 1e-10 between its two solutions, these stand as one.
    (met,) = np.nonzero(s.status == "clustered")
    assert len(met) <= 3
    assert (2 * count[met] == expected[met - 1] + expected[met + 1]).all()
    np.testing.assert_array_equal(np.delete(count, met), np.delete(expected, met))
