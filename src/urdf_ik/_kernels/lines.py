"""Lines under rigid motions, as vectors of 15 numbers on which a motion acts linearly.

A line with point p and direction l is w = (1, p, h, l, p x l, d, k) with h = p.p / 2, d = p.l, k = h l - d p.
For a motion (R, t): p' = R p + t, h' = h + t.Rp + t.t/2, l' = R l, m' = R m + t x R l, d' = d + t.Rl and
k' = R k - t x R m + (t.t/2) R l - (d + t.Rl) t. In these numbers the loop equation of an arm, applied to one of
its axes, is the fourteen equations of Raghavan and Roth (1990), without coordinates.
"""

from __future__ import annotations

from urdf_ik._kernels.compile import kernel

LINE = 15


@kernel
def line_vector(px, py, pz, lx, ly, lz, w):
    """The 15 numbers of the line through p along l to ``w``."""
    h = 0.5 * (px * px + py * py + pz * pz)
    d = px * lx + py * ly + pz * lz
    w[0] = 1.0
    w[1], w[2], w[3] = px, py, pz
    w[4] = h
    w[5], w[6], w[7] = lx, ly, lz
    w[8], w[9], w[10] = py * lz - pz * ly, pz * lx - px * lz, px * ly - py * lx
    w[11] = d
    w[12], w[13], w[14] = h * lx - d * px, h * ly - d * py, h * lz - d * pz


@kernel
def line_motion(G, U):
    """The matrix (15, 15) by which the rigid motion ``G`` (4, 4) acts on lines, to ``U``."""
    U[:, :] = 0.0
    t0, t1, t2 = G[0, 3], G[1, 3], G[2, 3]
    half = 0.5 * (t0 * t0 + t1 * t1 + t2 * t2)
    U[0, 0], U[4, 4], U[11, 11], U[4, 0] = 1.0, 1.0, 1.0, half
    for i in range(3):
        U[1 + i, 0] = G[i, 3]
        U[12 + i, 11] = -G[i, 3]
        for j in range(3):
            U[1 + i, 1 + j] = U[5 + i, 5 + j] = U[8 + i, 8 + j] = U[12 + i, 12 + j] = G[i, j]
    for j in range(3):
        r0, r1, r2 = G[0, j], G[1, j], G[2, j]
        along = t0 * r0 + t1 * r1 + t2 * r2
        U[4, 1 + j] = along
        U[11, 5 + j] = along
        x, y, z = t1 * r2 - t2 * r1, t2 * r0 - t0 * r2, t0 * r1 - t1 * r0
        U[8, 5 + j], U[9, 5 + j], U[10, 5 + j] = x, y, z
        U[12, 8 + j], U[13, 8 + j], U[14, 8 + j] = -x, -y, -z
        U[12, 5 + j] = half * r0 - t0 * along
        U[13, 5 + j] = half * r1 - t1 * along
        U[14, 5 + j] = half * r2 - t2 * along
