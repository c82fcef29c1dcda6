"""Parts of a pose: what is asked is reached, as Pinocchio measures it, by arms with more or fewer joints."""

import numpy as np
import pytest
from arms_few import case_of
from cases import Case, from_catalogue
from command import call
from hobby import LIFT, PAN, URDF, angle_between, urdf_of
from numpy.typing import NDArray

import urdf_ik

Array = NDArray[np.float64]
TASKS = ("position", "position and axis", "level", "orientation", "axis", "look at")


def arm_of(name: str) -> Case:
    """The hobby arm, a camera on two joints, or one of the catalogue."""
    texts = {"hobby": URDF, "camera": urdf_of((PAN, LIFT), "0.03 0.01 0.02")}
    return case_of(texts[name]) if name in texts else from_catalogue(name)


def missed(task: str, axis: Array, T: Array, reached: Array) -> float:
    """The greatest part of what a task asks for that a pose misses [m, 1]."""
    off, R, wanted = reached[:3, 3] - T[:3, 3], reached[:3, :3], T[:3, :3]
    parts = {
        "position": [off],
        "position and axis": [off, (R - wanted) @ axis],
        "level": [off, (R - wanted)[2]],
        "orientation": [(R - wanted).ravel()],
        "axis": [(R - wanted) @ axis],
        "look at": [off + (R @ axis) * np.linalg.norm(off)],
    }[task]
    return max(float(np.abs(part).max()) for part in parts)


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("name", ["hobby", "puma_560", "srs_7r"])
def test_what_is_asked_is_reached(name: str, task: str) -> None:
    """Every solution at the pose of a joint vector reaches what was asked to 1e-9."""
    arm, axis = arm_of(name), np.array([1.0, 0.0, 0.0])
    T = arm.oracle.pose(np.linspace(-0.6, 0.7, arm.arm.dof))
    named = axis if task in ("position and axis", "axis", "look at") else None
    s = arm.arm.ik(T, task=urdf_ik.Task.read(task, named))
    assert len(s) > 0
    for one in s:
        assert missed(task, axis, T, arm.oracle.pose(one.q)) < 1e-9
    assert max(s.error.position[s.valid].max(), s.error.rotation[s.valid].max()) < 1e-9


@pytest.mark.parametrize(
    ("name", "task"),
    [
        ("hobby", "position"),
        ("hobby", "position and axis"),
        ("hobby", "level"),
        ("srs_7r", "position and axis"),
        ("camera", "axis"),
        ("camera", "look at"),
    ],
)
def test_joints_follow_a_moving_target(name: str, task: str) -> None:
    """Joints moved by ``dq_dT`` miss a target that moves by 1e-5 m and rad by its square only."""
    arm, axis = arm_of(name), np.array([1.0, 0.0, 0.0])
    T = arm.oracle.pose(np.linspace(-0.6, 0.7, arm.arm.dof))
    T[:3, 3] += [0.3, 0.1, 0.2] if task == "look at" else [0.0, 0.0, 0.0]
    s = arm.arm.ik(T, task=urdf_ik.Task.read(task, axis if task in ("position and axis", "axis", "look at") else None))
    rates = s.dq_dT()
    for twist in 1e-5 * np.random.default_rng(3).normal(size=(3, 6)):
        moved = urdf_ik.pose(T[:3, 3] + twist[:3], rotvec=twist[3:])
        moved[:3, :3] = moved[:3, :3] @ T[:3, :3]
        for one, rate in zip(s, rates[s.valid], strict=True):
            assert missed(task, axis, moved, arm.oracle.pose(one.q + rate @ twist)) < 1e-7


@pytest.mark.parametrize(("name", "free"), [("hobby", 2), ("puma_560", 3), ("scara_rrpr", 1)])
def test_a_position_leaves_joints_free(name: str, free: int) -> None:
    """As many redundancy parameters as joints beyond three; at their values the joint vector comes back."""
    arm = arm_of(name)
    q = np.linspace(-0.2, 0.3, arm.arm.dof)
    made = arm.arm.for_task("position")
    assert len(made.solver.parameters) == free
    s = made.ik(arm.oracle.pose(q)[:3, 3], redundancy=made.redundancy_of(q))
    assert s.status == "complete"
    assert np.abs(s.nearest(q)[0].q - q).max() < 1e-8


