"""Nearest postures and tolerances: what arms with few joints do where they cannot do all that is asked."""

import json
import re

import numpy as np
import pytest
from arms_few import case_of, draw, few
from cases import Case
from command import call
from hobby import BESIDE, SPLIT, URDF, angle_between, least_angle
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.errors import ArgumentError

Array = NDArray[np.float64]
FEW = ("3R any", "4R any", "5R any", "5R 2||3||4+4x5", "RRPR SCARA", "PPPRR")


def hobby() -> Case:
    """The arm of five servos, and Pinocchio's view of it."""
    return case_of(URDF)


def drawn(case: Case, count: int, seed: int = 0) -> Array:
    """Joint vectors (count, n) inside the limits."""
    low, high = np.clip(case.arm.limits.T, -np.pi, np.pi)
    return np.random.default_rng(seed).uniform(low, high, (count, case.arm.dof))


@pytest.mark.parametrize("digits", [6, None])
def test_a_rounded_pose_gives_its_joint_vector_back(digits: int | None) -> None:
    """Poses rounded to six decimals or to single precision: a joint vector within the tolerance, by Pinocchio."""
    case = hobby()
    q = drawn(case, 100)
    T = np.array([case.oracle.pose(each) for each in q])
    rounded = T.astype(np.float32).astype(np.float64) if digits is None else np.round(T, digits)
    assert case.arm.ik(rounded).count.sum() < 30
    s = case.arm.ik(rounded, tolerance=(1e-6, 2e-6))
    assert (s.count > 0).all()
    for i, b in np.argwhere(s.valid):
        reached = case.oracle.pose(s.q[i, b])
        off, angle = np.linalg.norm(reached[:3, 3] - rounded[i, :3, 3]), angle_between(reached[:3, :3], T[i, :3, :3])
        assert off < 1e-6
        assert angle < 3e-6
        assert s.error.position[i, b] == pytest.approx(off, abs=1e-12)
    apart = np.abs(np.where(s.valid[..., None], s.q - q[:, None], 9.0)).max(axis=-1).min(axis=-1)
    assert np.median(apart) < 1e-5


def test_an_exact_question_stays_exact() -> None:
    """Without a tolerance a rounded pose has no solution, and with one an exact pose has its exact solutions."""
    case = hobby()
    T = case.oracle.pose(drawn(case, 1)[0])
    assert len(case.arm.ik(np.round(T, 6))) == 0
    exact, near = case.arm.ik(T), case.arm.ik(T, tolerance=(1e-6, 1e-6))
    assert len(exact) == len(near) > 0
    assert near.error.position[near.valid].max() < 1e-12
    with pytest.raises(ArgumentError, match="two positive numbers"):
        case.arm.ik(T, tolerance=(1e-6, 0.0))


def test_a_printed_pose_is_typed_back(tmp_path: object) -> None:
    """The command takes the tolerance from the decimals, and says the error that it kept."""
    path = f"{tmp_path}/hobby.urdf"
    with open(path, "w") as file:
        file.write(URDF)
    q = [0.3, -0.2, 0.5, 0.7, 0.2]
    said = call("fk", path, "--q", ",".join(map(str, q))).stdout
    xyz = re.search(r"position \((.*?)\)", said)[1].replace(" ", "")  # type: ignore[index]
    quat = re.search(r"xyzw \((.*?)\)", said)[1].replace(" ", "")  # type: ignore[index]
    typed = ("ik", path, f"--xyz={xyz}", f"--quat-xyzw={quat}")
    found = json.loads(call(*typed, "--json").stdout)["poses"][0]["solutions"]
    assert min(np.abs(np.array(one["q"]) - q).max() for one in found) < 1e-4
    assert "missed by at most" in " ".join(call(*typed).stdout.split())
    assert call("ik", path, "--xyz", "0.22 0.08 0.04", "--rpy", "0 0 0", "--closest").exit_code == 0


