"""explain: why a pose has no solution, with the number that is out of range."""

import math
import re
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import core_arms
import numpy as np
import pinocchio as pin
import pytest
from arms import industrial, random_arm
from arms_general import crx_like, jaco_like
from cases import Case, described, from_catalogue
from numpy.typing import NDArray
from oracle import Oracle

from urdf_ik.arm import Arm

Array = NDArray[np.float64]
Q = np.array([0.3, 0.5, 0.9, 0.4, 0.8, -0.2])


def numbers_in(text: str) -> list[float]:
    """The numbers that stand before 'm', a length."""
    return [float(number) for number in re.findall(r"(\d[\d.e+-]*) m\b", text)]


def origin_of(oracle: Oracle, joint: int, q: Array) -> Array:
    """Place (3,) [m] of a joint's frame in the base, by Pinocchio; joints count from 1."""
    oracle.pose(q)
    base = oracle.data.oMf[oracle.base]
    return base.actInv(oracle.data.oMi[oracle.joints[joint - 1]]).translation


def placed(arm: Arm, centre: Array, wrist: Array, turn: Array) -> Array:
    """The target (4, 4) with a rotation that brings the point ``centre`` of the tip's frame to ``wrist``."""
    target = np.eye(4)
    target[:3, :3] = turn
    target[:3, 3] = wrist - turn @ centre
    assert arm.ik(target).count == 0
    return target


def turns(m: int) -> Array:
    """Random rotation matrices (m, 3, 3)."""
    rng = np.random.default_rng(12)
    return np.array([pin.exp3(rng.uniform(-2.0, 2.0, 3)) for _ in range(m)])


ZYYZYZ = lru_cache(lambda: from_catalogue("zyyzyz_6r"))
HYPOT = math.hypot(math.hypot(1.2, 1.3) - 0.15, 0.9 - 0.5)
FOREARM = math.hypot(0.35 + 0.35, 0.12)  # axis 3 to the wrist's centre


@pytest.mark.parametrize(
    ("case", "centre", "shoulder", "distance", "lengths", "words"),
    [
        (ZYYZYZ, (0.0, 0.0, 3.1), (0.0, 0.0, 1.0), 2.1001, (2.1001, 2.1, 0.0001), "shoulder.*reach.*too far$"),
        (ZYYZYZ, (0.0, 0.0, 3.1), (0.0, 0.0, 1.0), 12.0, (12.0, 2.1, 9.9), "shoulder.*reach.*too far$"),
        (ZYYZYZ, (0.0, 0.0, 3.1), (0.0, 0.0, 1.0), 0.0999, (0.0999, 0.1, 0.0001), "folded.*too near$"),
        (ZYYZYZ, (0.0, 0.0, 3.1), (0.0, 0.0, 1.0), 0.001, (0.001, 0.1, 0.099), "folded.*too near$"),
        # The smaller distance of both ways to turn the shoulder, which stands 0.15 m beside axis 1.
        (lambda: described(industrial()), (0.85, 0.0, 1.22), (1.2, 1.3, 0.9), 0.0, (HYPOT, 0.6 + FOREARM), "reach"),
        (lambda: described(industrial(b=0.1)), (0.85, 0.1, 1.22), (0.03, 0.04, 1.0), 0.0, (0.05, 0.1, 0.05), "axis 1"),
    ],
)
def test_the_wrists_distance_and_the_reach_are_told(
    case: Callable[[], Case], centre: Sequence[float], shoulder: Sequence[float], distance: float,
    lengths: Sequence[float], words: str,
) -> None:  # fmt: skip
    """With the wrist's centre (at zero: ``centre``) at a distance from a place, the text tells the lengths [m]."""
    arm, oracle = case().arm, case().oracle
    in_tip = (np.linalg.inv(oracle.pose(np.zeros(6))) @ [*centre, 1.0])[:3]
    for turn in turns(3):
        target = placed(arm, in_tip, shoulder + distance * turn[0], turn)
        for text in (arm.explain(target), arm.ik(target).explain()):
            assert numbers_in(text)[:2] == pytest.approx(lengths[:2], rel=1e-5)
            assert numbers_in(text)[2 : len(lengths)] == pytest.approx(lengths[2:], rel=5e-3)
            assert re.search(words, text)


def test_ur5_wrist_near_axis_1_tells_its_offset() -> None:
    """Where the wrist would be closer to axis 1 than the sideways offset, the text tells both, as the URDF has them."""
    case = from_catalogue("ur5")
    wrist = origin_of(case.oracle, 6, np.zeros(6))
    # Axes 5 and 6 meet in the point of axis 6 at the height of axis 5; axis 1 is z, axes 2 to 4 are y.
    meeting = np.array([wrist[0], origin_of(case.oracle, 5, np.zeros(6))[1], wrist[2]])
    in_tip = (np.linalg.inv(case.oracle.pose(np.zeros(6))) @ [*meeting, 1.0])[:3]
    for turn in turns(3):
        target = placed(case.arm, in_tip, np.array([0.06, -0.02, 0.4]), turn)
        text = case.arm.ik(target).explain()
        assert numbers_in(text)[:2] == pytest.approx([math.hypot(0.06, 0.02), abs(meeting[1])], rel=1e-5)
        assert "axis 1" in text and "axes 5 and 6" in text


