"""The elimination to one joint's angle for an arm of six joints: constant matrices for the compiled core.

There are eight variants that depend on the arm alone: the loop can be cut in four places, on the chain or on the
reversed chain. The accuracy of each depends on the arm. On arms with parallel or meeting neighbours every variant may
be singular at all angles. Moving the axes by a millionth cures that, since solutions are polished on the arm as
written. When an arm is loaded, all variants are tried on some poses, and those that are certain of most poses are kept:
where one is in doubt, the next one hides another joint.
The equations are those of src/core/families/general/hidden_joint.hpp.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from urdf_ik._core import try_elimination
from urdf_ik.ik.families.parts.inexact import UNKNOWN, inexact
from urdf_ik.ik.families.parts.written import Numbers, written
from urdf_ik.kinematics.chain import Chain
from urdf_ik.typing import Array

_LINE = 15
_SHIFTS = (0.0, 1e-6, 1e-5)
# Poses on which variants are tried, in lots. The first lot chooses how far the axes move for each cut, the first two
# choose the counter.
_LOT, _LOTS = 8, 4
# Variants that are kept.
_KEPT = 3
# The share of poses whose sixteen solutions a variant finds; below it, real solutions are counted alone.
_MOST = 0.9
# Sizes of the core's arrays: rows of the left factor, columns of the right one.
_ROWS, _COLUMNS = 168, 32
# From parts of 1, cos t, sin t to parts of 1, d, d^2, for d = tan(t / 2): both sides times cos^2(t / 2).
_POWERS = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 2.0], [1.0, -1.0, 0.0]])


def elimination_arm(chain: Chain, *, near: bool = False) -> Numbers:
    """The arm for the compiled elimination, with the variants that are certain of most poses.

    Args:
        chain: six joints.
        near: whether the arm is near a special one: its complex solutions are then too far from real to be counted.
    """
    H, points, centre, scale = _scaled(chain)
    home = np.eye(4)
    home[:3, :3], home[:3, 3] = chain.R_tip, chain.P.sum(axis=0)
    to_centre = np.eye(4)
    to_centre[:3, 3] = centre
    rng = np.random.default_rng(0)
    Q = rng.uniform(-math.pi, math.pi, (_LOT * _LOTS, 6))
    Q[:, chain.prismatic] *= chain.size / math.pi
    setup = Numbers(
        written=written(chain),
        home_inverse=np.ascontiguousarray((np.linalg.inv(home) @ to_centre)[:3]),
        centre=centre,
        scale=scale,
        near=float(near or chain.prismatic.any()),
    )
    every = _all_variants(H, points, chain.prismatic, rng)
    trials = _Trials(setup, every, chain.fk(Q))
    order = trials.best()
    variant = _at(every, order)
    counter, rest = _with_bounds(_at(every, [0 if chain.prismatic.any() else trials.counter()]), setup)
    if not setup.near and (trials.certain[order[0]] & 1).mean() < _MOST:
        setup.near = 1.0
        variant = Numbers(**{k: np.concatenate([v, vars(variant)[k][:-1]]) for k, v in vars(counter).items()})
    return Numbers(kind="elimination", **vars(setup), variant=variant, counter=counter, counter_rest=rest)


def _with_bounds(variant: Numbers, setup: Numbers) -> tuple[Numbers, Numbers]:
    """One variant with bounds on how far it is from the arm, if all joints turn, and what its factors lack."""
    left, right = variant.left[0], variant.right[0]
    if variant.slides.any():
        unknown = Numbers(left=np.zeros_like(left), right=np.zeros_like(right), inexact=np.full(3, UNKNOWN))
        return variant, unknown
    cut = int(variant.first[0]), bool(variant.reversed[0])
    bound, rest = inexact(setup.written.steps, setup.centre, setup.scale, cut, left, right)
    return variant.but(inexact=bound[None]), rest


class _Trials:
    """What each variant alone finds of the poses (m, 4, 4), tried where that can matter."""

    def __init__(self, setup: Numbers, variants: Numbers, targets: Array) -> None:
        self.cuts = len(variants.first) // len(_SHIFTS)
        # What the zeros of unmoved axes' determinants would prove, were these as exact as rounding lets them be.
        exact = np.where(np.arange(len(variants.first))[:, None] < self.cuts, [1e-13, 0.0, 0.0], UNKNOWN)
        self.setup, self.variants, self.targets = setup, variants.but(inexact=exact), targets
        self.counts, self.certain = np.zeros((2, len(variants.first), len(targets)), np.uint8)
        self.done = np.zeros((len(variants.first), _LOTS), np.bool_)

    def run(self, rows: NDArray[np.intp], lot: int) -> None:
        """Try variants on a lot of poses, where they have not been."""
        rows, poses = rows[~self.done[rows, lot]], slice(_LOT * lot, _LOT * (lot + 1))
        counts, certain = np.empty((2, len(rows), _LOT), np.uint8)
        if len(rows):
            targets = np.ascontiguousarray(self.targets[poses])
            try_elimination(self.setup, _at(self.variants, rows), targets, counts, certain)
        self.counts[rows, poses], self.certain[rows, poses], self.done[rows, lot] = counts, certain, True

    def scores(self, rows: NDArray[np.intp]) -> NDArray[np.intp]:
        """The number of poses of which variants are rightly certain, so far; -1 where they are wrong about one."""
        certain = self.certain[rows] & 1
        # It is certain of fewer solutions than another one finds: its determinant lacks some of them as roots.
        wrong = ((certain > 0) & (self.counts[rows] < self.counts.max(axis=0))).any(axis=1)
        return np.where(wrong, -1, certain.sum(axis=1, dtype=np.intp))

    def order(self, rows: NDArray[np.intp]) -> NDArray[np.intp]:
        """The variants from the best one; among equals the one whose equations take the fewest products first."""
        return rows[np.lexsort((-self.variants.first[rows], -self.scores(rows)))]

    def best(self) -> NDArray[np.intp]:
        """Variants of the best cuts, the best one first."""
        every = np.arange(len(self.done))
        # Near a special arm, a root of moved axes is too far from the solution for certainty.
        for shift in range(1 if self.setup.near else len(_SHIFTS)):
            poor = self.scores(every).reshape(len(_SHIFTS), -1).max(axis=0) < _LOT
            self.run(every[shift * self.cuts :][: self.cuts][poor], 0)
        order = self.order(every)
        few = order[np.sort(np.unique(order % self.cuts, return_index=True)[1])]
        for k in range(len(few)):
            for lot in range(_LOTS):
                # Whatever the other poses say, it is not among the best.
                if lot and (most := self.scores(few))[k] + _LOT * (_LOTS - lot) < np.sort(most)[-_KEPT:][0]:
                    break
                self.run(few[k : k + 1], lot)
        return self.order(few)[:_KEPT]

    def counter(self) -> int:
        """The variant of the axes as they are whose determinant's zeros prove most of the poses complete."""
        for lot in (0, 1):
            self.run(np.arange(self.cuts), lot)
        proven = np.count_nonzero(self.certain[: self.cuts, : 2 * _LOT] & 2, axis=1)
        return int(np.argsort(proven, kind="stable")[-1])


