"""Functions of the Jacobian: manipulability and condition number."""

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.kinematics.chain import Chain
from urdf_ik.support import inputs
from urdf_ik.typing import Array

LEAST_LENGTH = 1e-12
"""The least length [m] that turns translations into angles."""

PARTS = {"all": slice(0, 6), "translation": slice(0, 3), "rotation": slice(3, 6)}
"""Rows of the Jacobian that a question may be about."""


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
        length: characteristic length [m], which linear rows and the speeds of prismatic joints are divided by; the
            chain's size where left out.

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
    length = chain.size if length is None else inputs.number(length, "length", low=LEAST_LENGTH, unit="m")
    J = chain.jacobian(q)
    J[..., :3, :] /= length
    J[..., chain.prismatic] *= length
    J = J[..., _rows(part), :]
    if chain.n == 0:
        return np.full(J.shape[:-2], np.inf)
    s = _singular_values(J)
    rounding = max(J.shape[-2:]) * np.finfo(np.float64).eps * s[..., 0]
    singular = s[..., -1] <= rounding
    return np.where(singular, np.inf, s[..., 0] / np.where(singular, 1.0, s[..., -1]))


def _singular_values(J: Array) -> Array:
    """(..., k) singular values of Jacobians, the greatest first; NaN where the Jacobian is."""
    gone = np.asarray(np.isnan(J).any(axis=(-2, -1)))
    s = np.linalg.svd(np.where(gone[..., None, None], 0.0, J), compute_uv=False)
    return np.where(gone[..., None], np.nan, s)


def _rows(part: str) -> slice:
    return PARTS[inputs.choice(part, "part", tuple(PARTS))]
