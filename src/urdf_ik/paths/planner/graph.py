"""The graph of a path: the joint vectors that reach each waypoint, and the motions from each to the next.

A node is a solution of a waypoint together with its images: the joint vectors whole turns apart inside the joint
limits. A state is a node with one of its images. An edge is a motion from a node to a node of the next waypoint; the
nodes determine which image leads to which. Dynamic programming (Bellman 1957) in the compiled core finds the cheapest
route from every state to the last waypoint.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from urdf_ik._core import StateGraph
from urdf_ik.ik.solutions import limits
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.paths.path_settings import COSTS, CheckedSettings
from urdf_ik.paths.planner.nodes import WIDEST_STEP, Joints, Layers
from urdf_ik.paths.planner.straightness import bisected, keeps_straight
from urdf_ik.typing import Array

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

MISMATCH = (0.05, 0.2)
"""Largest difference of J dq from the twist of the segment: position as a fraction of the arm's size, rotation [rad].

Up to third order this is four times the distance of the motion's middle from the segment.
"""
EQUAL_COST = 1e-9
"""Costs of two images that differ by less than this fraction are equal."""
CHANGE = -2
"""Number of an edge at which the branch changes."""


@dataclass
class Graph:
    """Layers and the edges between them.

    Attributes:
        settings: of the path.
        layers: the nodes.
        edge_first: (N + 1,) index of each node's first edge.
        end: (E,) int32, node at the end of each edge.
        cost: (E,) infinite where an edge is ruled out.
        node_cost: (N,) cost of a node, infinite where it is ruled out.
        proven: (E,) whether an edge was proven to stay within the tolerance.
        image_cost: (N, states) additional cost of an image of a node; None where there is none.
        between: shares of the segment and joint vectors inserted there, for edges that are not a single linear motion.
    """

    settings: CheckedSettings
    layers: Layers
    edge_first: Ints
    end: NDArray[np.int32]
    cost: Array
    node_cost: Array
    proven: Mask
    image_cost: Array | None = None
    between: dict[int, tuple[Array, Array]] = field(default_factory=dict)
    _routes: "_Routes | None" = None
    _on_circle: "_Routes | None" = None

    @property
    def joints(self) -> Joints:
        """The joints of the arm."""
        return self.settings.joints

    @classmethod
    def connected(
        cls, settings: CheckedSettings, layers: Layers, pieces: Array, window: Array, mismatch: tuple[float, float]
    ) -> "Graph":
        """A graph with every edge that may be a motion along the path, none of them proven.

        Args:
            settings: of the path.
            layers: the nodes.
            pieces: (m - 1,) number of pieces of the given segment that each piece is part of.
            window: (n,) largest |dq| of an edge [rad or m].
            mismatch: see ``MISMATCH``.
        """
        joints, free, nodes = settings.joints, settings.solver.free_axis, len(layers.q)
        jacobians = joints.chain.jacobian(layers.q) if nodes else np.empty((0, 6, joints.chain.n))
        off = (mismatch[0] * joints.chain.size, mismatch[1])
        twist = layers.twists
        if free is not None and nodes:
            # The axis has the same direction at every node of a waypoint.
            R = layers.T[:, :3, :3]
            jacobians = np.ascontiguousarray(free.reduced(joints.chain.fk(layers.q)[:, :3, :3], jacobians))
            twist = np.ascontiguousarray(free.reduced(R[:-1], twist[..., None])[..., 0])
        scale = np.where(settings.kind == COSTS.index("l2"), pieces, 1.0)
        first = np.empty(nodes + 1, np.int64)
        room, count = 1024 + 64 * nodes, -1
        while count < 0:  # the edges did not fit
            end, cost = np.empty(room, np.int32), np.empty(room)
            count = joints.core.connect(
                layers.first, layers.q, jacobians, twist, off, window, settings.kind, settings.weights, scale,
                first, end, cost,
            )  # fmt: skip
            room *= 4
        proven = np.zeros(count, dtype=np.bool_)
        return cls(settings, layers, first, end[:count].copy(), cost[:count].copy(), np.zeros(nodes), proven)

    def start_of(self, edges: Ints) -> Ints:
        """Start nodes (k,) of edges (k,)."""
        return np.searchsorted(self.edge_first, edges, side="right") - 1

    def motion(self, edges: Ints) -> tuple[Array, Array]:
        """Joint vectors at the start of edges (k,), and the motions along them, (k, n) each."""
        q = self.layers.q[self.start_of(edges)]
        return q, self.joints.step(q, self.layers.q[self.end[edges]])

    def pieces(self, edges: Ints) -> tuple[Array, Array, Ints]:
        """The linear motions of edges (k,): starts and ends (p, n), and the index of each one's edge (p,)."""
        q, dq = self.motion(edges)
        if self.between.keys().isdisjoint(edges.tolist()):
            return q, q + dq, np.arange(len(edges))
        points = [
            np.vstack([a, self.between.get(int(edge), (a, a[None][:0]))[1], a + step])
            for a, step, edge in zip(q, dq, edges, strict=True)
        ]
        owner = np.repeat(np.arange(len(edges)), [len(row) - 1 for row in points])
        return np.vstack([row[:-1] for row in points]), np.vstack([row[1:] for row in points]), owner

    def prove(self, edges: Ints) -> Mask:
        """Rule out the edges (k,) that may leave the tolerance; returns which ones stay within it (k,).

        Where a linear motion leaves it, joint vectors are inserted (``bisected``).
        """
        kept = self.proven[edges]
        undecided = np.flatnonzero(~kept & np.isfinite(self.cost[edges]))
        if not len(undecided):
            return kept
        solver, tolerance, layers = self.settings.solver, self.settings.tolerance, self.layers
        chosen = edges[undecided]
        start = self.start_of(chosen)
        q, dq = self.motion(chosen)
        waypoint = np.searchsorted(layers.first, start, side="right") - 1
        turns = layers.twists[:, 3:]
        straight = keeps_straight(solver, q, dq, layers.T, waypoint, turns, tolerance)
        bent = np.flatnonzero(~straight & (np.abs(dq).max(axis=1) <= WIDEST_STEP))
        if len(bent):
            value = np.column_stack([layers.value[start[bent]], layers.value[self.end[chosen[bent]]]])
            T0, T1 = layers.T[waypoint[bent]], layers.T[waypoint[bent] + 1]
            done, between = bisected(solver, self.joints, q[bent], dq[bent], value, T0, T1, tolerance)
            straight[bent[done]] = True
            for k in np.flatnonzero(done):
                self.between[int(chosen[bent[k]])] = between[k]
        self.proven[chosen] = straight
        self.cost[chosen[~straight]] = np.inf
        kept[undecided] = straight
        return kept

    def solve(self) -> None:
        """Find the cheapest route from every state to the last waypoint.

        Without ``image_cost`` the cost of a route does not depend on its images. So the cheapest route of joints
        without limits is looked for first: if one of its images stays inside the limits, it is the cheapest of all.
        """
        self._routes, self._on_circle = None, None
        if len(self.joints.digits) > 1 and self.image_cost is None and not self.settings.reconfigure:
            self._on_circle = _Routes.cheapest(self, images=False)
        else:
            self._routes = _Routes.cheapest(self)

    def best_start(self, nodes: Mask | None = None) -> int | None:
        """The state of the first waypoint whose route is cheapest; only nodes of the mask ``nodes`` count."""
        if self._routes is None:
            assert self._on_circle is not None  # solve() sets one of both
            node = self._on_circle.best_start(nodes)
            if node is None:
                return None
            image = self._image(self._on_circle.traced(node)[0])
            if image is not None:
                return node * len(self.joints.digits) + image
            self._routes = _Routes.cheapest(self)
        return self._routes.best_start(nodes)

    def route(self, state: int) -> "Route":
        """The cheapest route from a state that ``best_start`` returned."""
        states = len(self.joints.digits)
        if self._routes is not None:
            passed, taken = self._routes.traced(state)
            nodes, images = np.divmod(passed, states)
            return Route(self, nodes, images, taken[:-1], float(self._routes.value.flat[state]))
        assert self._on_circle is not None  # solve() sets one of both
        node, image = divmod(state, states)
        nodes, taken = self._on_circle.traced(node)
        images = image + self._images_ahead(nodes) @ self.joints.strides
        return Route(self, nodes, images, taken[:-1], float(self._on_circle.value.flat[node]))

    def _images_ahead(self, nodes: Ints) -> Ints:
        """(m, n) by how many images each joint is ahead of its start, along nodes (m,)."""
        q, counted = self.layers.q[nodes], self.joints.counted > 0
        ahead = np.zeros(q.shape, np.int64)
        turns = np.round((q[:-1, counted] - q[1:, counted]) / self.joints.turn[counted])
        ahead[1:, counted] = np.cumsum(turns, axis=0)
        return ahead

    def _image(self, nodes: Ints) -> int | None:
        """The start image, nearest to the middle of the limits, with which a route (m,) stays inside them, or None."""
        ahead = self._images_ahead(nodes)
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
        """(N, states) cost of each state; without images (N, 1), infinite for nodes outside the limits."""
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
        self.states(self.joints.digits, self.joints.strides).spread(self.state_costs(), out)
        return out

    def states(self, digits: NDArray[np.uint8], strides: Ints) -> StateGraph:
        """The states of these images, as the compiled core has them."""
        of = self.layers
        arrays = of.first, of.q, self.edge_first, self.end, self.cost, digits, strides, of.counts
        return StateGraph(self.joints.core, arrays)


