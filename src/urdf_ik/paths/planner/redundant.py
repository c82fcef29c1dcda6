"""Paths of arms with one redundancy parameter: a coarse grid of its values, then finer ones around the best route."""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.paths import waypoints
from urdf_ik.paths.path_settings import CheckedSettings
from urdf_ik.paths.planned_motion import EVERY_BRANCH, Plan
from urdf_ik.paths.planner import nodes as node_sets
from urdf_ik.paths.planner.assembly import Refined, add_limit_costs, cut, made, not_found, offer, priced
from urdf_ik.paths.planner.graph import CHANGE, MISMATCH, Graph, Route
from urdf_ik.paths.planner.nodes import Nodes
from urdf_ik.paths.planner.search import Search
from urdf_ik.paths.planner.smoothing import smoothed
from urdf_ik.paths.planner.stops import COARSE_VALUES, FINE_VALUES, closed_waypoint, grid_values, is_closed, stops_of
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array

FEWEST_VALUES, MOST_VALUES, WANTED_NODES = 48, 768, 250
"""Least and greatest number of values on the first grid; between them, this many nodes per waypoint are aimed at.

Narrow joint limits leave few nodes, so the grid becomes finer.
"""
SPARSE_TURN, SPARSE_MOVE = 0.2, 0.06
"""Distance between the waypoints of the first grid [rad, fraction of the arm's size]."""
DENSE_TURN, DENSE_MOVE = 0.15, 0.05
"""Longer segments are cut into equal pieces [rad, fraction of the arm's size]."""
DENSE_GRIDS = (COARSE_VALUES, 128, FINE_VALUES)
"""Numbers of values of the grids at every waypoint; tried in this order where the first grid leads to no plan."""
LOOSE_MISMATCH = (0.25, 1.0)
"""The same as ``MISMATCH``, for grids whose routes are refined later."""
WIDEST_GRID_STEP = 1.0
"""Largest step of a turning joint between two waypoints of a grid [rad]."""
NEAR = 0.2
"""Distance of a turning joint from the guide on finer grids, in addition to the change of the parameter [rad]."""
FINER = 4
"""Refinement factor between successive grids."""
NEIGHBOURS = (12, 6, 4)
"""Number of values on each side of the guide, on successive finer grids."""
MOST_PASSES = 6
"""Most passes on one grid."""
WORTHWHILE = 0.99
"""Repeat the pass while it lowers the cost by more than 1 %."""
SAME_COST = 1e-6
"""Routes whose costs differ by less than this fraction are equal."""
PROMISING = 3.0
"""A start branch that costs more than this many times the cheapest is refined only if all others fail."""


class _Guide(NamedTuple):
    """A route on a grid.

    Attributes:
        q: (k, n) rad or m.
        value: (k,) redundancy parameter.
        column: (k,) branches.
        changes: (k - 1,) where the branch changes.
        cost: of the route.
        round: whether the parameter is an angle without ends.
    """

    q: Array
    value: Array
    column: NDArray[np.int64]
    changes: NDArray[np.bool_]
    cost: float
    round: bool

    @property
    def order(self) -> tuple[int, float]:
        """Routes are compared by their changes of branch, then by their costs."""
        return int(self.changes.sum()), self.cost

    def spread(self, place: Array, places: Array) -> "_Guide":
        """Interpolate a guide without changes from its places on the path to others."""
        right = np.clip(np.searchsorted(place, places), 1, len(place) - 1)
        share = (places - place[right - 1]) / (place[right] - place[right - 1])
        q = self.q[right - 1] + share[:, None] * (self.q[right] - self.q[right - 1])
        step = self.value[right] - self.value[right - 1]
        step = shortest(step) if self.round else step
        value = self.value[right - 1] + share * step
        column = np.where(share < 0.5, self.column[right - 1], self.column[right])
        return _Guide(q, value, column, np.zeros(len(places) - 1, dtype=np.bool_), np.inf, self.round)


def plan(settings: CheckedSettings, path: Array) -> Plan:
    """The plan of an arm with a redundancy parameter.

    Obstacles make no route cheaper. So if the best route without them is free of contact, it is the best with them. If
    it is not, its colliding stretches are searched for a waypoint at which every solution is in contact.
    """
    obstacles = settings.obstacles
    if obstacles is not None and not settings.reconfigure:
        settings.watch.begin("looking for the best way without obstacles")
        alone = _searched(replace(settings, obstacles=None), path)
        q = alone.motion
        if alone.found and obstacles.free(q).all() and obstacles.motions_free(q[:-1], q[1:]).all():
            return replace(alone, obstacles=obstacles, others=lambda: _searched(settings, path).alternatives)
        if alone.found and (stop := closed_waypoint(settings, path, alone.q)) is not None:
            return not_found(settings, path, [stop])
        settings.watch.begin("looking for a way around the obstacles")
    return _searched(settings, path)


