"""The joint vectors at each waypoint that a path may pass through."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from urdf_ik.motion.path.graph import Layers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.motion.path.joints import Joints

    Array = NDArray[np.float64]
    Ints = NDArray[np.int64]
    Mask = NDArray[np.bool_]

SAME = 1e-6
"""rad or m: joint vectors that differ by less in every joint are one node."""
_NUMBERS = 1 << 22
"""Numbers in the solutions that are computed at once: 32 MB of them."""


class Nodes(NamedTuple):
    """Joint vectors at waypoints, in any order.

    Attributes:
        at: (k,) number of the waypoint.
        q: (k, n) rad or m, each joint at its least value inside the limits, among those whole turns apart.
        counts: (k, n) uint8, how many such values each joint has.
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


def solved(
    arm: Arm,
    joints: Joints,
    T: Array,
    at: Ints,
    values: Array | None,
    *,
    outside: bool = False,
    centres: Array | None = None,
    near: float = 0.0,
) -> Nodes:
    """All solutions inside the joint limits.

    Args:
        arm: the arm.
        joints: how its joints turn.
        T: (m, 4, 4) m, waypoints.
        at: (k,) waypoints to solve.
        values: (k, v) of the redundancy parameter, None for an arm without one.
        outside: solutions outside the limits, too; their counts are zero where they are outside.
        centres: (k, n) joint vectors; only solutions near to them are wanted.
        near: rad that a joint that turns may be off them.
    """
    size = arm.dof * len(arm.structure.branches) * (1 if values is None else values.shape[1])
    share = max(1, _NUMBERS // size)
    return joined(
        [
            _solved(
                arm,
                joints,
                T,
                at[k : k + share],
                None if values is None else values[k : k + share],
                outside,
                None if centres is None else centres[k : k + share],
                near,
            )  # fmt: skip
            for k in range(0, max(len(at), 1), share)
        ]
    )


def _solved(
    arm: Arm,
    joints: Joints,
    T: Array,
    at: Ints,
    values: Array | None,
    outside: bool,
    centres: Array | None,
    near: float,
) -> Nodes:
    solutions = arm.ik(T[at]) if values is None else arm.ik(T[at, None], redundancy=values)
    flags = (solutions.valid | (solutions.singular << np.uint8(1))).reshape(-1)
    kept, q, counts = joints.choose(solutions.q.reshape(-1, arm.dof), flags, centres, near, outside)
    pose, column = np.divmod(kept, solutions.valid.shape[-1])
    row, value = (pose, np.zeros(len(kept))) if values is None else (pose // values.shape[1], values.reshape(-1)[pose])
    return Nodes(at[row], q, counts, column, value, flags[kept] > 1)


def at_vector(arm: Arm, joints: Joints, q: Array, at: int, value: float, column: int) -> Nodes:
    """The one node of a given joint vector (n,): no other of its images counts."""
    return Nodes(
        np.array([at]), q[None].astype(np.float64), np.ones((1, arm.dof), np.uint8), np.array([column]),
        np.array([value]), np.zeros(1, dtype=np.bool_),
    )  # fmt: skip


def with_representatives(arm: Arm, joints: Joints, T: Array, nodes: Nodes) -> Nodes:
    """The nodes, and at singular poses those that continue the nodes of the neighbouring waypoints best.

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
        column, q, counts = joints.choose(solutions.q, loose.astype(np.uint8))
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
