"""The independent check of proofs: true answers are accepted, and those that lack or add a solution are refused."""

from typing import Any

import numpy as np
import pytest
from arms_general import calibrated_ur, crx_like, irb140_like, jaco_like, upright_ur, ur_with_right_angles
from cases import described, from_catalogue
from searches import folds

import urdf_ik
from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.verify import check_proof
from urdf_ik.verify.proof.check import examine
from urdf_ik.verify.proof.elimination import zeros
from urdf_ik.verify.proof.enclosure import between, enclosed
from urdf_ik.verify.proof.loop import Loop, exact, largest, residual

Q = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])


def verdict(loop: Loop, solutions: np.ndarray, *, clustered: bool = False) -> bool | None:
    """What the check says."""
    return examine(loop, solutions, clustered=clustered)[0]


@pytest.fixture(scope="module")
def general() -> tuple[Loop, np.ndarray]:
    """A pose of an arm without structure: its loop and its solutions."""
    arm = described(crx_like()).arm
    s = arm.ik(arm.fk(Q))
    return Loop.of(arm.chain, s.poses), s.q[s.valid]


def test_the_zeros_of_the_determinant_are_the_solutions(general: tuple[Loop, np.ndarray]) -> None:
    """As many on the circle as there are solutions, at their joint values; the others come in pairs."""
    loop, solutions = general
    found = zeros(loop, np.inf)
    assert len(found) == 16
    real = np.array([[float(x.real) for x in zero.q] for zero in found if not zero.off])
    apart = np.abs((real[:, None] - solutions + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)
    assert (apart < 1e-9).sum(axis=0).tolist() == [1] * len(solutions) == (apart < 1e-9).sum(axis=1).tolist()
    assert all(largest(residual(loop.values(zero.q))) < 1e-15 for zero in found)


def test_a_missing_doubled_or_wrong_solution_is_refused(general: tuple[Loop, np.ndarray]) -> None:
    """And the true answer is accepted."""
    loop, solutions = general
    wrong = solutions.copy()
    wrong[0, 1] += 1e-4
    assert verdict(loop, solutions) is True
    for each in (solutions[1:], np.concatenate([solutions, solutions[:1]]), wrong):
        assert verdict(loop, each) is False


MADE = {"calibrated": calibrated_ur, "parallel axes that are oblique": lambda: ur_with_right_angles(1.5708)}


@pytest.mark.parametrize("name", ["zyyzyz_6r", "puma_560", "ur5", *MADE])
def test_answers_of_closed_forms_are_accepted_and_shortened_ones_refused(name: str) -> None:
    """Their determinant vanishes, or all but vanishes, until the axes are moved."""
    arm = (described(MADE[name]()) if name in MADE else from_catalogue(name)).arm
    T = arm.fk(Q)
    solutions = arm.ik(T).q
    solutions = solutions[np.isfinite(solutions).all(-1)]
    loop = Loop.of(arm.chain, T)
    assert verdict(loop, solutions) is True
    assert verdict(loop, solutions[:-1]) is False


def test_an_empty_answer_is_accepted_only_out_of_reach() -> None:
    """Beyond the arm's length there is nothing; a pose in reach has solutions."""
    arm = urdf_ik.load("ur5")
    T = arm.fk(Q)
    none = np.zeros((0, 6))
    assert verdict(Loop.of(arm.chain, T), none) is False
    T[0, 3] += 5.0
    assert verdict(Loop.of(arm.chain, T), none) is True


def test_at_a_double_root_no_box_holds_a_single_one() -> None:
    """Of the arm as written. Two zeros of the moved arm are beside it."""
    arm = described(crx_like()).arm
    (q,) = folds(arm, 1, np.random.default_rng(0))
    loop = Loop.of(arm.chain, arm.fk(q))
    beside = [zero for zero in zeros(loop, 1e-4) if largest(between(zero.q, exact(q))) < 1e-4]
    assert len(beside) == 2
    assert enclosed(loop, exact(q)) is None


def test_an_answer_at_a_fold_is_accepted() -> None:
    """One of its solutions stands for a double root, or for two roots that rounding of the pose took off the reals."""
    arm = described(crx_like()).arm
    (q,) = folds(arm, 1, np.random.default_rng(0))
    T = arm.fk(q)
    s = arm.ik(T)
    solutions = s.q[s.valid]
    apart = np.abs((solutions - q + np.pi) % (2 * np.pi) - np.pi).max(axis=1)
    assert s.status == "clustered" and (apart < 1e-5).any()
    assert examine(Loop.of(arm.chain, T), solutions, clustered=True) == (True, "")


@pytest.mark.parametrize(
    "quarters", [(1, 1, 2, -1, -1, -1), pytest.param((2, 1, 2, -1, 1, -1), marks=pytest.mark.slow)]
)
def test_where_two_folds_meet_a_solution_stands_for_four_roots(quarters: tuple[int, ...]) -> None:
    """Four roots are within 1e-5 rad. The answer is clustered: it would not pass as complete, or without a solution."""
    arm = described(upright_ur()).arm
    T = arm.fk(0.5 * np.pi * np.array(quarters))
    s = arm.ik(T)
    assert s.status == "clustered"
    loop, solutions = Loop.of(arm.chain, T), s.q[s.valid]
    assert verdict(loop, solutions, clustered=True) is True
    assert verdict(loop, solutions) is not True
    assert all(verdict(loop, np.delete(solutions, k, 0), clustered=True) is False for k in range(len(solutions)))


@pytest.mark.parametrize(
    ("make", "quarters"),
    [
        (jaco_like, (0, 1, 2, 2, -1, -1)),
        (jaco_like, (-1, -1, 2, 2, 2, 1)),
        (irb140_like, (0, 2, 0, 2, 0, 1)),
        (irb140_like, (0, -1, -1, 0, 2, 0)),
    ],
)
def test_roots_far_from_real_are_proven_too(make: Any, quarters: tuple[int, ...]) -> None:
    """Imaginary parts add up to 13 to 17 rad there: rounding in doubles, times their exponential, exceeds the balls."""
    arm = described(make()).arm
    s = arm.ik(arm.fk(0.5 * np.pi * np.array(quarters)))
    assert s.certain
    assert np.abs(s.proof.roots.imag).sum(axis=1).max() > 13.0
    assert check_proof(arm, s).accepted


def test_filtered_answers_and_those_of_another_arm_are_refused() -> None:
    """What a filter left out is no solution that is missing."""
    arm = urdf_ik.load("zyyzyz_6r")
    s = arm.ik(arm.fk(Q))
    with pytest.raises(ArgumentError, match="filtered"):
        check_proof(arm, s.within_limits())
    with pytest.raises(ArgumentError, match="another arm"):
        check_proof(urdf_ik.load("puma_560"), s)


def test_the_report_counts_every_pose() -> None:
    """Accepted, not claimed, open and refused poses add up; a slide is no six turning joints."""
    arm = urdf_ik.load("zyyzyz_6r")
    q = np.random.default_rng(0).uniform(-3, 3, (2, 2, 6))
    report = check_proof(arm, arm.ik(arm.fk(q)))
    assert report.passed
    assert report.poses == 4 == report.unproven + report.accepted + len(report.open)
    slide = urdf_ik.load("scara_rrpr")
    with pytest.raises(UnsupportedArm, match="six turning joints"):
        check_proof(slide, slide.ik(slide.fk([0.3, 0.5, 0.1, 0.2])))
