"""The cheapest way through a graph that keeps to the path and clear of obstacles.

Motions are proven and obstacles are asked about only where the cheapest way passes: what fails is ruled out, and the
way is found anew. Ruling out makes no other way cheaper, so the first one that passes is the best of all (Dellin and
Srinivasa, "A unifying formalism for shortest path problems with expensive edge evaluations via lazy best-first
search", ICAPS 2016).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.solver import Solver
from urdf_ik.paths.planner.graph import CHANGE, Graph, Way
from urdf_ik.paths.planner.obstacles import Obstacles
from urdf_ik.paths.planner.straightness import Tolerance
from urdf_ik.support.watch import Watch

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Search:
    """Ways through one graph.

    Attributes:
        graph: what was ruled out so far stays so.
        hits: nodes that touch something.
        swept: edges whose motion touches something although their ends do not.
    """

    def __init__(
        self,
        solver: Solver,
        graph: Graph,
        tolerance: Tolerance | None,
        obstacles: Obstacles | None,
        watch: Watch,
        *,
        reconfigure: bool = False,
    ) -> None:
        """Search a graph.

        Args:
            solver: the arm's solver.
            graph: its costs are changed.
            tolerance: that motions must keep to; None: they are neither proven nor asked about contacts, only joint
                vectors are.
            obstacles: what to stay clear of.
            watch: the time limit of the search.
            reconfigure: whether the branch may be changed, as rarely as possible.
        """
        self.solver, self.graph = solver, graph
        self.tolerance, self.obstacles, self.reconfigure = tolerance, obstacles, reconfigure
        self._watch = watch
        self.hits = np.zeros(len(graph.layers.q), dtype=np.bool_)
        self.swept = np.zeros(len(graph.end), dtype=np.bool_)
        self._clear = self.hits.copy()
        self._clear_edges = self.swept.copy()
        self._rounds = 0
        self._stale = True

    def best(self, nodes: Mask | None = None) -> Way | None:
        """The cheapest way that passes; of those that begin at the first waypoint's nodes where ``nodes`` holds.

        Raises:
            TimeIsUp: the time limit has passed.
        """
        while True:
            self._watch.check()
            if self._stale:
                self.graph.solve(self.reconfigure)
                self._stale = False
            start = self.graph.best_start(nodes)
            if start is None:
                return None
            way = self.graph.way(start)
            if self._passes(way):
                return way
            self._stale = True
            self._rounds += 1

    def _passes(self, way: Way) -> bool:
        edges = way.edges[way.edges != CHANGE]
        if self.tolerance is not None:
            straight = self.graph.prove(self.solver, edges, self.tolerance)
            if not straight.all():
                self._prove_around(edges[~straight])
                return False
        if self.obstacles is None:
            return True
        return self._clear_nodes(way.nodes) and (self.tolerance is None or self._clear_motions(edges))

    def _prove_around(self, failed: Ints) -> None:
        """Prove all edges of the segments in which one failed: the next cheapest way most likely takes one of them."""
        assert self.tolerance is not None  # who proves nothing finds nothing failing
        layers, first = self.graph.layers, self.graph.edge_first
        segments = np.unique(
            np.searchsorted(layers.first, np.searchsorted(first, failed, side="right") - 1, side="right") - 1
        )
        for k in segments:
            self.graph.prove(self.solver, np.arange(first[layers.first[k]], first[layers.first[k + 1]]), self.tolerance)

    def _clear_nodes(self, nodes: Ints) -> bool:
        """Whether all of these nodes are clear; where some are not, those beside them are asked, too."""
        if self._ask(nodes):
            return True
        around = self._beside(nodes[self.hits[nodes]])
        if len(around):
            self._ask(around)
        return False

    def _ask(self, nodes: Ints) -> bool:
        assert self.obstacles is not None  # who has none asks nothing
        asked = np.unique(nodes[~self._clear[nodes] & ~self.hits[nodes]])
        free = self.obstacles.free(self.graph.layers.q[asked])
        self._clear[asked[free]] = True
        self.hits[asked[~free]] = True
        self.graph.node_cost[asked[~free]] = np.inf
        return not self.hits[nodes].any()

    def _beside(self, nodes: Ints) -> Ints:
        """Nodes of the same waypoint and branch as those that touch something, more of them in every round."""
        layers = self.graph.layers
        found = []
        for node in nodes:
            at = int(np.searchsorted(layers.first, node, side="right")) - 1
            same = np.arange(layers.first[at], layers.first[at + 1])
            same = same[layers.column[same] == layers.column[node]]
            apart = np.abs(layers.value[same] - layers.value[node])
            found.append(same[np.argsort(apart, kind="stable")[: 2 << min(self._rounds, 10)]])
        return np.unique(np.concatenate(found)) if found else np.empty(0, np.int64)

    def _clear_motions(self, edges: Ints) -> bool:
        """Whether all of these motions are clear; where some are not, those beside them are asked, too."""
        if self._sweep(edges):
            return True
        assert self.tolerance is not None  # without it no motion is asked about
        around = self._motions_beside(edges[self.swept[edges]])
        self._sweep(around[self.graph.prove(self.solver, around, self.tolerance)])
        return False

    def _sweep(self, edges: Ints) -> bool:
        assert self.obstacles is not None  # who has none asks nothing
        asked = edges[~self._clear_edges[edges]]
        q0, q1, edge = self.graph.pieces(asked)
        free = np.ones(len(asked), dtype=np.bool_)
        free[edge[~self.obstacles.motions_free(q0, q1)]] = False
        self._clear_edges[asked[free]] = True
        self.swept[asked[~free]] = True
        self.graph.cost[asked[~free]] = np.inf
        return bool(free.all())

    def _motions_beside(self, failed: Ints) -> Ints:
        """Motions of the same segment and branch as those that touch something, more of them in every round."""
        graph, layers = self.graph, self.graph.layers
        found = []
        for edge in failed:
            node = graph.start_of(edge)
            at = int(np.searchsorted(layers.first, node, side="right")) - 1
            same = np.arange(graph.edge_first[layers.first[at]], graph.edge_first[layers.first[at + 1]])
            start = graph.start_of(same)
            open_ = (layers.column[start] == layers.column[node]) & np.isfinite(graph.cost[same])
            same, start = same[open_], start[open_]
            apart = np.abs(layers.value[start] - layers.value[node])
            apart += np.abs(layers.value[graph.end[same]] - layers.value[graph.end[edge]])
            found.append(same[np.argsort(apart, kind="stable")[: 2 << min(self._rounds, 10)]])
        return np.unique(np.concatenate(found)) if found else np.empty(0, np.int64)
