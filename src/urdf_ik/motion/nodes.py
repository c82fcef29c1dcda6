"""The joint vectors at each waypoint that a path may pass through."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from urdf_ik.motion.graph import Layers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.motion.graph import Joints

    Array = NDArray[np.float64]
    Ints = NDArray[np.int64]
    Mask = NDArray[np.bool_]

SAME = 1e-6
"""rad or m: joint vectors that differ by less in every joint are one node."""
_NUMBERS = 1 << 22


class Nodes(NamedTuple):
    """Joint vectors at waypoints, in any order.

    Attributes:
        at: (k,) number of the waypoint.
        q: (k, n) rad or m, lowest images.
        counts: (k, n) uint8, images of each joint.
        column: (k,) which branch.
        value: (k,) of the redundancy parameter.
        singular: (k,) whether the arm is singular there.
    """

    at: Ints
    q: Array
    counts: NDArray[np.uint8]
    column: Ints
    value: Array
    singular: Mask

    def __add__(self, other: Nodes) -> Nodes:  # type: ignore[override]
        return joined((self, other))

    def chosen(self, which: Mask | Ints) -> Nodes:
        """Some of them."""
        parts: list[Any] = [part[which] for part in self]
        return Nodes(*parts)

    def layers(self, T: Array) -> Layers:
        """As layers of waypoints (m, 4, 4)."""
        return Layers.made(T, self.at, self.q, self.counts, self.column, self.value)


def joined(parts: Sequence[Nodes]) -> Nodes:
    """All nodes of several sets."""
    columns: list[Any] = [np.concatenate(each) for each in zip(*parts, strict=True)]
    return Nodes(*columns)


def solved(arm: Arm, joints: Joints, T: Array, at: Ints, values: Array | None, *, outside: bool = False) -> Nodes:
    """All solutions inside the joint limits.

    Args:
        arm: the arm.
        joints: how its joints turn.
        T: (m, 4, 4) m, waypoints.
        at: (k,) waypoints to solve.
        values: (k, v) of the redundancy parameter, None for an arm without one.
        outside: solutions outside the limits, too; their counts are zero where they are outside.
    """
    size = arm.dof * len(arm.structure.branches) * (1 if values is None else values.shape[1])
    parts = [_solved(arm, joints, T, at[:0], None if values is None else values[:0], outside)]
    share = max(1, _NUMBERS // size)
    for k in range(0, len(at), share):
        here = slice(k, k + share)
        parts.append(_solved(arm, joints, T, at[here], None if values is None else values[here], outside))
    return joined(parts)


def _solved(arm: Arm, joints: Joints, T: Array, at: Ints, values: Array | None, outside: bool) -> Nodes:
    if values is None:
        solutions = arm.ik(T[at])
        spread = np.zeros(len(at))
        where = np.broadcast_to(at[:, None], solutions.valid.shape)
        at_value = np.broadcast_to(spread[:, None], solutions.valid.shape)
    else:
        solutions = arm.ik(T[at, None], redundancy=values)
        where = np.broadcast_to(at[:, None, None], solutions.valid.shape)
        at_value = np.broadcast_to(values[:, :, None], solutions.valid.shape)
    valid = solutions.valid
    q, counts = joints.images(solutions.q[valid])
    column = np.broadcast_to(np.arange(valid.shape[-1]), valid.shape)[valid]
    nodes = Nodes(where[valid], q, counts, column, at_value[valid], solutions.singular[valid] > 0)
    return nodes if outside else nodes.chosen(np.flatnonzero(counts.all(axis=1)))


def at_vector(arm: Arm, joints: Joints, q: Array, at: int, value: float, column: int) -> Nodes:
    """The one node of a given joint vector (n,): no other of its images counts."""
    return Nodes(
        np.array([at]), q[None].astype(np.float64), np.ones((1, arm.dof), np.uint8), np.array([column]),
        np.array([value]), np.zeros(1, dtype=np.bool_),
    )  # fmt: skip


def with_representatives(arm: Arm, joints: Joints, T: Array, nodes: Nodes) -> Nodes:
    """The nodes, and at singular poses those that continue the neighbouring waypoints' best.

    Where a pose leaves a joint free, ``ik`` returns the representative nearest to a reference: the nodes before and
    after the waypoint are taken as references, first from the start to the end, then back.
    """
    if not nodes.singular.any():
        return nodes
    layers: list[list[Nodes]] = [[] for _ in T]
    order = np.argsort(nodes.at, kind="stable")
    for at, part in zip(
        range(len(T)), np.split(order, np.searchsorted(nodes.at[order], np.arange(1, len(T)))), strict=True
    ):
        layers[at].append(nodes.chosen(part))
    loose = np.unique(nodes.at[nodes.singular])
    for step, path in ((-1, loose), (1, loose[::-1])):
        for at in path:
            if 0 <= at + step < len(T):
                _continue(arm, joints, T[at], int(at), layers[at], layers[at + step])
    return joined([part for layer in layers for part in layer])


def _continue(arm: Arm, joints: Joints, T: Array, at: int, here: list[Nodes], beside: list[Nodes]) -> None:
    """Add to a waypoint's nodes the solutions that are nearest to each of its neighbour's."""
    known = np.concatenate([part.q for part in here])
    for reference in np.concatenate([part.q for part in beside]):
        solutions = arm.ik(T, reference)
        loose = solutions.singular > 0
        if not loose.any():
            continue
        q, counts = joints.images(solutions.q[loose])
        column = np.flatnonzero(loose)
        good = counts.all(axis=1)
        q, counts, column = q[good], counts[good], column[good]
        if not len(q):
            continue
        nearest = int(np.argmin(np.abs(joints.step(reference, q)).max(axis=1)))
        if np.abs(joints.step(known, q[nearest])).max(axis=1).min() <= SAME:
            continue
        known = np.concatenate([known, q[nearest : nearest + 1]])
        here.append(
            Nodes(
                np.array([at]),
                q[nearest : nearest + 1],
                counts[nearest : nearest + 1],
                column[nearest : nearest + 1],
                np.zeros(1),
                np.ones(1, dtype=np.bool_),
            )  # fmt: skip
        )
