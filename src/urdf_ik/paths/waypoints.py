"""Waypoints along lines, arcs and polylines, and the poses between two waypoints."""

import os
import warnings
from collections.abc import Callable, Sequence
from typing import IO, Any

import numpy as np

from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.model.poses import check_poses, pose, to_rotvec
from urdf_ik.support import inputs
from urdf_ik.support.tables import Table, read_table
from urdf_ik.typing import Array


def read(T: Any) -> Array:
    """Waypoints (m, 4, 4) with m >= 1, checked.

    Raises:
        ArgumentError: there is no waypoint, or the array has another shape.
        PoseError: a waypoint is no pose; ``index`` says which.
    """
    poses = check_poses(T)
    if poses.ndim == 2:
        poses = poses[None]
    if poses.ndim != 3:
        raise ArgumentError(f"waypoints of shape {poses.shape} given; (m, 4, 4) are needed")
    if not len(poses):
        raise ArgumentError("no waypoint given; at least one pose (4, 4) is needed")
    return poses


MOST_WAYPOINTS = 10_000_000
"""Most waypoints of a line or an arc (1.3 GB of poses)."""


def interpolated(T0: Array, T1: Array, share: Array, turn: Array | None = None) -> Array:
    """Poses on the straight segments between poses, turning at a constant rate about a fixed axis.

    Args:
        T0: (..., 4, 4) m.
        T1: (..., 4, 4) m.
        share: (...) 0 at T0, 1 at T1.
        turn: (..., 3) rad, the rotation vector from T0 to T1 in base axes, where it is known.

    Returns:
        (..., 4, 4).
    """
    turn = twists(T0, T1)[..., 3:] if turn is None else turn
    angle = np.linalg.norm(turn, axis=-1)
    x, y, z = np.moveaxis(turn / np.where(angle > 0.0, angle, 1.0)[..., None], -1, 0)
    sine, cosine = np.sin(angle * share), np.cos(angle * share)
    versine = 1.0 - cosine
    out: Array = np.zeros((*np.broadcast_shapes(T0.shape[:-2], T1.shape[:-2], np.shape(share)), 4, 4))
    # Rodrigues' formula, row by row.
    R = np.empty((*sine.shape, 3, 3))
    R[..., 0, 0], R[..., 1, 1], R[..., 2, 2] = (cosine + component * component * versine for component in (x, y, z))
    R[..., 0, 1], R[..., 1, 0] = x * y * versine - z * sine, x * y * versine + z * sine
    R[..., 0, 2], R[..., 2, 0] = x * z * versine + y * sine, x * z * versine - y * sine
    R[..., 1, 2], R[..., 2, 1] = y * z * versine - x * sine, y * z * versine + x * sine
    out[..., :3, :3] = R @ T0[..., :3, :3]
    out[..., :3, 3] = T0[..., :3, 3] + np.asarray(share)[..., None] * (T1[..., :3, 3] - T0[..., :3, 3])
    out[..., 3, 3] = 1.0
    return out


def twists(T0: Array, T1: Array) -> Array:
    """From poses (..., 4, 4) to others: displacement [m] and rotation vector [rad] in base axes, (..., 6)."""
    turn = np.zeros((*np.broadcast_shapes(T0.shape, T1.shape)[:-2], 4, 4))
    turn[..., :3, :3] = T1[..., :3, :3] @ np.swapaxes(T0[..., :3, :3], -1, -2)
    turn[..., 3, 3] = 1.0
    return np.concatenate([T1[..., :3, 3] - T0[..., :3, 3], to_rotvec(turn)], axis=-1)


def line(T0: Any, T1: Any, n: int = 100) -> Array:
    """A straight line of ``n`` poses from T0 to T1, turning at a constant rate about a fixed axis.

    Args:
        T0: (4, 4) m.
        T1: (4, 4) m.
        n: number of waypoints, both ends among them; at least 2.

    Returns:
        (n, 4, 4).

    Raises:
        ArgumentError: ``n`` is less than 2.
        PoseError: an end is no pose.

    Example:
        >>> import urdf_ik
        >>> T = urdf_ik.line(urdf_ik.pose([0.5, 0, 0.2]), urdf_ik.pose([0.5, 0.4, 0.2]), 5)
        >>> T[:, 1, 3].tolist()
        [0.0, 0.1, 0.2, 0.30000000000000004, 0.4]
    """
    start, end = _one(T0, "T0"), _one(T1, "T1")
    return interpolated(start, end, np.linspace(0.0, 1.0, _count(n)))


