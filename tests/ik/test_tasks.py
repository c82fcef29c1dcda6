"""Tasks: targets with fewer numbers than a pose, for arms that control no more."""

import math
from typing import Any

import numpy as np
import pytest
from arms import X, Y, Z, rotation
from arms_few import BUILDS, apart, axes_and_points, case_of, draw, few, few_urdf
from cases import Case, rows
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError, PoseError

Array = NDArray[np.float64]
TURNING = tuple(name for name, b in BUILDS.items() if b.task == "position" and b.kinds.count("R") > 1)
CONTROLLED = tuple(name for name, build in BUILDS.items() if build.task != "pose")


def target_of(case: Case, q: Array) -> Array:
    """The target (k,) of the arm's own task at q, by Pinocchio's pose."""
    T, arm = case.oracle.pose(q), case.arm
    if arm.task == "position":
        return T[:3, 3]
    if arm.task == "position and axis":
        return np.concatenate([T[:3, 3], T[:3, :3] @ arm.solver.control.aimed])
    planar: Array = arm.solver.control.plane.coordinates(T)
    return planar[:2] if arm.task == "planar position" else planar


def miss(case: Case, q: Array, target: Array) -> float:
    """How far [m, rad] a joint vector is from a target, by Pinocchio."""
    off = target_of(case, q) - target
    if case.arm.task == "planar pose":
        off[2] = math.remainder(off[2], 2.0 * math.pi)
    return float(np.abs(off).max())


@pytest.mark.parametrize("name", BUILDS)
def test_an_arm_knows_its_task(name: str) -> None:
    """The task follows from the joints, whatever the mount, the tool and the directions of the axes."""
    for seed in range(3):
        arm = few(name, seed).arm
        assert arm.task == BUILDS[name].task
        assert (arm.solver.control.plane is not None) == name.endswith("planar") or name == "PP"


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("name", CONTROLLED)
def test_planted_joint_vector_is_found(name: str, seed: int) -> None:
    """A planted joint vector is found for its target; every solution reaches the target, none is given twice."""
    case = few(name, seed)
    for q in draw(case, np.random.default_rng(seed), 25):
        target = target_of(case, q)
        found = rows(case.arm.ik(target, task=case.arm.task))
        assert len(found)
        assert max(miss(case, one, target) for one in found) <= 1e-9
        assert apart(case, found, q).min() < 1e-5
        for i, one in enumerate(found[:-1]):
            assert (apart(case, found[i + 1 :], one) > 1e-8).all()


@pytest.mark.parametrize("name", CONTROLLED)
def test_answers_are_complete(name: str) -> None:
    """Every solution that Newton's method finds from random starts is there."""
    case, rng, arrived = few(name, 3), np.random.default_rng(1), 0
    for q in draw(case, rng, 3):
        target = target_of(case, q)
        found = rows(case.arm.ik(target, task=case.arm.task))
        for start in draw(case, rng, 25):
            other = _search(case, start, target)
            if other is not None:
                arrived += 1
                assert apart(case, found, other).min() < 1e-4
    assert arrived


def _search(case: Case, q: Array, target: Array) -> Array | None:
    for _ in range(30):
        off = target - target_of(case, q)
        if case.arm.task == "planar pose":
            off[2] = math.remainder(off[2], 2.0 * math.pi)
        if np.abs(off).max() < 1e-10:
            return q
        near = [target_of(case, q + 1e-6 * one) - target_of(case, q - 1e-6 * one) for one in np.eye(len(q))]
        J = np.array(near).T / 2e-6
        if np.abs(J).max() > 1e3:  # across the end of an angle's range
            return None
        step = np.linalg.solve(J.T @ J + 1e-4 * min(1.0, float(off @ off)) * np.eye(len(q)) + 1e-15, J.T @ off)
        q = q + step * min(1.0, 0.7 / max(float(np.abs(step).max()), 1e-9))
    return None


