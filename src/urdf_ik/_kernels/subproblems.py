"""The steps that the families are made of, without branches: each takes and gives angles as (cos, sin).

A step that has two solutions takes a sign. Where they meet, or cease to exist, it continues with the double
root, and the margin that it returns beside the angles (zero where they meet, negative beyond) tells.
Frames are Denavit-Hartenberg's in Craig's order, so every rotation is about z or x.
Sources: Pieper 1968; Paden 1986 (subproblems 1 to 4); Elias and Wen 2022.
"""

from __future__ import annotations

import math

from urdf_ik._kernels.compile import kernel, step
from urdf_ik._kernels.trig import wrap

_TINY = 1e-300


@step
def unit(c, s):
    """(c, s) scaled to length 1."""
    w = 1.0 / math.sqrt(c * c + s * s + _TINY)
    return c * w, s * w


@step
def swing_to_offset(x, y, k, sign):
    """Turn about z so that (X, k) becomes (x, y), X free: subproblem 4.

    Returns cos, sin, X, margin r^2 - k^2 [m^2].
    """
    rr = x * x + y * y
    margin = rr - k * k
    X = sign * math.sqrt(max(margin, 0.0))
    c, s = unit(X * x + k * y, X * y - k * x)
    return c, s, X, margin


@step
def elbow(ux, uy, a, b, side, sign):
    """Planar two-link arm: a e(q2) + b e(q2 + side * gamma) = (ux, uy); law of cosines, then subproblem 1.

    1 + cos gamma and 1 - cos gamma are taken apart, so that a folded arm of equal links keeps its digits.
    Returns cos q2, sin q2, cos gamma, sin gamma, margin sin^2 gamma.
    """
    uu = ux * ux + uy * uy
    w = 0.5 / (a * b)
    folded, stretched = (uu - (a - b) * (a - b)) * w, ((a + b) * (a + b) - uu) * w
    margin = folded * stretched
    c = min(max(0.5 * (folded - stretched), -1.0), 1.0)
    s = sign * math.sqrt(max(margin, 0.0))
    wx, wy = a - b + b * max(folded, 0.0), side * b * s
    c2, s2 = unit(wx * ux + wy * uy, wx * uy - wy * ux)
    return c2, s2, c, s, margin


@step
def unturn(x, y, c, s):
    """(x, y) turned back by the angle (c, s)."""
    return c * x + s * y, c * y - s * x


@step
def swing_to_tilt(x, y, z, ca, sa, c, across, sign):
    """Turn about z so that an axis tilted by alpha (ca, sa) from it encloses a given angle with the unit vector given.

    The angle has cosine ``c`` and squared sine ``across``; the axis is Rz(-t) (0, sin alpha, cos alpha). The margin
    is a product of two factors, each free of cancellation, so the turn keeps its digits where the vectors align.
    Returns cos t, sin t, margin.
    """
    r = math.copysign(math.sqrt(x * x + y * y), sa)
    c_low, s_low = ca * z + sa * r, sa * z - ca * r
    c_high, s_high = ca * z - sa * r, sa * z + ca * r
    above = (across - s_low * s_low) / (c_low + c) if c_low + c > 0.5 else c_low - c
    below = (s_high * s_high - across) / (c_high + c) if c_high + c < -0.5 else c - c_high
    margin = above * below / (sa * sa)
    k = (c - ca * z) / sa
    X = sign * math.sqrt(max(margin, 0.0))
    ct, st = unit(X * x + k * y, k * x - X * y)
    return ct, st, margin


@step
def wrist_bend(x, y, z, ca, sa, cb, sb, sign):
    """Middle angle of a wrist whose last axis points along (x, y, z) in the frame of the first: subproblem 4.

    The axes enclose alpha (ca, sa) and beta (cb, sb). The sine comes from the part of the last axis across the
    first one, which keeps its digits where the three axes fall into a plane.
    Returns cos, sin, margin sin^2.
    """
    c = (ca * cb - z) / (sa * sb)
    across = ca * sb * c + sa * cb
    margin = (x * x + y * y - across * across) / (sb * sb)
    s = sign * math.sqrt(max(margin, 0.0))
    c, s = unit(c, s)
    return c, s, margin


@step
def wrist_turns(m00, m10, m20, m01, m11, m21, m02, m12, m22, c, s, ca, sa, cb, sb, hold, ch, sh):
    """First and last angle of a wrist with known bend (c, s): M = Rz(first) Rx(alpha) Rz(bend) Rx(beta) Rz(last).

    ``hold`` sets the first angle to (ch, sh), for a target that leaves it free.
    The last angle is measured after the first one is undone, so their sum stays exact where the axes align.
    Returns both as (cos, sin), the squared length that fixes the first (0: only their sum matters), and the
    squared error of the rotation reached.
    """
    X = sb * s
    Y = -(ca * sb * c + sa * cb)
    fixed = X * X + Y * Y
    cf, sf = unit(X * m02 + Y * m12, X * m12 - Y * m02)
    cf, sf = (ch, sh) if hold else (cf, sf)
    vx, vy, vz = cf * c - sf * ca * s, sf * c + cf * ca * s, sa * s
    cl = vx * m00 + vy * m10 + vz * m20
    sl = -(vx * m01 + vy * m11 + vz * m21)
    ex = cf * X - sf * Y - m02
    ey = sf * X + cf * Y - m12
    ez = ca * cb - sa * sb * c - m22
    ev = vx * m02 + vy * m12 + vz * m22
    return cf, sf, cl, sl, fixed, ex * ex + ey * ey + ez * ez + ev * ev


@step
def is_double(margin, arm, rounding):
    """Whether a margin cannot be told from zero: the two solutions are one double root.

    The margin is a difference of squares; where the squared length ``arm`` that it belongs to is small, so is
    its rounding error, and the solutions part by half a turn instead of meeting.
    """
    return margin <= rounding * math.sqrt(arm)


@kernel
def nearest_between(wanted, x, y, low, high, slack):
    """The angle nearest to ``wanted`` at which x cos + y sin lies between ``low`` and ``high``; NaN: there is none.

    ``slack``, in their unit, is allowed to rounding.
    """
    size = math.hypot(x, y)
    if low > size + slack or high < -size - slack:
        return math.nan
    phase = math.atan2(y, x)
    beta = wrap(wrap(wanted - phase))
    now = size * math.cos(beta)
    if now < low:
        beta = math.copysign(math.acos(min(low / size, 1.0)), beta)
    elif now > high:
        beta = math.copysign(math.acos(max(high / size, -1.0)), beta)
    return beta + phase


@kernel
def free_turn(wanted, ox, oy, fx, fy, longest, shortest, slack):
    """The turn phi nearest to ``wanted`` that brings o - Rz(phi) f within a two-link arm's reach [m]; NaN: none.

    ``slack`` [m^2] is allowed to rounding.
    """
    total = ox * ox + oy * oy + fx * fx + fy * fy
    low, high = 0.5 * (total - longest * longest), 0.5 * (total - shortest * shortest)
    return nearest_between(wanted, ox * fx + oy * fy, oy * fx - ox * fy, low, high, slack)
