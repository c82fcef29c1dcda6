"""General 6R, second half: from the hidden joint's angles to all solutions, verified on the arm as written."""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import hidden_joint as hidden
from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import kernel
from urdf_ik._kernels.lines import LINE, line_vector
from urdf_ik._kernels.newton import newton_on_starts
from urdf_ik._kernels.polynomials import LANES, self_inversive_roots
from urdf_ik._kernels.refine import STARTS, is_new, keep, least_stretch, place, refine, refine_held, start_beside
from urdf_ik._kernels.screws import jacobian_from_axes
from urdf_ik._kernels.target import check_target, project_rotation
from urdf_ik._kernels.thresholds import (
    ALONG_FOLD,
    CLOSE,
    CONVERGED,
    CROWDED,
    FINISHED,
    LARGEST_NOISE,
    NEAR_CIRCLE,
    NEAR_FOLD,
    NEARLY,
    ON_CIRCLE,
    PATIENCE,
    WIDE_FOLD,
)
from urdf_ik._kernels.trig import wrap


@kernel
def turned(h, p, angle, v):
    """Turn the point ``v`` (3,) in place about the axis through ``p`` along ``h``."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = v[0] - p[0], v[1] - p[1], v[2] - p[2]
    d = (h[0] * x + h[1] * y + h[2] * z) * (1.0 - c)
    v[0] = c * x + s * (h[1] * z - h[2] * y) + d * h[0] + p[0]
    v[1] = c * y + s * (h[2] * x - h[0] * z) + d * h[1] + p[1]
    v[2] = c * z + s * (h[0] * y - h[1] * x) + d * h[2] + p[2]


@kernel
def moved(slides, h, p, value, v):
    """Move the point ``v`` (3,) in place by a joint that turns by ``value``, or slides by it."""
    if slides:
        for i in range(3):
            v[i] += value * h[i]
    else:
        turned(h, p, value, v)


@kernel
def carried(G, v):
    """Move the point ``v`` (3,) in place by ``G`` (4, 4)."""
    x, y, z = v[0], v[1], v[2]
    for i in range(3):
        v[i] = G[i, 0] * x + G[i, 1] * y + G[i, 2] * z + G[i, 3]


@kernel
def other_side(variant, G, H, P, angles, v):
    """Move ``v`` in place through joints a + 3, a + 4, a + 5 backwards, and ``G`` where it stands among them."""
    first, before = int(variant[hidden.FIRST]), int(variant[hidden.BEFORE])
    slides = variant[hidden.SLIDES : hidden.SLIDES + 6]
    for k in range(3):
        if k == before:
            carried(G, v)
        j = (first + 3 + k) % 6
        moved(slides[j] != 0.0, H[j], P[j], -angles[j], v)
    if before == 3:
        carried(G, v)


@kernel
def remaining_angles(variant, G, x, c, s, angles):
    """The other five angles for the hidden one (c, s), to ``angles`` (6,), from the null vector ``x`` of its matrix.

    Of joints that slide the lengths, in the scaled frame.
    """
    first = int(variant[hidden.FIRST])
    slides = variant[hidden.SLIDES : hidden.SLIDES + 6]
    H = variant[hidden.AXES : hidden.AXES + 18].reshape(6, 3)
    P = variant[hidden.POINTS : hidden.POINTS + 18].reshape(6, 3)
    inverse = variant[hidden.LEFT_INVERSE : hidden.LEFT_INVERSE + 135].reshape(9, LINE)
    best, most = 0, -1.0
    for j in range(3):
        square = x[4 * j] ** 2 + x[4 * j + 1] ** 2
        if square > most:
            best, most = j, square
    d0, d1, d2 = 0.0, 0.0, 0.0
    for i in range(4):
        d0 += x[i] * x[4 * best + i]
        d1 += x[4 + i] * x[4 * best + i]
        d2 += x[8 + i] * x[4 * best + i]
    sign = 1.0 if d0 > 0.0 else -1.0
    angles[(first + 3) % 6] = math.atan2(sign * d2, sign * d1)
    angles[(first + 4) % 6] = 2.0 * math.atan2(x[4 * best + 1], x[4 * best])
    angles[(first + 5) % 6] = math.atan2(s, c)
    for j in range(first + 3, first + 6):
        if slides[j % 6]:
            angles[j % 6] = math.tan(0.5 * angles[j % 6])
    k = first + 2
    point, end = P[k].copy(), P[k] + H[k]
    other_side(variant, G, H, P, angles, point)
    other_side(variant, G, H, P, angles, end)
    w, products = np.empty(LINE), np.empty(9)
    line_vector(point[0], point[1], point[2], end[0] - point[0], end[1] - point[1], end[2] - point[2], w)
    for i in range(9):
        total = 0.0
        for j in range(LINE):
            total += inverse[i, j] * w[j]
        products[i] = total
    angles[first] = products[3] if slides[first] else math.atan2(products[6], products[3])
    angles[first + 1] = products[1] if slides[first + 1] else math.atan2(products[2], products[1])
    # The last one turns any vector across axis a + 2 to where the other side has it.
    least = 0
    for i in range(1, 3):
        if abs(H[k, i]) < abs(H[k, least]):
            least = i
    u = -H[k, least] * H[k]
    u[least] += 1.0
    u /= math.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    v = P[k] + u
    other_side(variant, G, H, P, angles, v)
    moved(slides[first] != 0.0, H[first], P[first], -angles[first], v)
    moved(slides[first + 1] != 0.0, H[first + 1], P[first + 1], -angles[first + 1], v)
    v -= P[k]
    across = H[k, 0] * (u[1] * v[2] - u[2] * v[1]) + H[k, 1] * (u[2] * v[0] - u[0] * v[2])
    across += H[k, 2] * (u[0] * v[1] - u[1] * v[0])
    angles[k] = math.atan2(across, u[0] * v[0] + u[1] * v[1] + u[2] * v[2])


@kernel
def loop_motion(arm, target, reverse, G):
    """The motion that the six joints must make together, in the scaled frame of the axes, to ``G`` (4, 4)."""
    centre = arm[layout.CENTRE_OF_AXES : layout.CENTRE_OF_AXES + 3]
    home = arm[layout.HOME_INVERSE : layout.HOME_INVERSE + 12].reshape(3, 4)
    for i in range(3):
        for j in range(3):
            G[i, j] = target[i, 0] * home[0, j] + target[i, 1] * home[1, j] + target[i, 2] * home[2, j]
        G[i, 3] = target[i, 0] * home[0, 3] + target[i, 1] * home[1, 3] + target[i, 2] * home[2, 3] + target[i, 3]
        G[3, i] = 0.0
    G[3, 3] = 1.0
    x = np.empty(3)
    for i in range(3):
        x[i] = G[i, 3] - centre[i] + G[i, 0] * centre[0] + G[i, 1] * centre[1] + G[i, 2] * centre[2]
        x[i] *= arm[layout.SCALE]
    for i in range(3):
        G[i, 3] = x[i]
    if reverse:
        for i in range(3):
            for j in range(i):
                G[i, j], G[j, i] = G[j, i], G[i, j]
        for i in range(3):
            G[i, 3] = -(G[i, 0] * x[0] + G[i, 1] * x[1] + G[i, 2] * x[2])


@kernel
def gather(arm, variant, circle, target, Q, flags, spare, stuck):
    """Add the solutions that one variant of the elimination finds; returns whether it gives cause for doubt.

    That is so where the determinant was drowned in rounding, and where more roots look real than solutions came of
    them. ``spare`` (7,), a joint vector and its error, takes the best of what was verified but did not converge, as
    at a singularity; ``stuck`` (17, 6) the starting points that led nowhere, their number in its last row.
    """
    G, A = np.empty((4, 4)), np.empty((3, 6, 9))
    D, coefficients = np.empty(hidden.SAMPLES), np.empty(2 * hidden.DEGREE + 1, np.complex128)
    z = np.empty(2 * hidden.DEGREE, np.complex128)
    hidden_angles, X = np.empty((LANES, 2)), np.empty((hidden.SIZE, LANES))
    on_circle, errors, stretches = np.empty(LANES, np.bool_), np.empty(LANES), np.empty(LANES)
    angles, starts, found = np.empty(6), np.empty((LANES, 6)), np.empty((LANES, 6))
    reverse = variant[hidden.REVERSED] != 0.0
    loop_motion(arm, target, reverse, G)
    hidden.equations(variant, G, A)
    hidden.determinants(A, circle, D)
    doubt = not hidden.harmonics(D, circle, coefficients) < LARGEST_NOISE
    self_inversive_roots(coefficients, z)
    many, expected = 0, 0
    stuck[16, 0] = 0.0
    for k in range(z.size):
        size = abs(z[k])
        if size > 0.0 and abs(math.log(size)) < NEAR_CIRCLE:
            hidden_angles[many, 0], hidden_angles[many, 1] = z[k].real / size, z[k].imag / size
            on_circle[many] = abs(math.log(size)) < ON_CIRCLE
            expected += on_circle[many]
            many += 1
    if many == 0:
        return doubt
    for k in range(many, LANES):
        hidden_angles[k] = hidden_angles[0]
    hidden.null_vectors(A, hidden_angles, X)
    for k in range(many):
        remaining_angles(variant, G, X[:, k], hidden_angles[k, 0], hidden_angles[k, 1], angles)
        for j in range(6):
            starts[k, j] = wrap(angles[5 - j] if reverse else angles[j])
    newton_on_starts(arm, target, starts, many, 12, found, errors, stretches)
    for k in range(many):
        q, error = found[k], errors[k]
        if error > CONVERGED and error < CLOSE:
            error = refine(arm, target, q, 40, FINISHED, PATIENCE)
        if error > CONVERGED and on_circle[k]:
            q[:] = starts[k]
            error = refine(arm, target, q, 40, FINISHED, PATIENCE)
        if error < spare[6]:
            spare[:6] = q
            spare[6] = error
        if error <= CONVERGED and is_new(arm, target, Q, flags, q):
            keep(Q, flags, 0, q, 0)
        elif on_circle[k]:
            stuck[int(stuck[16, 0])] = starts[k]
            stuck[16, 0] += 1.0
    return doubt or count(flags) < expected or crowded(z)


@kernel
def crowded(z):
    """Whether three roots, one of which may be real, are so close that rounding can move them about."""
    for i in range(z.size):
        if 0.9 < abs(z[i]) < 1.1:
            close = 0
            for j in range(z.size):
                apart = z[i] - z[j]
                close += apart.real * apart.real + apart.imag * apart.imag < CROWDED * CROWDED
            if close > 2:
                return True
    return False


@kernel
def count(flags):
    """Number of solutions among the columns of one pose."""
    total = 0
    for b in range(flags.size):
        total += flags[b] & layout.VALID
    return total


@kernel
def follow(arm, target, starts, many, Q, flags):
    """Keep what Newton's method finds from the rows of ``starts`` (many <= LANES, 6), if it is new."""
    found, errors, stretches = np.empty((LANES, 6)), np.empty(LANES), np.empty(LANES)
    newton_on_starts(arm, target, starts, many, 20, found, errors, stretches)
    for k in range(many):
        if errors[k] <= CONVERGED and is_new(arm, target, Q, flags, found[k]):
            keep(Q, flags, 0, found[k], 0)