def test_no_solution_of_newtons_method_is_lacking() -> None:
    """Position and direction with five joints: 'complete', and scipy's roots from 100 starts are all there."""
    from scipy.optimize import least_squares

    arm = arm_of("hobby")
    rng = np.random.default_rng(4)
    axis = np.array([0.0, 1.0, 0.0])
    T = arm.oracle.pose([0.3, -0.2, 0.5, 0.7, 0.2])
    s = arm.arm.ik(np.append(T[:3, 3], T[:3, 1]), task="position", axis="y")
    assert s.status == "complete"

    def error(q: Array) -> Array:
        reached = arm.oracle.pose(q)
        return np.concatenate([reached[:3, 3] - T[:3, 3], reached[:3, 1] - T[:3, 1]])

    for start in rng.uniform(-np.pi, np.pi, (100, 5)):
        root = least_squares(error, start, xtol=1e-14, ftol=1e-14, gtol=1e-14)
        if np.abs(root.fun).max() < 1e-9:
            apart = np.abs((s.q[s.valid] - root.x + np.pi) % (2 * np.pi) - np.pi).max(axis=1)
            assert apart.min() < 1e-6
    assert missed("position and axis", axis, T, arm.oracle.pose(s[0].q)) < 1e-9


def test_values_elsewhere() -> None:
    """Where the default has no solution inside the limits, ``best`` has one, and ``explain`` names a value."""
    arm = arm_of("hobby")
    rng = np.random.default_rng(2)
    low, high = arm.arm.limits.T
    made = arm.arm.for_task("position")
    places = np.array([arm.oracle.pose(q)[:3, 3] for q in rng.uniform(low, high, (60, 5))])
    s = made.ik(places)
    assert 5 < (s.within_limits().count == 0).sum() < 55
    best = s.best("limits")
    assert (best.count == 1).all()
    for q, place in zip(best.q[:, 0], places, strict=True):
        assert ((q >= low) & (q <= high)).all()
        assert np.abs(arm.oracle.pose(q)[:3, 3] - place).max() < 1e-9
    lacking = int(np.flatnonzero(s.count == 0)[0])
    assert "there are solutions at flex" in s[lacking].explain()


def test_the_command(tmp_path: object) -> None:
    """A point above the desk, with any orientation, with a direction, and one that only other values reach."""
    path = f"{tmp_path}/hobby.urdf"
    with open(path, "w") as file:
        file.write(URDF)
    point = ("ik", path, "--xyz=0.22,0.08,0.04", "--task=position")
    assert call(*point, "--within-limits").exit_code == 0
    said = call(*point, "--axis=x", "--rpy=0,1.57,0").stdout
    assert "position and direction of x" in said
    assert call("ik", path, "--axis=x").exit_code == 2
    assert "--task position" in call("ik", path, "--xyz=0.22,0.08,0.04").stderr
    assert "--closest" in call("ik", path, "--xyz=0.22,0.08,0.04", "--rpy=0.5,1,2").stderr
    assert "inside the limits" in " ".join(call("ik", path, "--xyz=-0.05,0.04,0.21", "--task=position").stdout.split())


@pytest.mark.parametrize("within_limits", [False, True])
@pytest.mark.parametrize("task", TASKS[1:])
def test_the_closest_of_a_part_of_a_pose(task: str, within_limits: bool) -> None:
    """What a joint vector does is missed by nothing."""
    arm, axis = arm_of("puma_560"), np.array([1.0, 0.0, 0.0])
    T = arm.oracle.pose(np.linspace(-0.6, 0.7, 6))
    asked = urdf_ik.Task.read(task, axis if task in ("position and axis", "axis", "look at") else None)
    T[:3, 3] += 0.3 * (T[:3, :3] @ axis) * (task == "look at")
    found = arm.arm.ik_closest(T, task=asked, within_limits=within_limits)[0]
    assert missed(task, axis, T, arm.oracle.pose(found.q)) < 1e-9


