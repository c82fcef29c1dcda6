"""The generic rank of a chain's Jacobian: which motions its joints control, and which joints are redundant."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from urdf_ik.kinematics.chain.serial import Chain
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

_SAMPLES = 60


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

    Joint vectors are sampled; the chain is redundant if at least half of them are singular by the solvers' measure.
    Seven joints of a redundant chain do not control all six directions of the tip.

    Example:
        >>> import urdf_ik
        >>> twice = urdf_ik.DHTable.from_array([[0.0, 0.0, 0.1, 0.0]] * 2, "standard")  # the same axis twice
        >>> is_redundant(twice.chain()), is_redundant(urdf_ik.load("puma_560").chain)
        (True, False)
    """
    return typical_stretch(chain) < DEFAULT.singular


def typical_stretch(chain: Chain) -> float:
    """The Jacobian's smallest singular value, lengths as shares of the size: the middle one of sampled joint vectors.

    Example:
        >>> import urdf_ik
        >>> typical_stretch(urdf_ik.load("puma_560").chain) > 1e-3
        True
    """
    return float(np.median(least_stretches(chain, chain.jacobian(sampled(chain)))))


def dependent_joints(chain: Chain) -> tuple[str, ...]:
    """Joints that move the tip as others among them do, at almost every joint vector, so few as can be; () if none do.

    Example:
        >>> import urdf_ik
        >>> twice = urdf_ik.DHTable.from_array([[0.3, 0, 0.2, 0.5], [0, 0, 0.1, 0], [0.2, 0, 0, 0]], "standard")
        >>> dependent_joints(twice.chain()), dependent_joints(urdf_ik.load("puma_560").chain)
        (('joint_2', 'joint_3'), ())
    """
    J = chain.jacobian(sampled(chain))

    def depends(joints: list[int]) -> bool:
        return float(np.median(least_stretches(chain, J, joints))) < DEFAULT.singular

    kept = list(range(chain.n))
    if chain.n > 6 or not depends(kept):
        return ()
    for k in range(chain.n):
        fewer = [j for j in kept if j != k]
        if fewer and depends(fewer):
            kept = fewer
    return tuple(chain.joint_names[k] for k in kept)


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


def least_stretches(chain: Chain, J: Array, joints: Sequence[int] | None = None) -> Array:
    """Smallest singular values (k,) of Jacobians (k, rows, n), lengths as shares of the arm's size.

    Args:
        chain: the arm.
        J: its Jacobians, or the rows of them that matter [m or rad, by rad or m].
        joints: those whose columns count; None: all.

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
    if joints is not None:
        scaled = scaled[:, :, list(joints)]
    return np.asarray(np.linalg.svd(scaled, compute_uv=False)[:, -1], dtype=np.float64)