def test_ur5_out_of_reach_tells_the_distance_of_axes_2_and_4() -> None:
    """The text tells how far apart the pose wants axes 2 and 4, and the reach of the two links between them."""
    case = from_catalogue("ur5")
    places = [origin_of(case.oracle, joint, np.zeros(6)) for joint in (2, 3, 4)]
    across = [np.array([p[0], p[2]]) for p in places]  # seen along y, the direction of axes 2 to 4
    links = math.dist(across[0], across[1]) + math.dist(across[1], across[2])
    for turn in turns(3):
        target = np.eye(4)
        target[:3, :3] = turn
        for place in ([0.0, 5.0, 0.0], [0.9, 0.9, 0.1]):
            target[:3, 3] = place
            wanted, reach, off = numbers_in(case.arm.explain(target))
            assert off == pytest.approx(wanted - reach, rel=5e-3)
            assert reach == pytest.approx(links, rel=1e-5)
            # Axis 2 is 0.09 m above the base's origin, axis 4 within 0.21 m of the tip, 0.11 m beside axis 2.
            assert links < wanted < math.hypot(*place) + 0.3
            assert wanted > math.hypot(*place) - 0.45


@pytest.mark.parametrize("kind", ["wrist, 1x2", "wrist, 1||2", "wrist, general", "2||3||4"])
def test_explain_every_family(kind: str) -> None:
    """Whatever the family, a pose far away is explained by a length in metres, and a reachable one by nothing."""
    case = described(random_arm(kind, 1))
    far = np.eye(4)
    far[:3, 3] = [40.0, 30.0, 20.0]
    assert max(numbers_in(case.arm.ik(far).explain())) > 10.0
    assert case.arm.ik(case.oracle.pose(Q)).explain() == ""
    assert case.arm.explain(case.oracle.pose(Q)) == ""


@pytest.mark.parametrize(("name", "seen_from"), [("2p3p4-0", "base"), ("2x3x4-0", "base"), ("2x3x4+reversed-0", "tip")])
def test_where_no_length_fails_the_nearest_pose_is_told(name: str, seen_from: str) -> None:
    """In the axes of a link that is named: of an arm that is solved from tip to base, the tip's."""
    arm = dict(core_arms.every_arm())[name]
    rng = np.random.default_rng(2)
    told = 0
    for _ in range(30):
        target = arm.fk(rng.uniform(-3.0, 3.0, 6))
        target[:3, 3] *= rng.uniform(0.5, 1.0) * arm.chain.size / np.linalg.norm(target[:3, 3])
        solutions = arm.ik(target)
        if not solutions.count and "nearest that was found" in (text := solutions.explain()):
            told += 1
            assert text.endswith(f" of {getattr(arm, seen_from)!r}")
    assert told


@pytest.mark.parametrize("make", [crx_like, jaco_like])
def test_a_general_arm_tells_the_nearest_pose(make: Any) -> None:
    """In reach of its links and without a solution, the text tells by how much the nearest pose is off."""
    case = described(make())
    rng = np.random.default_rng(3)
    told = 0
    for _ in range(24):
        target = case.oracle.pose(rng.uniform(-3.0, 3.0, 6))
        target[:3, 3] *= 0.97 * case.arm.chain.size / np.linalg.norm(target[:3, 3])
        solutions = case.arm.ik(target)
        if solutions.count or np.linalg.norm(target[:3, 3] - case.arm.chain.points[0]) > case.arm.chain.size:
            continue
        told += 1
        text = solutions.explain()
        assert "the nearest that was found is off by" in text and max(numbers_in(text)) > 1e-6
    assert told >= 3


@pytest.mark.parametrize("name", ["zyyzyz_6r", "srs_7r", "stanford_rrprrr", "scara_rrpr"])
def test_a_pose_within_reach_is_explained_by_the_limits_alone(name: str) -> None:
    """Nothing where a solution is inside them; else the limits, not the reach."""
    arm = from_catalogue(name).arm
    low, high = np.clip(arm.limits.T, -3.0, 3.0)
    assert arm.explain(arm.fk(0.5 * (low + high))) == ""
    target = arm.fk(high + 0.2 * (high - low))
    solutions = arm.ik(target)
    assert solutions.count
    expected = "" if arm.redundancy and arm.intervals(target) else solutions.within_limits().explain()
    assert arm.explain(target) == expected
