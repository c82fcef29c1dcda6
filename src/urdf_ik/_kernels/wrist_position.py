"""The first three joints of an arm with a spherical wrist put the wrist centre at a point; every shoulder.

``p = Rz(t1) [a1 x + Rx(alpha1) u]`` with ``u = Rz(t2) f`` and
``f = d2 z + a2 x + Rx(alpha2) (d3 z + Rz(t3) g)``, where ``g`` is the wrist centre in frame 3.
Sources: Pieper 1968; Craig, Introduction to Robotics, section 4.6; Elias and Wen 2022.
"""

from __future__ import annotations

import math

from urdf_ik._kernels.compile import kernel, step
from urdf_ik._kernels.layout import CENTRE, COS_ALPHA, COS_PHI, HEIGHT, RHO, SIN_ALPHA, SIN_PHI, SIZE, SWING, A, D
from urdf_ik._kernels.polynomials import trigonometric_roots
from urdf_ik._kernels.subproblems import elbow, swing_to_offset, unit

PARALLEL_23, INTERSECTING_12, PARALLEL_12, GENERAL = 0, 1, 2, 3


@step
def second_link(arm, c3, s3):
    """The point f of the module's text for a given third angle."""
    w0 = arm[CENTRE] * c3 - arm[CENTRE + 1] * s3
    w1 = arm[CENTRE] * s3 + arm[CENTRE + 1] * c3
    w2 = arm[CENTRE + 2] + arm[D + 1]
    ca2, sa2 = arm[COS_ALPHA + 1], arm[SIN_ALPHA + 1]
    return arm[A + 1] + w0, ca2 * w1 - sa2 * w2, arm[D] + sa2 * w1 + ca2 * w2


@step
def position(kind, px, py, pz, arm, front, up, hold1, c1h, s1h, hold2, c2h, s2h, c3r, s3r):
    """One of the four solutions for the wrist centre (px, py, pz) in frame 1.

    ``hold1`` and ``hold2`` replace an angle that the target leaves free; ``c3r, s3r`` is the root of the
    general shoulder's quartic, which the other kinds ignore.
    Returns the three angles as (cos, sin), the shoulder's and the elbow's margins (dimensionless), the squared
    arms that turn with joints 1 and 2 [share of size^2], and the squared position error [share of size^2].
    """
    a1, ca1, sa1 = arm[A], arm[COS_ALPHA], arm[SIN_ALPHA]
    a2, rho = arm[A + 1], arm[RHO]
    scale = 1.0 / (arm[SIZE] * arm[SIZE])
    if kind == PARALLEL_23:
        ca2, h = arm[COS_ALPHA + 1], arm[HEIGHT]
        uy = (pz - ca1 * h) / sa1
        c1, s1, X, m1 = swing_to_offset(px, py, ca1 * uy - sa1 * h, front)
        ux, uz = X - a1, h
        m1 *= scale
        c2, s2, c, s, m2 = elbow(ux, uy, a2, rho, ca2, up)
        c3, s3 = c * arm[COS_PHI] + s * arm[SIN_PHI], s * arm[COS_PHI] - c * arm[SIN_PHI]
        arm2 = ux * ux + uy * uy
        fx, fy, fz = second_link(arm, c3, s3)
    else:
        if kind == INTERSECTING_12:
            k = (px * px + py * py + pz * pz) * arm[SWING] + arm[SWING + 1]
            m2 = (1.0 - k) * (1.0 + k)
            c = min(max(k, -1.0), 1.0)
            s = up * math.sqrt(max(m2, 0.0))
            c3, s3 = c * arm[COS_PHI] - s * arm[SIN_PHI], s * arm[COS_PHI] + c * arm[SIN_PHI]
        elif kind == PARALLEL_12:
            s = ca1 * pz * arm[SWING] + arm[SWING + 1]
            m2 = (1.0 - s) * (1.0 + s)
            s = min(max(s, -1.0), 1.0)
            c = up * math.sqrt(max(m2, 0.0))
            c3, s3 = c * arm[COS_PHI] + s * arm[SIN_PHI], s * arm[COS_PHI] - c * arm[SIN_PHI]
        else:
            m2 = 1.0
            c3, s3 = c3r, s3r
        fx, fy, fz = second_link(arm, c3, s3)
        arm2 = fx * fx + fy * fy
        uz = fz
        if kind == PARALLEL_12:
            length = math.sqrt(arm2)
            c1, s1, c, s, m1 = elbow(px, py, a1, length, ca1, front)
            ux, uy = length * c, length * s
        else:
            uy = (pz - ca1 * fz) / sa1
            if kind == INTERSECTING_12:
                m1 = (arm2 - uy * uy) * scale
                ux = front * math.sqrt(max(arm2 - uy * uy, 0.0))
            else:
                m1 = 1.0
                ux = (px * px + py * py + pz * pz - a1 * a1 - arm2 - fz * fz) / (2.0 * a1)
            X, Y = a1 + ux, ca1 * uy - sa1 * uz
            c1, s1 = unit(X * px + Y * py, X * py - Y * px)
        c2, s2 = unit(fx * ux + fy * uy, fx * uy - fy * ux)
    c1, s1 = (c1h, s1h) if hold1 else (c1, s1)
    c2, s2 = (c2h, s2h) if hold2 else (c2, s2)
    gx, gy = a1 + c2 * fx - s2 * fy, s2 * fx + c2 * fy
    hy, hz = ca1 * gy - sa1 * fz, sa1 * gy + ca1 * fz
    ex, ey, ez = c1 * gx - s1 * hy - px, s1 * gx + c1 * hy - py, hz - pz
    error = (ex * ex + ey * ey + ez * ez) * scale
    return c1, s1, c2, s2, c3, s3, m1, m2, (px * px + py * py) * scale, arm2 * scale, error


