"""How far an elimination's constant matrices are from those of the arm, by fixed-point arithmetic in integers."""

import math

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.families.parts.written import Numbers
from urdf_ik.typing import Array

Fixed = NDArray[np.object_]  # integers, in units of 2^-_DIGITS

_LINE = 15
_DIGITS = 160
_UNIT = 2.0**-53
# Of numbers of twice the digits: DOUBLED_UNIT of the core.
_PRECISE = 2.0**-102
_ONE = 1 << _DIGITS
# Each round adds the digits of a double to null vectors, as the inverse is rounded, and doubles those of rotations.
_ROUNDS = 4
UNKNOWN = 1e300
"""A bound where nothing is known: files of numbers hold no infinity."""


def inexact(
    steps: Array, centre: Array, scale: float, cut: tuple[int, bool], left: Array, right: Array
) -> tuple[Array, Numbers]:
    """A bound on the Frobenius norm of the error of the elimination's matrix at any angle of the hidden joint.

    The equations are set up anew from the arm's steps, with the rotations nearest to the stored ones, to 160 binary
    digits, with those null vectors of the left side L (15 x 9) that are nearest to the ones that were used:
    N - N L L^+. What separates both factors from the ones that were used is measured. The loop's motion, both products
    with it and the matrix's sums are rounded when a pose is solved, by 16 u each. Six equations enter the matrix twice,
    with factors up to one, and each of their coefficients with the hidden joint's (1, cos, sin): the matrix errs by at
    most twice as much as they do.

    Args:
        steps: (7, 3, 4) the arm's motions from joint to joint [m].
        centre: (3,) m, the origin of the scaled frame.
        scale: 1/m.
        cut: the joint behind which the loop is cut, and whether it is the chain from tip to base.
        left: (15, 168) left factor that is used, padded with zeros.
        right: (15, 32) right factor that is used, padded with zeros.

    Returns:
        (3,) coefficients of 1, t, t^2, with the length t of the loop's motion; and ``PreciseFactors`` of the core, what
        rounding leaves out of the factors: left (15, 168), right (15, 32), inexact (3,), the bound with both.
    """
    first, is_back = cut
    rows, columns = 6 * 3**first, 3 ** (3 - first)
    rest = Numbers(left=np.zeros_like(left), right=np.zeros_like(right), inexact=np.full(3, UNKNOWN))
    axes = _axes(steps, centre, scale)
    if is_back:
        axes = [(-h, p) for h, p in reversed(axes)]
    motions = [_motions(h, p) for h, p in axes]
    line = _line(axes[first + 2][1], axes[first + 2][0])
    L = _behind(motions[first], _behind(motions[first + 1], line[None])).T
    inverse: Array = np.linalg.pinv(_floats(L)).astype(np.float64)
    if not np.linalg.norm(inverse @ _floats(L) - np.eye(9)) < 0.1:
        return np.full(3, UNKNOWN), rest
    back = np.array([1, 1, -1])[:, None, None]  # of the sine
    joints = [motions[(first + k) % 6] * back for k in (5, 4, 3)]
    N = _fixed(_null(left[:, :rows], joints[:first]))
    for _ in range(_ROUNDS):
        N = N - _times(_times(N, L), _fixed(inverse))
    front, rear = N, line[None]
    for joint in joints[:first]:
        front = _before(front, joint)
    for joint in reversed(joints[first:]):
        rear = _behind(joint, rear)
    front, rear = front.T - _fixed(left[:, :rows]), rear.T - _fixed(right[:, :columns])
    rest.left[:, :rows], rest.right[:, :columns] = _floats(front), _floats(rear)
    sizes = np.abs(left[:, :rows]), np.abs(right[:, :columns])
    rest.inexact[:] = _bound(
        sizes, (front - _fixed(rest.left[:, :rows]), rear - _fixed(rest.right[:, :columns])), _PRECISE
    )
    return _bound(sizes, (front, rear), _UNIT), rest


def _bound(sizes: tuple[Array, Array], off: tuple[Fixed, Fixed], unit: float) -> Array:
    """The bound from the factors' sizes, what separates them from the exact ones, and the unit of rounding."""
    front_size, rear_size = sizes[0].T, sizes[1]
    # What was computed in integers is off by less than their last thirty digits.
    front_off, rear_off = (np.abs(_floats(each)) + 2.0 ** (30 - _DIGITS) for each in (off[0].T, off[1]))
    product = 16.0 * unit
    out = np.empty(3)
    for power, G in enumerate(_MAJORANT):
        moved = G @ rear_size
        moved_off = G @ rear_off + 2.0 * product * moved
        out[power] = np.linalg.norm(
            front_off @ (moved + moved_off) + front_size @ moved_off + 2.0 * product * (front_size @ moved)
        )
    bound: Array = 2.0 * out
    return bound