def arc(T0: Any, via: Any, T1: Any, n: int = 100) -> Array:
    """The circular arc of ``n`` poses from T0 to T1 whose circle passes through ``via``.

    The orientation turns at a constant rate about a fixed axis from that of T0 to that of T1.

    Args:
        T0: (4, 4) m.
        via: (3,) m, a point of the arc between its ends; of a pose (4, 4) its position.
        T1: (4, 4) m.
        n: number of waypoints, both ends among them; at least 2.

    Returns:
        (n, 4, 4).

    Raises:
        ArgumentError: ``n`` is less than 2, or the three points lie on a line.
        PoseError: an end is no pose.

    Example:
        >>> import urdf_ik
        >>> T = urdf_ik.arc(urdf_ik.pose([1, 0, 0]), [0, 1, 0], urdf_ik.pose([-1, 0, 0]), 3)
        >>> T[1, :3, 3].round(12).tolist()
        [0.0, 1.0, 0.0]
    """
    start, end, count = _one(T0, "T0"), _one(T1, "T1"), _count(n)
    middle = np.asarray(getattr(via, "homogeneous", via))
    middle = inputs.array(middle[:3, 3] if middle.shape == (4, 4) else middle, "via", (3,), unit="m")
    a, b, c = start[:3, 3], middle, end[:3, 3]
    ab, ac = b - a, c - a
    normal = np.cross(ab, ac)
    size = normal @ normal
    if size <= (1e-9 * (ab @ ab + ac @ ac)) ** 2:
        raise ArgumentError("the three points of an arc lie on a line; line() goes straight")
    centre = a + (np.cross(normal, ab) * (ac @ ac) + np.cross(ac, normal) * (ab @ ab)) / (2.0 * size)
    x = a - centre
    y = np.cross(normal / np.sqrt(size), x)

    def angle(point: Array) -> float:
        return float(np.arctan2((point - centre) @ y, (point - centre) @ x) % (2.0 * np.pi))

    turns = np.linspace(0.0, angle(c), count)[:, None]
    out = interpolated(start, end, np.linspace(0.0, 1.0, count))
    out[:, :3, 3] = centre + np.cos(turns) * x + np.sin(turns) * y
    out[0], out[-1] = start, end
    return out


def polyline(poses: Any, step: float = 0.01, *, blend: float = 0.0, turn: float = 0.05) -> Array:
    """Waypoints along straight lines from pose to pose, the corners rounded where ``blend`` is not zero.

    A corner is replaced by a parabola that begins and ends ``blend`` before and after it, at most half of the way to
    the next corner; the orientation is blended with it.

    Args:
        poses: (k, 4, 4) m, corners, k >= 2.
        step: greatest distance [m] between waypoints.
        blend: distance [m] from a corner at which its rounding begins.
        turn: greatest rotation [rad] between waypoints.

    Returns:
        (m, 4, 4); both ends and, without blends, all corners are among them.

    Raises:
        ArgumentError: fewer than two poses, a step or turn that is not positive, a negative blend.
        PoseError: a corner is no pose.

    Example:
        >>> import urdf_ik
        >>> corners = [urdf_ik.pose(p) for p in ([0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0])]
        >>> len(urdf_ik.polyline(corners, 0.02))
        11
    """
    corners = read(poses)
    if len(corners) < 2:
        raise ArgumentError(f"a polyline through {len(corners)} pose asked for; at least two are needed")
    step, turn = (inputs.number(value, name, above=0.0) for name, value in (("step", step), ("turn", turn)))
    blend = inputs.number(blend, "blend", low=0.0, unit="m")
    legs_twists = twists(corners[:-1], corners[1:])
    lengths = np.linalg.norm(legs_twists[:, :3], axis=1)
    # Where a leg begins and ends being straight, as shares of it.
    shares = np.divide(blend, lengths, out=np.zeros_like(lengths), where=lengths > 0.0).clip(0.0, 0.5)
    angles = np.linalg.norm(legs_twists[:, 3:], axis=1)
    legs: list[Array] = []
    for k, (length, rotation) in enumerate(zip(lengths.tolist(), angles.tolist(), strict=True)):
        low, high = (shares[k] if k else 0.0), 1.0 - (shares[k] if k + 1 < len(lengths) else 0.0)
        pieces = max(1, int(np.ceil((high - low) * max(length / step, rotation / turn) - 1e-9)))
        straight = interpolated(corners[k], corners[k + 1], np.linspace(low, high, pieces + 1))
        legs.append(straight if not legs or shares[k] else straight[1:])
        if k + 1 < len(lengths) and shares[k]:
            after = interpolated(corners[k + 1], corners[k + 2], np.array(shares[k + 1]))
            size = twists(straight[-1], after)
            pieces = max(2, int(np.ceil(max(2.0 * blend / step, float(np.linalg.norm(size[3:])) / turn))))
            u = np.linspace(0.0, 1.0, pieces + 1)[1:-1]
            inwards = interpolated(straight[-1], corners[k + 1], u)
            legs.append(interpolated(inwards, interpolated(corners[k + 1], after, u), u))
    return np.concatenate(legs)


