"""Arms of few joints, and of seven at a swivel angle: what an answer claims, against planted joint vectors."""

import numpy as np
import pytest

import urdf_ik
from urdf_ik import Arm

FEW = ("planar_2r", "positioning_3r", "scara_rrpr", "stanford_rrprrr")


def vectors(arm: Arm, many: int, seed: int) -> np.ndarray:
    """Joint vectors (many, n): all over, at multiples of 90 degrees, and 1e-9 to 1e-1 rad from such."""
    rng = np.random.default_rng(seed)
    Q = rng.uniform(-np.pi, np.pi, (many, arm.dof))
    Q[1::3] = rng.integers(-1, 3, Q[1::3].shape) * (np.pi / 2)
    width = 10.0 ** rng.uniform(-9, -1, (len(Q[2::3]), 1))
    Q[2::3] = rng.integers(-1, 3, Q[2::3].shape) * (np.pi / 2) + width * rng.normal(size=Q[2::3].shape)
    return Q


def missing(arm: Arm, Q: np.ndarray, s: urdf_ik.IKSolutions) -> np.ndarray:
    """Where an answer that says certain lacks the planted vector, and one half way to which the pose is kept, too."""
    step = (Q[:, None] - s.q + np.pi) % (2 * np.pi) - np.pi
    middle = np.asarray(arm.fk(np.nan_to_num(s.q + step / 2)))
    kept = np.abs(middle - np.asarray(arm.fk(Q))[:, None]).max(axis=(2, 3)) < 1e-10
    there = s.valid & (kept | (np.abs(step).max(axis=2) < 1e-4))
    missed: np.ndarray = s.certain & ~there.any(axis=1)
    return missed


@pytest.mark.parametrize("name", FEW)
def test_few_joints_deny_no_planted_vector(name: str) -> None:
    """Proven at most poses all over; never without the vector that the pose was made from."""
    arm = urdf_ik.load(name)
    Q = vectors(arm, 150, 3)
    s = arm.ik(arm.fk(Q))
    assert not missing(arm, Q, s).any()
    assert np.count_nonzero(s.certain[::3]) >= 40


def test_an_srs_arm_is_proven_at_a_swivel_angle_or_has_a_curve() -> None:
    """At round poses axes align: joints turn against each other, and the answer says so."""
    arm = urdf_ik.load("srs_7r")
    Q = vectors(arm, 300, 4)
    s = arm.ik(arm.fk(Q), redundancy=arm.redundancy_of(Q))
    assert not missing(arm, Q, s).any()
    assert (s.status[::3] == "complete").all()
    assert np.count_nonzero(s.status[1::3] == "incomplete") <= 2
    assert (s.status[1::3] == "continuum").any()