@dataclass(frozen=True)
class _Routes:
    """The cheapest routes of a graph, from every state to the last waypoint.

    Attributes:
        graph: the graph.
        digits: (states, n) number of each joint's image in each state.
        core: its states, as the compiled core has them.
        value: (N, states) cost of the route.
        changes: (N, states) changes of branch on it; None where they are not allowed.
        edge: (N, states) the edge to take.
        jump: (m,) the state to which a change of branch leads.
    """

    graph: Graph
    digits: NDArray[np.uint8]
    core: StateGraph
    value: Array
    changes: NDArray[np.int32] | None
    edge: NDArray[np.int32]
    jump: Ints

    @classmethod
    def cheapest(cls, graph: Graph, *, images: bool = True) -> "_Routes":
        """Solve a graph; without ``images`` as if its joints had no limits."""
        joints = graph.joints
        digits, strides = (joints.digits, joints.strides) if images else (joints.digits[:1], 0 * joints.strides)
        node = graph.state_costs(images)
        value, edge = np.empty(node.shape), np.empty(node.shape, np.int32)
        jump = np.full(len(graph.layers.T), -1, np.int64)
        changes = np.zeros(node.shape, np.int32) if graph.settings.reconfigure else None
        core = graph.states(digits, strides)
        core.cheapest(node, value, changes, edge, jump)
        return cls(graph, digits, core, value, changes, edge, jump)

    def best_start(self, nodes: Mask | None) -> int | None:
        """See :meth:`Graph.best_start`; of images that cost the same, the one nearest to the middle of the limits."""
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
        equal = value[node] <= value[node].min() * (1.0 + EQUAL_COST) + EQUAL_COST
        return int(node * value.shape[1] + np.argmin(np.where(equal, off, np.inf)))

    def traced(self, state: int) -> tuple[Ints, Ints]:
        """States (m,) and edges (m,) of the route from a state of the first waypoint."""
        passed, taken = np.empty(len(self.jump), np.int64), np.empty(len(self.jump), np.int64)
        self.core.way(self.edge, self.jump, state, passed, taken)
        return passed, taken


