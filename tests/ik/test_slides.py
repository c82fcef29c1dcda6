"""Six joints, some of them slides: complete, exact, named, and explained where a pose is out of reach."""

import math
import re

import numpy as np
import pytest
from arms import X, Y, Z
from arms_few import (
    SLIDES,
    WRISTLESS,
    apart,
    assert_answers,
    axes_and_points,
    draw,
    few,
    few_urdf,
)
from cases import Case, from_catalogue, rows, worst_error
from chains import joint, robot
from numpy.typing import NDArray
from oracle import Oracle

import urdf_ik
from urdf_ik.errors import UnsupportedArm
from urdf_ik.ik.solutions import Singular
from urdf_ik.verify import crosscheck

Array = NDArray[np.float64]
NAMES = tuple(SLIDES | WRISTLESS)
DISTANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)


@pytest.mark.parametrize("name", NAMES)
def test_near_and_at_singularities(name: str) -> None:
    """On a zero of the Jacobian's determinant, and 1e-1 to 1e-7 from there, no planted vector is lost."""
    case, rng = few(name, 6), np.random.default_rng(9)
    for _ in range(4):
        q, joint = case.oracle.singular(rng)
        T = case.oracle.pose(q)
        solutions = case.arm.ik(T)
        assert len(solutions)
        assert worst_error(case, rows(solutions), T) <= 1e-9
        assert solutions.singular.any()
        for distance in DISTANCES:
            near = q.copy()
            near[joint] += distance
            near = np.where(case.arm.chain.prismatic, near, (near + math.pi) % (2.0 * math.pi) - math.pi)
            T = case.oracle.pose(near)
            # Moving the pose by its rounding moves a solution by this over the square of the distance from a fold.
            tol = 1e-6 + 1e-13 / case.oracle.sigma_min(near) ** 1.5
            assert_answers(case, near, T, tol=tol)


def test_stanford_arm_has_eight_and_names_its_straight_wrist() -> None:
    """The bundled arm has eight solutions, passes its check, and names its wrist where that is singular."""
    case = from_catalogue("stanford_rrprrr")
    arm = case.arm
    assert arm.structure.family == "RRPRRR spherical wrist"
    report = crosscheck.check(arm, n=100)
    assert report.passed, str(report)
    q = np.array([0.3, 0.8, 0.7, -0.4, 0.9, 1.2])
    assert len(assert_answers(case, q, case.oracle.pose(q))) == 8
    q[4] = 0.0
    solutions = arm.ik(case.oracle.pose(q))
    assert all(one.singular & Singular.WRIST for one in solutions if abs(one.q[4]) < 1e-6)
    beside = arm.ik(case.oracle.pose(q), q_ref=q)
    assert apart(case, rows(beside), q).min() < 1e-6
    # The boom's centre on axis 1 is beyond an offset of 0.154 m.
    T = np.eye(4)
    T[:3, 3] = 0.05, 0.0, 0.412 + 0.263 + 0.3
    unreached = arm.ik(T)
    assert not unreached
    assert re.search(r"\d.* (m|rad)\b", unreached.explain()), unreached.explain()


@pytest.mark.parametrize("name", NAMES)
def test_out_of_reach_is_no_error(name: str) -> None:
    """Whatever the pose, the answer is exact or empty, and an empty one is explained by a number."""
    case, rng = few(name, 5), np.random.default_rng(3)
    T = case.oracle.poses(draw(case, rng, 10))
    T[:, :3, 3] = rng.normal(size=(10, 3))
    T[5:, :3, 3] *= 30.0
    for pose, solutions in zip(T, map(case.arm.ik, T), strict=True):
        assert worst_error(case, rows(solutions), pose) <= 1e-9
        if not solutions:
            assert re.search(r"\d.* (m|rad)\b", solutions.explain()), solutions.explain()


def test_redundant_arms_give_samples() -> None:
    """Four slides, parallel ones, a slide along an axis that turns: samples of the continuum, exact and marked."""
    rng = np.random.default_rng(1)
    for kinds, axes in (
        ("PPPPRR", [X, Y, Z, X + Y + Z, X, Y]),
        ("PPRRRR", [X, X, Z, X, Y, Z]),
        ("PRRRRP", [Z, Z, Z, Z, Z, Z]),
    ):
        directions = np.array(axes) / np.linalg.norm(axes, axis=1, keepdims=True)
        points = np.cumsum(rng.uniform(0.2, 0.4, (6, 3)), axis=0)
        text = few_urdf(kinds, directions, points, points[-1] + 0.2, rng)
        case = Case(kinds, urdf_ik.load(text, "base", "tool"), Oracle(text))
        assert case.arm.structure.family == f"{kinds} singular everywhere"
        for q in rng.uniform(-1.0, 1.0, (10, 6)):
            target = case.oracle.pose(q)
            found = rows(case.arm.ik(target))
            assert len(found) > 1
            assert max(case.oracle.error(each, target) for each in found) < 1e-9


def test_far_slides_keep_their_digits() -> None:
    """A slide 20 m out, and a mount 50 m away, cost no more than the rounding of the pose itself."""
    rng = np.random.default_rng(4)
    build = SLIDES["PPPRRR gantry"]
    text = few_urdf(build.kinds, *axes_and_points(build, rng), rng)
    first = re.search(r'xyz="([^"]*)"', text)
    assert first
    moved = text.replace(first.group(0), 'xyz="50 -30 20"', 1)
    case = Case("far", urdf_ik.load(moved, "base", "tool"), Oracle(moved))
    for q in draw(case, rng, 10):
        assert_answers(case, q, case.oracle.pose(q))
        q[:3] += 20.0
        assert_answers(case, q, case.oracle.pose(q))


def test_a_refused_arm_of_eight_joints_is_solved_as_its_message_says() -> None:
    """A lift, four slides and a wrist, as on Stretch: with the lock that the refusal names the arm answers."""
    axes = {"lift": "0 0 1", **{f"arm_l{k}": "0 -1 0" for k in (3, 2, 1, 0)}}
    axes |= {"wrist_yaw": "0 0 1", "wrist_pitch": "0 1 0", "wrist_roll": "1 0 0"}
    limit = '<limit lower="0" upper="0.5" effort="1" velocity="1"/>'
    kinds = ["revolute" if "wrist" in name else "prismatic" for name in axes]
    rows = enumerate(zip(axes, kinds, axes.values(), strict=True))
    text = robot(*(joint(n, kind, f"l{i}", f"l{i + 1}", "0.05 0 0.1", axis=a, more=limit) for i, (n, kind, a) in rows))
    arm = urdf_ik.load(text, "l0", "l8")
    with pytest.raises(UnsupportedArm, match=r"solved where 1 joint is locked.*locked={'lift': 0.0}.*--lock lift=0"):
        arm.ik(np.eye(4))
    locked = urdf_ik.load(text, "l0", "l8", locked={"lift": 0.0})
    q = np.full(7, 0.2)
    found = locked.ik(locked.fk(q), redundancy=locked.redundancy_of(q)).to_array()
    assert len(found)
    np.testing.assert_allclose(locked.fk(found), np.broadcast_to(locked.fk(q), (len(found), 4, 4)), atol=1e-9)
