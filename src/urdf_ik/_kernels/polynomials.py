"""Roots of the polynomials that the families end in."""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels.compile import kernel

# A complex pair this close to the unit circle may be a double real root that rounding has split.
_NEAR_CIRCLE = 1e-3


@kernel
def trigonometric_roots(e0, ec, es, ec2, es2, roots):
    """Real roots of e0 + ec cos t + es sin t + ec2 cos 2t + es2 sin 2t, as (cos, sin) rows of ``roots`` (4, 2).

    With z = exp(it) it is a self-inversive quartic, whose roots on the unit circle are the real ones; all four
    are found together by Aberth's iteration, which needs no case distinction. A pair just off the circle is
    given as two roots, for the caller to verify. Returns how many there are.
    """
    # c[k] z^k, k = 0..4: conj(h2), conj(h1), e0, h1, h2 with h1 = (ec - i es) / 2.
    c = np.empty(5, np.complex128)
    c[0], c[1] = 0.5 * (ec2 + 1j * es2), 0.5 * (ec + 1j * es)
    c[2] = complex(e0, 0.0)
    c[3], c[4] = 0.5 * (ec - 1j * es), 0.5 * (ec2 - 1j * es2)
    largest = 0.0
    for k in range(5):
        largest = max(largest, abs(c[k]))
    if largest == 0.0:
        return 0
    degree = 4
    if abs(c[4]) < 1e-14 * largest:
        # The second harmonic vanishes: z divides out once at each end.
        degree = 2
        c[0], c[1], c[2] = c[1], c[2], c[3]
    z = np.empty(4, np.complex128)
    for k in range(degree):
        angle = 2.0 * math.pi * k / degree + 0.4
        z[k] = (1.0 + 0.1 * (k % 2)) * complex(math.cos(angle), math.sin(angle))
    for _ in range(60):
        moved = 0.0
        for k in range(degree):
            value, slope = c[degree], 0j
            for j in range(degree - 1, -1, -1):
                slope = slope * z[k] + value
                value = value * z[k] + c[j]
            if value == 0j:
                continue
            ratio = slope / value
            for j in range(degree):
                if j != k:
                    apart = z[k] - z[j]
                    if apart != 0j:
                        ratio -= 1.0 / apart
            if ratio == 0j:
                continue
            shift = 1.0 / ratio
            z[k] -= shift
            moved = max(moved, abs(shift) / max(abs(z[k]), 1e-30))
        if moved < 1e-15:
            break
    count = 0
    for k in range(degree):
        size = abs(z[k])
        if size > 0.0 and abs(math.log(size)) < _NEAR_CIRCLE:
            roots[count, 0], roots[count, 1] = z[k].real / size, z[k].imag / size
            count += 1
    _sort_by_angle(roots, count)
    return count


@kernel
def root_gap(roots, count, i):
    """Squared distance on the unit circle from root ``i`` to the nearest other one; 4 where it is alone."""
    gap = 4.0
    for k in range(count):
        if k != i:
            c, s = roots[k, 0] - roots[i, 0], roots[k, 1] - roots[i, 1]
            gap = min(gap, c * c + s * s)
    return gap


@kernel
def _sort_by_angle(roots, count):
    """Order the first rows of ``roots`` by angle in (-pi, pi], so that columns are stable."""
    for i in range(1, count):
        for j in range(i, 0, -1):
            if math.atan2(roots[j, 1], roots[j, 0]) < math.atan2(roots[j - 1, 1], roots[j - 1, 0]):
                for k in range(2):
                    roots[j, k], roots[j - 1, k] = roots[j - 1, k], roots[j, k]
