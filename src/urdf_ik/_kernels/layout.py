"""Where each number of an arm stands in the one array ``arm`` that the family kernels take.

One array, because unpacking an argument costs a kernel call about 50 ns. The ideal arm is in Craig's
Denavit-Hartenberg order: T = base Rz(t1) Tx(a1) Rx(alpha1) Tz(d2) Rz(t2) ... Rz(t6) tool, with t = q + offset;
the arm as written is a product of exponentials (see ``screws``).
"""

# Base rotation transposed, origin of frame 1 in the base, tool rotation transposed, solved point in the tip.
BASE_ROTATION, BASE_ORIGIN, TOOL_ROTATION, TOOL_POINT = 0, 9, 12, 21
# alpha 1-5, a 1-5, d 2-5, joint offsets, length that tolerances are relative to.
COS_ALPHA, SIN_ALPHA, A, D, OFFSET, SIZE = 24, 29, 34, 39, 43, 49
# Spherical wrist: the centre in frame 3, its polar form, its height along axis 2, the swing's factor and shift.
CENTRE, RHO, COS_PHI, SIN_PHI, HEIGHT, SWING = 50, 53, 54, 55, 56, 57
# Three parallel axes: height of axis 6 along them, the sign that axes 3 and 4 turn with, the wrist's first twist.
ALONG, TURN_3, TURN_4, COS_FIRST, SIN_FIRST = 50, 51, 52, 53, 54
# Tolerances, in the order of ``tolerances.Tolerances``.
REACH, EDGE, FOLD, CONTINUUM, SINGULAR, DUPLICATE, ROTATION, EXACT_ROTATION, EXACT_STRUCTURE = range(64, 73)
# How far below zero a margin may fall before the branch is given up, and how far the ideal arm is off.
CLAMP, IMPERFECTION = 73, 74
# Signs of the eight branches (8, 3); the arm as written.
SIGNS, H, P, R_TIP = 76, 100, 118, 139
# The arm as written again, for Newton's method: 1 / size, and seven frames (rotation 9, translation 3).
INVERSE_SIZE, FRAMES = 75, 148
LENGTH = 232
# General 6R, behind these: inverse of the tip's home pose (3, 4), centre of the axes, 1 / scale, number of variants.
HOME_INVERSE, CENTRE_OF_AXES, SCALE, VARIANTS, FIRST_VARIANT = 232, 244, 247, 248, 252

# Rows of a block's workspace: target (0-12), signs of the branch (13-15), root (16-17), scratch (13-25).
ROWS, BLOCK = 26, 32

# Bits of a solution's flags.
VALID, SHOULDER, ELBOW, WRIST, OTHER = 1, 2, 4, 8, 16
