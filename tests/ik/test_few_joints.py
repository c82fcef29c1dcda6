"""Arms with one to five joints: poses by any of them, complete, exact, and explained where they are out of reach."""

import math
import re

import numpy as np
import pytest
from arms import X, Z, rotation
from arms_few import (
    BUILDS,
    TRAVEL,
    apart,
    assert_answers,
    axes_and_points,
    case_of,
    draw,
    few,
    few_urdf,
)
from cases import Case, rows, worst_error
from numpy.typing import NDArray

from urdf_ik.errors import UnsupportedArm
from urdf_ik.ik.solutions import Singular

Array = NDArray[np.float64]
NAMES = tuple(BUILDS)
PLANAR = ("2R planar", "3R planar", "RRPR SCARA", "RRRP SCARA", "PRRR SCARA", "RPRR SCARA", "RRP SCARA")


@pytest.mark.parametrize("name", NAMES)
def test_out_of_reach_is_empty_and_explained(name: str) -> None:
    """A pose that the joints cannot give, however near, has no solution and a reason with a number."""
    case, rng = few(name, 5), np.random.default_rng(3)
    for distance in (1e-7, 1e-4, 0.1):
        q = draw(case, rng, 1)[0]
        T = case.oracle.pose(q)
        # Away from all that the joints can do: across the Jacobian's columns.
        J = case.oracle.jacobian(q)
        J[:3] /= case.arm.chain.size
        across = np.linalg.svd(J)[0][:, -1]
        T[:3, 3] += distance * case.arm.chain.size * across[:3]
        T[:3, :3] = rotation(across[3:] + 1e-30 * X, distance * np.linalg.norm(across[3:])) @ T[:3, :3]
        solutions = case.arm.ik(T)
        assert worst_error(case, rows(solutions), T) <= 1e-9
        if distance < 0.01:
            assert not solutions
            assert re.search(r"\d.* (m|rad)\b", solutions.explain()), solutions.explain()