@dataclass(frozen=True)
class Route:
    """A route through a graph.

    Attributes:
        graph: the graph.
        nodes: (m,) nodes.
        images: (m,) state of each node.
        edges: (m - 1,) edges; ``CHANGE`` where the branch changes.
        cost: the sum over edges and nodes.
    """

    graph: Graph
    nodes: Ints
    images: Ints
    edges: Ints
    cost: float

    @property
    def q(self) -> Array:
        """(m, n) rad or m, continuous except where the branch changes."""
        joints, layers = self.graph.joints, self.graph.layers
        q = layers.q[self.nodes] + joints.digits[self.images] * joints.turn
        uncounted = (joints.turn > 0.0) & (joints.counted == 0)
        if uncounted.any():
            q[:, uncounted] = _unwound(q, self.edges == CHANGE, joints)[:, uncounted]
        return q

    def motion(self, place: Array) -> tuple[Array, Array]:
        """All joint vectors (k, n), those inserted between waypoints included, and their places on the path (k,).

        Args:
            place: (m,) places of the graph's waypoints.
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
    """Make turning joints continuous from change to change, and shift them into their limits by whole turns."""
    steps = joints.step(q[:-1], q[1:])
    low, high = joints.chain.limits.T
    turn = np.where(joints.turn > 0.0, joints.turn, 1.0)
    out = q.copy()
    for part in np.split(np.arange(len(q)), np.flatnonzero(changes) + 1):
        moved = q[part[0]] + np.concatenate([np.zeros((1, q.shape[1])), np.cumsum(steps[part[:-1]], axis=0)])
        # Solutions shifted by whole turns, not sums of rounded differences.
        exact = q[part] + np.round((moved - q[part]) / turn) * turn
        below = np.where(np.isfinite(low), np.ceil((low - LIMIT_TOLERANCE - exact.min(axis=0)) / turn), -np.inf)
        above = np.where(np.isfinite(high), np.floor((high + LIMIT_TOLERANCE - exact.max(axis=0)) / turn), np.inf)
        out[part] = exact + np.maximum(np.minimum(0.0, above), below) * turn
    return out