@pytest.mark.parametrize("name", CONTROLLED)
def test_batch_is_single(name: str) -> None:
    """A stack of targets gives what each target gives; a target out of reach is empty and explained."""
    case = few(name, 4)
    targets = np.array([target_of(case, q) for q in draw(case, np.random.default_rng(2), 80)])
    if not case.arm.chain.prismatic.any():
        targets[::9, 0] += 100.0
    task = case.arm.task
    batch = case.arm.ik(targets.reshape(8, 10, -1), task=task)
    assert batch.shape == (8, 10)
    np.testing.assert_array_equal(batch.q, case.arm.ik(targets, task=task, threads=2).q.reshape(batch.q.shape))
    for i in range(0, 80, 3):
        one = case.arm.ik(targets[i], task=task)
        np.testing.assert_array_equal(batch[i // 10, i % 10].q, one.q)
        assert bool(one) != bool(one.explain())
    if not case.arm.chain.prismatic.any():
        assert "m" in case.arm.ik(targets[0], task=task).explain()


@pytest.mark.parametrize("distance", [0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("name", TURNING)
def test_position_near_its_singularities(name: str, distance: float) -> None:
    """At, and next to, joint vectors where the tip's velocity loses a direction, the planted vector is found."""
    case, rng = few(name, 6), np.random.default_rng(3)
    for _ in range(5):
        q, joint = _singular(case, rng)
        q[joint] += distance
        target = case.oracle.pose(q)[:3, 3]
        solutions = case.arm.ik(target, task="position")
        found = rows(solutions)
        assert len(found)
        assert max(miss(case, one, target) for one in found) <= 1e-9
        sigma = np.linalg.svd(case.oracle.jacobian(q)[:3], compute_uv=False)[-1]
        assert apart(case, found, q).min() < 1e-6 + 1e-11 / max(sigma, 1e-9 if distance else 1e-6), (q, found)
        if not distance:
            assert solutions.singular.any()


def _singular(case: Case, rng: np.random.Generator) -> tuple[Array, int]:
    """A joint vector at which the determinant of the position's Jacobian changes sign along one joint, and that one."""
    for _ in range(200):
        q, joint = draw(case, rng, 1)[0], int(rng.integers(3))

        def determinant(value: float, q: Array = q, joint: int = joint) -> float:
            moved = q.copy()
            moved[joint] = value
            return float(np.linalg.det(case.oracle.jacobian(moved)[:3]))

        grid = np.linspace(-3.0, 3.0, 25)
        values = [determinant(value) for value in grid]
        for low, high, at_low, at_high in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True):
            if at_low * at_high < 0.0 and max(abs(at_low), abs(at_high)) > 1e-6:
                while (middle := 0.5 * (low + high)) not in (low, high):
                    low, high = (middle, high) if determinant(middle) * at_low > 0.0 else (low, middle)
                q[joint] = middle
                return q, joint
    raise AssertionError("no singularity found")


def test_coordinates_of_the_plane() -> None:
    """Along the base's axes these are the plane's, in the order x, y, z; else the base's x as it lies in the plane."""
    rng = np.random.default_rng(0)
    for normal, first, second in ((Z, X, Y), (-Z, X, Y), (Y, X, Z), (-Y, X, Z), (X, Y, Z), (-X, Y, Z)):
        # Points that lie in the plane, so that nothing but the coordinates is tested.
        points = np.array([0.3 * first, 0.5 * first + 0.1 * second, 0.9 * first, 1.1 * first])
        urdf = few_urdf("RRR", np.array([normal, normal, -normal]), points[:3], points[3], rng, aligned=True)
        case = case_of(urdf)
        np.testing.assert_allclose(case.arm.solver.control.plane.axes, [first, second], atol=1e-12)
        T = case.oracle.pose(np.array([0.2, -0.5, 0.9]))
        x, y, angle = case.arm.solver.control.plane.coordinates(T)
        np.testing.assert_allclose([x, y], [T[:3, 3] @ first, T[:3, 3] @ second], atol=1e-12)
        ahead = T[:3, :3] @ case.arm.solver.control.plane.heading
        assert angle == pytest.approx(math.atan2(ahead @ second, ahead @ first))
    tilted = rotation(X, 0.4) @ Z
    points = np.array([0 * X, 0.4 * X, 0.8 * X])
    arm = case_of(few_urdf("RR", np.array([tilted, tilted]), points[:2], points[2], rng, aligned=True)).arm
    np.testing.assert_allclose(arm.solver.control.plane.axes[0], X, atol=1e-12)
    np.testing.assert_allclose(arm.solver.control.plane.normal, tilted, atol=1e-12)
    np.testing.assert_allclose(np.cross(*arm.solver.control.plane.axes), arm.solver.control.plane.normal, atol=1e-12)


def test_two_links_of_66_and_130_mm_obey_the_law_of_cosines() -> None:
    """The elbow's two angles are those of the law of cosines; the column names tell which side the elbow is on."""
    points = np.array([0 * X, 0.066 * X])
    text = few_urdf("RR", np.array([Z, Z]), points, 0.196 * X, np.random.default_rng(0), aligned=True)
    case = case_of(text)
    mount = case.oracle.pose(np.zeros(2))[:3, 3] - 0.196 * X
    x, y = 0.1, 0.12
    solutions = case.arm.ik(np.array([x, y]) + mount[:2], task="planar position")
    bend = math.acos((x * x + y * y - 0.066**2 - 0.13**2) / (2.0 * 0.066 * 0.13))
    np.testing.assert_allclose(sorted(rows(solutions)[:, 1]), [-bend, bend], atol=1e-12)
    left, right = solutions.q
    # The elbow left of the way to the point: the second link turns to the right.
    assert left[1] < 0.0 < right[1]
    assert left[0] > math.atan2(y, x) > right[0]


def test_the_last_axis_is_not_aimed() -> None:
    """Where z of the tip lies along the last axis, whose turn does not move it, another axis of the tip is aimed."""
    rng = np.random.default_rng(2)
    axes, points, tool = axes_and_points(BUILDS["5R 2||3||4+4x5"], rng)
    axes[4], tool = Z, points[4] + 0.3 * Z
    case = case_of(few_urdf("RRRRR", axes, points, tool, rng, aligned=True))
    assert case.arm.task == "position and axis"
    np.testing.assert_array_equal(case.arm.solver.control.aimed, X)
    q = draw(case, rng, 1)[0]
    assert apart(case, rows(case.arm.ik(target_of(case, q), task="position and axis")), q).min() < 1e-6


@pytest.mark.parametrize(
    ("name", "task", "target", "words"),
    [
        ("2R planar", "position", np.zeros(3), "do not control 'position'.*'planar position'"),
        ("3R planar", "planar position", np.zeros(2), "'planar pose'"),
        ("4R any", "position and axis", np.zeros(6), "give the whole pose"),
        ("3R any", "reach", np.zeros(3), "no task is called 'reach'; tasks: 'pose', 'position'"),
    ],
)
def test_tasks_that_an_arm_cannot_control(name: str, task: str, target: Array, words: str) -> None:
    """The error names the task that the arm controls."""
    with pytest.raises(ArgumentError, match=words):
        few(name).arm.ik(target, task=task)


@pytest.mark.parametrize(
    ("name", "target"),
    [
        ("2R planar", [0.1, 0.2, 0.3]),
        ("3R planar", "here"),
        ("3R any", [0.1, math.inf, 0.0]),
        ("5R any", ([0.1, 0.2, 0.3], [1.0, 0.0])),
    ],
)
def test_wrong_targets(name: str, target: Any) -> None:
    """A target of the wrong shape, not finite, or pointing nowhere raises PoseError that names the task."""
    arm = few(name).arm
    with pytest.raises(PoseError, match="task"):
        arm.ik(target, task=arm.task)
