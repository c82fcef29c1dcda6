"""Six joints of which one or two slide, without a structure to use: elimination, polished as arms of few joints are.

The determinant is that of six turns, see ``hidden_joint``: a slide takes part as an angle.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import few_joints as few
from urdf_ik._kernels import hidden_joint as hidden
from urdf_ik._kernels import layout
from urdf_ik._kernels import slides as wrist
from urdf_ik._kernels.compile import kernel
from urdf_ik._kernels.general_6r import count, crowded, loop_motion, remaining_angles, sample_circle, sort_columns
from urdf_ik._kernels.polynomials import LANES, self_inversive_roots
from urdf_ik._kernels.slide_position import dot
from urdf_ik._kernels.target import check_target, project_rotation
from urdf_ik._kernels.thresholds import CONVERGED, LARGEST_NOISE, NEAR_CIRCLE, ON_CIRCLE
from urdf_ik._kernels.trig import wrap

# A hidden slide's cosine below which it stands for a length beyond all reach: 20 times the mean distance of the axes.
_FARTHEST = -0.995
# Starts for poses at which every variant of the elimination leaves doubt and an odd number of solutions, or none.
_STARTS = 160


@kernel
def gather(arm, variant, circle, target, enough, Q, flags):
    """Add the solutions that one variant of the elimination finds; returns whether it gives cause for doubt."""
    G, A = np.empty((4, 4)), np.empty((3, 6, 9))
    D, coefficients = np.empty(hidden.SAMPLES), np.empty(2 * hidden.DEGREE + 1, np.complex128)
    z = np.empty(2 * hidden.DEGREE, np.complex128)
    at, X = np.empty((LANES, 2)), np.empty((hidden.SIZE, LANES))
    values, q = np.empty(6), np.empty(6)
    reverse = variant[hidden.REVERSED] != 0.0
    hides_slide = variant[hidden.SLIDES + (int(variant[hidden.FIRST]) + 5) % 6] != 0.0
    loop_motion(arm, target, reverse, G)
    hidden.equations(variant, G, A)
    hidden.determinants(A, circle, D)
    doubt = not hidden.harmonics(D, circle, coefficients) < LARGEST_NOISE
    self_inversive_roots(coefficients, z)
    many, expected = 0, 0
    for k in range(z.size):
        size = abs(z[k])
        if size > 0.0 and abs(math.log(size)) < NEAR_CIRCLE:
            at[many, 0], at[many, 1] = z[k].real / size, z[k].imag / size
            if hides_slide and at[many, 0] < _FARTHEST:
                continue
            expected += abs(math.log(size)) < ON_CIRCLE
            many += 1
    if many == 0:
        return doubt
    for k in range(many, LANES):
        at[k] = at[0]
    hidden.null_vectors(A, at, X)
    for k in range(many):
        remaining_angles(variant, G, X[:, k], at[k, 0], at[k, 1], values)
        for j in range(6):
            value = values[5 - j] if reverse else values[j]
            q[j] = value / arm[layout.SCALE] if arm[few.SLIDING + j] else wrap(value)
        few.take(arm, target, q, few.DOUBTFUL, enough, Q, flags)
    return doubt or count(flags) < expected or crowded(z)


@kernel
def _search(arm, target, enough, Q, flags):
    """Solutions from fixed starts all over the joints' values, until they come in pairs."""
    q, seed = np.empty(6), 12345
    for k in range(_STARTS):
        for j in range(6):
            seed = (seed * 1103515245 + 12345) % 2147483648
            share = seed / 1073741824.0 - 1.0
            q[j] = share * (arm[layout.SIZE] if arm[few.SLIDING + j] else math.pi)
        few.take(arm, target, q, few.SEARCHED, enough, Q, flags)
        if k >= _STARTS // 4 and count(flags) > 0 and count(flags) % 2 == 0:
            break


@kernel
def complete(arm, target, Q, flags):
    """Add what is missing to the solutions of one pose that ``Q`` and ``flags`` hold already."""
    circle, doubt = sample_circle(), True
    # A slide far out carries its rounding to the tip.
    enough = CONVERGED * (1.0 + math.sqrt(dot(target[:3, 3], target[:3, 3])) / arm[layout.SIZE])
    for v in range(int(arm[layout.VARIANTS])):
        if not doubt:
            break
        start = layout.FIRST_VARIANT + v * hidden.VARIANT
        doubt = gather(arm, arm[start : start + hidden.VARIANT], circle, target, enough, Q, flags)
        # Solutions come in pairs.
        doubt = doubt or count(flags) % 2 == 1
    if doubt and (count(flags) == 0 or count(flags) % 2 == 1):
        _search(arm, target, enough, Q, flags)
    if count(flags) == 0:
        first = arm[layout.FIRST_VARIANT : layout.FIRST_VARIANT + hidden.VARIANT]
        gather(arm, first, circle, target, arm[layout.REACH], Q, flags)


@kernel
def trial(arm, variant, targets, counts, doubts):
    """How many solutions one variant finds of ``targets`` (m, 4, 4), to ``counts``, and whether it is in doubt."""
    circle = sample_circle()
    Q, flags = np.empty((16, 6)), np.empty(16, np.uint8)
    for i in range(targets.shape[0]):
        Q[:, :] = math.nan
        flags[:] = 0
        doubts[i] = gather(arm, variant, circle, targets[i], CONVERGED, Q, flags) or count(flags) % 2 == 1
        counts[i] = count(flags)


@kernel
def solve(T, arm, q_ref, Q, flags):
    """All solutions of poses ``T`` (m, 4, 4) to ``Q`` (m, 16, 6) and ``flags`` (m, 16).

    Arguments and result as those of ``spherical_wrist.solve``. An arm whose wrist meets only nearly is first solved
    as if it did.
    """
    proper = np.empty((4, 4))
    for i in range(T.shape[0]):
        if not check_target(T[i]) <= arm[layout.ROTATION]:
            return i
        project_rotation(T[i], proper)
        Q[i, :, :] = math.nan
        flags[i, :] = 0
        if arm[wrist.BY_WRIST]:
            wrist.by_wrist(arm, proper, q_ref, Q[i], flags[i])
        complete(arm, proper, Q[i], flags[i])
        sort_columns(Q[i], flags[i])
    return -1
