"""Every solution of a loop as a zero of a determinant, in ball arithmetic: the elimination of Raghavan and Roth.

Axis 3 stays where it is while joint 3 turns. So joints 1 and 2 move it to where the pose and joints 6, 5 and 4 put it.
A line is fifteen numbers, on which motions act linearly. The nine products of (1, cos, sin) of joints 1 and 2 leave six
combinations of these numbers zero: six equations in joints 4, 5 and 6. Times the cosine and the sine of half of joint
5's angle they are twelve linear ones in twelve products of joints 4 and 5. Their determinant is a trigonometric
polynomial of degree eight in joint 6 (M. Raghavan and B. Roth, "Inverse kinematics of the general 6R manipulator and
related linkages", J. Mech. Des. 115, 1993).
"""

from cmath import phase
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import product

import numpy as np
from flint import acb, acb_mat, acb_poly, arb

from urdf_ik.verify.proof.loop import Axes, Loop, unit

_MOVED = arb(2) ** -96  # by how much axes are moved [rad, share of size]: a special arm's determinant vanishes
_SHARP = arb(2) ** -200  # radius up to which zeros are isolated
_DEGREE = 8  # of the determinant
_RANK, _FULL = 9, 11  # of the products of joints 1 and 2; of the matrix at a zero

Vector = list[acb]
Line = tuple[Vector, Vector]  # direction, point
Turn = tuple[acb, acb]  # cosine, sine

_QUARTERS = ((acb(1), acb(0)), (acb(-1), acb(0)), (acb(0), acb(1)))  # turns by 0, pi and pi / 2
_COEFFICIENTS = np.array([[0.5, 0.5, 0.0], [0.5, -0.5, 0.0], [-0.5, -0.5, 1.0]])  # of 1, cos and sin, from values there


@dataclass(frozen=True)
class Zero:
    """A zero of the determinant, and the only joint vector that can belong to it.

    Attributes:
        off: imaginary part of joint 6 [rad]; exactly 0 where the zero is on the circle.
        q: six complex angles [rad], each a ball.
    """

    off: float
    q: list[acb]


def zeros(loop: Loop, near: float) -> list[Zero]:
    """The zeros on and near the circle, for the arm whose axes are moved by 2^-96.

    A solution of the arm as written with the smallest singular value s, well above 2^-48, has one of the moved arm
    within about 2^-96 / s.

    Args:
        loop: the loop equations of a pose.
        near: imaginary part of joint 6 [rad] up to which zeros are wanted.

    Raises:
        ArithmeticError: the precision does not isolate the zeros, or the joints at one of them.
    """
    generic = np.random.default_rng(0).uniform(-1.0, 1.0, (6, 2, 3))
    axes = tuple((unit(_beside(h, a)), _beside(p, b)) for (h, p), (a, b) in zip(loop.axes, generic, strict=True))
    return _Elimination(axes, loop.G).zeros(near)


class _Elimination:
    def __init__(self, axes: Axes, G: acb_mat) -> None:
        self._axes: list[Line] = [([acb(x) for x in h], [acb(x) for x in p]) for h, p in axes]
        self._G = G
        first, second, third = self._axes[:3]
        self._inner = _columns([_turned(_turned(third, second, j), first, i) for i, j in product(_QUARTERS, repeat=2)])
        outer = _columns([self._others(third, turns) for turns in product(_QUARTERS, repeat=3)])
        equations = acb_mat(_null_space(self._inner.transpose(), _RANK)) * outer
        self._parts = [_matrix(equations, 9 * k) for k in range(3)]

    def zeros(self, near: float) -> list[Zero]:
        count = 2 * _DEGREE + 1
        samples = [acb(arb(2 * k) / count).exp_pi_i() for k in range(count)]
        values = [self._at(z.real, z.imag).det() for z in samples]
        powers = range(-_DEGREE, _DEGREE + 1)
        polynomial = [_dot(values, [samples[-i * k % count] for i in range(count)]) for k in powers]
        try:
            roots = acb_poly(polynomial).roots(tol=_SHARP)
        except ValueError as error:
            raise ArithmeticError("the zeros of the determinant are not isolated") from error
        # The polynomial is real on the circle: with a zero its mirror image is one, and a ball holds one zero.
        off = [0.0 if z.overlaps(1 / z.conjugate()) else -float(abs(z).log().mid()) for z in roots]
        return [Zero(y, self._joints(z)) for y, z in zip(off, roots, strict=True) if abs(y) < near]

    def _at(self, c: acb | arb, s: acb | arb) -> acb_mat:
        return self._parts[0] + self._parts[1] * c + self._parts[2] * s

    def _others(self, line: Line, turns: Sequence[Turn]) -> Line:
        """Where the pose and joints 6, 5 and 4, in this order, put a line."""
        for axis, (c, s) in zip(self._axes[3:], reversed(turns), strict=True):
            line = _turned(line, axis, (c, -s))
        G, (direction, point) = self._G, line
        rows = [[G[i, k] for k in range(3)] for i in range(3)]
        return [_dot(row, direction) for row in rows], [_dot(row, point) + G[i, 3] for i, row in enumerate(rows)]

    def _joints(self, z: acb) -> list[acb]:
        sixth = ((z + 1 / z) / 2, (z - 1 / z) / acb(0, 2))
        (x,) = _null_space(self._at(*sixth), _FULL)
        # (1, cos, sin) of joint 4 times C^3, C^2 S, C S^2 and S^3, with the cosine and sine of half of joint 5's angle.
        k = max((0, 3, 6, 9), key=lambda k: x[k].abs_lower())
        fourth = (x[k + 1] / x[k], x[k + 2] / x[k])
        C, S = (x[0], x[3]) if x[0].abs_lower() > x[9].abs_lower() else (x[6], x[9])
        length = C * C + S * S
        fifth = ((C * C - S * S) / length, 2 * C * S / length)
        after = sixth, fifth, fourth
        both = [
            [*row, -w]
            for row, w in zip(self._inner.tolist(), _numbers(self._others(self._axes[2], after)), strict=True)
        ]
        (y,) = _null_space(acb_mat(both), _RANK)
        first, second = (y[3] / y[0], y[6] / y[0]), (y[1] / y[0], y[2] / y[0])
        # Joint 3 turns a vector across its axis to where the others do.
        h, point = self._axes[2]
        least = min(range(3), key=lambda i: h[i].abs_lower())
        across = _cross(h, [acb(int(i == least)) for i in range(3)])
        line = self._others((across, point), after)
        for axis, (c, s) in zip(self._axes, (first, second), strict=False):
            line = _turned(line, axis, (c, -s))
        third = (_dot(across, line[0]) / _dot(across, across), _dot(_cross(h, across), line[0]) / _dot(across, across))
        turns = (first, second, third, fourth, fifth, sixth)
        if not all(x.is_finite() for turn in turns for x in turn):
            raise ArithmeticError("the joints at a zero are not told")
        return [_angle(turn) for turn in turns]