@kernel
def fold_width(J, x):
    """How far along ``x`` (6,), which ``J`` (6, 6) all but loses, a fold has its other solution [rad].

    To second order the pose moves by s J x + s^2 / 2 c along it. Derivative of the geometric Jacobian: Hourtash 2005.
    """
    c, w = np.zeros(6), np.zeros(6)
    for k in range(6):
        for i in range(k + 1):
            # w_i x v_k and w_i x w_k, for the angular parts w and the linear parts v of the columns.
            both = x[i] * x[k] * (1.0 if i == k else 2.0)
            for r in range(3):
                m, n = (r + 1) % 3, (r + 2) % 3
                c[r] += both * (J[3 + m, i] * J[n, k] - J[3 + n, i] * J[m, k])
                if i < k:
                    c[3 + r] += x[i] * x[k] * (J[3 + m, i] * J[3 + n, k] - J[3 + n, i] * J[3 + m, k])
        for r in range(6):
            w[r] += J[r, k] * x[k]
    square, along = 0.0, 0.0
    for r in range(6):
        square += w[r] * w[r]
        along += w[r] * c[r]
    return 2.0 * square / (abs(along) + 1e-300)


@kernel
def has_partner(Q, flags, b, x, width):
    """Whether another solution lies beside column ``b`` along the unit vector ``x`` (6,), some ``width`` [rad] away."""
    for k in range(Q.shape[0]):
        if k != b and flags[k] & layout.VALID:
            along, square = 0.0, 0.0
            for j in range(6):
                apart = wrap(Q[k, j] - Q[b, j])
                along += apart * x[j]
                square += apart * apart
            if square < 9.0 * width * width and along * along > ALONG_FOLD * square:
                return True
    return False


