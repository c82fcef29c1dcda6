"""The graph of a path: the joint vectors that reach each waypoint, and the motions between them that may follow it.

A node is a solution of a waypoint, standing for all of its images whole turns apart inside the joint limits; a state is
a node with one of these images. An edge is a motion from a node to one of the next waypoint; which image leads to which
follows from the nodes. The cheapest way from every state to the last waypoint is found by dynamic programming (Bellman
1957), in the compiled core.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik.motion.path import bisect
from urdf_ik.motion.path.joints import Joints
from urdf_ik.motion.path.straight import Tolerance, keeps_straight
from urdf_ik.motion.waypoints import twists
from urdf_ik.solutions.limits import LIMIT_TOLERANCE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm

    Array = NDArray[np.float64]
    Ints = NDArray[np.int64]
    Mask = NDArray[np.bool_]

COSTS = ("l1", "l2", "max")
"""Sum of |dq|, sum of dq^2, largest |dq|, as the compiled core counts them."""
MISMATCH = (0.05, 0.2)
"""A motion whose J dq is off the segment's twist by more (position as a share of the arm's size, rotation in rad) is no
edge. Up to terms of third order that is four times what the motion strays by in its middle."""
CHANGE = -2
"""Stands for an edge where the branch is changed."""


@dataclass
class Layers:
    """The nodes of a path, waypoint by waypoint.

    Attributes:
        T: (m, 4, 4) m, the waypoints.
        first: (m + 1,) each waypoint's first node.
        q: (N, n) rad or m, each joint at its least value inside the limits, among those whole turns apart.
        counts: (N, n) uint8, how many such values each joint has.
        column: (N,) which branch of the family it is.
        value: (N,) of the redundancy parameter, 0 for an arm without one.
    """

    T: Array
    first: Ints
    q: Array
    counts: NDArray[np.uint8]
    column: Ints
    value: Array

    @cached_property
    def twists(self) -> Array:
        """(m - 1, 6) from each waypoint to the next: displacement [m] and rotation vector [rad] in base axes."""
        return twists(self.T[:-1], self.T[1:])

    @property
    def at(self) -> Ints:
        """(N,) each node's waypoint."""
        return np.repeat(np.arange(len(self.T)), np.diff(self.first))

    @classmethod
    def made(
        cls, T: Array, at: Ints, q: Array, counts: NDArray[np.uint8], column: Ints, value: Array | None = None
    ) -> Layers:
        """From nodes in any order, each at the waypoint ``at``."""
        order = np.argsort(at, kind="stable")
        first = np.searchsorted(at[order], np.arange(len(T) + 1))
        values = np.zeros(len(q)) if value is None else value[order]
        return cls(T, first.astype(np.int64), q[order], counts[order], column[order], values)


@dataclass(frozen=True)
class Pricing:
    """What a motion costs.

    Attributes:
        kind: index in ``COSTS``.
        weights: (n,) of |dq|, of dq^2 for 'l2'.
        window: (n,) greatest |dq| between two waypoints [rad or m].
        pieces: (m - 1,) at each piece, how many equal ones the segment between two given waypoints was cut into.
    """

    kind: int
    weights: Array
    window: Array
    pieces: Array


