"""Poses from every notation and back, against SciPy and Pinocchio; what is refused, and in which words."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from urdf_ik import PoseError
from urdf_ik.model.poses import (
    as_pose_array,
    check_poses,
    pose,
    project_rotation,
    to_quat_wxyz,
    to_quat_xyzw,
    to_rotvec,
    to_rpy,
)

Array = NDArray[np.float64]

EPS = float(np.finfo(np.float64).eps)
EXACT = 8 * EPS
HALF_TURN, UPRIGHT = np.pi, np.pi / 2

# Angles where a formula may break: zero, a half turn, a vertical pitch, and a little beside them.
angles = st.one_of(
    st.floats(-np.pi, np.pi),
    st.builds(
        lambda at, off: at + off,
        st.sampled_from([0.0, UPRIGHT, -UPRIGHT, HALF_TURN, -HALF_TURN]),
        st.sampled_from([0.0, 1e-16, -1e-16, 1e-15, 1e-12, -1e-9, 1e-8, 1e-7, -1e-5, 1e-3]),
    ),
)
directions = st.one_of(
    st.sampled_from([(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.0, -0.8), (-1.0, 1e-9, 0.0)]),
    st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
)


def unit(v: tuple[float, ...]) -> Array:
    """Direction of length 1."""
    return np.asarray(v) / np.linalg.norm(v)


def drawn(m: int) -> Array:
    """Random poses (m, 4, 4) by SciPy."""
    rng = np.random.default_rng(m)
    T = turned(Rotation.random(m, rng).as_matrix())
    T[:, :3, 3] = rng.normal(size=(m, 3))
    return T


def turned(R: Array) -> Array:
    """A pose (..., 4, 4) with this rotation."""
    T = np.broadcast_to(np.eye(4), (*R.shape[:-2], 4, 4)).copy()
    T[..., :3, :3] = R
    return T


@given(st.tuples(angles, angles, angles))
def test_rpy_is_urdf_roll_pitch_yaw(rpy: tuple[float, float, float]) -> None:
    """``rpy`` gives the rotation that Pinocchio gives it, and ``euler_zyx`` the same with its values reversed."""
    T = pose([1, 2, 3], rpy=rpy)
    np.testing.assert_allclose(T[:3, :3], pin.rpy.rpyToMatrix(*rpy), rtol=0, atol=EXACT)
    np.testing.assert_array_equal(pose([1, 2, 3], euler_zyx=rpy[::-1]), T)
    np.testing.assert_allclose(T[:3, :3], Rotation.from_euler("ZYX", rpy[::-1]).as_matrix(), rtol=0, atol=EXACT)
    np.testing.assert_array_equal(T[:3, 3], [1, 2, 3])
    np.testing.assert_array_equal(T[3], [0, 0, 0, 1])


@given(directions, st.floats(-20.0, 20.0))
def test_rotvec_is_axis_times_angle(axis: tuple[float, float, float], angle: float) -> None:
    """``rotvec`` and the quaternion of the same axis and angle give SciPy's rotation."""
    rotvec = unit(axis) * angle
    expected = Rotation.from_rotvec(rotvec).as_matrix()
    np.testing.assert_allclose(pose(np.zeros(3), rotvec=rotvec)[:3, :3], expected, rtol=0, atol=4 * EXACT)
    xyzw = np.append(np.sin(angle / 2) * unit(axis), np.cos(angle / 2))
    np.testing.assert_allclose(pose(np.zeros(3), quat_xyzw=xyzw)[:3, :3], expected, rtol=0, atol=4 * EXACT)


@given(directions, angles, st.sampled_from([1.0, -1.0, 1e-200, 3e5, -1e200]))
def test_quaternions_of_any_length_and_both_orders(
    axis: tuple[float, float, float], angle: float, length: float
) -> None:
    """A quaternion's length does not matter, down to where squares underflow, and wxyz is xyzw in another order."""
    xyzw = np.append(np.sin(angle / 2) * unit(axis), np.cos(angle / 2))
    T = pose(np.zeros(3), quat_xyzw=xyzw * length)
    np.testing.assert_allclose(T, pose(np.zeros(3), quat_xyzw=xyzw), rtol=0, atol=EXACT)
    np.testing.assert_array_equal(pose(np.zeros(3), quat_wxyz=np.roll(xyzw * length, 1)), T)
    np.testing.assert_allclose(
        T[:3, :3], pin.Quaternion(xyzw / np.linalg.norm(xyzw)).toRotationMatrix(), rtol=0, atol=EXACT
    )