def _searched(settings: CheckedSettings, path: Array) -> Plan:
    """The plan that a search from coarse to fine grids finds."""
    dense = cut(settings, path, DENSE_TURN, DENSE_MOVE)
    if not settings.reconfigure:
        sparse = _sparse(settings, dense)
        values = _grid(settings, sparse, FEWEST_VALUES)
        count = len(node_sets.solved(settings.solver, settings.joints, sparse.T, np.arange(len(sparse.T)), values).q)
        wanted = FEWEST_VALUES * WANTED_NODES * len(sparse.T) / max(count, 1)
        nodes, step = _nodes(settings, sparse, int(np.clip(wanted, FEWEST_VALUES, MOST_VALUES)))
        plan = _plan(settings, path, dense, sparse, _coarse_search(settings, sparse, nodes), step)
        if plan is not None:
            return plan
    label = "" if settings.solver.parameter is None else settings.solver.parameter.label
    for count in DENSE_GRIDS:
        settings.watch.begin(f"solving {count} values of the {label} at every waypoint")
        nodes, step = _nodes(settings, dense, count, windows=count > DENSE_GRIDS[0])
        if count < DENSE_GRIDS[-1] and len(np.unique(nodes.waypoint)) < len(dense.T):
            continue  # a waypoint without a solution on this grid may have one on a finer grid
        search = _coarse_search(settings, dense, nodes)
        plan = _plan(settings, path, dense, dense, search, step)
        if plan is not None:
            return plan
        if _closed(settings, dense, search):
            break
    return _stopped(settings, path, dense, search, step)


def _stopped(settings: CheckedSettings, path: Array, dense: Refined, search: Search, step: float) -> Plan:
    """What stops each branch: on the last grid, or near the route that the branch has on it."""
    layers, names = search.graph.layers, settings.solver.structure.branches
    search.graph.solve()
    stops = stops_of(settings, search, dense.T, dense.place)
    columns = layers.column[: layers.first[1]]
    for column in np.unique(columns):
        route = search.best(columns == column)
        if route is None:
            continue
        near = _around(settings, dense, _guide(settings, route), step / FINER, NEIGHBOURS[0], last=True)
        better = near.best()
        if better is not None:
            return made(settings, path, dense, near, better, alone=True)
        near.graph.prove(np.arange(len(near.graph.end)))
        near_stops = stops_of(settings, near, dense.T, dense.place)
        stops += tuple(stop for stop in near_stops if stop.branch == names[column])
    return not_found(settings, path, sorted(stops, key=lambda stop: (stop.branch != EVERY_BRANCH, -stop.waypoint)))


def improved(settings: CheckedSettings, path: Array, known: Plan) -> Plan | None:
    """The cheapest plan in the neighbourhood of a known one; None where that changes its branch."""
    if known.changes or len(known.place) == 1:
        return None
    dense = cut(settings, path, DENSE_TURN, DENSE_MOVE)
    sparse = _sparse(settings, dense)
    names, parameter = settings.solver.structure.branches, settings.solver.parameter
    columns = np.array([names.index(known.branches[k]) for k in np.round(known.place).astype(np.int64)])
    still, unknown = np.zeros(len(columns) - 1, dtype=np.bool_), np.zeros(len(columns))
    guide = _Guide(known.motion, unknown, columns, still, np.inf, parameter is not None and parameter.round)
    guide = guide.spread(known.place, sparse.place)
    guide = guide._replace(value=nearest_values(settings.solver, guide.q, sparse.T)[:, 0])
    step = float(np.diff(_grid(settings, sparse, FEWEST_VALUES)[0, :2])[0])
    return _finished(settings, path, dense, sparse, step, _refined(settings, sparse, guide, step))


def _closed(settings: CheckedSettings, dense: Refined, search: Search) -> bool:
    """Whether at some waypoint every node is in contact, also on the finest grid."""
    if search.obstacles is None:
        return False
    layers = search.graph.layers
    hits = np.bincount(layers.waypoint[search.hits], minlength=len(layers.T))
    touching = np.flatnonzero((hits == np.diff(layers.first)) & (hits > 0))
    return len(touching) > 0 and is_closed(settings, dense.T[touching[0]], FINE_VALUES)


