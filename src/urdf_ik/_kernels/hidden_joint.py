"""General 6R, first half: the angles of one hidden joint, from a determinant that is a trigonometric polynomial.

The loop is cut so that joints a, a + 1 stand on one side and a + 3, a + 4, a + 5 (cyclically) on the other, and
applied to the axis of joint a + 2, which its own turn leaves in place. The left side is a constant 15 x 9 matrix
times the products of (1, cos, sin) of joints a and a + 1; its six left null vectors remove them. Multiplying the
six equations left by cos and sin of half of joint a + 4's angle makes them square: 12 x 12 in the products of
(1, cos, sin) of joint a + 3 and (cos, sin) of once and three times the half angle. The determinant is a
trigonometric polynomial of degree eight in the hidden joint a + 5, so it is sampled and its 16 roots are found in
the complex plane. Sources: Raghavan and Roth 1990; Manocha and Canny 1994; for the half angles, the samples and
the numerical construction see the notes in families/general_6r.py.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels.compile import kernel
from urdf_ik._kernels.lines import LINE, line_motion

DEGREE, SAMPLES, SIZE = 8, 24, 12

# Where a variant's numbers stand, one row a variant; see families/general_6r.py for what they are.
FIRST, REVERSED, BEFORE = 0, 1, 2
KEPT, KEPT_TOO, HIDDEN = 4, 679, 1354
LINE_0, NULL, NULL_HIDDEN, LEFT_INVERSE = 2029, 2044, 2134, 2404
AXES, POINTS = 2539, 2557
VARIANT = 2576


@kernel
def _apply(A, x, y):
    for i in range(A.shape[0]):
        s = 0.0
        for j in range(A.shape[1]):
            s += A[i, j] * x[j]
        y[i] = s


@kernel
def equations(variant, G, A):
    """The six equations to ``A`` (3, 6, 9): (1, cos, sin) of the hidden joint, equation, products of the others.

    The products are (1, cos, sin) of joint a + 4, slowest, times (1, cos, sin) of joint a + 3.
    """
    before = int(variant[BEFORE])
    kept = variant[KEPT : KEPT + 675].reshape(3, LINE, LINE)
    kept_too = variant[KEPT_TOO : KEPT_TOO + 675].reshape(3, LINE, LINE)
    hidden = variant[HIDDEN : HIDDEN + 675].reshape(3, LINE, LINE)
    line = variant[LINE_0 : LINE_0 + LINE]
    null = variant[NULL : NULL + 90].reshape(6, LINE)
    null_hidden = variant[NULL_HIDDEN : NULL_HIDDEN + 270].reshape(3, 6, LINE)
    U = np.empty((LINE, LINE))
    line_motion(G, U)
    x, w = np.empty(LINE), np.empty(LINE)
    once, twice = np.empty((3, LINE)), np.empty((9, LINE))
    x[:] = line
    if before == 0:
        _apply(U, line, x)
    for j in range(3):
        _apply(kept[j], x, once[j])
        if before == 1:
            _apply(U, once[j], w)
            once[j, :] = w
    for k in range(3):
        for j in range(3):
            _apply(kept_too[k], once[j], twice[3 * k + j])
            if before == 2:
                _apply(U, twice[3 * k + j], w)
                twice[3 * k + j, :] = w
    left, moved = np.empty((6, LINE)), np.empty((6, LINE))
    for h in range(3):
        if before == 3:
            if h == 0:
                for e in range(6):
                    for i in range(LINE):
                        s = 0.0
                        for j in range(LINE):
                            s += null[e, j] * U[j, i]
                        moved[e, i] = s
            for e in range(6):
                for i in range(LINE):
                    s = 0.0
                    for j in range(LINE):
                        s += moved[e, j] * hidden[h, j, i]
                    left[e, i] = s
        else:
            left[:, :] = null_hidden[h]
        for e in range(6):
            for m in range(9):
                s = 0.0
                for i in range(LINE):
                    s += left[e, i] * twice[m, i]
                A[h, e, m] = s


@kernel
def matrix_at(A, c, s, M):
    """The 12 x 12 matrix at the hidden angle (c, s) to ``M``; columns: joint a + 3's product, slowest, then halves."""
    for e in range(6):
        for j in range(3):
            f = A[0, e, j] + c * A[1, e, j] + s * A[2, e, j]
            g = 0.5 * (A[0, e, 3 + j] + c * A[1, e, 3 + j] + s * A[2, e, 3 + j])
            h = 0.5 * (A[0, e, 6 + j] + c * A[1, e, 6 + j] + s * A[2, e, 6 + j])
            M[e, 4 * j], M[e, 4 * j + 1], M[e, 4 * j + 2], M[e, 4 * j + 3] = f + g, h, g, h
            M[6 + e, 4 * j], M[6 + e, 4 * j + 1], M[6 + e, 4 * j + 2], M[6 + e, 4 * j + 3] = h, f - g, -h, g


