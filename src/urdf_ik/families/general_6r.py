"""Six revolute joints without a structure that a closed form could use: up to sixteen solutions.

The elimination of _kernels/hidden_joint.py can be set up in eight ways that need nothing of the pose: four places
to cut the loop, on the chain and on the reversed chain. Which of them keeps its digits depends on the arm, and on
arms with parallel or meeting neighbours every one may be singular at all angles; moving the axes by a millionth
cures that, since the solutions are polished on the arm as written. The choice is made by planted poses when the
arm is loaded.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._core import Solver
from urdf_ik._kernels import general_6r as kernels
from urdf_ik._kernels import hidden_joint, layout
from urdf_ik._kernels.lines import LINE, line_motion, line_vector
from urdf_ik.families.elimination import elimination_values
from urdf_ik.families.plan import Plan, pack_as_written

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]

_NAMES = tuple(f"solution {k}" for k in range(1, 17))
_SHIFTS = (0.0, 1e-6, 1e-5)
_KEPT = 5
_PLANTED = 24
# From parts of 1, cos t, sin t to parts of 1, d, d^2, for d = tan(t / 2): both sides times cos^2(t / 2).
_POWERS = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 2.0], [1.0, -1.0, 0.0]])


def matches(structure: Structure) -> bool:
    """Whether the arm has six revolute joints."""
    return len(structure.joint_types) == 6 and "prismatic" not in structure.joint_types


def prepare(chain: Chain) -> Plan:
    """The elimination's constant matrices, for the ways of setting it up that find most."""
    solver = Solver("general 6R", elimination_values(chain))
    arm = pack_as_written(chain)

    def solve(T: Array, arm: Array, q_ref: Array, Q: Array, flags: NDArray[np.uint8]) -> int:
        return solver.solve(T, None, Q, flags)

    return Plan(
        family="6R general",
        method="Elimination to one joint's angle (Raghavan and Roth), Newton's method on the URDF as written",
        branches=_NAMES,
        imperfection=(0.0, 0.0),
        error=0.0,
        arm=arm,
        solve=solve,
        explain=lambda rotation, point: _explain(chain, point),
        solver=solver,
    )


def with_elimination(arm: Array, chain: Chain, trial: Callable[..., None] = kernels.trial) -> Array:
    """``arm`` with the elimination's numbers behind its own; ``trial`` counts what a variant finds."""
    H, points, centre, scale = _scaled(chain)
    home = np.eye(4)
    home[:3, :3], home[:3, 3] = chain.R_tip, chain.P.sum(axis=0)
    inverse = np.asarray(np.linalg.inv(home)[:3], dtype=np.float64)
    return _best(arm, chain, H, points, centre, scale, inverse, trial)


def _explain(chain: Chain, point: Array) -> str:
    far = float(np.linalg.norm(point - chain.points[0]))
    if far > chain.size:
        return f"the tip is {far:.6g} m from axis 1, and all links together measure {chain.size:.6g} m"
    return "no joint angles bring the tip there: all real roots of the elimination were followed"


def _scaled(chain: Chain) -> tuple[Array, Array, Array, float]:
    """Axes with the origin in their midst and a mean distance of one: directions, points, centre, scale."""
    centre = chain.points.mean(axis=0)
    points = chain.points - centre
    points = points - np.einsum("ij,ij->i", points, chain.H)[:, None] * chain.H
    length = float(np.sqrt((points**2).sum(axis=1).mean()))
    scale = 1.0 / length if length > 0.0 else 1.0
    return chain.H, points * scale, centre, scale


def _best(
    arm: Array,
    chain: Chain,
    H: Array,
    points: Array,
    centre: Array,
    scale: float,
    home_inverse: Array,
    trial: Callable[..., None],
) -> Array:
    """``arm`` with a few variants behind it, in the order in which they are to be tried.

    Each is tried on planted poses. What counts most is that a variant does not miss a solution without giving
    cause for doubt, then that it gives little cause; those after the first are chosen by the poses that were left
    in doubt.
    """
    arm = np.concatenate([arm, np.zeros(layout.FIRST_VARIANT - len(arm))])
    arm[layout.HOME_INVERSE : layout.HOME_INVERSE + 12] = home_inverse.ravel()
    arm[layout.CENTRE_OF_AXES : layout.CENTRE_OF_AXES + 3] = centre
    arm[layout.SCALE] = scale
    rng = np.random.default_rng(0)
    targets = chain.fk(_planted(chain, rng))
    rows, counts, doubts = [], [], []
    for shift in _SHIFTS:
        moved = H + shift * rng.standard_normal((6, 3))
        moved /= np.linalg.norm(moved, axis=1, keepdims=True)
        at = points + shift * rng.standard_normal((6, 3))
        for reverse in (False, True):
            slides = chain.prismatic[::-1] if reverse else chain.prismatic
            for first in range(4):
                # A slide moves the points of its own axis.
                if slides[first + 2]:
                    continue
                row = _variant(moved, at, slides, first, reverse)
                count, doubt = np.empty(len(targets), np.int64), np.empty(len(targets), np.bool_)
                trial(arm, row, targets, count, doubt)
                rows.append(row)
                counts.append(count)
                doubts.append(doubt)
    missed = np.max(counts, axis=0) - np.array(counts)
    doubt = np.array(doubts)
    chosen: list[int] = []
    open_poses = np.ones(len(targets), np.bool_)
    while len(chosen) < _KEPT:
        silent = (missed * ~doubt)[:, open_poses].sum(axis=1)
        rest = (missed + doubt)[:, open_poses].sum(axis=1)
        order = sorted(range(len(rows)), key=lambda k: (silent[k], rest[k], k))
        best = next(k for k in order if k not in chosen)
        chosen.append(best)
        if (open_poses & doubt[best]).any():
            open_poses &= doubt[best]
    arm[layout.VARIANTS] = len(chosen)
    return np.concatenate([arm, *(rows[k] for k in chosen)])