def _sparse(settings: CheckedSettings, dense: Refined) -> Refined:
    """The first and the last waypoint, and some between them: see ``SPARSE_TURN``."""
    length = np.maximum(
        np.linalg.norm(dense.twists[:, :3], axis=1) / (SPARSE_MOVE * settings.solver.chain.size),
        np.linalg.norm(dense.twists[:, 3:], axis=1) / SPARSE_TURN,
    )
    place = np.concatenate([[0.0], np.cumsum(length)])
    chosen = np.searchsorted(place, np.arange(0.0, place[-1], 1.0))
    chosen = np.unique(np.concatenate([[0], chosen, [len(place) - 1]]))
    T, place = dense.T[chosen], dense.place[chosen]
    return Refined(T, place, 1.0 / np.diff(place), waypoints.twists(T[:-1], T[1:]))


def _grid(settings: CheckedSettings, refined: Refined, count: int) -> Array:
    """(m, count) the same values at every waypoint."""
    return np.broadcast_to(grid_values(settings, refined.T, count), (len(refined.T), count))


def _nodes(settings: CheckedSettings, refined: Refined, count: int, *, windows: bool = False) -> tuple[Nodes, float]:
    """The nodes on a grid of ``count`` values, and its step; with ``windows`` also those in narrow windows."""
    solver, joints, grid = settings.solver, settings.joints, _grid(settings, refined, count)
    everything = node_sets.solved(solver, joints, refined.T, np.arange(len(refined.T)), grid, outside=windows)
    nodes = node_sets.chosen(everything, everything.counts.all(axis=1))
    if windows:
        nodes = node_sets.joined((nodes, node_sets.in_narrow_windows(solver, joints, refined.T, everything, grid[0])))
    return _with_ends(settings, refined, nodes), float(grid[0, 1] - grid[0, 0])


def _with_ends(settings: CheckedSettings, refined: Refined, nodes: Nodes) -> Nodes:
    """The nodes, with the given start and end in place of those of the first and last waypoint."""
    ends = []
    for q, T in ((settings.start, refined.T[0]), (settings.end, refined.T[-1])):
        ends.append((q, 0.0 if q is None else float(nearest_values(settings.solver, q[None], T[None])[0, 0])))
    return node_sets.with_ends(settings.solver, settings.joints, refined.T, nodes, ends)


def _coarse_search(settings: CheckedSettings, refined: Refined, nodes: Nodes) -> Search:
    """The search on the first grid, whose motions are not proven."""
    window = np.where(settings.joints.turn > 0.0, WIDEST_GRID_STEP, np.inf)
    layers = nodes.layers(refined.T, refined.twists)
    graph = Graph.connected(settings, layers, refined.pieces, window, LOOSE_MISMATCH)
    add_limit_costs(settings, graph)
    return Search(graph, proves=False)


def _plan(
    settings: CheckedSettings, path: Array, dense: Refined, refined: Refined, search: Search, step: float
) -> Plan | None:
    """The plan to which a search on the first grid leads, at all waypoints or some of them."""
    columns = search.graph.layers.column[: search.graph.layers.first[1]]
    routes = [search.best(columns == column) for column in np.unique(columns)]
    guides = sorted((_guide(settings, route) for route in routes if route is not None), key=lambda guide: guide.order)
    # Branches that are images of each other cost the same; the first is enough unless it fails.
    chosen = [
        guide.cost <= PROMISING * guides[0].cost and (not k or guide.cost > guides[k - 1].cost * (1.0 + SAME_COST))
        for k, guide in enumerate(guides)
    ]
    rest = [guide for guide, first in zip(guides, chosen, strict=True) if not first]
    close = [_refined(settings, refined, guide, step) for guide, first in zip(guides, chosen, strict=True) if first]
    close.sort(key=lambda guide: guide.order)

    finished = partial(_finished, settings, path, dense, refined, step)

    def others() -> tuple[Plan, ...]:
        refined_rest = (_refined(settings, refined, guide, step) for guide in rest)
        plans = [finished(guide) for guide in (*close, *refined_rest)]
        return tuple(sorted((plan for plan in plans if plan is not None), key=lambda plan: plan.cost))

    best: Plan | None = None
    for k, guide in enumerate(close):
        # The cost at some waypoints is hardly more than the cost at all of them.
        if best is not None and best.order <= guide.order:
            break
        settings.watch.begin(f"following way {k + 1} of {len(guides)} from the first waypoint")
        plan = finished(guide)
        offer(settings, plan)
        if plan is not None and (best is None or plan.order < best.order):
            best = plan
    for guide in rest:
        best = finished(_refined(settings, refined, guide, step)) if best is None else best
    return None if best is None else replace(best, others=others)


