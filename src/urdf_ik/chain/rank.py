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
    """The joints in letters, base to tip: '4R' or 'RRPR'."""
    letters = "".join("P" if slides else "R" for slides in chain.prismatic)
    return letters if "P" in letters else f"{chain.n}R"


def is_redundant(chain: Chain) -> bool:
    """Whether the Jacobian loses rank everywhere: then a pose has a continuum of solutions, or no solution."""
    return float(np.median(least_stretches(chain, chain.jacobian(sampled(chain))))) < _ROUNDING


def sampled(chain: Chain) -> Array:
    """Joint vectors (k, n) all over."""
    q = np.random.default_rng(0).uniform(-math.pi, math.pi, (_SAMPLES, chain.n))
    return np.where(chain.prismatic, q * chain.size / math.pi, q)


def least_stretches(chain: Chain, J: Array) -> Array:
    """Smallest singular values (k,) of Jacobians (k, rows, n), lengths as shares of the arm's size."""
    scaled = J / chain.size
    scaled[:, 3:] = J[:, 3:]
    scaled[:, :, chain.prismatic] *= chain.size
    return np.asarray(np.linalg.svd(scaled, compute_uv=False)[:, -1], dtype=np.float64)