@kernel
def search_beside(arm, target, Q, flags, simple):
    """Find the partners of solutions that lie next to a fold; flag the singular ones. Returns whether it looked.

    Along the direction that the Jacobian all but loses, Newton's method starts at distances from 0.3 to 1e-8 rad
    on both sides. Where folds are ``simple`` a solution whose partner is known, or too far off to hide, is passed over;
    arms whose folds come in clusters have more solutions there than the two.
    """
    prismatic = np.zeros(6, np.bool_)
    T, J = np.empty((4, 4)), np.empty((6, 6))
    axes, points, x = np.empty((6, 3)), np.empty((6, 3)), np.empty(6)
    starts, unmoved = np.empty((LANES, 6)), np.empty((LANES, 6))
    errors, stretches = np.empty(LANES), np.empty(LANES)
    for b in range(Q.shape[0]):
        for j in range(6):
            starts[b, j] = Q[b, j] if flags[b] & layout.VALID else 0.0
    newton_on_starts(arm, target, starts, Q.shape[0], 0, unmoved, errors, stretches)
    beside = False
    for b in range(Q.shape[0]):
        if not flags[b] & layout.VALID or stretches[b] > NEAR_FOLD:
            continue
        place(arm, prismatic, Q[b], T, axes, points)
        jacobian_from_axes(prismatic, axes, points, T[:3, 3], J)
        for j in range(6):
            for i in range(3):
                J[i, j] /= arm[layout.SIZE]
        sigma = least_stretch(J, x)
        if sigma <= arm[layout.SINGULAR]:
            flags[b] |= layout.OTHER
        if sigma > NEAR_FOLD:
            continue
        if simple:
            width = fold_width(J, x)
            if width > WIDE_FOLD or has_partner(Q, flags, b, x, width):
                continue
        beside = True
        for side in range(2):
            for k in range(LANES):
                distance = (1.0 if side else -1.0) * 0.3 * 10.0 ** (-0.5 * k)
                for j in range(6):
                    starts[k, j] = wrap(Q[b, j] + distance * x[j])
            follow(arm, target, starts, LANES, Q, flags)
    return beside


