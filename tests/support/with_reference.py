"""Arms beside Pinocchio's view of them, where joints mimic others, and how joint vectors of them are compared."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.cell.reference import Reference

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


def scaled_jacobian(reference: Reference, q: Array) -> Array:
    """Jacobian (6, n), lengths as shares of the arm's size."""
    J = reference.jacobian(q)
    J[:3] /= reference.size
    return J