def _at(variants: Numbers, rows: Sequence[int] | NDArray[np.intp]) -> Numbers:
    """Some of the variants, by their places."""
    kept = np.asarray(rows)
    return Numbers(**{name: np.ascontiguousarray(values[kept]) for name, values in vars(variants).items()})


def _scaled(chain: Chain) -> tuple[Array, Array, Array, float]:
    """Axes with the origin in their midst and a mean distance of one: directions, points, centre, scale."""
    centre = chain.points.mean(axis=0)
    points = chain.points - centre
    points = points - np.einsum("ij,ij->i", points, chain.H)[:, None] * chain.H
    length = float(np.sqrt((points**2).sum(axis=1).mean()))
    scale = 1.0 / length if length > 0.0 else 1.0
    return chain.H, points * scale, centre, scale


def _all_variants(H: Array, points: Array, slides: NDArray[np.bool_], rng: np.random.Generator) -> Numbers:
    """Every variant, v of them, on the axes as they are and on axes moved a little."""
    shifts = np.array(_SHIFTS)[:, None, None]
    turned, moved = np.moveaxis(rng.standard_normal((len(_SHIFTS), 2, 6, 3)), 1, 0)
    turned = H + shifts * turned
    turned /= np.linalg.norm(turned, axis=-1, keepdims=True)
    moved = points + shifts * moved
    # (shifts, from base to tip or back, joint of the loop, ...)
    axes = np.stack([turned, -turned[:, ::-1]], axis=1)
    places = np.stack([moved, moved[:, ::-1]], axis=1)
    kinds = np.stack([slides, slides[::-1]])
    motions = _motions(axes, places, kinds)
    lines = _lines(places, axes)
    parts = []
    for reverse in (0, 1):
        for first in range(4):
            # A slide moves the points of its own axis.
            if not kinds[reverse, first + 2]:
                at = (slice(None), reverse)
                part = _factors(motions[at], lines[at][:, first + 2], kinds[reverse], first)
                part["axes"], part["points"] = axes[at], places[at]
                part["across"] = _across(axes[at][:, first + 2])
                part["slides"] = np.broadcast_to(kinds[reverse].astype(np.float64), (len(_SHIFTS), 6))
                part["inexact"] = np.full((len(_SHIFTS), 3), UNKNOWN)
                part["first"] = np.full(len(_SHIFTS), float(first))
                part["reversed"] = np.full(len(_SHIFTS), float(reverse))
                parts.append(part)
    rows = Numbers(**{name: np.concatenate([part[name] for part in parts]) for name in parts[0]})
    # Ordered by shift: among equals the unmoved axes are preferred.
    return _at(rows, np.argsort(np.tile(np.arange(len(_SHIFTS)), len(parts)), kind="stable"))