def _beside(v: Sequence[arb], by: Sequence[float]) -> list[arb]:
    return [x + _MOVED * arb(float(y)) for x, y in zip(v, by, strict=True)]


def _dot(a: Sequence[acb], b: Sequence[acb]) -> acb:
    return sum((x * y for x, y in zip(a, b, strict=True)), acb(0))


def _cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _turned(line: Line, axis: Line, turn: Turn) -> Line:
    (h, centre), (c, s) = axis, turn

    def rotated(v: Vector) -> Vector:
        along = (1 - c) * _dot(h, v)
        return [c * x + s * y + along * z for x, y, z in zip(v, _cross(h, v), h, strict=True)]

    direction, point = line
    moved = rotated([x - y for x, y in zip(point, centre, strict=True)])
    return rotated(direction), [x + y for x, y in zip(moved, centre, strict=True)]


def _numbers(line: Line) -> Vector:
    """A line as the fifteen numbers 1, p, |p|^2 / 2, d, p x d, p.d and |p|^2 d / 2 - (p.d) p."""
    d, p = line
    half, along = _dot(p, p) / 2, _dot(p, d)
    return [acb(1), *p, half, *d, *_cross(p, d), along, *(half * x - along * y for x, y in zip(d, p, strict=True))]


def _columns(lines: Sequence[Line]) -> acb_mat:
    """The coefficients of the products of (1, cos, sin) of the joints, from lines at their quarter turns."""
    joints = {9: 2, 27: 3}[len(lines)]
    table = reduce(np.kron, [_COEFFICIENTS] * joints)
    values = acb_mat([_numbers(line) for line in lines])
    return (acb_mat([[float(x) for x in row] for row in table]) * values).transpose()


def _matrix(equations: acb_mat, first: int) -> acb_mat:
    """The 12 x 12 matrix of nine of the equations' columns: (1, cos, sin) of joint 5, slowest, and of joint 4."""
    upper, lower = [], []
    zero = [acb(0)] * 3
    for row in equations.tolist():
        one, cosine, sine = (row[first + 3 * k : first + 3 * k + 3] for k in range(3))
        # 1 = C^2 + S^2, cos = C^2 - S^2, sin = 2 C S
        terms = [a + b for a, b in zip(one, cosine, strict=True)]
        terms += [2 * a for a in sine]
        terms += [a - b for a, b in zip(one, cosine, strict=True)]
        upper.append([*terms, *zero])
        lower.append([*zero, *terms])
    return acb_mat(upper + lower)


def _null_space(M: acb_mat, rank: int) -> list[Vector]:
    """A basis of the vectors that M takes to zero, of which there is none besides if its rank is at most ``rank``."""
    rows, count = M.tolist(), M.ncols()
    order = list(range(count))
    for k in range(rank):
        r, c = max(product(range(k, len(rows)), range(k, count)), key=lambda at: rows[at[0]][at[1]].abs_lower())
        rows[k], rows[r] = rows[r], rows[k]
        order[k], order[c] = order[c], order[k]
        for row in rows:
            row[k], row[c] = row[c], row[k]
        if not rows[k][k].abs_lower() > 0:
            raise ArithmeticError("a rank is not told from a lower one")
        for row in rows[k + 1 :]:
            factor = row[k] / rows[k][k]
            row[k:] = [x - factor * y for x, y in zip(row[k:], rows[k][k:], strict=True)]
    basis = []
    for free in range(rank, count):
        x = [acb(int(i == free)) for i in range(count)]
        for k in reversed(range(rank)):
            x[k] = -_dot(rows[k][k + 1 :], x[k + 1 :]) / rows[k][k]
        basis.append([x[order.index(i)] for i in range(count)])
    return basis


def _angle(turn: Turn) -> acb:
    """The angle of a complex turn, beside that of its midpoint."""
    e = turn[0] + turn[1] * acb(0, 1)
    about = phase(complex(e))
    return about - (e * acb(0, -about).exp()).log() * acb(0, 1)
