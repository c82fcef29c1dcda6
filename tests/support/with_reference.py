"""Arms beside Pinocchio's view of them, where joints mimic others, and how joint vectors of them are compared."""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference

Array = NDArray[np.float64]


@lru_cache
def arm_and_reference(text: str) -> tuple[urdf_ik.Arm, Reference]:
    """The arm of a URDF's text between its links 'base' and 'tool', and Pinocchio's view of it."""
    return urdf_ik.load(text, "base", "tool"), Reference(text, "base", "tool")


def distances(arm: urdf_ik.Arm, Q: Array, q: Array) -> Array:
    """Greatest difference (...) of a joint between vectors, images of a joint being the same."""
    turns = 2.0 * math.pi * arm.chain.image_turns
    gap = Q - q
    return np.asarray(np.abs(gap - turns * np.round(gap / np.where(turns, turns, 1.0))).max(axis=-1))


def holds(arm: urdf_ik.Arm, reference: Reference, planted: Array, loosened: float = 1.0) -> None:
    """Planted joint vectors (m, n) are found in a batch of their poses; all solutions are exact, none given twice.

    ``loosened`` multiplies the tolerance of 1e-9 and 1e-11 over the smallest singular value.
    """
    solutions = arm.ik(reference.pose(planted))
    for k, q in enumerate(planted):
        found = solutions[k].to_array()
        sigma = np.linalg.svd(scaled_jacobian(reference, q), compute_uv=False)[-1]
        assert distances(arm, found, q).min() < loosened * (1e-9 + 1e-11 / sigma), q.tolist()
        assert max(error.max() for error in reference.errors(found, reference.pose(q))) <= 1e-9, q.tolist()
        for i in range(1, len(found)):
            assert distances(arm, found[:i], found[i]).min() > 1e-7, q.tolist()


def scaled_jacobian(reference: Reference, q: Array) -> Array:
    """Jacobian (6, n), lengths as shares of the arm's size."""
    J = reference.jacobian(q)
    J[:3] /= reference.size
    return J
