"""Roots of the polynomials that the families end in."""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels.compile import kernel

# A complex pair this close to the unit circle may be a double real root that rounding has split.
_NEAR_CIRCLE = 1e-3
# A polynomial's value below this share of the sum of its terms' sizes is rounding.
_LOST = 4e-16
_TINY = 1e-300
LANES = 16


@kernel
def self_inversive_roots(c, z):
    """All roots of a polynomial that reads the same from both ends, to ``z`` (n <= 16,) complex.

    ``c`` (n + 1,) from the constant up, with c[n - k] the conjugate of c[k], as harmonics of a real function have
    them. Aberth's iteration on all roots side by side; a root outside the unit circle is evaluated at its mirror
    image inside, p(z) = z^n conj(p(1 / conj z)), so that no power overflows. A root rests when its polynomial is
    lost in rounding.
    """
    n = z.size
    W = np.empty((14, LANES))
    for k in range(n):
        angle = 2.0 * math.pi * k / n + 0.3
        radius = 1.0 + 0.2 * ((k % 3) - 1)
        W[0, k], W[1, k], W[2, k] = radius * math.cos(angle), radius * math.sin(angle), 1.0
    for _ in range(60):
        for k in range(n):
            x, y = W[0, k], W[1, k]
            square = x * x + y * y
            f = 1.0 if square <= 1.0 else 1.0 / square
            W[3, k], W[4, k], W[5, k] = x * f, y * f, math.sqrt(square) * f
            W[6, k], W[7, k], W[8, k], W[9, k] = c[n].real, c[n].imag, 0.0, 0.0
            W[10, k] = abs(c[n].real) + abs(c[n].imag)
        for j in range(n - 1, -1, -1):
            re, im = c[j].real, c[j].imag
            size = abs(re) + abs(im)
            for k in range(n):
                x, y = W[3, k], W[4, k]
                p, q, u, v = W[6, k], W[7, k], W[8, k], W[9, k]
                W[8, k], W[9, k] = u * x - v * y + p, u * y + v * x + q
                W[6, k], W[7, k] = p * x - q * y + re, p * y + q * x + im
                W[10, k] = W[10, k] * W[5, k] + size
        for k in range(n):
            x, y = W[0, k], W[1, k]
            p, q, u, v = W[6, k], W[7, k], W[8, k], W[9, k]
            square = p * p + q * q
            lost = _LOST * W[10, k]
            W[2, k] = 0.0 if square <= lost * lost else W[2, k]
            w = 1.0 / (square + _TINY)
            # Slope over value; seen from outside it is n / z - conj(slope / value at the mirror image) / z^2.
            re, im = (u * p + v * q) * w, (v * p - u * q) * w
            w = 1.0 / (x * x + y * y)
            a, b = x * w, -y * w
            a2, b2 = a * a - b * b, 2.0 * a * b
            outside = x * x + y * y > 1.0
            W[11, k] = n * a - (a2 * re + b2 * im) if outside else re
            W[12, k] = n * b - (b2 * re - a2 * im) if outside else im
        for j in range(n):
            x, y = W[0, j], W[1, j]
            for k in range(n):
                a, b = W[0, k] - x, W[1, k] - y
                w = 1.0 / (a * a + b * b + _TINY)
                W[11, k] -= a * w
                W[12, k] += b * w
        for k in range(n):
            w = W[2, k] / (W[11, k] * W[11, k] + W[12, k] * W[12, k] + _TINY)
            a, b = W[11, k] * w, -W[12, k] * w
            x, y = W[0, k], W[1, k]
            W[2, k] = 0.0 if a * a + b * b < 1e-30 * max(x * x + y * y, 1e-6) else W[2, k]
            W[0, k], W[1, k] = x - a, y - b
        moving = 0.0
        for k in range(n):
            moving = max(moving, W[2, k])
        if moving == 0.0:
            break
    for k in range(n):
        z[k] = complex(W[0, k], W[1, k])


@kernel
def trigonometric_roots(e0, ec, es, ec2, es2, roots):
    """Real roots of e0 + ec cos t + es sin t + ec2 cos 2t + es2 sin 2t, as (cos, sin) rows of ``roots`` (4, 2).

    With z = exp(it) it is a self-inversive quartic, whose roots on the unit circle are the real ones; all four
    are found together, which needs no case distinction. A pair just off the circle is given as two roots, for the
    caller to verify. Returns how many there are.
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
    z = np.empty(degree, np.complex128)
    self_inversive_roots(c[: degree + 1], z)
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