@given(directions, angles)
@example((1.0, 0.0, 0.0), HALF_TURN)
@example((-0.6, 0.8, 0.0), -HALF_TURN)
def test_every_notation_gives_the_rotation_back(axis: tuple[float, float, float], angle: float) -> None:
    """A rotation survives each notation to a few units of the last place, at half turns and vertical pitch too."""
    R = Rotation.from_rotvec(unit(axis) * angle).as_matrix()
    T = turned(R)
    for back in (
        pose(np.zeros(3), quat_xyzw=to_quat_xyzw(T)),
        pose(np.zeros(3), quat_wxyz=to_quat_wxyz(T)),
        pose(np.zeros(3), rotvec=to_rotvec(T)),
        pose(np.zeros(3), rpy=to_rpy(T)),
    ):
        np.testing.assert_allclose(back, T, rtol=0, atol=2 * EXACT)


@given(st.tuples(angles, st.sampled_from([-1, 1]), st.sampled_from([0.0, 1e-17, 1e-13, 1e-9, 1e-6, 1e-3]), angles))
def test_rpy_beside_gimbal_lock(case: tuple[float, int, float, float]) -> None:
    """Beside a vertical pitch the three angles still give the rotation back; at it roll is zero."""
    roll, side, off, yaw = case
    T = pose(np.zeros(3), rpy=[roll, side * (UPRIGHT - off), yaw])
    got = to_rpy(T)
    np.testing.assert_allclose(pose(np.zeros(3), rpy=got), T, rtol=0, atol=2 * EXACT)
    assert abs(got[1]) <= UPRIGHT
    if off < 1e-16:
        assert got[0] == 0.0