@dataclass
class Graph:
    """Layers and the edges between them.

    Attributes:
        joints: how the joints turn.
        layers: the nodes.
        edge_first: (N + 1,) each node's first edge.
        end: (E,) int32, node that each edge leads to.
        cost: (E,) infinite where an edge is ruled out.
        node_cost: (N, states) cost of being there, infinite where that is ruled out.
        proven: (E,) whether an edge was shown to keep within the tolerance.
        between: of an edge that is no single linear motion, the shares of the segment and the joint vectors in between.
        value: (N, states) least cost from there to the last waypoint, after ``solve``, as what follows.
        edge: (N, states) the edge to take, -1 at the end, ``CHANGE`` where the branch is changed.
        jump: (m,) the state to which a change of branch after each waypoint leads.
        changes: (N, states) changes of branch on the way; None where they are not allowed.
    """

    joints: Joints
    layers: Layers
    edge_first: Ints
    end: NDArray[np.int32]
    cost: Array
    node_cost: Array
    proven: Mask
    between: dict[int, tuple[Array, Array]] = field(default_factory=dict)
    value: Array = field(init=False)
    edge: NDArray[np.int32] = field(init=False)
    jump: Ints = field(init=False)
    changes: NDArray[np.int32] | None = field(init=False, default=None)

    @classmethod
    def connected(cls, joints: Joints, layers: Layers, pricing: Pricing, mismatch: tuple[float, float]) -> Graph:
        """With every edge that may be a motion along the path: none of them proven."""
        nodes = len(layers.q)
        jacobians = joints.chain.jacobian(layers.q) if nodes else np.empty((0, 6, joints.chain.n))
        off = (mismatch[0] * joints.chain.size, mismatch[1])
        twist = layers.twists
        scale = np.where(pricing.kind == COSTS.index("l2"), pricing.pieces, 1.0)
        room = 1024 + 16 * nodes
        while True:
            first = np.empty(nodes + 1, np.int64)
            end, cost = np.empty(room, np.int32), np.empty(room)
            count = joints.core.connect(
                layers.first, layers.q, jacobians, twist, off,
                pricing.window, pricing.kind, pricing.weights, scale, first, end, cost,
            )  # fmt: skip
            if count >= 0:
                break
            room *= 4
        node_cost = np.zeros((nodes, len(joints.digits)))
        proven = np.zeros(count, dtype=np.bool_)
        return cls(joints, layers, first, end[:count].copy(), cost[:count].copy(), node_cost, proven)

    def motion(self, edges: Ints) -> tuple[Array, Array]:
        """The joint vectors at which edges (k,) start, and how the joints move along them, (k, n) each."""
        q = self.layers.q[self.start_of(edges)]
        return q, self.joints.step(q, self.layers.q[self.end[edges]])

    def pieces(self, edges: Ints) -> tuple[Array, Array, Ints]:
        """The linear motions of edges (k,): where they begin and end, (p, n) each, and whose they are (p,)."""
        q, dq = self.motion(edges)
        if not any(int(edge) in self.between for edge in edges):
            return q, q + dq, np.arange(len(edges))
        points = [
            np.vstack([a, self.between.get(int(edge), (a, a[None][:0]))[1], a + step])
            for a, step, edge in zip(q, dq, edges, strict=True)
        ]
        owner = np.repeat(np.arange(len(edges)), [len(each) - 1 for each in points])
        return np.vstack([each[:-1] for each in points]), np.vstack([each[1:] for each in points]), owner

    def prove(self, arm: Arm, edges: Ints, tolerance: Tolerance) -> Mask:
        """Rule out those of the edges (k,) that may stray from the path; (k,) whether each one keeps to it.

        Where a linear motion strays, joint vectors are put in between (``bisect``).
        """
        kept = self.proven[edges]
        undecided = np.flatnonzero(~kept & np.isfinite(self.cost[edges]))
        if not len(undecided):
            return kept
        chosen = edges[undecided]
        start, layers = self.start_of(chosen), self.layers
        q, dq = self.motion(chosen)
        at = np.searchsorted(layers.first, start, side="right") - 1
        straight = keeps_straight(self.joints.chain, q, dq, layers.T, at, layers.twists[:, 3:], tolerance)
        bent = np.flatnonzero(~straight & (np.abs(dq).max(axis=1) <= bisect.WIDEST))
        if len(bent):
            value = np.column_stack([layers.value[start[bent]], layers.value[self.end[chosen[bent]]]])
            done, between = bisect.bisected(
                arm, self.joints, q[bent], dq[bent], value, layers.T[at[bent]], layers.T[at[bent] + 1], tolerance
            )
            straight[bent[done]] = True
            for k in np.flatnonzero(done):
                self.between[int(chosen[bent[k]])] = between[k]
        self.proven[chosen] = straight
        self.cost[chosen[~straight]] = np.inf
        kept[undecided] = straight
        return kept

    def start_of(self, edges: Ints) -> Ints:
        """(k,) the nodes that edges (k,) come from."""
        return np.searchsorted(self.edge_first, edges, side="right") - 1

    def solve(self, reconfigure: bool = False) -> None:
        """Find the cheapest way from every state to the last waypoint; with changes of branch only where asked for."""
        shape = self.node_cost.shape
        self.value, self.edge = np.empty(shape), np.empty(shape, np.int32)
        self.jump = np.full(len(self.layers.T), -1, np.int64)
        self.changes = np.zeros(shape, np.int32) if reconfigure else None
        self.joints.core.cheapest(
            self.layers.first, self.layers.q, self.edge_first, self.end, self.cost, self.joints.digits,
            self.joints.strides, self.layers.counts, self.node_cost, self.value, self.changes, self.edge, self.jump,
        )  # fmt: skip

    def best_start(self, nodes: Mask | None = None) -> int | None:
        """The state of the first waypoint from which the way is cheapest; of its nodes where ``nodes`` holds."""
        value = self.value[: self.layers.first[1]].copy()
        if nodes is not None:
            value[~nodes] = np.inf
        if not np.isfinite(value).any():
            return None
        if self.changes is not None:
            changes = np.where(np.isfinite(value), self.changes[: len(value)], np.iinfo(np.int32).max)
            value[changes > changes.min()] = np.inf
        return int(np.argmin(value))

    def way(self, state: int) -> Way:
        """The cheapest way on from a state of the first waypoint."""
        m = len(self.layers.T)
        passed, taken = np.empty(m, np.int64), np.empty(m, np.int64)
        self.joints.core.way(
            self.layers.first, self.layers.q, self.edge_first, self.end, self.cost, self.joints.digits,
            self.joints.strides, self.layers.counts, self.edge, self.jump, state, passed, taken,
        )  # fmt: skip
        nodes, images = np.divmod(passed, len(self.joints.digits))
        return Way(self, nodes, images, taken[:-1])

    def reached(self, marks: NDArray[np.uint64]) -> NDArray[np.uint64]:
        """Marks (N, states) of the first waypoint's states, passed on along all edges."""
        out = np.ascontiguousarray(marks)
        self.joints.core.spread(
            self.layers.first, self.layers.q, self.edge_first, self.end, self.cost, self.joints.digits,
            self.joints.strides, self.layers.counts, self.node_cost, out,
        )  # fmt: skip
        return out


