"""General 6R, first half: the angles of one hidden joint, from a determinant that is a trigonometric polynomial.

The loop is cut so that joints a, a + 1 stand on one side and a + 3, a + 4, a + 5 (cyclically) on the other, and
applied to the axis of joint a + 2, which its own turn leaves in place. The left side is a constant 15 x 9 matrix
times the products of (1, cos, sin) of joints a and a + 1; its six left null vectors remove them. Multiplying the
six equations left by cos and sin of half of joint a + 4's angle makes them square: 12 x 12 in the products of
(1, cos, sin) of joint a + 3 and (cos, sin) of once and three times the half angle. The determinant is a
trigonometric polynomial of degree eight in the hidden joint a + 5, so it is sampled and its 16 roots are found in
the complex plane. Sources: Raghavan and Roth 1990; Manocha and Canny 1994; for the half angles, the samples and
the numerical construction see the notes in families/general_6r.py.

A joint that slides by d takes part as an angle t with d = tan(t / 2): what it does to lines is of degree two in d, so
it is of the form 1, cos t, sin t but for the factor cos^2(t / 2), which the homogeneous equations do not see.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels.compile import inlined, kernel, step
from urdf_ik._kernels.lines import LINE, line_motion
from urdf_ik._kernels.polynomials import LANES
from urdf_ik._kernels.sixes import dot, less

DEGREE, SAMPLES, SIZE = 8, 24, 12
_TINY = 1e-300

# Where a variant's numbers stand, one row a variant; see families/general_6r.py for what they are.
FIRST, REVERSED, BEFORE = 0, 1, 2
KEPT, KEPT_TOO, HIDDEN = 4, 679, 1354
LINE_0, NULL, NULL_HIDDEN, LEFT_INVERSE = 2029, 2044, 2134, 2404
AXES, POINTS, SLIDES = 2539, 2557, 2575
VARIANT = 2584


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


@inlined
def _matrices(A, circle, M, lanes):
    """The 12 x 12 matrices at the hidden angles ``circle`` (lanes, 2), cosine and sine, to ``M`` (12, 12, lanes).

    Columns: joint a + 3's product, slowest, then the halves.
    """
    for e in range(6):
        for j in range(3):
            for k in range(lanes):
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


@step
def _upper(M, j, k):
    return M[0, j, k], M[1, j, k], M[2, j, k], M[3, j, k], M[4, j, k], M[5, j, k]


@step
def _lower(M, j, k):
    return M[6, j, k], M[7, j, k], M[8, j, k], M[9, j, k], M[10, j, k], M[11, j, k]


@inlined
def _triangular(M, lanes):
    """``M`` (12, 12, lanes) made upper triangular by eleven of Householder's reflections, all lanes side by side.

    The reflections' vectors are kept with zeros above, in two halves of six: loops over rows would cost more than
    the products with zero do.
    """
    V = np.empty((SIZE, 1, lanes))
    for i in range(SIZE - 1):
        for r in range(i):
            for k in range(lanes):
                V[r, 0, k] = 0.0
        for r in range(i, SIZE):
            for k in range(lanes):
                V[r, 0, k] = M[r, i, k]
        for k in range(lanes):
            upper, lower = _upper(V, 0, k), _lower(V, 0, k)
            square = dot(upper, upper) + dot(lower, lower)
            head = M[i, i, k]
            alpha = -math.copysign(math.sqrt(square), head)
            # Scaled so that the reflection is 1 - v v^T.
            w = 1.0 / math.sqrt(square - alpha * head + _TINY)
            M[i, i, k] = alpha
            V[i, 0, k] = head - alpha
            for r in range(SIZE):
                V[r, 0, k] *= w
        if i < 6:
            for j in range(i + 1, SIZE):
                for k in range(lanes):
                    v, w = _upper(V, 0, k), _lower(V, 0, k)
                    upper, lower = _upper(M, j, k), _lower(M, j, k)
                    f = dot(v, upper) + dot(w, lower)
                    upper, lower = less(upper, f, v), less(lower, f, w)
                    M[0, j, k], M[1, j, k], M[2, j, k], M[3, j, k], M[4, j, k], M[5, j, k] = upper
                    M[6, j, k], M[7, j, k], M[8, j, k], M[9, j, k], M[10, j, k], M[11, j, k] = lower
        else:
            for j in range(i + 1, SIZE):
                for k in range(lanes):
                    w, lower = _lower(V, 0, k), _lower(M, j, k)
                    lower = less(lower, dot(w, lower), w)
                    M[6, j, k], M[7, j, k], M[8, j, k], M[9, j, k], M[10, j, k], M[11, j, k] = lower


@kernel
def determinants(A, circle, D):
    """Determinants at the angles ``circle`` (24, 2) to ``D`` (24,), all angles side by side."""
    M = np.empty((SIZE, SIZE, SAMPLES))
    _matrices(A, circle, M, SAMPLES)
    _triangular(M, SAMPLES)
    for k in range(SAMPLES):
        # Every reflection turns the determinant's sign.
        D[k] = -M[0, 0, k]
    for i in range(1, SIZE):
        for k in range(SAMPLES):
            D[k] *= -M[i, i, k] if i < SIZE - 1 else M[i, i, k]


@kernel
def null_vectors(A, circle, X):
    """Unit vectors that the matrices at the hidden angles ``circle`` (16, 2) take to almost zero, to ``X`` (12, 16).

    Inverse iteration on the triangular factors.
    """
    M, length = np.empty((SIZE, SIZE, LANES)), np.empty(LANES)
    _matrices(A, circle, M, LANES)
    _triangular(M, LANES)
    for k in range(LANES):
        length[k] = 0.0
        for i in range(SIZE):
            length[k] = max(length[k], abs(M[i, i, k]))
    for i in range(SIZE):
        for k in range(LANES):
            least = 1e-15 * length[k] + 1e-300
            M[i, i, k] = M[i, i, k] if abs(M[i, i, k]) > least else least
            X[i, k] = 1.0 + 0.1 * i * ((i % 3) - 1)
    for _ in range(2):
        for i in range(SIZE):
            for j in range(i):
                for k in range(LANES):
                    X[i, k] -= M[j, i, k] * X[j, k]
            for k in range(LANES):
                X[i, k] /= M[i, i, k]
        for i in range(SIZE - 1, -1, -1):
            for j in range(i + 1, SIZE):
                for k in range(LANES):
                    X[i, k] -= M[i, j, k] * X[j, k]
            for k in range(LANES):
                X[i, k] /= M[i, i, k]
        for k in range(LANES):
            length[k] = 0.0
        for i in range(SIZE):
            for k in range(LANES):
                length[k] += X[i, k] * X[i, k]
        for i in range(SIZE):
            for k in range(LANES):
                X[i, k] /= math.sqrt(length[k])


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
