"""Angles without branches, so that loops over blocks of poses run on vector registers."""

from __future__ import annotations

import math

from urdf_ik._kernels.compile import step

_TAN_PI_8 = 0.41421356237309503
_TINY = 1e-300


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
