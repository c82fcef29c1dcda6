"""Measurements of an arm: joint vectors, and what was measured at each; from arrays and files, checked."""

import io
import os
from dataclasses import dataclass
from typing import IO, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.model.poses import check_poses
from urdf_ik.paths.waypoints import ORIENTATIONS, POSITION, read_waypoints
from urdf_ik.support import files, inputs
from urdf_ik.support.tables import Table, read_table
from urdf_ik.typing import Array

KINDS = {"pose": 6, "position": 3}
"""Kinds of measurements, and the number of components of each."""
ACCEPTED = (
    "accepted: a CSV whose first line names the columns: every joint [rad or m] by its name in the URDF, and x,y,z [m] "
    "with qw,qx,qy,qz or roll,pitch,yaw or rx,ry,rz [rad] for poses, x,y,z alone for positions; or an .npz or JSON "
    "with 'q' and 'T' or 'p'"
)
# Of angles in rad, few are this far from zero; of angles in degrees, most are.
_MANY_TURNS = 4.0 * np.pi
# A length in mm is a thousand times that in m; no arm is wrong by a factor of this.
_OTHER_UNIT = 50.0


@dataclass(frozen=True, eq=False)
class Measurements:
    """Joint vectors and what was measured at them; :func:`measured` and :func:`read_measurements` make it.

    Attributes:
        kind: 'pose' or 'position'.
        q: (m, n) rad or m.
        values: (m, 4, 4) or (m, 3) m.
    """

    kind: str
    q: Array
    values: Array

    def __len__(self) -> int:
        return len(self.q)

    @property
    def numbers(self) -> int:
        """Number of components of a measurement."""
        return KINDS[self.kind]

    def part(self, rows: NDArray[Any]) -> "Measurements":
        """Some of the measurements."""
        return Measurements(self.kind, self.q[rows], self.values[rows])


def measured(arm: Arm, q: ArrayLike, values: Any) -> Measurements:
    """Measurements from arrays.

    Args:
        arm: the arm that was measured.
        q: (m, n) rad or m.
        values: (m, 4, 4) poses [m] or (m, 3) positions [m].

    Raises:
        ArgumentError: shapes do not fit, a number is not finite, two rows are the same, or units look mixed up.
        PoseError: an invalid pose.
    """
    Q = arm.chain.check(q)
    if Q.ndim != 2:
        raise ArgumentError(f"joint vectors of shape {Q.shape} given; (m, {arm.dof}) are needed, one a measurement")
    kind = "position" if np.shape(values)[1:] == (3,) and not hasattr(values[0], "homogeneous") else "pose"
    numbers = check_poses(values) if kind == "pose" else values
    shape = (len(Q), 4, 4) if kind == "pose" else (len(Q), 3)
    out = Measurements(kind, Q, inputs.array(numbers, f"measured at {len(Q)} joint vectors", shape, unit="m"))
    _require_different(out)
    _require_units(arm, out)
    return out


def read_measurements(arm: Arm, source: str | os.PathLike[str] | IO[bytes], *, degrees: bool = False) -> Measurements:
    r"""Measurements from a file; its columns are found by their names, in any order.

    Args:
        arm: the arm that was measured.
        source: a path, or a file open for reading bytes: a CSV with a header, an .npz or JSON.
        degrees: whether joint angles and orientations of a CSV are in degrees.

    Raises:
        ArgumentError: the file cannot be read, has no header, lacks a column, or its numbers do not fit.

    Example:
        >>> import io
        >>> import urdf_ik
        >>> arm = urdf_ik.load("planar_2r")
        >>> text = b"joint_2,joint_1,x,y,z\n0.2,0.1,0.19,0.05,0\n0.4,0.3,0.16,0.11,0\n"
        >>> read_measurements(arm, io.BytesIO(text)).q.tolist()
        [[0.1, 0.2], [0.3, 0.4]]
    """
    name, data = files.name_of(source), files.read(source)

    def again() -> IO[bytes]:
        stream = io.BytesIO(data)
        stream.name = name  # what messages call the file
        return stream

    _, table = read_table(again(), ["q"], "measurement", ACCEPTED)
    if not isinstance(table, Table):
        values = read_table(again(), ["T", "p"], "measurement", ACCEPTED)[1]
        return _named(name, lambda: measured(arm, table, values))
    if table.header is None:
        raise ArgumentError(f"{name}, line {table.first}: no header; {ACCEPTED}")
    if absent := [joint for joint in arm.joint_names if table.header.count(joint) != 1]:
        problem = "twice" if absent[0] in table.header else "no column for it"
        raise ArgumentError(
            f"{name}, line {table.first}: joint {absent[0]!r}: {problem}; the header is {','.join(table.header)}, and "
            f"the joints are {', '.join(arm.joint_names)}"
        )
    q = table.numbers(list(arm.joint_names), table.header)
    if degrees:
        q = np.where(arm.chain.prismatic, q, np.deg2rad(q))
    lower = [column.lower() for column in table.header]
    if missing := [column for column in POSITION if column not in lower]:
        raise ArgumentError(f"{name}, line {table.first}: no column {', '.join(missing)}; {ACCEPTED}")
    if any(set(columns) <= set(lower) for columns in ORIENTATIONS.values()):
        values = read_waypoints(again(), degrees=degrees)
    else:
        values = table.numbers(POSITION, lower)
    return _named(name, lambda: measured(arm, q, values))


def _named(name: str, make: Any) -> Measurements:
    try:
        made: Measurements = make()
    except (ArgumentError, PoseError) as error:
        raise ArgumentError(f"{name}: {error}") from None
    return made


def _require_different(given: Measurements) -> None:
    """Refuse identical rows: copies would count twice."""
    rows = np.hstack([given.q, given.values.reshape(len(given), -1)])
    _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    copies = np.flatnonzero(first[inverse.ravel()] != np.arange(len(rows)))
    if len(copies):
        k = int(copies[0])
        raise ArgumentError(
            f"measurements {int(first[inverse.ravel()[k]])} and {k} are the same numbers (counted from 0), "
            f"{len(copies)} such copies in all; delete them: each would count twice"
        )


def _require_units(arm: Arm, given: Measurements) -> None:
    """Refuse angles that seem to be in degrees and lengths that seem to be in mm."""
    turning = given.q[:, ~arm.chain.prismatic]
    if turning.size and np.median(np.abs(turning).max(axis=0)) > _MANY_TURNS:
        raise ArgumentError(
            f"joint angles up to {np.abs(turning).max():.4g} are given; are they in degrees? rad are needed, or "
            "degrees=True (--degrees) for a file"
        )
    slides = given.q[:, arm.chain.prismatic]
    if slides.size and np.abs(slides).max() > _OTHER_UNIT * arm.chain.size:
        raise ArgumentError(f"slides of up to {np.abs(slides).max():.4g} m are given; are they in mm? m are needed")
    if len(given) > 1:
        positions = given.values[:, :3, 3] if given.kind == "pose" else given.values
        theirs, ours = (np.sqrt(p.var(axis=0).sum()) for p in (positions, arm.fk(given.q)[:, :3, 3]))
        if ours > 0.0 and theirs > _OTHER_UNIT * ours:
            raise ArgumentError(
                f"the measured positions are {theirs / ours:.0f} times as far apart as those of the URDF; are they in "
                "mm? m are needed"
            )
