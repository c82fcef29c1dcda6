"""Random arms with seven joints beside their reference, and how near their answers have to be."""

from functools import lru_cache

import numpy as np
from arms_seven import random_seven
from cases import Array, Case, described


@lru_cache
def member(kind: str, seed: int, orthogonal: bool = False, aligned: bool = False) -> Case:
    """Load a random member of a kind of ``SEVEN``."""
    return described(random_seven(kind, seed, orthogonal=orthogonal, aligned=aligned))


def tolerance(case: Case, q: Array) -> float:
    """How far [rad] an answer may be from q: rounding over the conditioning of pose and parameter together."""
    step = 1e-6 * np.eye(7)
    ahead, behind = case.arm.redundancy_of(q + step), case.arm.redundancy_of(q - step)
    gradient = ((ahead - behind + np.pi) % (2.0 * np.pi) - np.pi) / 2e-6
    sigma = np.linalg.svd(np.vstack([case.oracle.jacobian(q), gradient]), compute_uv=False)[-1]
    return 1e-6 + 1e-11 / max(float(sigma), 1e-14)
