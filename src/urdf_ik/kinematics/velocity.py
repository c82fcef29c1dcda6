"""Manipulability, a function of the Jacobian."""

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.kinematics.chain import Chain
from urdf_ik.support import inputs
from urdf_ik.typing import Array

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
    J = chain.jacobian(q)[..., PARTS[inputs.choice(part, "part", tuple(PARTS))], :]
    if chain.n == 0:
        return np.zeros(J.shape[:-2])
    gone = np.asarray(np.isnan(J).any(axis=(-2, -1)))
    volume = np.linalg.svd(np.where(gone[..., None, None], 0.0, J), compute_uv=False).prod(axis=-1)
    return np.where(gone, np.nan, volume)
