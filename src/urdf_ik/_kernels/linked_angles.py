"""Two angles u and v tied by two equations: cos u and sin u are both affine in (cos v, sin v).

The squares of cos u and sin u add up to one, which is a trigonometric polynomial of degree two in v: up to four
pairs of angles. The quartic families end in this: three parallel axes, wherever they stand, and a spherical
triple in the middle of the arm.
"""

from __future__ import annotations

import math

from urdf_ik._kernels.compile import kernel
from urdf_ik._kernels.polynomials import trigonometric_roots


@kernel
def linked_roots(c0, cc, cs, s0, sc, ss, roots):
    """Angles v at which cos u = c0 + cc cos v + cs sin v and sin u = s0 + sc cos v + ss sin v have a common u.

    As (cos v, sin v) rows of ``roots`` (4, 2); returns how many.
    """
    square_c, square_s = cc * cc + sc * sc, cs * cs + ss * ss
    return trigonometric_roots(
        c0 * c0 + s0 * s0 - 1.0 + 0.5 * (square_c + square_s),
        2.0 * (c0 * cc + s0 * sc),
        2.0 * (c0 * cs + s0 * ss),
        0.5 * (square_c - square_s),
        cc * cs + sc * ss,
        roots,
    )


@kernel
def sharpen_roots(ce, se, cosine, m, slope, s0, sc, ss, roots, found):
    """Make the roots exact at which cos u is almost +-1 and at its extreme; ``roots`` is changed in place.

    There the quartic has two roots that nearly meet, known to half the digits only. Both lie beside the plain angle
    (ce, se) of v at which cos u has its extreme value ``cosine``. With x the distance from it and w = 1 - cos x,
    sin u = b + g sin x + k w and cos u = cosine + slope w, so that sin^2 u = m - 2 cosine slope w - slope^2 w^2
    without cancellation, where m is sin^2 u at the extreme: Newton's method on their difference, from the quadratic
    equation that is left to second order in x.
    """
    first, second = -1, -1
    for i in range(found):
        if ce * roots[i, 0] + se * roots[i, 1] > 0.0 and abs(ce * roots[i, 1] - se * roots[i, 0]) < 1e-4:
            if first < 0:
                first = i
            else:
                second = i
    if first < 0:
        return
    b, g, k = s0 + sc * ce + ss * se, ss * ce - sc * se, -(sc * ce + ss * se)
    square, half = g * g + b * k + cosine * slope, b * g
    if abs(square) < 1e-9:
        return
    spread = math.sqrt(max(half * half - square * (b * b - m), 0.0)) / abs(square)
    low, high = -half / square - spread, -half / square + spread
    low, high = _sharpened(low, b, g, k, m, cosine, slope), _sharpened(high, b, g, k, m, cosine, slope)
    x = ce * roots[first, 1] - se * roots[first, 0]
    if second >= 0:
        y = ce * roots[second, 1] - se * roots[second, 0]
        x, y = (low, high) if x <= y else (high, low)
        _set_beside(roots, second, ce, se, y)
    else:
        x = low if abs(low - x) < abs(high - x) else high
    _set_beside(roots, first, ce, se, x)


@kernel
def _set_beside(roots, i, c, s, x):
    """Set root ``i`` to the angle (c, s) turned by ``x``."""
    roots[i, 0], roots[i, 1] = c * math.cos(x) - s * math.sin(x), s * math.cos(x) + c * math.sin(x)


@kernel
def _sharpened(x, b, g, k, m, cosine, slope):
    """Two steps of Newton's method on the difference of ``sharpen_roots``."""
    for _ in range(2):
        w = 2.0 * math.sin(0.5 * x) ** 2
        bend = b + g * math.sin(x) + k * w
        value = bend * bend - m + 2.0 * cosine * slope * w + slope * slope * w * w
        change = 2.0 * bend * (g * math.cos(x) + k * math.sin(x))
        change += 2.0 * (cosine * slope + slope * slope * w) * math.sin(x)
        if abs(change) > 1e-9 * abs(x):
            x -= value / change
    return x
