"""The swivel angle of an S-R-S arm: axes 1, 2, 3 meet in S, axes 5, 6, 7 in W, axis 4 between.

It is the angle about the line SW by which axis 4's direction, less its part along the line, is turned from the
normal of the plane that holds S, W and axis 1. Where W lies on axis 1, to ``ON_AXIS``, that plane is none, and
frame 1's x stands in for its normal. Unlike the elbow's place, axis 4's direction tells the angle of a stretched
arm, too.
Source: Shimizu, Kakuya, Yoon, Kitagaki and Kosuge 2008, there for axes at right angles.

Frames: frame 1 stands in S, its z along axis 1, its x along the common normal of axes 1 and 2. The elbow's frame
turns with the upper arm: z along axis 4, x from the parallel to axis 4 through S to axis 4.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels.compile import kernel, step
from urdf_ik._kernels.screws import place_axes
from urdf_ik._kernels.subproblems import elbow, unit
from urdf_ik._kernels.target import to_frame_1
from urdf_ik._kernels.thresholds import ON_AXIS, ROUNDING

# Where the arm's numbers stand, beside those of ``layout`` that every family has: distance from S to the parallel
# axis 4, from there to W, height of W along axis 4, joint 4's angle where the two are in line.
UPPER, FORE, ALONG, ZERO_4 = 24, 25, 26, 27
# Of each triple of axes: cosine and sine of the twists between them, offset of the middle joint; then the rotation
# from the elbow's frame to frame 3, from frame 5 to the elbow's.
SHOULDER, WRIST = 28, 33
TO_FRAME_3, FROM_FRAME_5 = 38, 50
H, P, R_TIP = 76, 97, 121
LENGTH = 130


@step
def plane_normal(x, y, z):
    """Unit normal of the plane of axis 1 and the wrist (x, y, z) in frame 1, its vector product with the line, length.

    The line's direction times the normal, and the line's length; see the module's text for a wrist on axis 1.
    """
    square = x * x + y * y
    length = math.sqrt(square + z * z)
    w = 1.0 / (length + 1e-300)
    dx, dy, dz = x * w, y * w, z * w
    aside = math.sqrt(square)
    on = aside <= ON_AXIS * length
    v = 1.0 / (aside + 1e-300)
    nx, ny, nz = -y * v, x * v, 0.0
    # Frame 1's x, made perpendicular to the line.
    u = 1.0 / math.sqrt(1.0 - dx * dx + 1e-300)
    nx, ny, nz = (1.0 - dx * dx) * u if on else nx, -dx * dy * u if on else ny, -dx * dz * u if on else nz
    # A wrist in S gives no line at all; axis 1 stands in for it.
    dz = dz if length > 0.0 else 1.0
    return dx, dy, dz, nx, ny, nz, dy * nz - dz * ny, dz * nx - dx * nz, dx * ny - dy * nx, length


@step
def upper_arm(x, y, z, cp, sp, arm, up):
    """Elbow bend and the elbow's frame in frame 1, for the wrist (x, y, z) in frame 1 and the swivel (cp, sp).

    Returns cos and sin of the bend, the frame's nine entries by rows, the bend's margin sin^2, the squared distance
    of the parallel to axis 4 through S from W [m^2], and the squared position error [m^2].
    """
    a, b, c = arm[UPPER], arm[FORE], arm[ALONG]
    dx, dy, dz, nx, ny, nz, tx, ty, tz, length = plane_normal(x, y, z)
    reach = length * length - c * c
    across = math.sqrt(max(reach, 0.0))
    ex, ey, cg, sg, margin = elbow(across, 0.0, a, b, -1.0, up)
    # Of a wrist on the parallel to axis 4 through S any direction is right.
    ex, ey = unit(ex + (0.0 if across > 0.0 else 1.0), ey)
    margin = margin if reach >= -ROUNDING * c * c else -1.0
    w = 1.0 / (math.sqrt(across * across + c * c) + 1e-300)
    rho, kappa = across * w, c * w
    rho = rho if rho + abs(kappa) > 0.0 else 1.0
    # Turned by the swivel: the plane's normal and what is at right angles to it and the line.
    ax, ay, az = cp * nx + sp * tx, cp * ny + sp * ty, cp * nz + sp * tz
    px, py, pz = cp * tx - sp * nx, cp * ty - sp * ny, cp * tz - sp * nz
    mx, my, mz = rho * dx - kappa * ax, rho * dy - kappa * ay, rho * dz - kappa * az
    u0, u1, u2 = ex * mx + ey * px, ex * my + ey * py, ex * mz + ey * pz
    v0, v1, v2 = ey * mx - ex * px, ey * my - ex * py, ey * mz - ex * pz
    w0, w1, w2 = kappa * dx + rho * ax, kappa * dy + rho * ay, kappa * dz + rho * az
    X, Y = a + b * cg, b * sg
    x = u0 * X + v0 * Y + w0 * c - x
    y = u1 * X + v1 * Y + w1 * c - y
    z = u2 * X + v2 * Y + w2 * c - z
    return cg, sg, u0, v0, w0, u1, v1, w1, u2, v2, w2, margin, reach, x * x + y * y + z * z


@kernel
def place(arm, prismatic, q, T, axes, points):
    """``place_axes`` of the arm as written."""
    axes_at_zero, steps = arm[H : H + 21].reshape(7, 3), arm[P : P + 24].reshape(8, 3)
    place_axes(axes_at_zero, steps, arm[R_TIP : R_TIP + 9].reshape(3, 3), prismatic, q, T, axes, points)


@kernel
def swivels(arm, Q, values):
    """Swivel angles of joint vectors ``Q`` (m, 7) to ``values`` (m,): what ``solve`` finds them again at."""
    axes, points, T, X = np.empty((7, 3)), np.empty((7, 3)), np.empty((4, 4)), np.empty(12)
    prismatic = np.zeros(7, np.bool_)
    for k in range(Q.shape[0]):
        place(arm, prismatic, Q[k], T, axes, points)
        to_frame_1(T, arm, X)
        _, _, _, nx, ny, nz, tx, ty, tz, _ = plane_normal(X[9], X[10], X[11])
        x = arm[0] * axes[3, 0] + arm[1] * axes[3, 1] + arm[2] * axes[3, 2]
        y = arm[3] * axes[3, 0] + arm[4] * axes[3, 1] + arm[5] * axes[3, 2]
        z = arm[6] * axes[3, 0] + arm[7] * axes[3, 1] + arm[8] * axes[3, 2]
        values[k] = math.atan2(tx * x + ty * y + tz * z, nx * x + ny * y + nz * z)
