"""Poses: conversions from and to the usual notations of position and orientation, and the checks of given poses."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import PoseError
from urdf_ik.support import inputs
from urdf_ik.support.tolerances import DEFAULT, LARGEST
from urdf_ik.typing import Array

ORIENTATIONS = {
    "quat_xyzw": "xyzw", "quat_wxyz": "wxyz", "rotvec": ("rx", "ry", "rz"), "rpy": ("roll", "pitch", "yaw"),
    "euler_zyx": ("yaw", "pitch", "roll"), "abb": ("q1", "q2", "q3", "q4"), "fanuc": "wpr", "kuka": "abc",
    "motoman": ("rx", "ry", "rz"), "staubli": ("rx", "ry", "rz"),
}  # fmt: skip
"""The notations of an orientation, and the names of their numbers."""
_SAME = {"abb": "quat_wxyz", "fanuc": "rpy", "motoman": "rpy", "kuka": "euler_zyx"}
"""Notations of makers that have another name."""
PROJECTION_TOLERANCE = 0.1
"""Greatest entry of R^T R - I that :func:`project_rotation` takes for an inexact rotation, not for a mistake."""

# Rounding: below this, a half turn's w and a vertical pitch's cosine count as zero.
_ZERO = 4.0 * np.finfo(np.float64).eps
_LAST_ROW = np.array([0.0, 0.0, 0.0, 1.0])
_AT_ONCE = 1024  # poses that are checked at a time: what is computed of them stays in the processor's cache


def pose(
    position: ArrayLike,
    *,
    quat_xyzw: ArrayLike | None = None,
    quat_wxyz: ArrayLike | None = None,
    rotvec: ArrayLike | None = None,
    rpy: ArrayLike | None = None,
    euler_zyx: ArrayLike | None = None,
    abb: ArrayLike | None = None,
    fanuc: ArrayLike | None = None,
    kuka: ArrayLike | None = None,
    motoman: ArrayLike | None = None,
    staubli: ArrayLike | None = None,
    degrees: bool = False,
) -> Array:
    """Pose from a position and at most one orientation; without one, the rotation is the identity.

    Leading dimensions broadcast: one position with many orientations, or the other way round.

    Args:
        position: (..., 3) m.
        quat_xyzw: (..., 4) quaternion, scalar last (Pinocchio, SciPy, ROS). Any length but zero.
        quat_wxyz: (..., 4) quaternion, scalar first (viser, MuJoCo). Any length but zero.
        rotvec: (..., 3) rad, axis times angle.
        rpy: (..., 3) rad, roll, pitch, yaw about the fixed x, y, z axes, as in URDF:
            R = Rz(yaw) Ry(pitch) Rx(roll).
        euler_zyx: (..., 3) rad, yaw, pitch, roll about the moving z, y, x axes: the same rotation as
            ``rpy`` with its three values reversed.
        abb: (..., 4) quaternion q1 to q4, scalar first.
        fanuc: (..., 3) rad, W P R about the fixed x, y, z axes: the same as ``rpy``.
        kuka: (..., 3) rad, A B C about the moving z, y, x axes: the same as ``euler_zyx``.
        motoman: (..., 3) rad, Rx Ry Rz about the fixed x, y, z axes: the same as ``rpy``.
        staubli: (..., 3) rad, Rx Ry Rz about the moving x, y, z axes.
        degrees: whether the angles are in degrees.

    Returns:
        (..., 4, 4) homogeneous transforms.

    Raises:
        PoseError: more than one orientation, values that are not finite numbers, a quaternion of zeros,
            or shapes that do not fit together.

    Example:
        >>> pose([0.5, 0.0, 0.2]).tolist()[0]
        [1.0, 0.0, 0.0, 0.5]
    """
    values = (quat_xyzw, quat_wxyz, rotvec, rpy, euler_zyx, abb, fanuc, kuka, motoman, staubli)
    chosen = {name: value for name, value in zip(ORIENTATIONS, values, strict=True) if value is not None}
    if len(chosen) > 1:
        raise PoseError(f"{' and '.join(chosen)} given; a pose has one orientation, of {', '.join(ORIENTATIONS)}")
    p = _numbers(position, "position", 3)
    R = np.eye(3)
    for name, value in chosen.items():
        numbers = _numbers(value, name, len(ORIENTATIONS[name]))
        R = _rotation(_SAME.get(name, name), np.deg2rad(numbers) if degrees and numbers.shape[-1] == 3 else numbers)
    try:
        batch = np.broadcast_shapes(p.shape[:-1], R.shape[:-2])
    except ValueError:
        shapes = f"{p.shape[:-1]} positions and {R.shape[:-2]} orientations given"
        raise PoseError(f"{shapes}; the shapes do not broadcast") from None
    T = np.zeros((*batch, 4, 4))
    T[..., :3, :3] = R
    T[..., :3, 3] = p
    T[..., 3, 3] = 1.0
    return T


def to_quat_xyzw(T: Any) -> Array:
    """Orientation as a unit quaternion, scalar last.

    Of the two quaternions the one with w >= 0; at a half turn, the one whose first component that is not
    zero is positive. Errors are a few units of the last place at every angle (Shepperd, "Quaternion from
    rotation matrix", Journal of Guidance and Control 1(3), 1978).

    Args:
        T: (..., 4, 4), ``pinocchio.SE3`` or a list of them.

    Returns:
        (..., 4) x, y, z, w.

    Raises:
        PoseError: ``T`` holds something that is no pose.

    Example:
        >>> (to_quat_xyzw(pose([0.5, 0.0, 0.2], rpy=[0.0, 0.0, 1.0])).round(4) + 0.0).tolist()
        [0.0, 0.0, 0.4794, 0.8776]
    """
    from scipy.spatial.transform import Rotation

    R = check_poses(T)[..., :3, :3]
    q = Rotation.from_matrix(np.array(R.reshape(-1, 3, 3))).as_quat().reshape(*R.shape[:-2], 4)
    # Scalar first, the first component that is not zero decides the sign.
    ranked = np.roll(q, 1, axis=-1)
    leading = np.argmax(np.abs(ranked) > _ZERO, axis=-1)[..., None]
    return np.asarray(np.where(np.take_along_axis(ranked, leading, axis=-1) < 0.0, -q, q))


def to_quat_wxyz(T: Any) -> Array:
    """Orientation as a unit quaternion (..., 4), scalar first; else as :func:`to_quat_xyzw`."""
    return np.roll(to_quat_xyzw(T), 1, axis=-1)


def to_rotvec(T: Any) -> Array:
    """Orientation as a rotation vector, axis times angle, the angle in [0, pi].

    At a half turn, both signs of the axis are the same rotation: the first component that is not zero is
    positive.

    Args:
        T: (..., 4, 4), ``pinocchio.SE3`` or a list of them.

    Returns:
        (..., 3) rad.

    Raises:
        PoseError: ``T`` holds something that is no pose.
    """
    q = to_quat_xyzw(T)
    sine = np.linalg.norm(q[..., :3], axis=-1, keepdims=True)
    tiny = sine < 1e-8  # where the ratio below is 2 to all digits
    ratio = np.where(tiny, 2.0, 2.0 * np.arctan2(sine, q[..., 3:]) / np.where(tiny, 1.0, sine))
    return np.asarray(ratio * q[..., :3])


def to_rpy(T: Any) -> Array:
    """Orientation as roll, pitch, yaw about the fixed x, y, z axes, as in URDF.

    Roll and yaw lie in [-pi, pi], pitch in [-pi/2, pi/2]. With the x axis vertical (pitch = +-pi/2) only
    yaw - roll (or their sum) is defined, and roll is 0. Near there roll is computed from what yaw leaves,
    so that the three angles give the rotation back to all digits although each of them alone is
    ill-conditioned (Herter and Lott, "Algorithms for decomposing 3-D orthogonal matrices into primitive
    rotations", Computers and Graphics 17(5), 1993).

    Args:
        T: (..., 4, 4), ``pinocchio.SE3`` or a list of them.

    Returns:
        (..., 3) rad: roll, pitch, yaw.

    Raises:
        PoseError: ``T`` holds something that is no pose.

    Example:
        >>> (to_rpy(pose([0.5, 0.0, 0.2], rpy=[0.0, 0.0, 1.0])).round(4) + 0.0).tolist()
        [0.0, 0.0, 1.0]
    """
    R = check_poses(T)[..., :3, :3]
    cosine = np.hypot(R[..., 0, 0], R[..., 1, 0])
    locked = cosine < _ZERO
    yaw = np.where(locked, np.arctan2(-R[..., 0, 1], R[..., 1, 1]), np.arctan2(R[..., 1, 0], R[..., 0, 0]))
    s, c = np.sin(yaw), np.cos(yaw)
    roll = np.arctan2(s * R[..., 0, 2] - c * R[..., 1, 2], c * R[..., 1, 1] - s * R[..., 0, 1])
    pitch = np.arctan2(-R[..., 2, 0], cosine)
    return np.stack([np.where(locked, 0.0, roll), pitch, yaw], axis=-1)


def as_pose_array(T: Any) -> Array:
    """Poses as one array; its values are not checked, see :func:`check_poses`.

    Args:
        T: (..., 4, 4) numbers, an object with a 4x4 ``homogeneous`` such as ``pinocchio.SE3``, or a list
            (of lists) of either.

    Returns:
        (..., 4, 4) float64, C-contiguous and aligned; ``T`` itself, not a copy, if it already is that.

    Raises:
        PoseError: the last two dimensions are not 4 by 4, or the entries are no real numbers.
    """
    needed = "a 4x4 array of real numbers, a pinocchio.SE3, or a list of either"
    array = inputs.real(_unwrapped(T), "a pose", needed, PoseError)
    if array.shape[-2:] != (4, 4):
        shown = f"an array of shape {array.shape} given"
        raise PoseError(f"{shown}; poses have the shape (..., 4, 4): urdf_ik.pose makes them")
    return array


def check_poses(T: Any) -> Array:
    """Poses as :func:`as_pose_array` gives them, every one of them a rigid motion.

    A rotation with rounding errors is one: the greatest entry of ``|R^T R - I|``, and the last row's
    distance from (0, 0, 0, 1), may be ``tolerances.DEFAULT.rotation``, which lets poses pass that went
    through single precision or were printed with six decimals.

    Args:
        T: (..., 4, 4), ``pinocchio.SE3`` or a list of them.

    Returns:
        (..., 4, 4) float64, C-contiguous; ``T`` itself if it already is that.

    Raises:
        PoseError: NaN or infinite entries, another last row, a reflection, a scaled or sheared rotation,
            with the index of the first bad pose of a batch.
    """
    return _checked(as_pose_array(T), DEFAULT.rotation)


def nearest_rotation(M: Array) -> Array:
    """The rotations nearest to matrices (..., 3, 3) (Kabsch 1976)."""
    U, _, V = np.linalg.svd(M)
    U[..., 2] *= np.linalg.det(U @ V)[..., None]
    R = U @ V
    # The factors are orthonormal to a few roundings, which Newton's iteration for the polar factor takes out.
    return np.asarray(1.5 * R - 0.5 * R @ (np.swapaxes(R, -1, -2) @ R))


def project_rotation(T: Any, tolerance: float = PROJECTION_TOLERANCE) -> Array:
    """Poses with each rotation replaced by the nearest one (in the Frobenius norm), by its polar decomposition.

    For poses that were rounded, averaged or multiplied too often (Higham, "Computing the polar
    decomposition", SIAM J. Sci. Stat. Comput. 7(4), 1986).

    Args:
        T: (..., 4, 4), ``pinocchio.SE3`` or a list of them.
        tolerance: greatest entry of ``|R^T R - I|`` that is repaired.

    Returns:
        (..., 4, 4) float64, a new array.

    Raises:
        PoseError: as :func:`check_poses`, but with this tolerance.

    Example:
        >>> T = pose([0.5, 0.0, 0.2], rpy=[0.0, 0.0, 1.0])
        >>> bool(np.allclose(project_rotation(T.round(3)), T, atol=1e-3))
        True
    """
    tolerance = inputs.number(tolerance, "tolerance", PoseError, low=0.0)
    out = _checked(as_pose_array(T), tolerance).copy()
    out[..., :3, :3] = nearest_rotation(out[..., :3, :3])
    out[..., 3, :] = _LAST_ROW
    return out


def _unwrapped(T: Any) -> Any:
    """``T`` with every object that has a ``homogeneous`` replaced by that, at any depth of lists."""
    if isinstance(T, np.ndarray):
        return np.array([_unwrapped(t) for t in T]) if T.dtype == np.object_ and T.ndim else T
    if hasattr(T, "homogeneous"):
        return np.asarray(T.homogeneous)
    if isinstance(T, list | tuple):
        return [t if isinstance(t, float | int) else _unwrapped(t) for t in T]
    return T


def _rotation(name: str, value: Array) -> Array:
    """(..., 3, 3) from an orientation in one of the notations."""
    if name == "rpy":
        return from_rpy(value)
    if name == "euler_zyx":
        return from_rpy(value[..., ::-1])
    if name == "staubli":  # the inverse of turns by the negative angles in the other order
        return from_rpy(-value).swapaxes(-1, -2)
    from scipy.spatial.transform import Rotation

    rows = np.array(value.reshape(-1, value.shape[-1]))  # SciPy takes no read-only arrays
    if name == "rotvec":
        return np.asarray(Rotation.from_rotvec(rows).as_matrix().reshape(*value.shape[:-1], 3, 3))
    largest = np.abs(rows).max(axis=-1, keepdims=True)  # the division keeps squares from over- and underflow
    if len(bad := np.argwhere(largest[:, 0] == 0.0)):
        index = tuple(int(k) for k in np.unravel_index(bad[0, 0], value.shape[:-1]))
        raise PoseError(f"{name} is all zeros, which is no rotation", index or None)
    rotation = Rotation.from_quat(rows / largest, scalar_first=name == "quat_wxyz")
    return np.asarray(rotation.as_matrix().reshape(*value.shape[:-1], 3, 3))


def from_rpy(rpy: Array) -> Array:
    """(..., 3, 3) Rz(yaw) Ry(pitch) Rx(roll), of complex angles too; yourdfpy's rounding, not SciPy's."""
    (sr, sp, sy), (cr, cp, cy) = np.moveaxis(np.sin(rpy), -1, 0), np.moveaxis(np.cos(rpy), -1, 0)
    R = np.empty((*rpy.shape[:-1], 3, 3), rpy.dtype)
    R[..., 0, 0], R[..., 0, 1], R[..., 0, 2] = cy * cp, sp * (sr * cy) - cr * sy, sp * (cr * cy) + sr * sy
    R[..., 1, 0], R[..., 1, 1], R[..., 1, 2] = sy * cp, sp * (sr * sy) + cr * cy, sp * (cr * sy) - sr * cy
    R[..., 2, 0], R[..., 2, 1], R[..., 2, 2] = -sp, cp * sr, cp * cr
    return R


def _numbers(value: ArrayLike, name: str, size: int) -> Array:
    """``value`` as (..., size) finite float64."""
    array = inputs.real(value, name, f"{size} real numbers, or an array (..., {size}) of them", PoseError)
    if array.shape[-1:] != (size,):
        raise PoseError(f"{name} has the shape {array.shape}; {size} numbers are needed, or (..., {size})")
    # The length of a quaternion does not matter, so that any number may be in one.
    largest = np.finfo(np.float64).max if size == 4 else LARGEST
    if (bad := inputs.first_bad(array, largest)) is not None:
        raise PoseError(f"{name} is {array[bad[:-1]]}; {inputs.why_bad(array[bad], largest)}", bad[:-1] or None)
    return array


def _checked(array: Array, tolerance: float) -> Array:
    flat = array.reshape(-1, 16)
    good = np.empty(len(flat), dtype=np.bool_)
    for start in range(0, len(flat), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        good[part] = _rigid(np.ascontiguousarray(flat[part].T).reshape(4, 4, -1), tolerance)
    if not good.all():
        where = np.unravel_index(int(np.argmin(good)), array.shape[:-2])
        raise PoseError(_problem(array[where], tolerance), tuple(int(k) for k in where) or None)
    return array


def _rigid(T: Array, tolerance: float) -> NDArray[np.bool_]:
    """Whether matrices (4, 4, k), one beside the other, are rigid motions."""
    R = T[:3, :3]
    with np.errstate(all="ignore"):  # infinities and overflows are what is looked for
        gram = (R[:, :, None] * R[:, None]).sum(axis=0)
        off_rotation = np.abs(gram - np.eye(3)[..., None]).max(axis=(0, 1))
        off_row = np.abs(T[3] - _LAST_ROW[:, None]).max(axis=0)
        x, y, z = R[:, 0], R[:, 1], R[:, 2]
        direct = ((x[[1, 2, 0]] * y[[2, 0, 1]] - x[[2, 0, 1]] * y[[1, 2, 0]]) * z).sum(axis=0) > 0.0
        finite = (np.abs(T) <= LARGEST).all(axis=(0, 1))
        return np.asarray(finite & (off_row <= tolerance) & (off_rotation <= tolerance) & direct)


def _problem(T: Array, tolerance: float) -> str:
    """The defect of one matrix (4, 4), and the correction."""
    bad = np.argwhere(~np.isfinite(T))
    if bad.size:
        r, c = bad[0]
        return f"entry [{r}, {c}] is {T[r, c]}; the entries of a pose are finite"
    if (far := inputs.first_bad(T[:3, 3])) is not None:
        return f"entry [{far[0]}, 3] is {T[far[0], 3]}; {inputs.why_bad(T[far[0], 3])}, in m"
    if not np.abs(T[3] - _LAST_ROW).max() <= tolerance:
        transposed = " (is it transposed?)" if not T[:3, 3].any() and T[3, 3] == 1.0 else ""
        row = ", ".join(f"{x:.6g}" for x in T[3])
        return f"the last row is ({row}) and must be (0, 0, 0, 1){transposed}"
    with np.errstate(over="ignore"):
        gram = T[:3, :3].T @ T[:3, :3]
    off = float(np.abs(gram - np.eye(3)).max())
    if off <= tolerance:
        return "the 3x3 block is a reflection, its determinant is -1; a rotation has +1: is an axis flipped?"
    square = float(np.trace(gram)) / 3.0
    if np.isfinite(square) and np.abs(gram - square * np.eye(3)).max() <= tolerance * square:
        return f"the rotation is scaled by {np.sqrt(square):.7g} and must not be; is there a scale in the pose?"
    return (
        f"the 3x3 block is no rotation: R^T R differs from the identity by {off:.3g}, and {tolerance:.3g} is allowed "
        "(urdf_ik.model.poses.project_rotation gives the nearest rotation)"
    )
