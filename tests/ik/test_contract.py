"""The contract of ``ik`` for one to six joints, turning or sliding."""

import contract
import numpy as np
import pytest
from arms_few import (
    BUILDS,
    BUILDS_OF_ALL,
    apart,
    assert_answers,
    assert_complete,
    axes_and_points,
    case_of,
    draw,
    few,
    few_urdf,
)
from cases import rows

from urdf_ik.errors import PoseError
from urdf_ik.verify import crosscheck

NAMES = tuple(BUILDS_OF_ALL)
ROUNDED = ("2R planar", "3R planar", "RRPR SCARA", "4R palletizer", "4R 1x2+2||3+3x4", "5R 2||3||4+4x5")
ROUNDED += ("RRPRRR Stanford", "RPPRRR cylindrical", "PRRRRR any", "RRRRPR wrist at the base")


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_planted_joint_vector_is_found(name: str, seed: int) -> None:
    """The planted vector is among exact and different solutions; six joints have an even number of them."""
    case = few(name, seed)
    for q in draw(case, np.random.default_rng(seed), 30):
        found = assert_answers(case, q, case.oracle.pose(q))
        assert case.arm.dof < 6 or len(found) % 2 == 0


@pytest.mark.parametrize("name", NAMES)
def test_answers_are_complete(name: str) -> None:
    """No solution that Newton's method finds from many random starts is missing."""
    assert assert_complete(few(name, 3)) > (0 if name in BUILDS else 10)


@pytest.mark.parametrize("name", NAMES)
def test_batch_is_single(name: str) -> None:
    """A stack of poses has the answers of each of them, with any number of threads."""
    case = few(name, 4)
    T = case.oracle.poses(draw(case, np.random.default_rng(2), 60))
    T[::7, :3, 3] += 0.3
    contract.batch_equals_single(case, T)


@pytest.mark.parametrize("off", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("name", ROUNDED)
def test_rounded_decimals_are_exact_as_written(name: str, off: float) -> None:
    """Axes that are parallel, or meet, only to 1e-3 .. 1e-9 are solved as the URDF has them."""
    build, rng = BUILDS_OF_ALL[name], np.random.default_rng(21)
    axes, points, tool = axes_and_points(build, rng)
    axes = axes + off * rng.normal(size=axes.shape)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    case = case_of(few_urdf(build.kinds, axes, points + off * rng.normal(size=points.shape), tool, rng))
    for q in draw(case, rng, 10):
        assert_answers(case, q, case.oracle.pose(q))


@pytest.mark.parametrize(
    "name", ["1R", "2R planar", "RRP polar", "RRPR SCARA", "4R palletizer", "5R any", "PPP gantry"]
)
def test_crosscheck_holds(name: str) -> None:
    """The package's own check against Pinocchio passes, the planted joint vector included."""
    report = crosscheck.check(few(name, 9).arm, n=40)
    assert report.passed, str(report)
    assert report.row("planted joint vector").checked == 40


@pytest.mark.parametrize("name", ["2R planar", "4R any", "PPP gantry", "RRPRRR Stanford", "RPRPRP any"])
def test_targets_that_are_no_poses(name: str) -> None:
    """NaN, infinity and a matrix that is no rotation raise PoseError with the index; 1e-7 off is made a rotation."""
    case = few(name, 0)
    Q = draw(case, np.random.default_rng(0), 40)
    T = case.oracle.poses(Q)
    for bad in (np.nan, np.inf, 3.0, 0.0, "mirrored"):
        broken = T.copy()
        broken[33, :3, 0] *= -1.0 if bad == "mirrored" else 1.0
        broken[33, 0, 0] = broken[33, 0, 0] if bad == "mirrored" else bad
        with pytest.raises(PoseError) as error:
            case.arm.ik(broken)
        assert error.value.index == (33,)
    T[:, :3, :3] *= 1.0 + 1e-7
    assert all(apart(case, rows(case.arm.ik(pose)), q).min() < 1e-6 for pose, q in zip(T, Q, strict=True))
