"""What a chain's joints do at almost every joint vector: their kinds, and whether they are redundant."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.chain.serial import Chain

    Array = NDArray[np.float64]

_SAMPLES = 60
# Smallest singular value of the Jacobian, at the middle one of sampled joint vectors, that is rounding of zero.
_ROUNDING = 1e-9


def kinds_of(chain: Chain) -> str:
    """The joints in letters, base to tip: '4R' or 'RRPR'.

    Example:
        >>> import urdf_ik
        >>> kinds_of(urdf_ik.load("scara_rrpr").chain), kinds_of(urdf_ik.load("puma_560").chain)
        ('RRPR', '6R')
    """
    letters = "".join("P" if slides else "R" for slides in chain.prismatic)
    return letters if "P" in letters else f"{chain.n}R"


def is_redundant(chain: Chain) -> bool:
    """Whether the Jacobian loses rank everywhere: then a pose has a continuum of solutions, or no solution.

    Example:
        >>> import urdf_ik
        >>> twice = urdf_ik.DHTable.from_array([[0.0, 0.0, 0.1, 0.0]] * 2, "standard")  # the same axis twice
        >>> is_redundant(twice.chain()), is_redundant(urdf_ik.load("puma_560").chain)
        (True, False)
    """
    return float(np.median(least_stretches(chain, chain.jacobian(sampled(chain))))) < _ROUNDING


def sampled(chain: Chain) -> Array:
    """Joint vectors (k, n) all over.

    Example:
        >>> import urdf_ik
        >>> q = sampled(urdf_ik.load("puma_560").chain)
        >>> len(q) > 1, q.shape[1]
        (True, 6)
    """
    q = np.random.default_rng(0).uniform(-math.pi, math.pi, (_SAMPLES, chain.n))
    return np.where(chain.prismatic, q * chain.size / math.pi, q)


def least_stretches(chain: Chain, J: Array) -> Array:
    """Smallest singular values (k,) of Jacobians (k, rows, n), lengths as shares of the arm's size.

    Example:
        >>> import urdf_ik
        >>> chain = urdf_ik.load("puma_560").chain
        >>> J = chain.jacobian([[0.1, 0.2, 0.3, 0.4, 0.0, 0.6], [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]])
        >>> (least_stretches(chain, J) > 1e-6).tolist()
        [False, True]
    """
    scaled = J / chain.size
    scaled[:, 3:] = J[:, 3:]
    scaled[:, :, chain.prismatic] *= chain.size
    return np.asarray(np.linalg.svd(scaled, compute_uv=False)[:, -1], dtype=np.float64)