def test_pose_broadcasts() -> None:
    """Positions and orientations broadcast like NumPy arrays, and each element is the single pose."""
    p, r = np.random.default_rng(1).normal(size=(5, 1, 3)), np.random.default_rng(2).normal(size=(4, 3))
    for name in ("rpy", "rotvec", "euler_zyx"):
        T = pose(p, **{name: r})
        assert T.shape == (5, 4, 4, 4)
        np.testing.assert_allclose(T[3, 2], pose(p[3, 0], **{name: r[2]}), rtol=0, atol=EXACT)
    assert pose(p).shape == (5, 1, 4, 4)
    np.testing.assert_array_equal(pose([1, 2, 3]), [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
    for back, k in ((to_quat_xyzw, 4), (to_quat_wxyz, 4), (to_rotvec, 3), (to_rpy, 3)):
        assert back(T).shape == (5, 4, k)
        np.testing.assert_allclose(back(T)[1, 2], back(T[1, 2]), rtol=0, atol=EXACT)
        assert back(np.empty((0, 4, 4))).shape == (0, k)


@pytest.mark.parametrize(
    ("position", "orientation", "message", "index"),
    [
        ([1, 2, 3], {"rpy": [0, 0, 0], "rotvec": [0, 0, 0]}, "rotvec and rpy given", None),
        ([1, 2], {}, r"position has the shape \(2,\)", None),
        ([1, 2, np.nan], {}, "position is .*nan.*finite", None),
        ([1, 2, 3], {"quat_xyzw": [0, 0, 0]}, "4 numbers are needed", None),
        ([1, 2, 3], {"quat_xyzw": [0, 0, 0, 0]}, "all zeros", None),
        ([1, 2, 3], {"quat_wxyz": [[1, 0, 0, 0], [0, 0, 0, 0]]}, "all zeros", (1,)),
        ([1, 2, 3], {"quat_wxyz": [1, 0, 0, np.nan]}, "finite", None),
        ([1, 2, 3], {"rpy": [[[0, 0, 0], [0, np.inf, 0]]]}, "rpy is", (0, 1)),
        (np.zeros((2, 3)), {"rpy": np.zeros((3, 3))}, "do not broadcast", None),
    ],
)
def test_pose_refuses(
    position: object, orientation: dict[str, object], message: str, index: tuple[int, ...] | None
) -> None:
    """What gives no pose raises PoseError that names the argument, with the index in a batch."""
    with pytest.raises(PoseError, match=message) as refused:
        pose(position, **orientation)  # type: ignore[arg-type]
    assert refused.value.index == index


def test_as_pose_array_takes_everything_that_holds_poses() -> None:
    """SE3, lists (of lists) of them, mixed lists, vectors of SE3, and arrays of any layout and number type."""
    stack = drawn(6)
    poses = [pin.SE3(T) for T in stack]
    np.testing.assert_array_equal(as_pose_array(poses[0]), stack[0])
    nested = [poses[:3], poses[3:]]
    vector = pin.StdVec_SE3()
    vector.extend(poses)
    objects = np.empty(6, dtype=object)
    objects[:] = poses
    for given_as in (poses, vector, objects, [stack[0], *poses[1:]], list(stack), stack.tolist(), stack.astype(">f8")):
        np.testing.assert_array_equal(as_pose_array(given_as), stack)
    np.testing.assert_array_equal(as_pose_array(nested), stack.reshape(2, 3, 4, 4))


def _bad(**entries: object) -> Array:
    T = pose([1, 2, 3], rpy=[0.3, -0.2, 0.5])
    for name, value in entries.items():
        if name == "block":
            T[:3, :3] = T[:3, :3] @ value
        else:
            T[int(name[1]), int(name[2])] = value
    return T


BAD = {
    "nan": (_bad(e03=np.nan), r"\[0, 3\] is nan"),
    "last row": (_bad(e31=1.0), r"last row is \(0, 1, 0, 1\)"),
    "transposed": (_bad().T, "transposed"),
    "reflection": (_bad(block=np.diag([1.0, -1.0, 1.0])), "reflection"),
    "scaled": (_bad(block=1.001 * np.eye(3)), r"scaled by 1\.001"),
    "huge": (_bad(block=1e200 * np.eye(3)), "no rotation"),
    "sheared": (_bad(block=np.array([[1, 0.1, 0], [0, 1, 0], [0, 0, 1.0]])), "no rotation.*project_rotation"),
    "zeros": (_bad(block=np.zeros((3, 3))), "rotation"),
}


@pytest.mark.parametrize("name", BAD)
def test_check_poses_refuses(name: str) -> None:
    """Each kind of matrix that is no rigid motion raises PoseError in its own words, with the first bad index."""
    bad, message = BAD[name]
    with pytest.raises(PoseError, match=message) as single:
        check_poses(bad)
    assert single.value.index is None
    stack = np.tile(np.eye(4), (2, 3, 1, 1))
    stack[0, 2], stack[1, 1] = bad, bad
    with pytest.raises(PoseError, match=message) as batch:
        check_poses(stack)
    assert batch.value.index == (0, 2)
    with pytest.raises(PoseError):
        to_rpy(bad)


def test_rounded_rotations_pass() -> None:
    """Poses from single precision, or printed with six decimals, pass the check; with four decimals not all do."""
    stack = drawn(500)
    for rounded in (stack.astype(np.float32), np.round(stack, 6)):
        np.testing.assert_array_equal(check_poses(rounded), rounded)
    with pytest.raises(PoseError, match="project_rotation"):
        check_poses(np.round(stack, 4))


def test_project_rotation_gives_the_nearest_one() -> None:
    """The result is a rotation to all digits, nothing near it is nearer, and the input is not modified."""
    rng = np.random.default_rng(3)
    exact = drawn(40)
    rough = exact.copy()
    rough[:, :3, :3] += rng.uniform(-0.01, 0.01, (40, 3, 3))
    before = rough.copy()
    got = project_rotation(rough)
    np.testing.assert_array_equal(rough, before)
    R = got[:, :3, :3]
    np.testing.assert_allclose(R.swapaxes(1, 2) @ R, np.tile(np.eye(3), (40, 1, 1)), rtol=0, atol=2 * EXACT)
    np.testing.assert_allclose(np.linalg.det(R), 1.0, rtol=0, atol=2 * EXACT)
    np.testing.assert_array_equal(got[:, :3, 3], rough[:, :3, 3])
    here = np.linalg.norm(got[:, :3, :3] - rough[:, :3, :3], axis=(1, 2))
    for nudge in np.concatenate([np.eye(3), -np.eye(3)]) * 1e-4:
        there = np.linalg.norm(got[:, :3, :3] @ pin.exp3(nudge) - rough[:, :3, :3], axis=(1, 2))
        assert (there > here).all()
    np.testing.assert_allclose(project_rotation(exact), exact, rtol=0, atol=EXACT)


@pytest.mark.parametrize("name", ["nan", "last row", "reflection", "sheared", "huge", "zeros"])
def test_project_rotation_repairs_no_mistakes(name: str) -> None:
    """A reflection, a shear, zeros or NaN are no inexact rotations and are refused."""
    with pytest.raises(PoseError):
        project_rotation(BAD[name][0])