def test_a_region_of_five_joints() -> None:
    """Any orientation at the point where the arm stands: the nearest joint vector is the one it has."""
    arm = arm_of("hobby")
    q = np.array([0.3, -0.2, 0.5, 0.7, 0.2])
    here = arm.oracle.pose(q)
    anyhow = urdf_ik.Region(cone=3.1415, rotation=np.pi)
    found = arm.arm.ik_nearest(urdf_ik.pose(here[:3, 3]), q, region=anyhow)
    assert np.abs(found[0].q - q).max() < 1e-6
    beside = urdf_ik.pose(here[:3, 3] + [0.0, 0.01, 0.0])
    moved = arm.arm.ik_nearest(beside, q, region=anyhow)
    reached = arm.oracle.pose(moved[0].q)
    assert anyhow.contains(beside, reached)
    assert np.abs(moved[0].q - q).max() < 0.1


@pytest.mark.parametrize("task", ["position", "level", "orientation", "axis"])
@pytest.mark.parametrize("name", ["hobby", "puma_560", "srs_7r"])
def test_the_nearest_of_what_is_asked(name: str, task: str) -> None:
    """A joint vector that does what is asked is nearest to itself; beside it SLSQP finds none that is nearer."""
    from scipy.optimize import minimize

    arm, axis = arm_of(name), np.array([1.0, 0.0, 0.0])
    q = np.linspace(-0.6, 0.7, arm.arm.dof)
    T, asked = arm.oracle.pose(q), urdf_ik.Task.read(task, "x" if task == "axis" else None)
    target = T[:3, 3] if task == "position" else T
    assert np.abs(arm.arm.ik_nearest(target, q, task=asked, within_limits=False).difference(q)).max() < 1e-6
    near = q + np.random.default_rng(2).uniform(-0.4, 0.4, arm.arm.dof)
    found = arm.arm.ik_nearest(target, near, task=asked, within_limits=False)[0].q
    assert missed(task, axis, T, arm.oracle.pose(found)) < 1e-9
    for start in (near, q):
        answer = minimize(
            lambda x: 0.5 * float((x - near) @ (x - near)),
            start,
            method="SLSQP",
            constraints={"type": "eq", "fun": lambda x: missed(task, axis, T, arm.oracle.pose(x))},
            options={"maxiter": 300, "ftol": 1e-12},
        )
        if missed(task, axis, T, arm.oracle.pose(answer.x)) < 1e-7:
            assert np.linalg.norm(found - near) < np.linalg.norm(answer.x - near) + 1e-5


@pytest.mark.parametrize("task", ["pose", "level", "position"])
def test_teleoperation(task: str) -> None:
    """The tip is pushed 60 mm aside, 1 mm a cycle: it comes along to 1e-6 m, and says what it misses."""
    arm = arm_of("hobby")
    q = np.array([0.0, -0.3, 0.4, 0.6, 0.0])
    T = arm.oracle.pose(q)
    tracker = arm.arm.for_task(task).tracker(q, dt=0.02)
    for _ in range(60):
        T[1, 3] += 0.001
        step = tracker.step(T)
    reached = arm.oracle.pose(step.q)
    assert np.linalg.norm(reached[:3, 3] - T[:3, 3]) < 1e-6
    assert step.distance < 1e-6
    if task == "pose":
        assert (step.status, step.why) == ("limited", "reach")
        assert np.trace(reached[:3, :3] @ T[:3, :3].T) == pytest.approx(1.0 + 2.0 * np.cos(step.angle), abs=1e-9)
    else:
        assert step.status == "ok"
        assert missed(task, T[:3, 0], T, reached) < 1e-6


def test_a_path_with_the_position_first() -> None:
    """60 mm aside with one orientation, as five joints cannot: the place is exact, the rotation as in the nearest."""
    arm = arm_of("hobby")
    T = np.tile(arm.oracle.pose(np.array([0.0, -0.3, 0.4, 0.6, 0.0])), (13, 1, 1))
    T[:, 1, 3] += np.linspace(0.0, 0.06, 13)
    assert not arm.arm.follow(T).found
    plan = arm.arm.follow(T, first="position")
    nearest = arm.arm.ik_closest(T, within_limits=True).error.rotation[:, 0]
    for q, wanted, least in zip(plan.q, T, nearest, strict=True):
        reached = arm.oracle.pose(q)
        assert np.linalg.norm(reached[:3, 3] - wanted[:3, 3]) < 1e-9
        assert angle_between(reached[:3, :3], wanted[:3, :3]) == pytest.approx(least, abs=1e-7)
