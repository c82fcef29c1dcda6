"""The graph of a path: the joint vectors that reach each waypoint, and the motions between them that may follow it.

A node is a solution of a waypoint, standing for all of its images whole turns apart inside the joint limits; a state is
a node with one of these images. An edge is a motion from a node to one of the next waypoint; which image leads to which
follows from the nodes. The cheapest way from every state to the last waypoint is found by dynamic programming (Bellman
1957), in the compiled core.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.solutions import limits
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.paths.planner import refinement
from urdf_ik.paths.planner.joint_steps import Joints
from urdf_ik.paths.planner.straightness import Tolerance, keeps_straight
from urdf_ik.typing import Array

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

COSTS = ("l1", "l2", "max")
"""Sum of |dq|, sum of dq^2, largest |dq|, as the compiled core counts them."""
MISMATCH = (0.05, 0.2)
"""A motion whose J dq is off the segment's twist by more (position as a share of the arm's size, rotation in rad) is no
edge. Up to terms of third order that is four times what the motion strays by in its middle."""
EQUAL = 1e-9
"""Share by which the costs of two images' ways may differ and count as equal."""
CHANGE = -2
"""Stands for an edge where the branch is changed."""


@dataclass
class Layers:
    """The nodes of a path, waypoint by waypoint.

    Attributes:
        T: (m, 4, 4) m, the waypoints.
        twists: (m - 1, 6) from each waypoint to the next: displacement [m] and rotation vector [rad] in base axes.
        first: (m + 1,) each waypoint's first node.
        q: (N, n) rad or m, each joint at its least value inside the limits, among those whole turns apart.
        counts: (N, n) uint8, how many such values each joint has.
        column: (N,) which branch of the family it is.
        value: (N,) of the redundancy parameter, 0 for an arm without one.
    """

    T: Array
    twists: Array
    first: Ints
    q: Array
    counts: NDArray[np.uint8]
    column: Ints
    value: Array

    @property
    def at(self) -> Ints:
        """(N,) each node's waypoint."""
        return np.repeat(np.arange(len(self.T)), np.diff(self.first))

    @classmethod
    def made(
        cls, T: Array, twists: Array, at: Ints, q: Array, counts: NDArray[np.uint8], column: Ints, value: Array
    ) -> Layers:
        """From nodes in any order, each at the waypoint ``at``."""
        order = np.argsort(at, kind="stable")
        first = np.searchsorted(at[order], np.arange(len(T) + 1))
        return cls(T, twists, first.astype(np.int64), q[order], counts[order], column[order], value[order])


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
        node_cost: (N,) of being at a node, infinite where it is ruled out.
        proven: (E,) whether an edge was shown to keep within the tolerance.
        image_cost: (N, states) of being at an image of a node; None where all cost the same.
        between: of an edge that is no single linear motion, the shares of the segment and the joint vectors in between.
    """

    joints: Joints
    layers: Layers
    edge_first: Ints
    end: NDArray[np.int32]
    cost: Array
    node_cost: Array
    proven: Mask
    image_cost: Array | None = None
    between: dict[int, tuple[Array, Array]] = field(default_factory=dict)
    _reconfigure: bool = False
    _ways: Ways | None = None
    _on_circle: Ways | None = None

    @classmethod
    def connected(
        cls,
        joints: Joints,
        layers: Layers,
        pricing: Pricing,
        mismatch: tuple[float, float],
        free: FreeAxis | None = None,
    ) -> Graph:
        """With every edge that may be a motion along the path: none of them proven."""
        nodes = len(layers.q)
        jacobians = joints.chain.jacobian(layers.q) if nodes else np.empty((0, 6, joints.chain.n))
        off = (mismatch[0] * joints.chain.size, mismatch[1])
        twist = layers.twists
        if free is not None and nodes:
            # The axis' direction is the same at every node of a waypoint.
            R = layers.T[:, :3, :3]
            jacobians = np.ascontiguousarray(free.reduced(joints.chain.fk(layers.q)[:, :3, :3], jacobians))
            twist = np.ascontiguousarray(free.reduced(R[:-1], twist[..., None])[..., 0])
        scale = np.where(pricing.kind == COSTS.index("l2"), pricing.pieces, 1.0)
        room = 1024 + 64 * nodes
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
        proven = np.zeros(count, dtype=np.bool_)
        return cls(joints, layers, first, end[:count].copy(), cost[:count].copy(), np.zeros(nodes), proven)

    def motion(self, edges: Ints) -> tuple[Array, Array]:
        """The joint vectors at which edges (k,) start, and how the joints move along them, (k, n) each."""
        q = self.layers.q[self.start_of(edges)]
        return q, self.joints.step(q, self.layers.q[self.end[edges]])

    def pieces(self, edges: Ints) -> tuple[Array, Array, Ints]:
        """The linear motions of edges (k,): where they begin and end, (p, n) each, and whose they are (p,)."""
        q, dq = self.motion(edges)
        if self.between.keys().isdisjoint(edges.tolist()):
            return q, q + dq, np.arange(len(edges))
        points = [
            np.vstack([a, self.between.get(int(edge), (a, a[None][:0]))[1], a + step])
            for a, step, edge in zip(q, dq, edges, strict=True)
        ]
        owner = np.repeat(np.arange(len(edges)), [len(each) - 1 for each in points])
        return np.vstack([each[:-1] for each in points]), np.vstack([each[1:] for each in points]), owner

    def prove(self, solver: Solver, edges: Ints, tolerance: Tolerance) -> Mask:
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
        turns, free = layers.twists[:, 3:], solver.free_axis
        straight = keeps_straight(self.joints.chain, q, dq, layers.T, at, turns, tolerance, free)
        bent = np.flatnonzero(~straight & (np.abs(dq).max(axis=1) <= refinement.WIDEST))
        if len(bent):
            value = np.column_stack([layers.value[start[bent]], layers.value[self.end[chosen[bent]]]])
            done, between = refinement.bisected(
                solver, self.joints, q[bent], dq[bent], value, layers.T[at[bent]], layers.T[at[bent] + 1], tolerance
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
        """Find the cheapest way from every state to the last waypoint; with changes of branch only where asked for.

        What a way costs does not depend on its images but where ``image_cost`` says so. The cheapest way of joints that
        turn without end is then the cheapest of all if one of its images stays inside the limits; only where none does,
        all images are looked at.
        """
        self._reconfigure, self._ways, self._on_circle = reconfigure, None, None
        if len(self.joints.digits) > 1 and self.image_cost is None and not reconfigure:
            self._on_circle = Ways.cheapest(self, images=False)
        else:
            self._ways = Ways.cheapest(self, reconfigure=reconfigure)

    def best_start(self, nodes: Mask | None = None) -> int | None:
        """The state of the first waypoint from which the way is cheapest; of its nodes where ``nodes`` holds."""
        if self._ways is None:
            assert self._on_circle is not None  # one of both is there after solve()
            node = self._on_circle.best_start(nodes)
            if node is None:
                return None
            image = self._image(self._on_circle.traced(node)[0])
            if image is not None:
                return node * len(self.joints.digits) + image
            self._ways = Ways.cheapest(self)
        return self._ways.best_start(nodes)

    def way(self, state: int) -> Way:
        """The cheapest way on from a state of the first waypoint that ``best_start`` gave."""
        states = len(self.joints.digits)
        if self._ways is not None:
            passed, taken = self._ways.traced(state)
            nodes, images = np.divmod(passed, states)
            return Way(self, nodes, images, taken[:-1], self._ways.cost_of(state))
        assert self._on_circle is not None  # one of both is there after solve()
        node, image = divmod(state, states)
        nodes, taken = self._on_circle.traced(node)
        images = image + self._ahead(nodes) @ self.joints.strides
        return Way(self, nodes, images, taken[:-1], self._on_circle.cost_of(node))

    def _ahead(self, nodes: Ints) -> Ints:
        """(m, n) by how many images a way along nodes (m,) is ahead of where it began, joint by joint."""
        q, counted = self.layers.q[nodes], self.joints.counted > 0
        ahead = np.zeros(q.shape, np.int64)
        turns = np.round((q[:-1, counted] - q[1:, counted]) / self.joints.turn[counted])
        ahead[1:, counted] = np.cumsum(turns, axis=0)
        return ahead

    def _image(self, nodes: Ints) -> int | None:
        """The image that a way along nodes (m,) can begin at and stay inside the limits, nearest to their middle."""
        ahead = self._ahead(nodes)
        low, high = -ahead.min(axis=0), (self.layers.counts[nodes] - 1 - ahead).min(axis=0)
        if not (low <= high).all():
            return None
        counted = self.joints.counted > 0
        turns = (limits.middle(self.joints.chain.limits) - self.layers.q[nodes[0]]) / np.where(
            counted, self.joints.turn, 1.0
        )
        wanted = np.where(counted, np.clip(np.round(turns), low, high), 0.0)
        return int(wanted @ self.joints.strides)

    def state_costs(self, images: bool = True) -> Array:
        """(N, states) of being at each state; (N, 1) where images do not count, infinite for nodes that have none."""
        if not images:
            inside = (self.layers.counts > 0).all(axis=1)
            return np.where(inside, self.node_cost, np.inf)[:, None]
        more = 0.0 if self.image_cost is None else self.image_cost
        return np.ascontiguousarray(
            np.broadcast_to(self.node_cost[:, None] + more, (len(self.node_cost), len(self.joints.digits)))
        )

    def reached(self, marks: NDArray[np.uint64]) -> NDArray[np.uint64]:
        """Marks (N, states) of the first waypoint's states, passed on along all edges."""
        out = np.ascontiguousarray(marks)
        self.joints.core.spread(
            self.layers.first, self.layers.q, self.edge_first, self.end, self.cost, self.joints.digits,
            self.joints.strides, self.layers.counts, self.state_costs(), out,
        )  # fmt: skip
        return out