def _axes(steps: Array, centre: Array, scale: float) -> list[tuple[Fixed, Fixed]]:
    """Directions of the joints' axes and their points next to the origin, in the scaled frame."""
    R, p = _rotation(steps[0, :, :3]), _fixed(steps[0, :, 3])
    origin, unit = _fixed(centre), int(math.ldexp(scale, _DIGITS))
    out = []
    for step in steps[1:]:
        z, at = R[:, 2], (p - origin) * unit >> _DIGITS
        h = (z << _DIGITS) // math.isqrt(int(z @ z))
        out.append((h, at - (_times(at, h) * h >> _DIGITS)))
        R, p = _times(R, _rotation(step[:, :3])), p + _times(R, _fixed(step[:, 3]))
    return out


def _rotation(R: Array) -> Fixed:
    """The rotation nearest to a stored one: Newton's method squares what orthogonality lacks."""
    out = _fixed(R)
    for _ in range(_ROUNDS):
        out = (3 * out - _times(out, _times(out.T, out))) >> 1
    return out


def _null(left: Array, joints: list[Fixed]) -> Array:
    """The null vectors (6, 15) in the left factor (15, r): where the joints' angles are zero, it is they."""
    rows = left.T.reshape(6, *[3] * len(joints), _LINE)
    for _ in joints:
        rows = rows[..., 0, :] + rows[..., 1, :]
    return rows


def _fixed(a: Array) -> Fixed:
    out: Fixed = np.frompyfunc(lambda x: int(math.ldexp(x, _DIGITS)), 1, 1)(a)
    return out


def _floats(a: Fixed) -> Array:
    out: Array = a.astype(np.float64) / 2.0**_DIGITS
    return out


def _times(a: Fixed, b: Fixed) -> Fixed:
    out: Fixed = (a @ b) >> _DIGITS
    return out


def _before(front: Fixed, motion: Fixed) -> Fixed:
    """Rows (r, 15) times a joint's motion (3, 15, 15): (3 r, 15), the joint's part fastest."""
    return _times(front, motion.transpose(1, 0, 2).reshape(_LINE, 3 * _LINE)).reshape(-1, _LINE)


def _behind(motion: Fixed, rear: Fixed) -> Fixed:
    """A joint's motion (3, 15, 15) times columns (c, 15): (3 c, 15), the joint's part slowest."""
    moved = _times(motion.reshape(3 * _LINE, _LINE), rear.T)
    return moved.reshape(3, _LINE, -1).transpose(0, 2, 1).reshape(-1, _LINE)


def _cross(a: Fixed, b: Fixed) -> Fixed:
    out = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    return np.array([each >> _DIGITS for each in out], dtype=object)


def _line(p: Fixed, direction: Fixed) -> Fixed:
    """The 15 numbers of the line through p; see hidden_joint.hpp."""
    h, d = _times(p, p) >> 1, _times(p, direction)
    last = (h * direction - d * p) >> _DIGITS
    out: Fixed = np.concatenate([[_ONE], p, [h], direction, _cross(p, direction), [d], last])
    return out


def _motions(h: Fixed, p: Fixed) -> Fixed:
    """(3, 15, 15): the motion of lines by a turn about the axis is the sum of these times 1, cos, sin."""
    x, y, z = h
    eye = np.array([[_ONE * (i == k) for k in range(3)] for i in range(3)], dtype=object)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=object)
    KK = _times(K, K)
    at_zero, half, quarter = (_moved(R, p - _times(R, p)) for R in (eye, eye + 2 * KK, eye + K + KK))
    constant = (at_zero + half) >> 1
    return np.stack([constant, (at_zero - half) >> 1, quarter - constant])


def _moved(R: Fixed, t: Fixed) -> Fixed:
    """(15, 15): how the motion R, t acts on lines."""
    U = np.zeros((_LINE, _LINE), dtype=object)
    half, along = _times(t, t) >> 1, _times(t, R)
    cross = np.stack([_cross(t, R[:, k]) for k in range(3)], axis=1)
    U[0, 0] = U[4, 4] = U[11, 11] = _ONE
    U[4, 0] = half
    U[1:4, 0], U[12:, 11] = t, -t
    for k in (1, 5, 8, 12):
        U[k : k + 3, k : k + 3] = R
    U[4, 1:4] = U[11, 5:8] = along
    U[8:11, 5:8], U[12:, 8:11] = cross, -cross
    U[12:, 5:8] = (half * R - t[:, None] * along) >> _DIGITS
    return U


def _majorants() -> Array:
    """(3, 15, 15): entries of a line's motion are at most the sum of these times 1, t, t^2, by the shift's length t."""
    U = np.zeros((3, _LINE, _LINE))
    for k in (0, 4, 11):
        U[0, k, k] = 1.0
    for k in (1, 5, 8, 12):
        U[0, k : k + 3, k : k + 3] = 1.0
    U[1, 1:4, 0], U[1, 12:, 11], U[1, 4, 1:4], U[1, 11, 5:8] = 1.0, 1.0, 1.0, 1.0
    U[1, 8:11, 5:8], U[1, 12:, 8:11] = 1.0, 1.0
    U[2, 4, 0], U[2, 12:, 5:8] = 0.5, 1.5
    return U


_MAJORANT = _majorants()