@kernel
def sort_columns(Q, flags):
    """Order the solutions of one pose by their joint angles, first joint first, from -pi to pi; empty columns last."""
    for i in range(1, Q.shape[0]):
        for b in range(i, 0, -1):
            if not flags[b] & layout.VALID:
                break
            ahead = not flags[b - 1] & layout.VALID
            if not ahead:
                for j in range(Q.shape[1]):
                    if abs(Q[b, j] - Q[b - 1, j]) > 1e-6:
                        ahead = Q[b, j] < Q[b - 1, j]
                        break
            if not ahead:
                break
            flags[b], flags[b - 1] = flags[b - 1], flags[b]
            for j in range(Q.shape[1]):
                Q[b, j], Q[b - 1, j] = Q[b - 1, j], Q[b, j]


@kernel
def trial(arm, variant, targets, counts, doubts):
    """How many solutions one variant finds of ``targets`` (m, 4, 4), to ``counts``, and whether it is in doubt."""
    circle = sample_circle()
    Q, flags, spare, stuck = np.empty((16, 6)), np.empty(16, np.uint8), np.empty(7), np.empty((17, 6))
    for i in range(targets.shape[0]):
        Q[:, :] = math.nan
        flags[:] = 0
        spare[:] = math.inf
        doubts[i] = gather(arm, variant, circle, targets[i], Q, flags, spare, stuck)
        doubts[i] = doubts[i] or count(flags) % 2 == 1
        search_beside(arm, targets[i], Q, flags, False)
        counts[i] = count(flags)


