"""Product of exponentials: forward kinematics and Jacobian of a chain of screw axes, one vector or many.

A chain is four arrays: ``H`` (n, 3) unit directions of the joint axes and ``P`` (n + 1, 3) steps from the base
origin to axis 1, from axis to axis, and from axis n to the tip, both in base axes at the zero configuration;
``R_tip`` (3, 3) the tip's rotation there; ``prismatic`` (n,) true for a joint that slides along its axis.
Source: Lynch and Park, Modern Robotics, chapters 4 and 5 (space form).
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels.compile import kernel


@kernel
def turn(R, h, c, s):
    """Replace ``R`` (3, 3) by R times the rotation by (cos, sin) = (c, s) about unit axis ``h`` (Rodrigues)."""
    v = 1.0 - c
    x, y, z = h[0], h[1], h[2]
    e00, e11, e22 = c + v * x * x, c + v * y * y, c + v * z * z
    e01, e10 = v * x * y - s * z, v * x * y + s * z
    e02, e20 = v * x * z + s * y, v * x * z - s * y
    e12, e21 = v * y * z - s * x, v * y * z + s * x
    for i in range(3):
        a, b, d = R[i, 0], R[i, 1], R[i, 2]
        R[i, 0] = a * e00 + b * e10 + d * e20
        R[i, 1] = a * e01 + b * e11 + d * e21
        R[i, 2] = a * e02 + b * e12 + d * e22


@kernel
def advance(R, step, p):
    """Add R ``step`` to the point ``p`` (3,)."""
    for i in range(3):
        p[i] += R[i, 0] * step[0] + R[i, 1] * step[1] + R[i, 2] * step[2]


@kernel
def place_axes(H, P, R_tip, prismatic, q, T, axes, points):
    """Forward kinematics that keeps the axes: tip pose to ``T`` (4, 4), directions and points to (n, 3) each."""
    n = H.shape[0]
    R = np.zeros((3, 3))
    p = np.empty(3)
    for i in range(3):
        R[i, i] = 1.0
        p[i] = P[0, i]
    for k in range(n):
        for i in range(3):
            axes[k, i] = R[i, 0] * H[k, 0] + R[i, 1] * H[k, 1] + R[i, 2] * H[k, 2]
            points[k, i] = p[i]
        if prismatic[k]:
            for i in range(3):
                p[i] += q[k] * axes[k, i]
        else:
            turn(R, H[k], math.cos(q[k]), math.sin(q[k]))
        advance(R, P[k + 1], p)
    for i in range(3):
        for j in range(3):
            T[i, j] = R[i, 0] * R_tip[0, j] + R[i, 1] * R_tip[1, j] + R[i, 2] * R_tip[2, j]
        T[i, 3] = p[i]
        T[3, i] = 0.0
    T[3, 3] = 1.0


@kernel
def jacobian_from_axes(prismatic, axes, points, tip, J):
    """Geometric Jacobian (6, n) at point ``tip``: linear rows, then angular ones, in base axes."""
    for k in range(axes.shape[0]):
        x, y, z = axes[k, 0], axes[k, 1], axes[k, 2]
        if prismatic[k]:
            J[0, k], J[1, k], J[2, k] = x, y, z
            J[3, k], J[4, k], J[5, k] = 0.0, 0.0, 0.0
        else:
            u, v, w = tip[0] - points[k, 0], tip[1] - points[k, 1], tip[2] - points[k, 2]
            J[0, k], J[1, k], J[2, k] = y * w - z * v, z * u - x * w, x * v - y * u
            J[3, k], J[4, k], J[5, k] = x, y, z


@kernel
def forward_batch(H, P, R_tip, prismatic, Q, T):
    """Poses of ``Q`` (m, n) to ``T`` (m, 4, 4)."""
    n = H.shape[0]
    axes, points = np.empty((n, 3)), np.empty((n, 3))
    for m in range(Q.shape[0]):
        place_axes(H, P, R_tip, prismatic, Q[m], T[m], axes, points)


@kernel
def jacobian_batch(H, P, R_tip, prismatic, Q, J):
    """Jacobians of ``Q`` (m, n) to ``J`` (m, 6, n)."""
    n = H.shape[0]
    axes, points, T = np.empty((n, 3)), np.empty((n, 3)), np.empty((4, 4))
    for m in range(Q.shape[0]):
        place_axes(H, P, R_tip, prismatic, Q[m], T, axes, points)
        jacobian_from_axes(prismatic, axes, points, T[:3, 3], J[m])