def _refined(settings: CheckedSettings, refined: Refined, guide: _Guide, step: float) -> _Guide:
    """A guide improved on successively finer grids around it."""
    for neighbours in NEIGHBOURS:
        step /= FINER
        for _ in range(MOST_PASSES):
            route = _around(settings, refined, guide, step, neighbours, last=False).best()
            better = guide if route is None else _guide(settings, route)
            if not better.cost < guide.cost:
                break
            before, guide = guide.cost, better
            if not guide.cost < WORTHWHILE * before:
                break
        if settings.smooth and not guide.changes.any():
            return _smoothed(settings, refined, guide)
    return guide


def _finished(
    settings: CheckedSettings, path: Array, dense: Refined, refined: Refined, step: float, guide: _Guide
) -> Plan | None:
    """The plan at all waypoints, its motions proven and free of contact; None without one near the guide."""
    if len(refined.T) < len(dense.T):
        guide = guide.spread(refined.place, dense.place)
    for finer in (1, FINER):
        for _ in range(MOST_PASSES):
            route = _around(settings, dense, guide, step / finer, NEIGHBOURS[-1], last=False).best()
            if route is None:
                return None
            before, guide = guide.cost, _guide(settings, route)
            if not guide.cost < WORTHWHILE * before:
                break
    last = None
    if settings.smooth and not guide.changes.any():  # smoothing ignores obstacles between waypoints
        last = _proven(settings, dense, _smoothed(settings, dense, guide), step / FINER**3)
    last = last or _proven(settings, dense, guide, step / FINER**3)
    return None if last is None else made(settings, path, dense, *last, alone=True)


def _proven(settings: CheckedSettings, dense: Refined, guide: _Guide, step: float) -> tuple[Search, Route] | None:
    """The route near a guide whose motions are proven and free of contact; None without one."""
    last: tuple[Search, Route] | None = None
    for factor in (FINER, 1):
        for k in range(MOST_PASSES):
            neighbours = NEIGHBOURS[0] if last is None and k else NEIGHBOURS[-1]
            search = _around(settings, dense, guide, step * factor, neighbours, last=True)
            route = search.best()
            if route is None and last is None and not k:
                continue  # a second time, on a wider grid
            if route is None:
                break
            before, guide, last = guide.cost, _guide(settings, route), (search, route)
            if not guide.cost < WORTHWHILE * before:
                break
        if last is None:
            return None
    return last


def _smoothed(settings: CheckedSettings, refined: Refined, guide: _Guide) -> _Guide:
    if len(guide.q) < 2:
        return guide
    q = smoothed(settings, refined, guide.q)
    steps = np.diff(q, axis=0)
    cost = float((settings.weights * steps * steps * refined.pieces[:, None]).sum())
    value = nearest_values(settings.solver, q, refined.T)[:, 0]
    return guide._replace(q=q, value=value, cost=cost) if cost < guide.cost else guide


def _guide(settings: CheckedSettings, route: Route) -> _Guide:
    layers, parameter = route.graph.layers, settings.solver.parameter
    value, column = layers.value[route.nodes], layers.column[route.nodes]
    is_round = parameter is not None and parameter.round
    return _Guide(route.q, value, column, route.edges == CHANGE, route.cost, is_round)


def _around(
    settings: CheckedSettings, refined: Refined, guide: _Guide, step: float, neighbours: int, last: bool
) -> Search:
    """The search on a grid of values around a guide; only with ``last`` motions are proven."""
    solver, joints, parameter = settings.solver, settings.joints, settings.solver.parameter
    assert parameter is not None  # this module plans only for arms with a parameter
    values = guide.value[:, None] + step * np.arange(-neighbours, neighbours + 1)
    values = parameter.wrapped(values) if parameter.round else np.clip(values, *parameter.range)
    near = min(WIDEST_GRID_STEP, NEAR + 2.0 * neighbours * step)
    everywhere = np.arange(len(refined.T))
    nodes = node_sets.solved(solver, joints, refined.T, everywhere, values, centres=guide.q, near=near)
    layers = _with_ends(settings, refined, nodes).layers(refined.T, refined.twists)
    return Search(priced(settings, refined, layers, MISMATCH if last else LOOSE_MISMATCH), proves=last)