@dataclass(frozen=True)
class Way:
    """A way through a graph.

    Attributes:
        graph: the graph.
        nodes: (m,) nodes.
        images: (m,) which state of each node.
        edges: (m - 1,) edges taken; ``CHANGE`` where the branch is changed instead.
    """

    graph: Graph
    nodes: Ints
    images: Ints
    edges: Ints

    @property
    def q(self) -> Array:
        """(m, n) rad or m, without a jump by a whole turn but where the branch is changed."""
        joints, layers = self.graph.joints, self.graph.layers
        q = layers.q[self.nodes] + joints.digits[self.images] * joints.turn
        loose = (joints.turn > 0.0) & (joints.counted == 0)
        if loose.any():
            q[:, loose] = _unwound(q, self.edges == CHANGE, joints)[:, loose]
        return q

    def motion(self, place: Array) -> tuple[Array, Array]:
        """All joint vectors (k, n), those between waypoints among them, and where they are on the path (k,).

        Args:
            place: (m,) where the graph's waypoints are.
        """
        q = self.q
        if not self.graph.between:
            return q, place
        vectors, places = [q[:1]], [place[:1]]
        for k, edge in enumerate(self.edges):
            shares, between = self.graph.between.get(int(edge), (np.empty(0), q[:0]))
            turned = q[k] - self.graph.layers.q[self.nodes[k]]  # by whole turns
            vectors += [between + turned, q[k + 1 : k + 2]]
            places += [place[k] + shares * (place[k + 1] - place[k]), place[k + 1 : k + 2]]
        return np.concatenate(vectors), np.concatenate(places)


def _unwound(q: Array, changes: Mask, joints: Joints) -> Array:
    """Joints that turn without end made continuous from change to change, moved into their limits by whole turns."""
    steps = joints.step(q[:-1], q[1:])
    low, high = joints.chain.limits.T
    turn = np.where(joints.turn > 0.0, joints.turn, 1.0)
    out = q.copy()
    for part in np.split(np.arange(len(q)), np.flatnonzero(changes) + 1):
        moved = q[part[0]] + np.concatenate([np.zeros((1, q.shape[1])), np.cumsum(steps[part[:-1]], axis=0)])
        # The values as they were solved, not sums of differences.
        exact = q[part] + np.round((moved - q[part]) / turn) * turn
        below = np.where(np.isfinite(low), np.ceil((low - LIMIT_TOLERANCE - exact.min(axis=0)) / turn), -np.inf)
        above = np.where(np.isfinite(high), np.floor((high + LIMIT_TOLERANCE - exact.max(axis=0)) / turn), np.inf)
        out[part] = exact + np.maximum(np.minimum(0.0, above), below) * turn
    return out