def _factors(motions: Array, line: Array, slides: NDArray[np.bool_], first: int) -> dict[str, Array]:
    """The equations' two constant factors, and the left side's inverse, for a loop cut before joint ``first`` + 3.

    ``motions`` (k, 6, 3, 15, 15) of the loop's joints, ``line`` (k, 15) of axis ``first`` + 2.
    """
    count = len(motions)
    before, behind = (
        np.einsum("ij,kjab->kiab", _POWERS, motions[:, k]) if slides[k] else motions[:, k] for k in (first, first + 1)
    )
    carried = (behind @ line[:, None, :, None])[..., 0]
    left = np.einsum("kiab,kjb->kaij", before, carried).reshape(count, _LINE, 9)
    # Of rank less than nine on special arms: then some of the null vectors are among the directions of u.
    u, s, vt = np.linalg.svd(left)
    null = u[:, :, 9:].transpose(0, 2, 1)
    weights = np.where(s > 1e-10 * s[:, :1], 1.0 / np.where(s > 0.0, s, 1.0), 0.0)
    inverse = (vt.transpose(0, 2, 1) * weights[:, None, :]) @ u[:, :, :9].transpose(0, 2, 1)
    # A joint's motion back: the sine's part turns its sign.
    back = motions * np.array([1.0, 1.0, -1.0])[:, None, None]
    hidden, kept_too, kept = (back[:, (first + k) % 6] for k in (5, 4, 3))
    # Products of (1, cos, sin) of the joints that stand before the loop's motion, and of those behind it.
    front, rear = null, line[:, None, :]
    for joint in (hidden, kept_too, kept)[:first]:
        front = _before(front, joint)
    for joint in (kept, kept_too, hidden)[: 3 - first]:
        rear = _behind(joint, rear)
    rows, columns = front.shape[1], rear.shape[1]
    left_factor, right_factor = np.zeros((count, _LINE, _ROWS)), np.zeros((count, _LINE, _COLUMNS))
    left_factor[:, :, :rows] = front.transpose(0, 2, 1)
    right_factor[:, :, :columns] = rear.transpose(0, 2, 1)
    return {"left": left_factor, "right": right_factor, "left_inverse": inverse}


def _before(front: Array, joint: Array) -> Array:
    """Rows (k, r, 15) times a joint's motion (k, 3, 15, 15): (k, 3 r, 15), the joint's part fastest."""
    count = len(front)
    return (front @ joint.transpose(0, 2, 1, 3).reshape(count, _LINE, 3 * _LINE)).reshape(count, -1, _LINE)