def _one(T: Any, name: str) -> Array:
    checked = check_poses(T)
    if checked.ndim != 2:
        raise PoseError(f"{name} has the shape {checked.shape}; one pose (4, 4) is needed")
    return checked


def _count(n: int) -> int:
    return inputs.whole(n, "n", low=2, high=MOST_WAYPOINTS)


POSITION = ("x", "y", "z")
ORIENTATIONS = {
    "quat_wxyz": ("qw", "qx", "qy", "qz"),
    "rpy": ("roll", "pitch", "yaw"),
    "rotvec": ("rx", "ry", "rz"),
}
"""Columns of each orientation notation, by the keyword of ``pose``. The header names them, so any order is valid."""
KEYS = ("poses", "waypoints", "T", "pose")
"""Names of an array of waypoints in an .npz file or a JSON object."""
ACCEPTED = (
    "accepted: CSV with a header that names x,y,z [m] and one of qw,qx,qy,qz or roll,pitch,yaw [rad] or rx,ry,rz "
    "[rad, axis times angle], or with 16 numbers a line (4x4, row by row); JSON, .npy or .npz with matrices (m, 4, 4)"
)
LENGTH = 0.02
"""Largest accepted difference of a quaternion's length from 1."""
POSE_COLUMNS = (*POSITION, "qx", "qy", "qz", "qw")
"""Columns of a pose of seven numbers without a header (``bare=True``)."""


def read_waypoints(source: str | os.PathLike[str] | IO[bytes], *, degrees: bool = False) -> Array:
    r"""Waypoints (m, 4, 4) from a file, whose format is recognised by its content.

    Args:
        source: a path, or a file open for reading bytes. CSV: a header names the columns, in any order and among
            others: x, y, z [m] with qw, qx, qy, qz, or with roll, pitch, yaw [rad], or with rx, ry, rz [rad, axis
            times angle]; without a header 16 numbers a line, a 4x4 matrix row by row. JSON: a list of 4x4 matrices,
            or an object that holds it as 'poses', 'waypoints' or 'T'. .npy and .npz: (m, 4, 4), in .npz under one of
            these names or as the only array.
        degrees: whether the angles of a CSV are in degrees instead of rad.

    Returns:
        (m, 4, 4) m, m >= 1.

    Raises:
        ArgumentError: the file cannot be read, or holds no waypoints; the message names the line, the column and the
            value, and what would be valid.

    Example:
        >>> import io
        >>> import urdf_ik
        >>> urdf_ik.read_waypoints(io.BytesIO(b"x,y,z,qw,qx,qy,qz\n0.5,0,0.2,0,0,1,0\n")).shape
        (1, 4, 4)
    """
    name, table = read_table(source, KEYS, "waypoint", ACCEPTED)
    return _from_rows(table, degrees, bare=False) if isinstance(table, Table) else _checked(name, table)


def read_poses(source: str | os.PathLike[str] | IO[bytes], *, degrees: bool = False) -> Array:
    """Poses (m, 4, 4) as :func:`read_waypoints` reads them, or of seven numbers each: ``POSE_COLUMNS``.

    ``degrees``: whether the angles of a CSV are in degrees instead of rad.

    Raises:
        ArgumentError: the file cannot be read, or holds no poses.
    """
    accepted = f"{ACCEPTED}; {','.join(POSE_COLUMNS)} without a header, too"
    name, table = read_table(source, KEYS, "pose", accepted)
    if isinstance(table, Table):
        return _from_rows(table, degrees, bare=True)
    if table.ndim in (1, 2) and table.shape[-1] == len(POSE_COLUMNS):
        rows = np.atleast_2d(table)
        return _posed("quat_wxyz", rows[:, [0, 1, 2, 6, 3, 4, 5]], lambda k: f"{name}, pose {k}")
    return _checked(name, table)