@pytest.mark.parametrize("name", ["2R planar", "3R planar", "RRPR SCARA", "PRRR SCARA"])
@pytest.mark.parametrize("bend", [0.0, math.pi])
def test_planar_elbow_straight_and_folded(name: str, bend: float) -> None:
    """At the edges of reach, and next to them, the planted vector is found; exactly there it is marked singular."""
    case, rng = few(name, 6), np.random.default_rng(5)
    turning = np.flatnonzero(~case.arm.chain.prismatic)
    arm = case.arm
    for distance in (0.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
        q = draw(case, rng, 1)[0]
        # Where the Jacobian of the links is singular: the second joint's angle at which the two links line up.
        q[turning[1]] = 0.0
        joints = np.array([_joint_place(case, q, int(j)) for j in turning])
        end = joints[2] if len(turning) == 3 else case.oracle.pose(q)[:3, 3]
        normal = case.arm.chain.H[turning[0]]
        first, second = joints[1] - joints[0], end - joints[1]
        angle = math.atan2(np.cross(first, second) @ normal, first @ second - (first @ normal) * (second @ normal))
        sign = np.sign(case.arm.chain.H[turning[1]] @ normal)
        q[turning[1]] = sign * (bend - angle) + distance
        q[turning[1]] = (q[turning[1]] + math.pi) % (2.0 * math.pi) - math.pi
        T = case.oracle.pose(q)
        assert_answers(case, q, T, tol=None if distance else 1e-6)
        if distance == 0.0 and arm.dof > 2:
            assert any(one.singular & Singular.ELBOW for one in arm.ik(T))


def _joint_place(case: Case, q: Array, joint: int) -> Array:
    """Where a joint's axis is (3,) m at q, in the base, by Pinocchio's pose of the link behind it."""
    return np.asarray(case.arm.link_poses(q)[f"link_{joint + 1}"][:3, 3])


def test_rrp_folded_onto_axis_1_leaves_joint_1_free() -> None:
    """With the tip on axis 1 joint 1 is free: one marked representative, at the reference where one is given."""
    text = few_urdf("RRP", np.array([Z, Z, Z]), np.array([0 * X, 0.4 * X, 0.8 * X]), 0.8 * X, np.random.default_rng(0),
                    aligned=True)  # fmt: skip
    case = case_of(text)
    T = case.oracle.pose(np.array([0.7, math.pi, 0.2]))
    found = case.arm.ik(T)
    # Two joints and a slide: the turn of the tip still tells the first angle.
    assert apart(case, rows(found), np.array([0.7, math.pi, 0.2])).min() < 1e-6
    point = case.arm.ik(T[:3, 3], task="position")
    assert len(point) == 1
    assert point[0].singular
    at = case.arm.ik(T[:3, 3], q_ref=[0.7, 3.0, 0.0], task="position")
    assert at[0].q[0] == pytest.approx(0.7)


@pytest.mark.parametrize("name", ["3R positioning", "4R palletizer", "4R 1x2+2||3+3x4", "5R 2||3||4+4x5", "5R 1x2+4x5"])
@pytest.mark.parametrize("distance", [0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-3])
def test_wrist_point_on_axis_1_loses_no_planted_vector(name: str, distance: float) -> None:
    """Where the point that is placed first lies on axis 1, the later joints' turns still determine joint 1."""
    build, rng = BUILDS[name], np.random.default_rng(11)
    axes, points, tool = axes_and_points(build, rng)
    points[:, 1] = points[0, 1]  # no sideways offset, so that the point can come onto axis 1
    for first, second in build.meet:
        points[second] = points[first] + 0.2 * axes[first] if first == 0 else points[first]
    case = case_of(few_urdf(build.kinds, axes, points, tool, rng))
    rest = draw(case, rng, 1)[0]
    # Joint 2 leans the rest of the arm until the point on axis 4 (or the tip, for three) stands over axis 1.
    low, high = 0.0, math.pi
    place = points[3] if len(points) > 3 else tool * np.array([1.0, 0.0, 1.0]) + points[0] * np.array([0.0, 1.0, 0.0])

    def lean(angle: float) -> float:
        moved = points[2] + rotation(axes[2], rest[2]) @ (place - points[2])
        moved = points[1] + rotation(axes[1], angle) @ (moved - points[1])
        return float((moved - points[0])[0])

    assert lean(low) * lean(high) < 0.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if lean(middle) * lean(low) > 0.0 else (low, middle)
    rest[1] = middle + distance
    assert_answers(case, rest, case.oracle.pose(rest), tol=1e-6 + 1e-11 / max(distance, 1e-4))


def test_5r_axis_5_along_axes_1_2_3_gives_one_marked_representative() -> None:
    """Where axis 5 lies along axes 1, 2 and 3 the arm moves with its tip at rest: one representative, marked."""
    case, rng = few("5R 1||2||3", 2), np.random.default_rng(8)
    for _ in range(5):
        q = draw(case, rng, 1)[0]
        q[3] = rng.choice([-1.0, 1.0]) * math.pi / 2.0
        T = case.oracle.pose(q)
        solutions = case.arm.ik(T)
        assert worst_error(case, rows(solutions), T) <= 1e-9
        assert 1 <= np.count_nonzero(solutions.singular) <= 2


def test_redundant_arms_are_refused() -> None:
    """Joints that are redundant everywhere leave a continuum: the arm loads, and asking for solutions raises."""
    for kinds, axes in (("PP", [X, X]), ("RRRR", [Z, Z, Z, Z]), ("PRRP", [Z, Z, Z, Z]), ("RRPRP", [Z, Z, X, Z, Z])):
        rng = np.random.default_rng(1)
        points = np.cumsum(rng.uniform(0.2, 0.4, (len(kinds), 3)), axis=0)
        arm = case_of(few_urdf(kinds, np.array(axes), points, points[-1] + 0.2, rng)).arm
        with pytest.raises(UnsupportedArm, match="joints"):
            arm.ik(np.eye(4))


def test_scara_slide_beyond_its_limit_has_no_turns() -> None:
    """A slide is inside its limits or not; a revolute joint's image 2 pi away may be inside."""
    case = few("RRPR SCARA", 8)
    q = np.array([0.4, -0.8, 0.9 * TRAVEL, 2.0])
    T = case.oracle.pose(q)
    inside = case.arm.ik(T).within_limits()
    assert apart(case, rows(inside), q).min() < 1e-9
    assert len(case.arm.ik(T).turns()) == len(inside)
    np.testing.assert_allclose(inside.nearest(q).q[0], q, atol=1e-9)
    beyond = q.copy()
    beyond[2] = TRAVEL + 0.05
    out = case.arm.ik(case.oracle.pose(beyond))
    assert len(out)
    assert not out.within_limits()
    assert "'joint_3' at 1.0500 m, 0.05 m beyond its upper limit" in out.within_limits().explain()


@pytest.mark.parametrize("name", PLANAR)
def test_planar_arms_name_their_elbows(name: str) -> None:
    """The two columns are the two ways in which the elbow bends, the same ones for every pose."""
    case = few(name, 10)
    if name == "RRP SCARA":
        assert case.arm.ik(np.eye(4)).branches == ("elbow left", "elbow right")
    T = case.oracle.poses(draw(case, np.random.default_rng(4), 60))
    solutions = case.arm.ik(T)
    assert solutions.branches == ("elbow left", "elbow right")
    second = int(np.flatnonzero(~case.arm.chain.prismatic)[1])
    middle = {}
    for b in (0, 1):
        bent = solutions.q[solutions.valid[:, b], b, second]
        middle[b] = np.sort(bent)
        assert len(bent) > 10
    # One half turn of the second joint for each: the columns do not overlap on the circle.
    gaps = np.angle(np.exp(1j * (middle[0][:, None] - middle[1][None])))
    assert (np.abs(gaps) > 1e-9).all()


def test_an_arm_far_from_its_base_keeps_its_digits() -> None:
    """A mount 50 m away costs no more than the rounding of the pose itself."""
    rng = np.random.default_rng(4)
    text = few_urdf("RRRR", *axes_and_points(BUILDS["4R palletizer"], rng), rng)
    first = re.search(r'xyz="([^"]*)"', text)
    assert first
    moved = text.replace(first.group(0), 'xyz="50 -30 20"', 1)
    case = case_of(moved)
    for q in draw(case, rng, 20):
        assert_answers(case, q, case.oracle.pose(q))
