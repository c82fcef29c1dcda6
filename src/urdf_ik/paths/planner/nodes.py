"""The nodes of the graph: the joint vectors at each waypoint."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.solver import Solver
from urdf_ik.paths.planner.graph import Layers
from urdf_ik.paths.planner.joint_steps import Joints
from urdf_ik.paths.planner.refinement import WIDEST
from urdf_ik.typing import Array

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

SAME = 1e-6
"""rad or m: joint vectors that differ by less in every joint are one node."""
TANGENTS = 8
"""How often the nearest solution of a singular pose is asked for at most, each time with a better reference."""
FREE = 1e-4
"""Singular values of the Jacobian below this share of the largest one are taken as zero, where tangents are drawn."""
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

    def layers(self, T: Array, twists: Array) -> Layers:
        """As layers of waypoints (m, 4, 4), with the twists (m - 1, 6) from each to the next."""
        return Layers.made(T, twists, self.at, self.q, self.counts, self.column, self.value)


def joined(parts: Sequence[Nodes]) -> Nodes:
    """All nodes of several sets."""
    columns: list[Any] = [np.concatenate(each) for each in zip(*parts, strict=True)]
    return Nodes(*columns)


def solved(
    solver: Solver,
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
        solver: the arm's solver.
        joints: how its joints turn.
        T: (m, 4, 4) m, waypoints.
        at: (k,) waypoints to solve.
        values: (k, v) of the redundancy parameter, None for an arm without one.
        outside: solutions outside the limits, too; their counts are zero where they are outside.
        centres: (k, n) joint vectors; only solutions near to them are wanted.
        near: rad that a joint that turns may be off them.
    """
    size = solver.dof * len(solver.structure.branches) * (1 if values is None else values.shape[1])
    share = max(1, _NUMBERS // size)
    return joined(
        [
            _solved(
                solver,
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
    solver: Solver,
    joints: Joints,
    T: Array,
    at: Ints,
    values: Array | None,
    outside: bool,
    centres: Array | None,
    near: float,
) -> Nodes:
    solutions = solve(solver, T[at]) if values is None else solve(solver, T[at, None], redundancy=values)
    flags = (solutions.valid | (solutions.singular << np.uint8(1))).reshape(-1)
    kept, q, counts = joints.choose(solutions.q.reshape(-1, solver.dof), flags, centres, near, outside)
    pose, column = np.divmod(kept, solutions.valid.shape[-1])
    row, value = (pose, np.zeros(len(kept))) if values is None else (pose // values.shape[1], values.reshape(-1)[pose])
    return Nodes(at[row], q, counts, column, value, flags[kept] > 1)


def at_vector(solver: Solver, joints: Joints, q: Array, at: int, value: float, column: int) -> Nodes:
    """The one node of a given joint vector (n,): no other of its images counts."""
    return Nodes(
        np.array([at]), q[None].astype(np.float64), np.ones((1, solver.dof), np.uint8), np.array([column]),
        np.array([value]), np.zeros(1, dtype=np.bool_),
    )  # fmt: skip


def with_representatives(solver: Solver, joints: Joints, T: Array, nodes: Nodes) -> Nodes:
    """The nodes, and at singular poses those that continue the nodes of the neighbouring waypoints best.

    Where a pose leaves a joint free, ``ik`` returns the representative nearest to a reference. Along each singular part
    of the path, the nodes before it are carried on from waypoint to waypoint, those after it carried back, and the
    straight ways from each node before to the nearest one after it are taken as references between.
    """
    if not nodes.singular.any():
        return nodes
    order = np.argsort(nodes.at, kind="stable")
    cuts = np.searchsorted(nodes.at[order], np.arange(1, len(T)))
    layers = [[nodes.chosen(part)] for part in np.split(order, cuts)]
    loose = np.unique(nodes.at[nodes.singular])
    for part in np.split(loose, np.flatnonzero(np.diff(loose) > 1) + 1):
        first, last = int(part[0]), int(part[-1])
        ways = [(range(first, last + 1), first - 1), (range(last, first - 1, -1), last + 1)]
        for waypoints, before in ways:
            # A path that begins or ends on a singular pose does so at one of the solutions there.
            carried = layers[before if 0 <= before < len(T) else waypoints[0]][0].q
            for at in waypoints:
                carried = _continue(solver, joints, T[at], at, layers[at], carried)
        if first > 0 and last + 1 < len(T):
            a, b = layers[first - 1][0].q, layers[last + 1][0].q
            for at, references in zip(part.tolist(), _straight_ways(joints, a, b, len(part)), strict=True):
                _continue(solver, joints, T[at], at, layers[at], references)
    return joined([part for layer in layers for part in layer])


def _straight_ways(joints: Joints, a: Array, b: Array, count: int) -> Array:
    """On the straight ways from joint vectors to the nearest of others, (count, k, n) between their ends."""
    if not len(a) or not len(b):
        return np.empty((count, 0, a.shape[1]))
    steps = joints.step(a[:, None], b)
    step = steps[np.arange(len(a)), np.abs(steps).max(axis=2).argmin(axis=1)]
    share = np.arange(1, count + 1) / (count + 1)
    return np.asarray(a + share[:, None, None] * step)


def _continue(solver: Solver, joints: Joints, T: Array, at: int, here: list[Nodes], references: Array) -> Array:
    """Add to a waypoint's nodes the solutions that are nearest to each of the references (k, n); returns these."""
    known = np.concatenate([part.q for part in here])
    carried = references[:0]
    for reference in references:
        found = _nearest_loose(solver, joints, T, at, reference)
        # None can be reached in one motion, or another reference has led there.
        if found is None or np.abs(joints.step(reference, found.q[0])).max() > WIDEST:
            continue
        if np.abs(joints.step(carried, found.q[0])).max(axis=1).min(initial=np.inf) <= SAME:
            continue
        carried = np.concatenate([carried, found.q])
        if np.abs(joints.step(known, found.q[0])).max(axis=1).min() > SAME:
            known = np.concatenate([known, found.q])
            here.append(found)
    return carried


def _nearest_loose(solver: Solver, joints: Joints, T: Array, at: int, reference: Array) -> Nodes | None:
    """Of a pose's singular solutions the nearest to a reference (n,); None where there is none.

    The representative that ``ik`` returns is near to its reference, not always the nearest: the reference is moved to
    where the tangent of the solutions comes nearest to it, until that is where the solution is.
    """
    asked, found = reference, None
    for _ in range(TANGENTS):
        solutions = solve(solver, T, asked)
        loose = (solutions.singular > 0).astype(np.uint8)
        if not loose.any():
            break
        column, q, counts = joints.choose(solutions.q, loose)
        if not len(q):
            break
        k = int(np.argmin(np.abs(joints.step(reference, q)).max(axis=1)))
        one = slice(k, k + 1)
        found = Nodes(np.array([at]), q[one], counts[one], column[one], np.zeros(1), np.ones(1, dtype=np.bool_))
        _, size, directions = np.linalg.svd(solver.chain.jacobian(q[k]), full_matrices=False)
        free = directions[size <= FREE * size[0]]
        along = free.T @ (free @ joints.step(q[k], reference))
        if np.abs(along).max(initial=0.0) <= SAME:
            break
        asked = q[k] + along
    return found
