"""Functions of the Jacobian: manipulability, condition number, singular directions, joint velocities for a twist.

A twist is (vx, vy, vz, wx, wy, wz) [m/s, rad/s] of the tip, in base axes at the tip, as the Jacobian's rows. Where
metres and radians have to be compared, lengths are shares of a characteristic length: linear rows, and the speeds
of prismatic joints, are divided by it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support import inputs
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

Mask = NDArray[np.bool_]

PARTS = {"all": slice(0, 6), "translation": slice(0, 3), "rotation": slice(3, 6)}
"""Rows of the Jacobian that a question may be about."""


@dataclass(frozen=True)
class SingularDirections:
    """Gains between joint motions and twists, and the directions that have no gain.

    Twists and motions have the length 1 when their lengths are counted as shares of the characteristic length;
    they are given in m, rad and m/s, rad/s.

    Attributes:
        gains: (..., 6) singular values, greatest first: speed of each of ``twists`` for a motion of length 1; zero
            where the arm has fewer joints.
        twists: (..., 6, 6) one a row, at right angles to each other.
        lost: (..., 6) bool: twists that no motion gives.
        motion_gains: (..., n) singular values of ``motions``.
        motions: (..., n, n) joint velocities, one a row, at right angles to each other.
        idle: (..., n) bool: motions that leave the tip where it is.
    """

    gains: Array
    twists: Array
    lost: Mask
    motion_gains: Array
    motions: Array
    idle: Mask


def manipulability(chain: Chain, q: ArrayLike, part: str = "all") -> Array:
    """Yoshikawa's measure: the volume of twists that joint velocities of length 1 give.

    sqrt(det(J J^T)) for at least as many joints as rows, sqrt(det(J^T J)) for fewer, as the product of the singular
    values (Yoshikawa, "Manipulability of robotic mechanisms", International Journal of Robotics Research 4(2), 1985).

    Args:
        chain: the arm.
        q: (..., n) rad or m.
        part: 'all', 'translation' or 'rotation': the Jacobian's rows.

    Returns:
        (...) in m to the power of the linear rows.

    Raises:
        ArgumentError: ``q`` is not a joint vector of this chain.
        ArgumentError: an unknown part.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> float(manipulability(arm.chain, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]).round(4)) > 0.0
        True
    """
    J = chain.jacobian(q)[..., _rows(part), :]
    if chain.n == 0:
        return np.zeros(J.shape[:-2])
    return np.asarray(_singular_values(J).prod(axis=-1))


def condition_number(chain: Chain, q: ArrayLike, part: str = "all", length: float | None = None) -> Array:
    """Greatest over smallest singular value: 1 where all directions are equally easy, infinite at a singularity.

    Args:
        chain: the arm.
        q: (..., n) rad or m.
        part: 'all', 'translation' or 'rotation': the Jacobian's rows.
        length: characteristic length [m]; the chain's size where left out.

    Returns:
        (...) of the first min(rows, n) singular values.

    Raises:
        ArgumentError: ``q`` is not a joint vector of this chain.
        ArgumentError: an unknown part, or an invalid length.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> float(condition_number(arm.chain, [0.1, 0.2, 0.3, 0.4, 0.0, 0.6]))
        inf
    """
    J = _scaled_jacobian(chain, q, _length(chain, length))[..., _rows(part), :]
    if chain.n == 0:
        return np.full(J.shape[:-2], np.inf)
    s = _singular_values(J)
    rounding = max(J.shape[-2:]) * np.finfo(np.float64).eps * s[..., 0]
    singular = s[..., -1] <= rounding
    return np.where(singular, np.inf, s[..., 0] / np.where(singular, 1.0, s[..., -1]))


def singular_directions(
    chain: Chain, q: ArrayLike, *, length: float | None = None, tolerance: float = DEFAULT.singular
) -> SingularDirections:
    """Twists that are lost and joint motions that do nothing, with the singular values.

    Args:
        chain: the arm.
        q: (..., n) rad or m.
        length: characteristic length [m]; the chain's size where left out.
        tolerance: singular value below which a direction counts as lost or idle.

    Raises:
        ArgumentError: ``q`` is not a joint vector of this chain.
        ArgumentError: an invalid length or tolerance.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> int(singular_directions(arm.chain, [0.1, 0.2, 0.3, 0.4, 0.0, 0.6]).lost.sum())
        1
    """
    L = _length(chain, length)
    bound = inputs.number(tolerance, "tolerance", low=0.0)
    J = _scaled_jacobian(chain, q, L)
    gone = np.asarray(np.isnan(J).any(axis=(-2, -1)))
    U, s, Vt = np.linalg.svd(np.where(gone[..., None, None], 0.0, J))
    gains, motion_gains = (np.zeros((*s.shape[:-1], count)) for count in (6, chain.n))
    gains[..., : s.shape[-1]] = motion_gains[..., : s.shape[-1]] = s
    twists = np.swapaxes(U, -1, -2).copy()
    twists[..., :3] *= L
    motions = Vt * np.where(chain.prismatic, L, 1.0)
    for array in (gains, twists, motion_gains, motions):
        array[gone] = np.nan
    return SingularDirections(gains, twists, gains < bound, motion_gains, motions, motion_gains < bound)


def joint_velocities(
    chain: Chain,
    q: ArrayLike,
    twist: ArrayLike,
    *,
    part: str = "all",
    damping: float | None = None,
    weights: ArrayLike | None = None,
    limits: ArrayLike | None = None,
    length: float | None = None,
) -> Array:
    """Joint velocities that give the tip a twist, by damped least squares.

    They minimise ``|J qd - twist|^2 + damping^2 |qd|^2``. Left out, the damping follows from the smallest singular
    value s: 0 from ``tolerances.DEFAULT.damped`` on, below it the root of 1 - (s / damped)^2 times ``damping``
    (Nakamura and Hanafusa, ASME Journal of Dynamic Systems, Measurement, and Control 108, 1986; the form is that of
    Chiaverini, Siciliano and Egeland, IEEE Transactions on Control Systems Technology 2(2), 1994). Undamped, they are
    the least ones of those that come nearest to the twist.

    Args:
        chain: the arm.
        q: (..., n) rad or m.
        twist: (..., 6) m/s and rad/s at the tip, in base axes; (..., 3) for a part. The leading dimensions broadcast.
        part: 'all', 'translation' or 'rotation': the Jacobian's rows that matter.
        damping: of all joint vectors, against a Jacobian in shares of ``length``; 0 for no damping.
        weights: (n,) positive: a joint of greater weight moves less. Only their ratios matter.
        limits: (n,) greatest speed of each joint, rad/s or m/s. Where one would be exceeded, all joints slow down
            together, and the tip with them in the same direction.
        length: characteristic length [m]; the chain's size where left out.

    Returns:
        (..., n) rad/s or m/s.

    Raises:
        ArgumentError: ``q`` is not a joint vector of this chain.
        ArgumentError: an invalid twist, damping, weight, limit, length or part.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> joint_velocities(arm.chain, [0.1] * 6, [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]).shape
        (6,)
    """
    rows, L = _rows(part), _length(chain, length)
    units = np.where(np.arange(6) < 3, L, 1.0)[rows]
    wanted = inputs.array(twist, "twist", (..., len(units))) / units
    easy = np.ones(chain.n)
    if weights is not None:
        heavy = _each_joint(chain, "weights", weights)
        easy = np.sqrt(heavy.mean() / heavy)
    J = _scaled_jacobian(chain, q, L)[..., rows, :] * easy
    try:
        batch = np.broadcast_shapes(J.shape[:-2], wanted.shape[:-1])
    except ValueError:
        raise ArgumentError(
            f"{J.shape[:-2]} joint vectors and {wanted.shape[:-1]} twists given; the shapes do not broadcast"
        ) from None
    if chain.n == 0:
        return np.zeros((*batch, 0))
    gone = np.asarray(np.isnan(J).any(axis=(-2, -1)))
    U, s, Vt = np.linalg.svd(np.where(gone[..., None, None], 0.0, J), full_matrices=False)
    if damping is None:
        near = np.minimum(s[..., -1:] / DEFAULT.damped, 1.0)
        square = DEFAULT.damping**2 * (1.0 - near**2)
    else:
        square = np.full((*s.shape[:-1], 1), inputs.number(damping, "damping", low=0.0) ** 2)
    # What is singular to rounding gives nothing, also without damping.
    live = s > max(J.shape[-2:]) * np.finfo(np.float64).eps * s[..., :1]
    inverse = np.where(live, s / np.where(live, s**2 + square, 1.0), 0.0)
    share = inverse * np.einsum("...ik,...i->...k", U, wanted)
    rates = np.einsum("...kj,...k->...j", Vt, share) * easy * np.where(chain.prismatic, L, 1.0)
    if limits is not None:
        most = (np.abs(rates) / _each_joint(chain, "limits", limits)).max(axis=-1, keepdims=True)
        rates = rates / np.maximum(most, 1.0)
    return np.where(gone[..., None], np.nan, rates)


LEAST_LENGTH = 1e-12
"""The least length [m] that turns translations into angles."""


def _scaled_jacobian(chain: Chain, q: ArrayLike, length: float) -> Array:
    """The Jacobian (..., 6, n) without units: lengths as shares of ``length``, also those of prismatic joints."""
    J = chain.jacobian(q)
    J[..., :3, :] /= length
    J[..., chain.prismatic] *= length
    return J


def _singular_values(J: Array) -> Array:
    """(..., k) singular values of Jacobians, the greatest first; NaN where the Jacobian is."""
    gone = np.asarray(np.isnan(J).any(axis=(-2, -1)))
    s = np.linalg.svd(np.where(gone[..., None, None], 0.0, J), compute_uv=False)
    return np.where(gone[..., None], np.nan, s)


def _rows(part: str) -> slice:
    return PARTS[inputs.choice(part, "part", tuple(PARTS))]


def _length(chain: Chain, length: float | None) -> float:
    return chain.size if length is None else inputs.number(length, "length", low=LEAST_LENGTH, unit="m")


def _each_joint(chain: Chain, name: str, values: ArrayLike) -> Array:
    """One positive number a joint."""
    array = inputs.real(values, name, f"{chain.n} numbers")
    if array.shape != (chain.n,):
        raise ArgumentError(f"{name} of shape {array.shape} given; one number a joint ({chain.n},) is needed")
    for joint, value in zip(chain.joint_names, array, strict=True):
        if not inputs.usable(value):
            raise ArgumentError(f"{name}: {value} for joint {joint!r}; a number {inputs.USABLE} is needed")
    return array