@kernel
def general_roots(px, py, pz, arm, roots):
    """Third angles of a general shoulder, as (cos, sin) rows of ``roots`` (4, 2); returns how many.

    The length of p and its height fix u_x and u_y as affine functions of (cos, sin); u_x^2 + u_y^2 + u_z^2 = f^2
    is then a trigonometric polynomial of degree two (Pieper 1968).
    """
    a1, ca1, sa1 = arm[A], arm[COS_ALPHA], arm[SIN_ALPHA]
    # f is affine in (cos, sin); three values give its coefficients.
    _, _, z0 = second_link(arm, 0.0, 0.0)
    x1, y1, z1 = second_link(arm, 1.0, 0.0)
    x2, y2, z2 = second_link(arm, 0.0, 1.0)
    ff = 0.5 * (x1 * x1 + y1 * y1 + z1 * z1)
    g1x, g1y, g1z = second_link(arm, -1.0, 0.0)
    g2x, g2y, g2z = second_link(arm, 0.0, -1.0)
    minus1 = 0.5 * (g1x * g1x + g1y * g1y + g1z * g1z)
    plus2 = 0.5 * (x2 * x2 + y2 * y2 + z2 * z2)
    minus2 = 0.5 * (g2x * g2x + g2y * g2y + g2z * g2z)
    # |f|^2 = f0 + fc cos + fs sin exactly: the squares of (cos, sin) add up to a constant.
    f0, fc, fs = ff + minus1, ff - minus1, plus2 - minus2
    k = (px * px + py * py + pz * pz - a1 * a1 - f0) / (2.0 * a1)
    kc, ks = -fc / (2.0 * a1), -fs / (2.0 * a1)
    h, hc, hs = z0, z1 - z0, z2 - z0
    v, vc, vs = (pz - ca1 * h) / sa1, -ca1 * hc / sa1, -ca1 * hs / sa1
    scale = 1.0 / (arm[SIZE] * arm[SIZE])
    constant = (k * k + v * v + h * h - f0) * scale
    first_c = (2.0 * (k * kc + v * vc + h * hc) - fc) * scale
    first_s = (2.0 * (k * ks + v * vs + h * hs) - fs) * scale
    cc = (kc * kc + vc * vc + hc * hc) * scale
    ss = (ks * ks + vs * vs + hs * hs) * scale
    cs = (kc * ks + vc * vs + hc * hs) * scale
    return trigonometric_roots(constant + 0.5 * (cc + ss), first_c, first_s, 0.5 * (cc - ss), cs, roots)
