"""Vectors of six numbers as tuples, so that the compiler keeps them in registers."""

from __future__ import annotations

import math

from urdf_ik._kernels.compile import step

_TINY = 1e-300


@step
def dot(a, b):
    """Sum of the products."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]


@step
def times(a, f):
    """``a`` scaled by ``f``."""
    return a[0] * f, a[1] * f, a[2] * f, a[3] * f, a[4] * f, a[5] * f


@step
def less(a, f, b):
    """The difference a - f b."""
    return a[0] - f * b[0], a[1] - f * b[1], a[2] - f * b[2], a[3] - f * b[3], a[4] - f * b[4], a[5] - f * b[5]


@step
def inverse_length(a):
    """One over the Euclidean length."""
    return 1.0 / math.sqrt(dot(a, a) + _TINY)


@step
def largest(a):
    """Greatest absolute value."""
    return max(max(max(abs(a[0]), abs(a[1])), max(abs(a[2]), abs(a[3]))), max(abs(a[4]), abs(a[5])))
