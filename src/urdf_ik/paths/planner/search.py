"""The cheapest route through a graph that stays on the path and clear of obstacles.

Motions are proven and checked for contacts only where the cheapest route passes. What fails is ruled out, and the
cheapest route is found again. Ruling out makes no other route cheaper, so the first one that passes is the best (Dellin
and Srinivasa, "A unifying formalism for shortest path problems with expensive edge evaluations via lazy best-first
search", ICAPS 2016).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.paths.planner.graph import CHANGE, Graph, Route
from urdf_ik.typing import Array

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Search:
    """Routes through one graph.

    Attributes:
        graph: what was ruled out in it remains ruled out.
        hits: (N,) nodes in contact.
        swept: (E,) edges whose motion makes contact although their ends do not.
    """

    def __init__(self, graph: Graph, *, proves: bool) -> None:
        """Search a graph.

        Args:
            graph: its costs are changed.
            proves: whether motions are proven to stay on the path and free of contacts; otherwise only joint vectors
                are checked, for contacts.
        """
        self.graph, self.proves = graph, proves
        self.obstacles, self._watch = graph.settings.obstacles, graph.settings.watch
        self.hits = np.zeros(len(graph.layers.q), dtype=np.bool_)
        self.swept = np.zeros(len(graph.end), dtype=np.bool_)
        self._clear, self._clear_edges = self.hits.copy(), self.swept.copy()
        self._rounds = 0
        self._stale = True

    def best(self, nodes: Mask | None = None) -> Route | None:
        """The cheapest route that passes; only start nodes of the mask ``nodes`` count."""
        while True:
            self._watch.check()
            if self._stale:
                self.graph.solve()
                self._stale = False
            start = self.graph.best_start(nodes)
            if start is None:
                return None
            route = self.graph.route(start)
            if self._passes(route):
                return route
            self._stale = True
            self._rounds += 1

    def _passes(self, route: Route) -> bool:
        edges = route.edges[route.edges != CHANGE]
        if self.proves:
            straight = self.graph.prove(edges)
            if not straight.all():
                self._prove_around(edges[~straight])
                return False
        if self.obstacles is None:
            return True
        return self._clear_nodes(route.nodes) and (not self.proves or self._clear_motions(edges))

    def _prove_around(self, failed: Ints) -> None:
        """Prove all edges of the segments of failed edges: the next route is likely to take one of them."""
        layers, first = self.graph.layers, self.graph.edge_first
        segments = np.unique(np.searchsorted(layers.first, self.graph.start_of(failed), side="right") - 1)
        for k in segments:
            self.graph.prove(np.arange(first[layers.first[k]], first[layers.first[k + 1]]))

    def _clear_nodes(self, nodes: Ints) -> bool:
        """Whether all nodes are free of contact; if not, nodes near those in contact are checked as well."""
        if self.check_nodes(nodes):
            return True
        layers = self.graph.layers
        near = []
        for node in nodes[self.hits[nodes]]:
            same = self._same_branch(node)
            near.append(self._nearest(same, np.abs(layers.value[same] - layers.value[node])))
        if near:
            self.check_nodes(np.unique(np.concatenate(near)))
        return False

    def check_nodes(self, nodes: Ints) -> bool:
        """Whether nodes are free of contact; those that are not are closed."""
        assert self.obstacles is not None  # called only with obstacles
        unknown = np.unique(nodes[~self._clear[nodes] & ~self.hits[nodes]])
        free = self.obstacles.free(self.graph.layers.q[unknown])
        self._clear[unknown[free]] = True
        self.hits[unknown[~free]] = True
        self.graph.node_cost[unknown[~free]] = np.inf
        return not self.hits[nodes].any()

    def _clear_motions(self, edges: Ints) -> bool:
        """Whether all motions are free of contact; if not, motions near those in contact are checked as well."""
        if self._check_motions(edges):
            return True
        graph, layers = self.graph, self.graph.layers
        near = [np.empty(0, np.int64)]
        for edge in edges[self.swept[edges]]:
            node = graph.start_of(edge)
            same = self._same_branch(node, edges=True)
            same = same[np.isfinite(graph.cost[same])]
            distance = np.abs(layers.value[graph.start_of(same)] - layers.value[node])
            distance += np.abs(layers.value[graph.end[same]] - layers.value[graph.end[edge]])
            near.append(self._nearest(same, distance))
        around = np.unique(np.concatenate(near))
        self._check_motions(around[graph.prove(around)])
        return False

    def _check_motions(self, edges: Ints) -> bool:
        assert self.obstacles is not None  # called only with obstacles
        unknown = edges[~self._clear_edges[edges]]
        q0, q1, edge = self.graph.pieces(unknown)
        free = np.ones(len(unknown), dtype=np.bool_)
        free[edge[~self.obstacles.motions_free(q0, q1)]] = False
        self._clear_edges[unknown[free]] = True
        self.swept[unknown[~free]] = True
        self.graph.cost[unknown[~free]] = np.inf
        return bool(free.all())

    def _same_branch(self, node: Any, *, edges: bool = False) -> Ints:
        """All nodes of a node's waypoint and branch, or the edges from them."""
        layers, first = self.graph.layers, self.graph.edge_first
        waypoint = int(np.searchsorted(layers.first, node, side="right")) - 1
        low, high = layers.first[waypoint : waypoint + 2]
        items = np.arange(first[low], first[high]) if edges else np.arange(low, high)
        nodes = self.graph.start_of(items) if edges else items
        return np.asarray(items[layers.column[nodes] == layers.column[node]])

    def _nearest(self, items: Ints, distance: Array) -> Ints:
        """The nearest of some items: two in the first round, in each later one twice as many."""
        return np.asarray(items[np.argsort(distance, kind="stable")[: 2 << self._rounds]])