def _behind(joint: Array, rear: Array) -> Array:
    """A joint's motion (k, 3, 15, 15) times columns (k, c, 15): (k, 3 c, 15), the joint's part slowest."""
    count = len(rear)
    moved = (joint.reshape(count, 3 * _LINE, _LINE) @ rear.transpose(0, 2, 1)).reshape(count, 3, _LINE, -1)
    return moved.transpose(0, 1, 3, 2).reshape(count, -1, _LINE)


def _across(axes: Array) -> Array:
    """A unit vector across each of the axes (k, 3), from the base vector that is least along it."""
    least = np.abs(axes).argmin(axis=1)
    rows = np.arange(len(axes))
    u = -axes[rows, least][:, None] * axes
    u[rows, least] += 1.0
    return np.asarray(u / np.linalg.norm(u, axis=1, keepdims=True))


def _lines(points: Array, directions: Array) -> Array:
    """The 15 numbers of lines through ``points`` (..., 3) along ``directions`` (..., 3)."""
    h = 0.5 * (points * points).sum(axis=-1, keepdims=True)
    d = (points * directions).sum(axis=-1, keepdims=True)
    moments = np.cross(points, directions)
    one = np.ones_like(h)
    return np.concatenate([one, points, h, directions, moments, d, h * directions - d * points], axis=-1)


def _line_motions(R: Array, t: Array) -> Array:
    """The matrices (..., 15, 15) by which the rigid motions R (..., 3, 3), t (..., 3) act on lines."""
    U = np.zeros((*t.shape[:-1], _LINE, _LINE))
    half = 0.5 * (t * t).sum(axis=-1)
    along = (t[..., None, :] @ R)[..., 0, :]
    cross = np.cross(t[..., :, None], R, axis=-2)
    U[..., 0, 0] = U[..., 4, 4] = U[..., 11, 11] = 1.0
    U[..., 4, 0] = half
    U[..., 1:4, 0], U[..., 12:, 11] = t, -t
    for k in (1, 5, 8, 12):
        U[..., k : k + 3, k : k + 3] = R
    U[..., 4, 1:4] = U[..., 11, 5:8] = along
    U[..., 8:11, 5:8], U[..., 12:, 8:11] = cross, -cross
    U[..., 12:, 5:8] = half[..., None, None] * R - t[..., :, None] * along[..., None, :]
    return U


def _motions(axes: Array, points: Array, slides: NDArray[np.bool_]) -> Array:
    """(..., 6, 3, 15, 15): the motion of lines by a joint's value t is the sum of these times 1, cos t, sin t.

    A slide by d = tan(t / 2) counts times cos^2(t / 2). ``axes``, ``points`` (..., 6, 3), ``slides`` (2, 6).
    """
    x, y, z = np.moveaxis(axes, -1, 0)
    zero = np.zeros_like(x)
    K = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    KK = K @ K
    eye = np.eye(3)
    # At t = 0, pi and pi / 2, and at d = 0, 1 and -1.
    turns = np.stack([np.broadcast_to(eye, K.shape), eye + 2.0 * KK, eye + K + KK], axis=-3)
    shifts = points[..., None, :] - (turns @ points[..., None, :, None])[..., 0]
    at_zero, half, quarter = np.moveaxis(_line_motions(turns, shifts), -3, 0)
    constant = 0.5 * (at_zero + half)
    motions = np.stack([constant, 0.5 * (at_zero - half), quarter - constant], axis=-3)
    if slides.any():
        lengths = np.array([0.0, 1.0, -1.0])[:, None] * axes[..., None, :]
        at_zero, ahead, back = np.moveaxis(_line_motions(np.broadcast_to(eye, (*lengths.shape, 3)), lengths), -3, 0)
        linear, square = 0.5 * (ahead - back), 0.5 * (ahead + back) - at_zero
        sliding = 0.5 * np.stack([at_zero + square, at_zero - square, linear], axis=-3)
        motions = np.where(slides[..., None, None, None], sliding, motions)
    return motions