@pytest.mark.parametrize("within_limits", [False, True])
def test_no_posture_is_nearer_that_reaches_the_position(within_limits: bool) -> None:
    """The first solution turns the tip no further than the best of 16 starts of SLSQP; the position is exact."""
    case = hobby()
    bounds = case.arm.limits if within_limits else None
    rng = np.random.default_rng(5)
    for q in drawn(case, 4, seed=2):
        T = urdf_ik.pose(case.oracle.pose(q)[:3, 3], rotvec=rng.uniform(-2.0, 2.0, 3))
        s = case.arm.ik_closest(T, within_limits=within_limits)
        reached = case.oracle.pose(s[0].q)
        assert np.linalg.norm(reached[:3, 3] - T[:3, 3]) < 1e-9
        assert angle_between(reached[:3, :3], T[:3, :3]) < least_angle(case, T, drawn(case, 16, seed=3), bounds) + 1e-6
        if within_limits:
            assert len(s.within_limits()) == len(s)


@pytest.mark.parametrize("name", FEW)
def test_what_can_be_reached_is_missed_by_nothing(name: str) -> None:
    """Poses of joint vectors: the nearest posture is a solution, for each of the orders and for weights."""
    case = few(name, 0)
    T = np.array([case.oracle.pose(q) for q in draw(case, np.random.default_rng(1), 20)])
    for options in ({}, {"first": "orientation"}, {"weights": (2.0, 1.0)}):
        error = case.arm.ik_closest(T, **options).error
        assert error.position[:, 0].max() < 1e-9
        assert error.rotation[:, 0].max() < 1e-9


def test_out_of_reach_the_arm_stretches() -> None:
    """Two links of 66 and 130 mm: the point at 0.3 m on x is missed by 0.104 m, with both links along x."""
    s = urdf_ik.load("planar_2r").ik_closest(urdf_ik.pose([0.3, 0.0, 0.0]))
    np.testing.assert_allclose(s[0].q, 0.0, atol=1e-6)
    assert s.error.position[0] == pytest.approx(0.104, abs=1e-9)


def test_orientation_first() -> None:
    """Of the postures with the exact rotation the nearest: no random start of SLSQP gets nearer."""
    from scipy.optimize import minimize

    case = hobby()
    T = urdf_ik.pose([0.1, 0.05, 0.5], rpy=[0.3, 0.9, 0.2])
    s = case.arm.ik_closest(T, first="orientation")
    assert s.error.rotation[0] < 1e-9
    turned = {"type": "eq", "fun": lambda q: (case.oracle.pose(q)[:3, :3] @ T[:3, :3].T)[[2, 0, 1], [1, 2, 0]]}
    for start in drawn(case, 20, seed=4):
        answer = minimize(
            lambda q: 10.0 * float(np.sum((case.oracle.pose(q)[:3, 3] - T[:3, 3]) ** 2)),
            start,
            method="SLSQP",
            constraints=[turned],
            options={"ftol": 1e-14, "maxiter": 200},
        )
        reached = case.oracle.pose(answer.x)
        if angle_between(reached[:3, :3], T[:3, :3]) < 1e-7:
            assert np.linalg.norm(reached[:3, 3] - T[:3, 3]) > s.error.position[0] - 1e-6


@pytest.mark.parametrize("within_limits", [False, True])
def test_three_joints_reach_positions_at_folds(within_limits: bool) -> None:
    """The position of a joint vector is reached to 1e-9, next to folds too, whatever the rotation is."""
    case = few("3R any", 0)
    rng = np.random.default_rng(1)
    places = [case.oracle.pose(q)[:3, 3] for q in drawn(case, 100, seed=1)]
    T = np.array([urdf_ik.pose(place, rotvec=rng.uniform(-2.0, 2.0, 3)) for place in places])
    s = case.arm.ik_closest(T, within_limits=within_limits)
    reached = np.array([case.oracle.pose(q) for q in s.q[:, 0]])
    assert np.linalg.norm(reached[:, :3, 3] - T[:, :3, 3], axis=1).max() < 1e-9


