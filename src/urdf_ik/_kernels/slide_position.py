"""Three joints, each turning or sliding, put a point at a place: every solution, whatever their order.

``p = g1 g2 g3 X`` is solved for (q1, q2, q3). What joint 3 does to X is affine in phi = (cos q3, sin q3), or a
polynomial in phi = (q3, q3^2) where it slides. What joint 1 leaves unchanged of p (height along its axis and distance
from it; or, of a slide, the projection along it) makes two equations:

- joint 2 turns: they are linear in the turned point w, across axis 2, with constant rows that are orthogonal:
  m1.w = b1(phi), m2.w = b2(phi), and |w| = |y(phi)|. With both rows it is one equation of degree two in the
  harmonics of q3 (four in q3); where a row vanishes (axes 1 and 2 parallel or meeting) its b alone gives q3.
- joint 2 slides: q2 follows from one of them, and the other one gives q3.

A polynomial in q3 becomes a trigonometric one by q3 = tan(t / 2), so one root finder serves all; a root at infinity
stands at t = pi. Lengths are shares of the arm's size. Sources: Pieper 1968, generalised to slides.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels.compile import kernel
from urdf_ik._kernels.polynomials import trigonometric_roots
from urdf_ik._kernels.thresholds import FREE, VANISHING, WEAK

# A row of numbers: which of the three slide; directions, points (feet of the common normal of axes 1 and 2), X.
SLIDES, DIRECTIONS, POINTS, POINT, LENGTH = 0, 3, 12, 21, 24
# Most solutions: four roots twice where a row is weak, and their two signs.
MOST = 24
# Columns of a solution: the three joints, and a bit for each of joints 1 and 2 that the place leaves free.
FREE_JOINTS, COLUMNS = 3, 4
_FARTHEST = 1e6


@kernel
def _product(slide, a, b, factor, out):
    """Add factor a b to ``out`` (5,), for forms a, b (3,) in 1, phi: harmonics up to two, or powers up to four."""
    if slide:
        for i in range(3):
            for j in range(3):
                out[i + j] += factor * a[i] * b[j]
    else:
        out[0] += factor * (a[0] * b[0] + 0.5 * (a[1] * b[1] + a[2] * b[2]))
        out[1] += factor * (a[0] * b[1] + a[1] * b[0])
        out[2] += factor * (a[0] * b[2] + a[2] * b[0])
        out[3] += factor * 0.5 * (a[1] * b[1] - a[2] * b[2])
        out[4] += factor * 0.5 * (a[1] * b[2] + a[2] * b[1])


@kernel
def _roots(slide, f, ref, scale, values):
    """Real roots q3 of ``f`` (5,) to ``values``; how many. Where f vanishes, to ``scale``, ``ref`` stands for all."""
    largest = 0.0
    for k in range(5):
        largest = max(largest, abs(f[k]))
    if largest <= VANISHING * scale:
        values[0] = ref
        return 1
    circle = np.empty((4, 2))
    if not slide:
        found = trigonometric_roots(f[0], f[1], f[2], f[3], f[4], circle)
        for k in range(found):
            values[k] = math.atan2(circle[k, 1], circle[k, 0])
        return found
    if max(abs(f[3]), abs(f[4])) <= VANISHING * largest:
        found = trigonometric_roots(0.5 * (f[0] + f[2]), 0.5 * (f[0] - f[2]), 0.5 * f[1], 0.0, 0.0, circle)
    else:
        found = trigonometric_roots(
            3.0 * (f[0] + f[4]) + f[2],
            4.0 * (f[0] - f[4]),
            2.0 * (f[1] + f[3]),
            f[0] - f[2] + f[4],
            f[1] - f[3],
            circle,
        )
    kept = 0
    for k in range(found):
        if abs(circle[k, 1]) <= _FARTHEST * (1.0 + circle[k, 0]):
            values[kept] = circle[k, 1] / (1.0 + circle[k, 0])
            kept += 1
    return kept


@kernel
def dot(a, b):
    """Scalar product of vectors (3,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """Vector product (3,)."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@kernel
def rotated(R, v):
    """The first three rows of ``R`` times ``v`` (3,)."""
    return np.array([dot(R[0], v), dot(R[1], v), dot(R[2], v)])


@kernel
def turned(v, h, angle):
    """The vector ``v`` (3,) turned about unit ``h`` (3,)."""
    c, s = math.cos(angle), math.sin(angle)
    return c * v + s * cross(h, v) + (1.0 - c) * dot(h, v) * h


@kernel
def angle_about(h, a, b):
    """Angle about unit ``h`` (3,) from ``a`` to ``b`` (3,), of what lies across it; and the shorter squared length."""
    u, v = a - dot(h, a) * h, b - dot(h, b) * h
    return math.atan2(dot(h, cross(u, v)), dot(u, v)), min(dot(u, u), dot(v, v))


@kernel
def _finish(row, p, ref, q2, free, q3, point, out, count):
    """Add the solution with these q2 and q3, ``point`` being g2 g3 X; returns the number of solutions."""
    if count >= MOST:
        return count
    h1 = row[DIRECTIONS : DIRECTIONS + 3]
    if row[SLIDES]:
        out[count, 0] = dot(h1, p - point)
    else:
        p1 = row[POINTS : POINTS + 3]
        out[count, 0], square = angle_about(h1, point - p1, p - p1)
        if square < FREE:
            free += 1
        if square < VANISHING * VANISHING:
            out[count, 0] = ref[0]
    out[count, 1], out[count, 2], out[count, FREE_JOINTS] = q2, q3, free
    return count + 1


@kernel
def _turn_to(row, p, ref, y, along, w, q3, out, count):
    """Add the solution in which joint 2 turns ``y`` (3,), across axis 2, to the direction of ``w`` (3,)."""
    h2, p2 = row[DIRECTIONS + 3 : DIRECTIONS + 6], row[POINTS + 3 : POINTS + 6]
    q2, free = math.atan2(dot(h2, cross(y, w)), dot(y, w)), 0
    if dot(y, y) < FREE:
        free = 2
        q2 = ref[1] if dot(y, y) < VANISHING * VANISHING else q2
    return _finish(row, p, ref, q2, free, q3, p2 + along * h2 + turned(y, h2, q2), out, count)


@kernel
def _value(slide, form, q3):
    """A form (3,) in 1, phi at q3."""
    if slide:
        return form[0] + q3 * (form[1] + q3 * form[2])
    return form[0] + math.cos(q3) * form[1] + math.sin(q3) * form[2]


@kernel
def _forms(row, origin, Z, square):
    """g3 X - origin as affine function of phi, rows of ``Z`` (3, 3) for 1 and phi, and its squared length (3,)."""
    h3, p3 = row[DIRECTIONS + 6 : DIRECTIONS + 9], row[POINTS + 6 : POINTS + 9]
    X = row[POINT : POINT + 3]
    if row[SLIDES + 2]:
        Z[0], Z[1], Z[2] = X - origin, h3, 0.0
        square[0], square[1], square[2] = dot(Z[0], Z[0]), 2.0 * dot(Z[0], h3), 1.0
    else:
        arm = X - p3
        along = dot(h3, arm) * h3
        Z[0], Z[1] = p3 + along - origin, arm - along
        Z[2] = cross(h3, Z[1])
        square[0] = dot(Z[0], Z[0]) + dot(Z[1], Z[1])
        square[1], square[2] = 2.0 * dot(Z[0], Z[1]), 2.0 * dot(Z[0], Z[2])


@kernel
def _rows(row, p, Z, square, M, b):
    """Rows ``M`` (2, 3) and right sides ``b`` (2, 3), forms, of the equations of a joint 2 that turns."""
    h1, h2 = row[DIRECTIONS : DIRECTIONS + 3], row[DIRECTIONS + 3 : DIRECTIONS + 6]
    p1, p2 = row[POINTS : POINTS + 3], row[POINTS + 3 : POINTS + 6]
    if row[SLIDES]:
        side = cross(h1, h2)
        length = math.sqrt(dot(side, side))
        if length < VANISHING:
            side = cross(h1, p2 - p)
            length = math.sqrt(dot(side, side))
            if length < VANISHING:
                side, length = cross(h1, np.array([h1[1], h1[2], -h1[0]])), 1.0
                length = math.sqrt(dot(side, side))
        side /= length
        up = cross(side, h1)
        M[0], M[1] = side, up
        b[0], b[1] = 0.0, 0.0
        b[0, 0], b[1, 0] = dot(side, p - p2), dot(up, p - p2)
        for k in range(3):
            b[1, k] -= dot(up, h2) * dot(h2, Z[k])
        M[1] -= dot(up, h2) * h2
        M[0] -= dot(side, h2) * h2
        return
    d = p2 - p1
    M[0] = h1 - dot(h1, h2) * h2
    M[1] = 2.0 * d
    for k in range(3):
        b[0, k] = -dot(h1, h2) * dot(h2, Z[k])
        b[1, k] = -square[k]
    b[0, 0] += dot(h1, p - p1)
    b[1, 0] += dot(p - p1, p - p1) - dot(d, d)


@kernel
def _second_turns(row, p, ref, out):
    """Solutions with a joint 2 that turns."""
    h2 = row[DIRECTIONS + 3 : DIRECTIONS + 6]
    slide = row[SLIDES + 2] != 0.0
    Z, square, M, b = np.empty((3, 3)), np.empty(3), np.empty((2, 3)), np.empty((2, 3))
    _forms(row, row[POINTS + 3 : POINTS + 6], Z, square)
    _rows(row, p, Z, square, M, b)
    m = np.array([dot(M[0], M[0]), dot(M[1], M[1])])
    along = np.array([dot(h2, Z[0]), dot(h2, Z[1]), dot(h2, Z[2])])
    f, values = np.empty(5), np.empty(4)
    count = 0
    span = 1.0 + dot(p, p)
    if min(m[0], m[1]) > VANISHING * VANISHING:
        f[:] = 0.0
        _product(slide, b[0], b[0], m[1], f)
        _product(slide, b[1], b[1], m[0], f)
        _product(slide, along, along, m[0] * m[1], f)
        for k in range(3):
            f[k] -= m[0] * m[1] * square[k]
        for i in range(_roots(slide, f, ref[2], m[0] * m[1] * span, values)):
            q3 = values[i]
            w = _value(slide, b[0], q3) / m[0] * M[0] + _value(slide, b[1], q3) / m[1] * M[1]
            z = _point(slide, Z, q3)
            over = dot(h2, z)
            count = _turn_to(row, p, ref, z - over * h2, over, w, q3, out, count)
    for k in range(2):
        if m[k] > WEAK * WEAK or m[1 - k] <= VANISHING * VANISHING:
            continue
        f[:] = 0.0
        f[:3] = b[k]
        side = cross(h2, M[1 - k]) / math.sqrt(m[1 - k])
        for i in range(_roots(slide, f, ref[2], span, values)):
            q3 = values[i]
            z = _point(slide, Z, q3)
            over = dot(h2, z)
            y = z - over * h2
            foot = _value(slide, b[1 - k], q3) / m[1 - k]
            rest = dot(y, y) - foot * foot * m[1 - k]
            if rest < -WEAK * span:
                continue
            height = math.sqrt(max(rest, 0.0))
            for sign in range(2):
                w = foot * M[1 - k] + (height if sign == 0 else -height) * side
                count = _turn_to(row, p, ref, y, over, w, q3, out, count)
                if height == 0.0:
                    break
    return count


@kernel
def _point(slide, Z, q3):
    """The vector (3,) that ``Z`` (3, 3), from ``_forms``, is at q3."""
    if slide:
        return Z[0] + q3 * Z[1]
    return Z[0] + math.cos(q3) * Z[1] + math.sin(q3) * Z[2]


@kernel
def _second_slides(row, p, ref, out):
    """Solutions with a joint 2 that slides."""
    h1, h2 = row[DIRECTIONS : DIRECTIONS + 3], row[DIRECTIONS + 3 : DIRECTIONS + 6]
    p1 = row[POINTS : POINTS + 3]
    slide = row[SLIDES + 2] != 0.0
    Z, square, f, values = np.empty((3, 3)), np.empty(3), np.zeros(5), np.empty(4)
    count, span = 0, 1.0 + dot(p, p)
    if row[SLIDES]:
        _forms(row, p, Z, square)
        side = cross(h1, h2)
        up = cross(side, h1) / dot(side, side)
        for k in range(3):
            f[k] = dot(side, Z[k])
        for i in range(_roots(slide, f, ref[2], span, values)):
            z = _point(slide, Z, values[i])
            q2 = -dot(up, z)
            count = _finish(row, p, ref, q2, 0, values[i], p + z + q2 * h2, out, count)
        return count
    _forms(row, p1, Z, square)
    slope = dot(h1, h2)
    height, over = np.empty(3), np.empty(3)
    for k in range(3):
        height[k], over[k] = -dot(h1, Z[k]), dot(h2, Z[k])
    height[0] += dot(h1, p - p1)
    rr = dot(p - p1, p - p1)
    if abs(slope) > VANISHING:
        for k in range(3):
            f[k] = slope * slope * square[k]
        f[0] -= slope * slope * rr
        _product(slide, height, over, 2.0 * slope, f)
        _product(slide, height, height, 1.0, f)
        for i in range(_roots(slide, f, ref[2], slope * slope * span, values)):
            z = _point(slide, Z, values[i])
            q2 = _value(slide, height, values[i]) / slope
            count = _finish(row, p, ref, q2, 0, values[i], p1 + z + q2 * h2, out, count)
    if abs(slope) < WEAK:
        f[:] = 0.0
        f[:3] = height
        for i in range(_roots(slide, f, ref[2], span, values)):
            z = _point(slide, Z, values[i])
            half = dot(h2, z)
            rest = half * half - dot(z, z) + rr
            if rest < -WEAK * span:
                continue
            for sign in range(2):
                q2 = -half + (1.0 if sign == 0 else -1.0) * math.sqrt(max(rest, 0.0))
                count = _finish(row, p, ref, q2, 0, values[i], p1 + z + q2 * h2, out, count)
                if rest <= 0.0:
                    break
    return count


@kernel
def solve_position(row, p, ref, out):
    """All (q1, q2, q3), rad or shares of the size, that put the row's point at ``p`` (3,); returns how many.

    They are candidates: clamped ones near an edge of reach and, where a row of the equations is weak, approximate ones
    are among them; the caller polishes and verifies. ``ref`` (3,) is taken for a joint that the place leaves free.
    ``out`` is (MOST, COLUMNS).
    """
    return _second_slides(row, p, ref, out) if row[SLIDES + 1] else _second_turns(row, p, ref, out)