@kernel
def determinants(A, circle, D):
    """Determinants at the angles ``circle`` (24, 2) to ``D`` (24,), by Householder's QR, all angles side by side."""
    M = np.empty((SIZE, SIZE, SAMPLES))
    V = np.empty((SIZE, SAMPLES))
    square, head, first, dot = np.empty(SAMPLES), np.empty(SAMPLES), np.empty(SAMPLES), np.empty(SAMPLES)
    for e in range(6):
        for j in range(3):
            for k in range(SAMPLES):
                c, s = circle[k, 0], circle[k, 1]
                f = A[0, e, j] + c * A[1, e, j] + s * A[2, e, j]
                g = 0.5 * (A[0, e, 3 + j] + c * A[1, e, 3 + j] + s * A[2, e, 3 + j])
                h = 0.5 * (A[0, e, 6 + j] + c * A[1, e, 6 + j] + s * A[2, e, 6 + j])
                M[e, 4 * j, k] = f + g
                M[e, 4 * j + 1, k] = h
                M[e, 4 * j + 2, k] = g
                M[e, 4 * j + 3, k] = h
                M[6 + e, 4 * j, k] = h
                M[6 + e, 4 * j + 1, k] = f - g
                M[6 + e, 4 * j + 2, k] = -h
                M[6 + e, 4 * j + 3, k] = g
    for k in range(SAMPLES):
        D[k] = 1.0
    for i in range(SIZE):
        for k in range(SAMPLES):
            square[k] = 0.0
        for r in range(i, SIZE):
            for k in range(SAMPLES):
                V[r, k] = M[r, i, k]
                square[k] += V[r, k] * V[r, k]
        for k in range(SAMPLES):
            norm = math.sqrt(square[k])
            alpha = -norm if V[i, k] > 0.0 else norm
            # Every reflection turns the determinant's sign.
            D[k] *= -alpha if i < SIZE - 1 else V[i, k]
            head[k] = V[i, k] - alpha
            first[k] = 1.0 / (square[k] - alpha * V[i, k] + 1e-300)
            V[i, k] = head[k]
        for j in range(i + 1, SIZE):
            for k in range(SAMPLES):
                dot[k] = 0.0
            for r in range(i, SIZE):
                for k in range(SAMPLES):
                    dot[k] += V[r, k] * M[r, j, k]
            for k in range(SAMPLES):
                dot[k] *= first[k]
            for r in range(i, SIZE):
                for k in range(SAMPLES):
                    M[r, j, k] -= dot[k] * V[r, k]