@pytest.mark.parametrize("within_limits", [False, True])
def test_no_solution_of_the_position_is_lost(within_limits: bool) -> None:
    """A position that a 3R arm reaches in two ways, which starts spread evenly do not find: both, exactly."""
    case = few("3R any", 3)
    T = urdf_ik.pose([0.573, -0.242, 0.184], rotvec=[-0.83, -2.01, -0.9])
    s = case.arm.ik_closest(T, within_limits=within_limits)
    assert len(s) == len(case.arm.ik(T[:3, 3], task="position")) == 2
    assert max(np.linalg.norm(case.oracle.pose(one.q)[:3, 3] - T[:3, 3]) for one in s) < 1e-9


@pytest.mark.parametrize("name", SPLIT)
def test_minima_in_closed_form(name: str) -> None:
    """SLSQP finds no smaller angle, from random starts or from near each of the minima."""
    case = case_of(SPLIT[name])
    rng = np.random.default_rng(7)
    for q in drawn(case, 3, seed=5):
        T = urdf_ik.pose(case.oracle.pose(q)[:3, 3], rotvec=rng.uniform(-2.0, 2.0, 3))
        s = case.arm.ik_closest(T)
        assert s.status == "complete"
        angles = s.error.rotation[s.valid]
        assert angles.min() < least_angle(case, T, drawn(case, 16, seed=6), None) + 1e-6
        for one, angle in zip(s, angles, strict=True):
            reached = case.oracle.pose(one.q)
            assert np.linalg.norm(reached[:3, 3] - T[:3, 3]) < 1e-9
            assert angle_between(reached[:3, :3], T[:3, :3]) == pytest.approx(angle, abs=1e-7)
            assert least_angle(case, T, one.q + rng.normal(size=(1, case.arm.dof)) * 1e-3, None) > angle - 1e-6


def test_a_tip_beside_the_roll() -> None:
    """Of SO-101's kind, its tip 8 mm beside the roll: SLSQP finds no smaller angle, and the position is exact."""
    case = case_of(BESIDE)
    rng = np.random.default_rng(3)
    T = np.array([case.oracle.pose(q) for q in drawn(case, 60, seed=5)])
    for k, pose in enumerate(T):
        T[k] = urdf_ik.pose(pose[:3, 3], rotvec=rng.uniform(-2.0, 2.0, 3))
    s = case.arm.ik_closest(T)
    assert set(s.status) == {"incomplete"}
    assert s.error.position[s.valid].max() < 1e-9
    for k in range(0, 60, 12):
        assert s.error.rotation[k, 0] < least_angle(case, T[k], drawn(case, 16, seed=6), None) + 1e-6
        assert np.linalg.norm(case.oracle.pose(s.q[k, 0])[:3, 3] - T[k, :3, 3]) < 1e-9


@pytest.mark.parametrize("name", ["yaw, plane, roll", "wrist"])
def test_the_nearest_point_of_the_reach(name: str) -> None:
    """Beyond the reach, and in the hole around the shoulder: no start of least squares gets nearer."""
    from scipy.optimize import least_squares

    case = case_of(SPLIT[name])
    rng = np.random.default_rng(1)
    shoulder = [0.0388, 0.0, 0.1166]
    for place in (*rng.normal(size=(4, 3)) * 0.5, shoulder + rng.normal(size=3) * 1e-3):
        T = urdf_ik.pose(place, rotvec=rng.uniform(-2.0, 2.0, 3))
        s = case.arm.ik_closest(T)
        assert s.status == "complete"
        starts = drawn(case, 12, seed=8)
        least = min(least_squares(lambda q, p: case.oracle.pose(q)[:3, 3] - p, q, args=(place,)).cost for q in starts)
        off = np.linalg.norm(case.oracle.pose(s[0].q)[:3, 3] - place)
        assert off == pytest.approx(s.error.position[0], abs=1e-12)
        assert off < np.sqrt(2.0 * least) + 1e-7
