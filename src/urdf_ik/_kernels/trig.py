"""Angles without branches, so that loops over blocks of poses run on vector registers."""

from __future__ import annotations

import math

from urdf_ik._kernels.compile import step

_TAN_PI_8 = 0.41421356237309503
_TINY = 1e-300
# Added and taken off again, it rounds to whole numbers.
_ROUNDS = 6755399441055744.0


@step
def atan2(y, x):
    """Angle of (x, y) in [-pi, pi]; 0 for (0, 0). Error below 2 ulp, about three times faster in blocks than libm.

    The octant is folded to |t| <= tan(pi/8), where atan(t)/t is a polynomial in t^2: the Chebyshev expansion
    of (atan(t)/t - 1)/t^2 truncated after 11 terms, error 5e-18.
    """
    ax, ay = abs(x), abs(y)
    low, high = min(ax, ay), max(ax, ay)
    folded = low > _TAN_PI_8 * high
    t = (low - high if folded else low) / ((low + high if folded else high) + _TINY)
    z = t * t
    p = -0.01917688711906226
    p = p * z + 0.03923165829558719
    p = p * z - 0.0508544973794026
    p = p * z + 0.0585814891280221
    p = p * z - 0.06664511447381948
    p = p * z + 0.07692183190826087
    p = p * z - 0.09090904578123903
    p = p * z + 0.11111111015256361
    p = p * z - 0.14285714284666542
    p = p * z + 0.1999999999999552
    p = p * z - 0.3333333333333333
    a = t + t * (z * p)
    a = a + 0.7853981633974483 if folded else a
    a = 1.5707963267948966 - a if ay > ax else a
    a = 3.141592653589793 - a if x < 0.0 else a
    return math.copysign(a, y)


@step
def wrap(a):
    """The angle ``a``, at most one turn off, in (-pi, pi]."""
    a = a - 6.283185307179586 if a > 3.141592653589793 else a
    return a + 6.283185307179586 if a <= -3.141592653589793 else a


@step
def cos_sin(a):
    """Cosine and sine of an angle in [-1.1 pi, 1.1 pi], error below 1 ulp of 1.

    The nearest multiple of pi/2 is taken off in two parts; what is left goes into the Chebyshev expansions of
    (sin x / x - 1) / x^2 and (cos x - 1 + x^2 / 2) / x^4 in x^2, truncated after six terms, error below 3e-17.
    """
    k = (a * 0.6366197723675814 + _ROUNDS) - _ROUNDS
    r = (a - k * 1.5707963267948966) - k * 6.123233995736766e-17
    z = r * r
    p = 1.5916732964827756e-10
    p = p * z - 2.5051112378038593e-08
    p = p * z + 2.755731600874652e-06
    p = p * z - 0.0001984126983657699
    p = p * z + 0.008333333333330828
    p = p * z - 0.16666666666666666
    s = r + r * (z * p)
    p = -1.1381758418038708e-11
    p = p * z + 2.087613408272447e-09
    p = p * z - 2.755731721300625e-07
    p = p * z + 2.4801587298652004e-05
    p = p * z - 0.0013888888888887322
    p = p * z + 0.041666666666666664
    c = 1.0 - (0.5 * z - z * z * p)
    odd, opposite = abs(k) == 1.0, abs(k) == 2.0
    c, s = (-c if opposite else c), (-s if opposite else s)
    return (-k * s if odd else c), (k * c if odd else s)