@kernel
def sample_circle():
    """The angles at which the determinant is sampled, as (cos, sin) rows."""
    circle = np.empty((hidden.SAMPLES, 2))
    for k in range(hidden.SAMPLES):
        circle[k, 0] = math.cos(2.0 * math.pi * k / hidden.SAMPLES)
        circle[k, 1] = math.sin(2.0 * math.pi * k / hidden.SAMPLES)
    return circle


@kernel
def complete(arm, target, Q, flags, known):
    """Add what is missing to the solutions of one pose that ``Q`` and ``flags`` hold already.

    Where these are ``known`` from a closed form, of an arm whose folds are simple, they test the elimination: a first
    look that misses none of them is believed.
    """
    circle = sample_circle()
    variants = int(arm[layout.VARIANTS])
    spare, stuck, starts = np.full(7, math.inf), np.empty((17, 6)), np.empty((LANES, 6))
    sure, beside = False, False
    for v in range(variants):
        start = layout.FIRST_VARIANT + v * hidden.VARIANT
        variant = arm[start : start + hidden.VARIANT]
        if known and v == 0:
            doubt = gather_anew(arm, variant, circle, target, Q, flags, spare, stuck)
        else:
            doubt = gather(arm, variant, circle, target, Q, flags, spare, stuck)
        sure = not doubt or (known and sure)
        last = v == variants - 1
        if v == 0 or last:
            beside = search_beside(arm, target, Q, flags, known)
        # Solutions come in pairs; next to a fold one opinion is not enough.
        if sure and count(flags) % 2 == 0 and (v > 0 or not beside):
            break
        if last:
            for i in range(int(stuck[16, 0])):
                for k in range(1, STARTS):
                    start_beside(stuck[i], k, starts[k - 1])
                follow(arm, target, starts, STARTS - 1, Q, flags)
    if count(flags) == 0 and spare[6] < NEARLY:
        best = spare[:6].copy()
        if refine_held(arm, target, best) <= arm[layout.REACH]:
            keep(Q, flags, 0, best, layout.OTHER)


@kernel
def gather_anew(arm, variant, circle, target, Q, flags, spare, stuck):
    """``gather`` without help from the solutions in ``Q``; missing one of them is cause for doubt too."""
    found, marks = np.full(Q.shape, math.nan), np.zeros(flags.size, np.uint8)
    doubt = gather(arm, variant, circle, target, found, marks, spare, stuck)
    for b in range(flags.size):
        doubt = doubt or (flags[b] & layout.VALID and is_new(arm, target, found, marks, Q[b]))
    for b in range(flags.size):
        if marks[b] & layout.VALID and is_new(arm, target, Q, flags, found[b]):
            keep(Q, flags, 0, found[b], marks[b])
    return doubt


@kernel
def solve(T, arm, q_ref, Q, flags):
    """All solutions of poses ``T`` (m, 4, 4) to ``Q`` (m, 16, 6) and ``flags`` (m, 16).

    Arguments and result as those of ``spherical_wrist.solve``; ``q_ref`` has no part in it.
    """
    proper = np.empty((4, 4))
    for i in range(T.shape[0]):
        if not check_target(T[i]) <= arm[layout.ROTATION]:
            return i
        project_rotation(T[i], proper)
        Q[i, :, :] = math.nan
        flags[i, :] = 0
        complete(arm, proper, Q[i], flags[i], False)
        sort_columns(Q[i], flags[i])
    return -1