@kernel
def harmonics(D, circle, coefficients):
    """Fourier coefficients -8..8 of the samples to ``coefficients`` (17,) complex.

    Returns the largest of the harmonics 9 to 11, which must vanish, relative to the largest of the others: what
    rounding has left of the determinant.
    """
    largest, noise = 0.0, 0.0
    for h in range(SAMPLES // 2):
        re, im = 0.0, 0.0
        for k in range(SAMPLES):
            re += D[k] * circle[(k * h) % SAMPLES, 0]
            im -= D[k] * circle[(k * h) % SAMPLES, 1]
        size = math.sqrt(re * re + im * im)
        if h <= DEGREE:
            coefficients[DEGREE + h] = complex(re, im)
            coefficients[DEGREE - h] = complex(re, -im)
            largest = max(largest, size)
        else:
            noise = max(noise, size)
    return noise / largest if largest > 0.0 else math.inf


@kernel
def complex_roots(coefficients, z):
    """All roots of a polynomial, ``coefficients`` (n + 1,) from the constant up, to ``z`` (n,), by Aberth's iteration.

    Outside the unit circle the reversed polynomial is evaluated in 1/z, so that no power overflows.
    """
    n = z.size
    for k in range(n):
        angle = 2.0 * math.pi * k / n + 0.3
        z[k] = (1.0 + 0.2 * ((k % 3) - 1)) * complex(math.cos(angle), math.sin(angle))
    settled = np.zeros(n, np.bool_)
    for _ in range(60):
        moving = 0
        for k in range(n):
            if settled[k]:
                continue
            x = z[k]
            inside = x.real * x.real + x.imag * x.imag <= 1.0
            y = x if inside else 1.0 / x
            value, slope = (coefficients[n] if inside else coefficients[0]), 0j
            for j in range(1, n + 1):
                slope = slope * y + value
                value = value * y + (coefficients[n - j] if inside else coefficients[j])
            if value == 0j:
                settled[k] = True
                continue
            ratio = slope / value if inside else n * y - y * y * (slope / value)
            for j in range(n):
                if j != k:
                    apart = x - z[j]
                    square = apart.real * apart.real + apart.imag * apart.imag
                    if square > 0.0:
                        ratio -= complex(apart.real / square, -apart.imag / square)
            square = ratio.real * ratio.real + ratio.imag * ratio.imag
            if square == 0.0:
                continue
            shift = complex(ratio.real / square, -ratio.imag / square)
            z[k] = x - shift
            size = shift.real * shift.real + shift.imag * shift.imag
            if size < 1e-28 * max(x.real * x.real + x.imag * x.imag, 1e-6):
                settled[k] = True
            else:
                moving += 1
        if moving == 0:
            break


@kernel
def null_vector(A, c, s, x):
    """Unit vector ``x`` (12,) that the matrix at the hidden angle (c, s) takes to almost zero: inverse iteration."""
    M, swaps = np.empty((SIZE, SIZE)), np.empty(SIZE, np.int64)
    matrix_at(A, c, s, M)
    largest = 0.0
    for i in range(SIZE):
        for j in range(SIZE):
            largest = max(largest, abs(M[i, j]))
    for i in range(SIZE):
        pivot = i
        for r in range(i + 1, SIZE):
            if abs(M[r, i]) > abs(M[pivot, i]):
                pivot = r
        swaps[i] = pivot
        if pivot != i:
            for j in range(SIZE):
                M[i, j], M[pivot, j] = M[pivot, j], M[i, j]
        if abs(M[i, i]) < 1e-15 * largest:
            M[i, i] = 1e-15 * largest + 1e-300
        w = 1.0 / M[i, i]
        for r in range(i + 1, SIZE):
            M[r, i] *= w
            for j in range(i + 1, SIZE):
                M[r, j] -= M[r, i] * M[i, j]
    for i in range(SIZE):
        x[i] = 1.0 + 0.1 * i * ((i % 3) - 1)
    for _ in range(2):
        for i in range(SIZE):
            x[i], x[swaps[i]] = x[swaps[i]], x[i]
        for i in range(SIZE):
            for j in range(i):
                x[i] -= M[i, j] * x[j]
        for i in range(SIZE - 1, -1, -1):
            for j in range(i + 1, SIZE):
                x[i] -= M[i, j] * x[j]
            x[i] /= M[i, i]
        square = 0.0
        for i in range(SIZE):
            square += x[i] * x[i]
        w = 1.0 / math.sqrt(square)
        for i in range(SIZE):
            x[i] *= w