@dataclass(frozen=True)
class Ways:
    """The cheapest ways through a graph, from every state to the last waypoint.

    Attributes:
        graph: the graph.
        digits: (states, n) which image each joint has in each state.
        strides: (n,) what one image more adds to a state's number.
        value: (N, states) what the way costs.
        changes: (N, states) changes of branch on it; None where there may be none.
        edge: (N, states) the edge to take.
        jump: (m,) the state that a change of branch leads to.
    """

    graph: Graph
    digits: NDArray[np.uint8]
    strides: Ints
    value: Array
    changes: NDArray[np.int32] | None
    edge: NDArray[np.int32]
    jump: Ints

    @classmethod
    def cheapest(cls, graph: Graph, *, images: bool = True, reconfigure: bool = False) -> Ways:
        """Those of a graph; without ``images`` as if its joints turned without end."""
        joints, layers = graph.joints, graph.layers
        digits, strides = (joints.digits, joints.strides) if images else (joints.digits[:1], 0 * joints.strides)
        node = graph.state_costs(images)
        value, edge = np.empty(node.shape), np.empty(node.shape, np.int32)
        jump = np.full(len(layers.T), -1, np.int64)
        changes = np.zeros(node.shape, np.int32) if reconfigure else None
        joints.core.cheapest(
            layers.first, layers.q, graph.edge_first, graph.end, graph.cost, digits, strides, layers.counts,
            node, value, changes, edge, jump,
        )  # fmt: skip
        return cls(graph, digits, strides, value, changes, edge, jump)

    def best_start(self, nodes: Mask | None) -> int | None:
        """The state of the first waypoint from which the way is cheapest; of its nodes where ``nodes`` holds.

        Of images that are equally good, the one nearest to the middle of the limits.
        """
        value = self.value[: self.graph.layers.first[1]].copy()
        if nodes is not None:
            value[~nodes] = np.inf
        if not np.isfinite(value).any():
            return None
        if self.changes is not None:
            changes = np.where(np.isfinite(value), self.changes[: len(value)], np.iinfo(np.int32).max)
            value[changes > changes.min()] = np.inf
        node = int(np.argmin(value.min(axis=1)))
        joints, layers = self.graph.joints, self.graph.layers
        off = np.abs(layers.q[node] + self.digits * joints.turn - limits.middle(joints.chain.limits)).sum(axis=1)
        equal = value[node] <= value[node].min() * (1.0 + EQUAL) + EQUAL
        return int(node * value.shape[1] + np.argmin(np.where(equal, off, np.inf)))

    def cost_of(self, state: int) -> float:
        """What the way from a state costs."""
        return float(self.value.reshape(-1)[state])

    def traced(self, state: int) -> tuple[Ints, Ints]:
        """The states (m,) that the way from one of the first waypoint passes, and the edges (m,) it takes."""
        graph, layers = self.graph, self.graph.layers
        passed, taken = np.empty(len(layers.T), np.int64), np.empty(len(layers.T), np.int64)
        graph.joints.core.way(
            layers.first, layers.q, graph.edge_first, graph.end, graph.cost, self.digits, self.strides,
            layers.counts, self.edge, self.jump, state, passed, taken,
        )  # fmt: skip
        return passed, taken


@dataclass(frozen=True)
class Way:
    """A way through a graph.

    Attributes:
        graph: the graph.
        nodes: (m,) nodes.
        images: (m,) which state of each node.
        edges: (m - 1,) edges taken; ``CHANGE`` where the branch is changed instead.
        cost: of all of it.
    """

    graph: Graph
    nodes: Ints
    images: Ints
    edges: Ints
    cost: float

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
        q, known = self.q, self.graph.between
        cut = [k for k, edge in enumerate(self.edges.tolist()) if edge in known]
        vectors, places, begin = [], [], 0
        for k in cut:
            shares, between = known[int(self.edges[k])]
            turned = q[k] - self.graph.layers.q[self.nodes[k]]  # by whole turns
            vectors += [q[begin : k + 1], between + turned]
            places += [place[begin : k + 1], place[k] + shares * (place[k + 1] - place[k])]
            begin = k + 1
        return np.concatenate([*vectors, q[begin:]]), np.concatenate([*places, place[begin:]])


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
