"""Intervals of the redundancy parameter that are free of contact."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from urdf_ik.ik.redundancy.interval_arrays import End, Found
from urdf_ik.ik.redundancy.self_motion import Curves
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from urdf_ik.ik.contacts import Bodies

STEP = 0.05
"""rad or shares of the arm's size along a curve between two joint vectors that are asked about first."""
NARROWEST = 1e-5
"""rad or m: a motion between two free values is cut down to this before it counts as a contact between them."""
_ENDS = 36
"""How often the place of a contact is halved: from ``STEP`` to below 1e-11."""


def without_contacts(model: Bodies, curves: Curves, T: Array, found: Found) -> Found:
    """Cut intervals of poses (m, 4, 4) where bodies touch.

    Between two values that are free the straight motion of the joints is proven free, or cut in halves, down to
    ``NARROWEST``; where a free value has one in contact beside it, the place of the contact is halved.
    """
    pieces = [piece for k in range(len(found.low)) for piece in _cut(model, curves, T[found.pose[k]], found, k)]
    count = np.array([len(piece.values) for piece in pieces], dtype=np.intp)
    of = found.of(np.array([piece.interval for piece in pieces], dtype=np.intp))
    samples = [curves.samples(T[pose], each.q, each.values) for pose, each in zip(of.pose, pieces, strict=True)]
    return replace(
        of,
        low=np.array([piece.values[0] for piece in pieces]),
        high=np.array([piece.values[-1] for piece in pieces]),
        ends=np.array([piece.ends for piece in pieces], dtype=object).reshape(-1, 2),
        first=np.cumsum(count) - count,
        count=count,
        value=np.concatenate([*(piece.values for piece in pieces), []]),
        q=np.concatenate([*(piece.q for piece in pieces), found.q[:0]]),
        core=np.concatenate([*samples, found.core[:0]]),
    )


class _Piece(NamedTuple):
    """What is left of an interval: its number, samples of growing value, and ends."""

    interval: int
    values: Array
    q: Array
    ends: tuple[End, End]


def _cut(model: Bodies, curves: Curves, T: Array, found: Found, k: int) -> list[_Piece]:
    """The pieces of interval ``k``, of pose T (4, 4), without contacts."""
    part = slice(found.first[k], found.first[k] + found.count[k])
    value, q = _refined(curves, T, found.value[part], found.q[part])
    hit = np.asarray(model.in_collision(q), dtype=np.bool_)
    # Motions between free neighbours that are not proven free are halved.
    while True:
        near = np.flatnonzero(~hit[:-1] & ~hit[1:] & (np.diff(value) > NARROWEST))
        way = _way(curves, q[near], q[near + 1])
        near = near[~np.asarray(model.motions_free(q[near], q[near] + way).free)] if len(near) else near
        fresh = 0.5 * (value[near] + value[near + 1])
        if not len(near):
            break
        joints = curves.at(np.broadcast_to(T, (len(near), 4, 4)), q[near], fresh)
        value, q = np.insert(value, near + 1, fresh), np.insert(q, near + 1, joints, axis=0)
        hit = np.insert(hit, near + 1, np.asarray(model.in_collision(joints), dtype=np.bool_))
    out = []
    edges = np.flatnonzero(np.diff(np.concatenate([[1], hit.astype(np.int8), [1]])))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        values, joints, (low, high) = value[start:stop], q[start:stop], tuple(found.ends[k])
        if start > 0:
            at, there, low = _contact(model, curves, T, value, q, start, start - 1)
            values, joints = np.append(at, values), np.vstack([there, joints])
        if stop < len(value):
            at, there, high = _contact(model, curves, T, value, q, stop - 1, stop)
            values, joints = np.append(values, at), np.vstack([joints, there])
        out.append(_Piece(k, values, joints, (low, high)))
    return out


def _refined(curves: Curves, T: Array, value: Array, q: Array) -> tuple[Array, Array]:
    """Samples (k,), (k, n) of a curve, and others between them, so that no joint moves by more than ``STEP``."""
    pieces = np.ceil(np.abs(_way(curves, q[:-1], q[1:])).max(axis=1) / STEP).astype(np.intp)
    share = [np.arange(count) / count for count in np.maximum(pieces, 1)]
    before = np.repeat(np.arange(len(share)), [len(each) for each in share])
    values = value[before] + np.concatenate([*share, []]) * np.diff(value)[before]
    joints = q[before].copy()
    fresh = values > value[before]
    joints[fresh] = curves.at(np.broadcast_to(T, (int(fresh.sum()), 4, 4)), joints[fresh], values[fresh])
    kept = ~np.isnan(joints).any(axis=1)
    return np.append(values[kept], value[-1]), np.vstack([joints[kept], q[-1:]])


def _contact(
    model: Bodies, curves: Curves, T: Array, value: Array, q: Array, inside: int, outside: int
) -> tuple[float, Array, End]:
    """The last free value from sample ``inside`` towards ``outside``, its joint vector, and what touches behind it."""
    free, held, joints, touching = value[inside], value[outside], q[inside], q[outside]
    for _ in range(_ENDS):
        middle = 0.5 * (free + held)
        there = curves.at(T[None], joints[None], np.array([middle]))[0]
        if np.isnan(there).any():
            break
        if model.in_collision(there[None])[0]:
            held, touching = middle, there
        else:
            free, joints = middle, there
    nearest = model.nearest_pair(touching)
    return float(free), joints, End("contact", pair=None if nearest is None else nearest.links)


def _way(curves: Curves, q0: Array, q1: Array) -> Array:
    """How far each joint goes from q0 (k, n) to q1 (k, n), angles by the shorter way round."""
    return np.where(curves.turning, shortest(q1 - q0), q1 - q0)