def _checked(name: str, values: Array) -> Array:
    """Numbers as waypoints."""
    if values.ndim == 2 and values.shape[1] == 16:
        values = values.reshape(-1, 4, 4)
    if values.shape[-2:] != (4, 4) or values.ndim not in (2, 3):
        raise ArgumentError(f"{name} holds numbers of shape {values.shape}; {ACCEPTED}")
    try:
        return read(values.reshape(-1, 4, 4))
    except (ArgumentError, PoseError) as error:
        raise ArgumentError(f"{name}: {error}") from None


def _from_rows(rows: Table, degrees: bool, bare: bool) -> Array:
    """Waypoints of a CSV; ``bare``: seven numbers without a header are a pose, too."""
    width = len(rows.cells[0])
    if rows.header is None and not (bare and width == len(POSE_COLUMNS)):
        header = [str(k) for k in range(1, 17)]
        if width != 16:
            raise ArgumentError(
                f"{rows.name}, line {rows.first}: {width} numbers and no header; a first line such as "
                "x,y,z,qw,qx,qy,qz must say what they are"
            )
        matrices = rows.numbers(header, header).reshape(-1, 4, 4)
        try:
            return read(matrices)
        except PoseError as error:
            line = rows.lines[error.index[0]] if error.index else rows.first
            raise ArgumentError(f"{rows.name}, line {line}: {error}") from None
    header = list(POSE_COLUMNS) if rows.header is None else [name.lower() for name in rows.header]
    kind = _orientation(rows.name, rows.first, header)
    values = rows.numbers((*POSITION, *ORIENTATIONS[kind]), header)
    if degrees and kind != "quat_wxyz":
        values[:, 3:] = np.deg2rad(values[:, 3:])
    elif kind != "quat_wxyz" and (most := float(np.abs(values[:, 3:]).max())) > 2.0 * np.pi:
        turns = f"{most:g} is {most / (2.0 * np.pi):.1f} turns"
        hint = f"{rows.name}: angles are read in rad, and {turns}; degrees=True (--degrees) reads degrees"
        warnings.warn(hint, stacklevel=4)
    return _posed(kind, values, lambda k: f"{rows.name}, line {rows.lines[k]}")


def _posed(kind: str, values: Array, where: Callable[[int], str]) -> Array:
    """Poses of positions and orientations (k, 6 or 7); ``where`` says where row k is."""
    if kind == "quat_wxyz":
        lengths = np.linalg.norm(values[:, 3:], axis=1)
        for k in np.flatnonzero(~(np.abs(lengths - 1.0) <= LENGTH))[:1]:
            raise ArgumentError(
                f"{where(int(k))}: the quaternion {','.join(ORIENTATIONS[kind])} = "
                f"{','.join(f'{x:g}' for x in values[k, 3:])} has the length {lengths[k]:.4g}; a rotation has 1"
            )
    orientation: dict[str, Any] = {kind: values[:, 3:]}
    return read(pose(values[:, :3], **orientation))


def _orientation(name: str, line: int, header: Sequence[str]) -> str:
    """What ``pose`` calls the orientation that a header names."""
    doubled = sorted({column for column in header if header.count(column) > 1})
    if doubled:
        raise ArgumentError(f"{name}, line {line}: the header names {', '.join(doubled)} twice")
    there = [kind for kind, columns in ORIENTATIONS.items() if set(columns) <= set(header)]
    missing = [column for column in POSITION if column not in header]
    if missing or len(there) != 1:
        choices = " or ".join(",".join(columns) for columns in ORIENTATIONS.values())
        problem = (
            f"no column {' and '.join(missing)}" if missing
            else f"{'more than one orientation' if there else 'no orientation'}: one of {choices} is needed"
        )  # fmt: skip
        raise ArgumentError(f"{name}, line {line}: the header {','.join(header)} has {problem}")
    return there[0]
