"""6R arms with a hollow wrist, whose joint 6 mimics joint 5: every solution by Pinocchio; refusals with reasons."""

import math

import numpy as np
import pytest
from arms_hollow import hollow
from arms_mimic import mimicking
from numpy.typing import NDArray
from searches import newton
from with_reference import arm_and_reference, distances, holds, scaled_jacobian

import urdf_ik
from urdf_ik.errors import UnsupportedArm
from urdf_ik.support.tolerances import DEFAULT

Array = NDArray[np.float64]

KINDS = ("irb_5400", "mirrored", "one point", "half")


def drawn(kind: str, count: int, seed: int) -> Array:
    """Joint vectors (count, 6) over the whole joint space."""
    turns = np.array([1.0, 1.0, 1.0, 1.0, 2.0 if kind == "half" else 1.0, 1.0])
    return np.random.default_rng(seed).uniform(-math.pi, math.pi, (count, 6)) * turns


@pytest.mark.parametrize("kind", KINDS)
def test_planted_vectors_are_found(kind: str) -> None:
    """The planted joint vector is found; all solutions are exact, and none is given twice."""
    for seed in range(2):
        arm, reference = arm_and_reference(hollow(kind, seed))
        assert arm.structure.family == "6R hollow wrist, 2||3"
        holds(arm, reference, drawn(kind, 40, seed), loosened=10.0)


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_missing(kind: str) -> None:
    """Every solution that Newton's method finds from many starts over the whole joint space is there."""
    arm, reference = arm_and_reference(hollow(kind, 3))
    compared = 0
    for k, planted in enumerate(drawn(kind, 6, 5)):
        target = reference.pose(planted)
        found = arm.ik(target).to_array()
        for q in newton(arm.fk, arm.jacobian, arm.chain.size, target, drawn(kind, 200, 100 + k)):
            assert distances(arm, found, q).min() < 1e-6
            compared += 1
    assert compared > 50


@pytest.mark.parametrize("kind", ["irb_5400", "mirrored"])
@pytest.mark.parametrize("joint", [2, 4])
def test_at_and_near_singularities(kind: str, joint: int) -> None:
    """With the arm stretched, or axes 4 and 7 in line, and 1e-1 to 1e-7 rad beside that, planted vectors are found."""
    arm, reference = arm_and_reference(hollow(kind, 0))
    for q in drawn(kind, 3, 9):
        for distance in (0.0, 1e-7, 1e-5, 1e-3, 1e-1):
            q[joint] = distance if joint == 4 else stretched(arm, q) + distance
            s = arm.ik(reference.pose(q))
            found = s.to_array()
            assert len(found)
            assert max(e.max() for e in reference.errors(found, reference.pose(q))) <= 1e-9
            sigma = np.linalg.svd(scaled_jacobian(reference, q), compute_uv=False)[-1]
            if sigma > 1e-6:
                assert distances(arm, found, q).min() < 1e-6 + 1e-10 / sigma


def stretched(arm: urdf_ik.Arm, q: Array, joint: int = 2) -> float:
    """The value of a joint, joint 3 if not said otherwise, at which the Jacobian's smallest singular value is least."""
    low, high = -math.pi, math.pi
    for _ in range(8):
        x = np.tile(q, (401, 1))
        x[:, joint] = np.linspace(low, high, 401)
        J = arm.jacobian(x)
        J[:, :3] /= arm.chain.size
        best = float(x[np.argmin(np.linalg.svd(J, compute_uv=False)[:, -1]), joint])
        low, high = best - (high - low) / 400, best + (high - low) / 400
    return best


@pytest.mark.parametrize(("kind", "seed"), [("irb_5400", 0), *((kind, k) for kind in KINDS[1:] for k in range(2))])
def test_random_arms_lose_nothing_beside_singularities(kind: str, seed: int) -> None:
    """Every regular vector 1e-1 to 1e-6 rad beside a singularity of a random arm is found."""
    arm, reference = arm_and_reference(hollow(kind, seed))
    rng = np.random.default_rng([11, seed])
    compared = 0
    for start in drawn(kind, 25, 20 + seed):
        joint = int(rng.integers(1, 5))
        singular = stretched(arm, start, joint)
        for distance in 10.0 ** -np.arange(1.0, 7.0):
            q = start.copy()
            q[joint] = singular + rng.choice([-1.0, 1.0]) * distance
            sigma = np.linalg.svd(scaled_jacobian(reference, q), compute_uv=False)[-1]
            if sigma <= DEFAULT.singular:
                continue
            found = arm.ik(reference.pose(q)).to_array()
            assert distances(arm, found, q).min() < 1e-6 + 1e-11 / sigma
            compared += 1
    assert compared > 60


def test_joint_1_that_turns_faster_than_joint_5_is_followed() -> None:
    """A regular vector is found where the wrist's point passes axis 1, so that joint 1 turns faster than joint 5."""
    arm, reference = arm_and_reference(hollow("irb_5400"))
    q = np.array([2.2034, -0.5287, 2.0195, -0.0271, 1.7965, -1.0714])
    assert distances(arm, arm.ik(reference.pose(q)).to_array(), q).min() < 1e-6


def test_out_of_reach_and_one_by_one() -> None:
    """Out of reach there is no solution and a reason with a number; a batch equals its poses to the last bit."""
    arm, reference = arm_and_reference(hollow("irb_5400", 0))
    T = reference.pose(drawn("irb_5400", 5, 2))
    np.testing.assert_array_equal(arm.ik(T, threads=2).q, [arm.ik(each).q for each in T])
    T[0, :3, 3] += 100.0
    assert not arm.ik(T[0])
    assert "m from axis 1" in arm.explain(T[0])
    with pytest.raises(urdf_ik.PoseError):
        arm.ik(np.full((4, 4), np.nan))


def refused() -> dict[str, tuple[str, str]]:
    """URDF text of arms with six independent joints that are not solved, and words of the reason."""
    plain = hollow("mirrored")
    return {
        "passes by": (
            plain.replace('multiplier="-1.0"', 'multiplier="1.0"'),
            r"axes 4 and 7 \(joint_4, joint_7\) would have to meet",
        ),
        "another axis": (
            mimicking(plain.replace('<mimic joint="joint_5" multiplier="-1.0" offset="0.0" />', ""), 3, "joint_2", -1),
            r"axis 3 \(joint_3\) follows -1 joint_2",
        ),
        "no fraction": (plain.replace('multiplier="-1.0"', 'multiplier="-0.7071"'), "'joint_5'.*does not repeat"),
    }


@pytest.mark.parametrize("case", ["passes by", "another axis", "no fraction"])
def test_what_is_refused(case: str) -> None:
    """An arm that is not solved names the joints that prevent it."""
    text, reason = refused()[case]
    arm = urdf_ik.load(text, "base", "tool")
    assert arm.dof == 6
    with pytest.raises(UnsupportedArm, match=reason):
        arm.ik(arm.fk(np.zeros(6)))
