"""The loop equations of six turning joints in ball arithmetic: every number is a ball that encloses the true value."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from flint import acb, acb_mat, arb, ctx
from numpy.typing import NDArray

from urdf_ik.errors import UnsupportedArm
from urdf_ik.kinematics.chain import Chain
from urdf_ik.typing import Array

Axes = tuple[tuple[list[arb], list[arb]], ...]

ORDER = (2, 1, 0, 5, 4, 3)  # in which the joints turn X
_HALF = acb("0.5")


@dataclass(frozen=True)
class Loop:
    """``X(q) = (e1 e2 e3)^-1 G (e4 e5 e6)^-1``, which is the identity where q reaches the pose.

    ``e_k`` turns about the screw axis k at the zero configuration and G is the pose times the inverse of the tip's pose
    at zero. Six equations say so: the position of X, and the vector of the skew part of its rotation. They also hold
    where X is half a turn; the trace of X tells these apart.

    Attributes:
        axes: unit direction and a point of each joint's axis at the zero configuration, joint 1 first.
        G: the 4x4 motion that the joints must make together.
    """

    axes: Axes
    G: acb_mat

    @cached_property
    def twists(self) -> tuple[acb_mat, ...]:
        """The six 4x4 matrices of the axes' twists, in the order in which X turns."""
        return tuple(twist(*self.axes[j]) for j in ORDER)

    @classmethod
    def of(cls, chain: Chain, T: Array, precision: int = 2048) -> Self:
        """The loop of a chain at a pose, whose rotation is the one nearest to the matrix given.

        Lengths are shares of the sum of the steps between the axes.

        Args:
            chain: six turning joints.
            T: (4, 4) pose of the tip in the base [m].
            precision: bits of every number from here on.
        """
        if chain.n != 6 or chain.prismatic.any() or chain.followers:
            raise UnsupportedArm("a proof is checked for six turning joints, and this chain has others")
        ctx.prec = precision
        size = arb(float(np.linalg.norm(chain.P[1:6], axis=1).sum()) or 1.0)
        at_zero = [
            [sum((arb(float(step)) for step in chain.P[: k + 1, i]), arb(0)) / size for i in range(3)] for k in range(7)
        ]
        axes = tuple((unit([arb(float(x)) for x in chain.H[j]]), at_zero[j]) for j in range(6))
        tip = _motion(_rotation(chain.R_tip), at_zero[6])
        goal = _motion(_rotation(T[:3, :3]), [arb(float(x)) / size for x in T[:3, 3]])
        return cls(axes, goal * _inverse(tip))

    def values(self, q: Sequence[acb]) -> acb_mat:
        """X at q, six balls."""
        return self._swept(q)[0]

    def jacobian(self, q: Sequence[acb]) -> tuple[acb_mat, acb_mat]:
        """X and the (6, 6) derivatives of the six equations by the joints, joint 1 first."""
        X, moved = self._swept(q)
        columns = {j: residual(moved[i] * X) for i, j in enumerate(ORDER)}
        return X, acb_mat([[columns[j][row] for j in range(6)] for row in range(6)])

    def _swept(self, q: Sequence[acb]) -> tuple[acb_mat, list[acb_mat]]:
        """X, and the twist of each factor carried to the left end: dX/dq = moved X."""
        X, moved = _identity(), []
        for place, (j, generator) in enumerate(zip(ORDER, self.twists, strict=True)):
            if place == 3:
                X = X * self.G
            moved.append(-(X * generator * _inverse(X)))
            X = X * _turn(generator, -q[j])
        return X, moved


def is_identity(X: acb_mat) -> bool:
    """Whether X, which holds a root of the equations, is the identity, and not half a turn."""
    trace = X[0, 0] + X[1, 1] + X[2, 2]  # 3 or -1: the rotation is symmetric, and its own inverse
    return not trace.contains(acb(-1))