def _planted(chain: Chain, rng: np.random.Generator) -> Array:
    """(_PLANTED, 6) rad or m: half at random, half 1e-2 to 1e-7 from a singularity found along one turning joint."""
    Q = rng.uniform(-math.pi, math.pi, (_PLANTED, 6))
    Q[:, chain.prismatic] *= chain.size / (2.0 * math.pi)
    half = _PLANTED // 2
    inner = np.flatnonzero(~chain.prismatic[1:5]) + 1
    joints = inner[np.arange(half) % len(inner)]
    rows = np.arange(half)

    def determinant(values: Array) -> Array:
        moved = Q[:half].copy()
        moved[rows, joints] = values
        J = chain.jacobian(moved)
        J[:, :3] /= chain.size
        signs: Array = np.linalg.det(J)
        return signs

    grid = np.linspace(-math.pi, math.pi, 25)
    values = np.array([determinant(np.full(half, x)) for x in grid])
    changes = values[:-1] * values[1:] < 0.0
    k = changes.argmax(axis=0)
    low, high, at_low = grid[k], grid[k + 1], values[k, rows]
    for _ in range(45):
        middle = 0.5 * (low + high)
        same = determinant(middle) * at_low > 0.0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    found = changes.any(axis=0)
    near = low + 10.0 ** -(2.0 + rows % 6)
    Q[rows[found], joints[found]] = near[found]
    return Q


def _variant(H: Array, points: Array, slides: NDArray[np.bool_], first: int, reverse: bool) -> Array:
    """One row of numbers, as _kernels/hidden_joint.py reads it, for a loop cut before joint ``first`` + 3.

    ``slides`` (6,) tells which joints slide, in the order of the loop, reversed or not.
    """
    if reverse:
        H, points = -H[::-1], points[::-1]
    joints = [_slide_motion(H[i]) if slides[i] else _joint_motion(H[i], points[i]) for i in range(6)]
    back = [motion * np.array([1.0, 1.0, -1.0])[:, None, None] for motion in joints]
    line = np.empty(LINE)
    (px, py, pz), (lx, ly, lz) = points[first + 2], H[first + 2]
    line_vector(px, py, pz, lx, ly, lz, line)
    before, behind = (_POWERS @ joints[k].reshape(3, -1) if slides[k] else joints[k] for k in (first, first + 1))
    before, behind = before.reshape(3, LINE, LINE), behind.reshape(3, LINE, LINE)
    left = np.stack([before[i] @ behind[j] @ line for i in range(3) for j in range(3)], axis=1)
    full, _, _ = np.linalg.svd(left)
    null = full[:, 9:].T
    kept, kept_too, hidden = ((first + k) % 6 for k in (3, 4, 5))
    row = np.zeros(hidden_joint.VARIANT)
    row[hidden_joint.FIRST], row[hidden_joint.REVERSED], row[hidden_joint.BEFORE] = first, reverse, 3 - first
    for start, values in (
        (hidden_joint.KEPT, back[kept]),
        (hidden_joint.KEPT_TOO, back[kept_too]),
        (hidden_joint.HIDDEN, back[hidden]),
        (hidden_joint.LINE_0, line),
        (hidden_joint.NULL, null),
        (hidden_joint.NULL_HIDDEN, null @ back[hidden]),
        (hidden_joint.LEFT_INVERSE, np.linalg.pinv(left, rcond=1e-10)),
        (hidden_joint.AXES, H),
        (hidden_joint.POINTS, points),
        (hidden_joint.SLIDES, slides),
    ):
        row[start : start + values.size] = values.ravel()
    return row


def _joint_motion(h: Array, p: Array) -> Array:
    """(3, 15, 15): the motion of lines by a joint's angle t is the sum of these times 1, cos t, sin t."""
    at = []
    K = np.array([[0.0, -h[2], h[1]], [h[2], 0.0, -h[0]], [-h[1], h[0], 0.0]])
    for c, s in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0)):
        G = np.eye(4)
        G[:3, :3] = np.eye(3) + s * K + (1.0 - c) * K @ K
        G[:3, 3] = p - G[:3, :3] @ p
        U = np.empty((LINE, LINE))
        line_motion(G, U)
        at.append(U)
    zero, half, quarter = at
    constant = 0.5 * (zero + half)
    return np.stack([constant, 0.5 * (zero - half), quarter - constant])


def _slide_motion(h: Array) -> Array:
    """(3, 15, 15): the motion of lines by d = tan(t / 2) along ``h``, times cos^2(t / 2), for 1, cos t, sin t."""
    at = []
    for d in (0.0, 1.0, -1.0):
        G = np.eye(4)
        G[:3, 3] = d * h
        U = np.empty((LINE, LINE))
        line_motion(G, U)
        at.append(U)
    zero, ahead, back = at
    linear, square = 0.5 * (ahead - back), 0.5 * (ahead + back) - zero
    return 0.5 * np.stack([zero + square, zero - square, linear])