def twist(h: list[arb], p: list[arb]) -> acb_mat:
    """The 4x4 matrix of the unit twist about the axis through p along h."""
    v = [p[1] * h[2] - p[2] * h[1], p[2] * h[0] - p[0] * h[2], p[0] * h[1] - p[1] * h[0]]
    rows = [[arb(0), -h[2], h[1], v[0]], [h[2], arb(0), -h[0], v[1]], [-h[1], h[0], arb(0), v[2]]]
    return acb_mat([*([acb(x) for x in row] for row in rows), [0, 0, 0, 0]])


def midpoints(values: Sequence[acb]) -> list[acb]:
    """The centres of balls, as exact numbers."""
    return [acb(value.real.mid(), value.imag.mid()) for value in values]


def box(centre: Sequence[acb], radius: arb) -> list[acb]:
    """Around each centre the square of half width ``radius``."""
    side = arb(0, radius)
    return [acb(c.real + side, c.imag + side) for c in centre]


def exact(values: NDArray[np.complex128] | Array) -> list[acb]:
    """Doubles as exact numbers."""
    return [acb(arb(float(v.real)), arb(float(v.imag))) for v in np.asarray(values, dtype=np.complex128)]


def largest(values: Sequence[acb]) -> arb:
    """An upper bound on the greatest absolute value."""
    out = arb(0)
    for value in values:
        out = out.max(value.abs_upper())
    return out


def unit(v: list[arb]) -> list[arb]:
    """The vector over its length."""
    length = _length(v)
    return [x / length for x in v]


def _length(v: list[arb]) -> arb:
    return sum((x * x for x in v), arb(0)).sqrt()


def _rotation(R: Array) -> list[list[arb]]:
    """The rotation nearest to a matrix of doubles that is all but a rotation, exact up to the precision."""
    M = acb_mat([[acb(float(x)) for x in row] for row in R])
    for _ in range(5):
        M = (M + M.transpose().inv()) * _HALF
        M = acb_mat([[acb(M[i, k].real.mid()) for k in range(3)] for i in range(3)])
    m = [[M[i, k].real for k in range(3)] for i in range(3)]
    diagonal = [m[0][0] + m[1][1] + m[2][2], m[0][0], m[1][1], m[2][2]]
    most = max(range(4), key=lambda i: float(diagonal[i]))
    if most == 0:
        q = [1 + diagonal[0], m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]
    else:
        i = most - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        q = [m[k][j] - m[j][k], arb(0), arb(0), arb(0)]
        q[1 + i] = 1 + m[i][i] - m[j][j] - m[k][k]
        q[1 + j], q[1 + k] = m[j][i] + m[i][j], m[k][i] + m[i][k]
    w, x, y, z = unit([value.mid() for value in q])
    return [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]


def _motion(R: list[list[arb]], p: list[arb]) -> acb_mat:
    return acb_mat([[acb(R[i][k]) for k in range(3)] + [acb(p[i])] for i in range(3)] + [[0, 0, 0, 1]])


def _turn(S: acb_mat, angle: acb) -> acb_mat:
    """exp(S angle) of a turning joint: 1 + sin S + (1 - cos) S^2, since S^3 = -S."""
    return _identity() + S * angle.sin() + (S * S) * (1 - angle.cos())


def _inverse(X: acb_mat) -> acb_mat:
    """The inverse of a motion: its rotation's transpose is its inverse, for complex angles too."""
    R = [[X[k, i] for k in range(3)] for i in range(3)]
    p = [-(R[i][0] * X[0, 3] + R[i][1] * X[1, 3] + R[i][2] * X[2, 3]) for i in range(3)]
    return acb_mat([[*R[i], p[i]] for i in range(3)] + [[0, 0, 0, 1]])


def _identity() -> acb_mat:
    return acb_mat([[int(i == k) for k in range(4)] for i in range(4)])


def residual(A: acb_mat) -> list[acb]:
    """The six equations at X, or their derivatives from those of X."""
    skew = ((A[2, 1] - A[1, 2]), (A[0, 2] - A[2, 0]), (A[1, 0] - A[0, 1]))
    return [A[0, 3], A[1, 3], A[2, 3], *(each * _HALF for each in skew)]
