"""Paths of arms with one redundancy parameter: a coarse grid of its values, then finer ones around the best path."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.paths.checked_settings import CheckedSettings
from urdf_ik.paths.planned_motion import EVERY_BRANCH, Plan
from urdf_ik.paths.planner import nodes as node_sets
from urdf_ik.paths.planner.assembly import Refined, add_margins, cut_coarse, made, not_found, offer, priced
from urdf_ik.paths.planner.closed_waypoints import FINEST, closed_waypoint, grid_values, is_closed
from urdf_ik.paths.planner.graph import CHANGE, COSTS, MISMATCH, Graph, Pricing, Way
from urdf_ik.paths.planner.limit_windows import narrow
from urdf_ik.paths.planner.nodes import Nodes
from urdf_ik.paths.planner.search import Search
from urdf_ik.paths.planner.smoothing import smoothed
from urdf_ik.paths.planner.stops import stops_of
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array

FEWEST, MOST, WANTED = 48, 768, 250
"""Values of the parameter on the first grid, at some of the waypoints, and how many nodes of a waypoint are wanted:
where the limits leave few, the grid is finer, so that a step to the next value is small beside the joints' way."""
APART_TURN, APART_MOVE = 0.2, 0.06
"""rad and share of the arm's size between these waypoints."""
GRIDS = (64, 128, FINEST)
"""Values of grids at every waypoint, tried one after the other where the grid at some of them led to no plan."""
LOOSE = (0.25, 1.0)
"""See ``graph.MISMATCH``, on grids that only guide: from one of their values to the next a motion strays far."""
STEPS = 1.0
"""rad: the greatest step of a joint from one waypoint to the next on the first grid."""
COARSE_TURN, COARSE_MOVE = 0.15, 0.05
"""rad and share of the arm's size: longer segments are cut."""
NEAR = 0.2
"""rad that a joint may be off a way on the finer grids, beside what the parameter brings."""
FINER = 4
"""By what each grid is finer than the one before."""
AROUND = (12, 6, 4)
"""Values to each side of the way on each of the finer grids. The first grid is so coarse that the best way may lie some
of its steps beside the way that it gave."""
PASSES = 6
"""How often a finer grid is laid around the way that it gave, while the cost falls."""
ROUGH_PASSES, LAST_PASSES = 4, 3
"""The same at all waypoints: before the way is smoothed, and after."""
BETTER = 0.99
"""Share of the cost before that another pass must come below to be worth one more."""
SAME = 1e-6
"""Share by which the costs of two ways may differ and count as the same."""
WORTH = 3.0
"""A branch of the first waypoint is looked at closer where its way costs at most so many times the cheapest."""


class Guide(NamedTuple):
    """A way on a grid.

    Attributes:
        q: (k, n) rad or m.
        value: (k,) of the parameter.
        column: (k,) branches.
        changes: (k - 1,) where the branch is changed.
        cost: what it costs.
        turns: whether the parameter is an angle without ends.
    """

    q: Array
    value: Array
    column: NDArray[np.int64]
    changes: NDArray[np.bool_]
    cost: float
    turns: bool

    def spread(self, place: Array, places: Array) -> Guide:
        """At other places of the path, between those that it has; without changes."""
        right = np.clip(np.searchsorted(place, places), 1, len(place) - 1)
        share = (places - place[right - 1]) / (place[right] - place[right - 1])
        q = self.q[right - 1] + share[:, None] * (self.q[right] - self.q[right - 1])
        step = self.value[right] - self.value[right - 1]
        step = shortest(step) if self.turns else step
        value = self.value[right - 1] + share * step
        column = np.where(share < 0.5, self.column[right - 1], self.column[right])
        return Guide(q, value, column, np.zeros(len(places) - 1, dtype=np.bool_), np.inf, self.turns)


def plan(settings: CheckedSettings, path: Array) -> Plan:
    """The plan of an arm with a redundancy parameter.

    Obstacles make no way cheaper: where the best way without them is clear, it is the best with them. Where it touches,
    its waypoints are looked at first: one at which every solution touches ends every way.
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
    """The plan that a search from coarse to fine finds."""
    whole = cut_coarse(settings, path, COARSE_TURN, COARSE_MOVE)
    if not settings.reconfigure:
        some = _some(settings, whole)
        nodes, step = _nodes(settings, some, _values(settings, some))
        found = _plan(settings, path, whole, some, _search(settings, some, nodes), step)
        if found is not None:
            return found
    for count in GRIDS:
        settings.watch.begin(f"solving {count} values of the {_label(settings)} at every waypoint")
        nodes, step = _nodes(settings, whole, count, closely=count > GRIDS[0])
        if count < GRIDS[-1] and len(np.unique(nodes.at)) < len(whole.T):
            continue  # a waypoint that has no value on this grid may have one on a finer one
        search = _search(settings, whole, nodes)
        found = _plan(settings, path, whole, whole, search, step)
        if found is not None:
            return found
        if _closed(settings, whole, search):
            break
    return _stopped(settings, path, whole, search, step)


def _stopped(settings: CheckedSettings, path: Array, whole: Refined, search: Search, step: float) -> Plan:
    """What stops each branch: the last grid where it has no way through, else the motions near the way that it has."""
    layers, names = search.graph.layers, settings.solver.structure.branches
    search.graph.solve(settings.reconfigure)
    stops = stops_of(settings, search, whole.T, whole.place)
    columns = layers.column[: layers.first[1]]
    for column in np.unique(columns):
        way = search.best(columns == column)
        if way is None:
            continue
        near = _around(settings, whole, _guide(settings, way), step / FINER, AROUND[0], last=True)
        found = near.best()
        if found is not None:
            return made(settings, path, whole, near, found, alone=True)
        near.graph.prove(settings.solver, np.arange(len(near.graph.end)), settings.tolerance)
        stops += tuple(
            stop for stop in stops_of(settings, near, whole.T, whole.place) if stop.branch == names[column]
        )
    return not_found(settings, path, sorted(stops, key=lambda stop: (stop.branch != EVERY_BRANCH, -stop.waypoint)))


def beside(settings: CheckedSettings, path: Array, known: Plan) -> Plan | None:
    """The cheapest plan in the neighbourhood of one that is known; None where that changes its branch."""
    if known.changes:
        return None
    whole = cut_coarse(settings, path, COARSE_TURN, COARSE_MOVE)
    some = _some(settings, whole)
    place = some.place
    right = np.clip(np.searchsorted(known.place, place), 1, max(len(known.place) - 1, 1))
    if len(known.place) == 1:
        return None
    share = (place - known.place[right - 1]) / (known.place[right] - known.place[right - 1])
    q = known.motion[right - 1] + share[:, None] * (known.motion[right] - known.motion[right - 1])
    names = settings.solver.structure.branches
    column = np.array([names.index(known.branches[k]) for k in np.round(place).astype(np.int64)])
    value = nearest_values(settings.solver, q, some.T)[:, 0]
    parameter = settings.solver.parameter
    turns = parameter is not None and parameter.round
    guide = Guide(q, value, column, np.zeros(len(q) - 1, dtype=np.bool_), np.inf, turns)
    step = float(np.diff(_grid(settings, some, FEWEST)[0, :2])[0])
    last = _finished(settings, whole, some, _improved(settings, some, guide, step), step / FINER**3)
    return None if last is None else made(settings, path, whole, *last, alone=True)


def _closed(settings: CheckedSettings, refined: Refined, search: Search) -> bool:
    """Whether there is a waypoint where everything on the finest grid touches something."""
    if search.obstacles is None:
        return False
    layers = search.graph.layers
    hits = np.bincount(layers.at[search.hits], minlength=len(layers.T))
    touching = np.flatnonzero((hits == np.diff(layers.first)) & (hits > 0))
    return len(touching) > 0 and is_closed(settings, refined.T[touching[0]], FINEST)


def _some(settings: CheckedSettings, refined: Refined) -> Refined:
    """The first and the last waypoint, and some between them, as far apart as a first look allows."""
    apart = refined.twists
    way = np.maximum(
        np.linalg.norm(apart[:, :3], axis=1) / (APART_MOVE * settings.solver.chain.size),
        np.linalg.norm(apart[:, 3:], axis=1) / APART_TURN,
    )
    place = np.concatenate([[0.0], np.cumsum(way)])
    chosen = np.searchsorted(place, np.arange(0.0, place[-1], 1.0))
    chosen = np.unique(np.concatenate([[0], chosen, [len(place) - 1]]))
    at = refined.place[chosen]
    return Refined(refined.T[chosen], at, 1.0 / np.diff(at))


def _values(settings: CheckedSettings, refined: Refined) -> int:
    """How many values the first grid has."""
    at = np.arange(len(refined.T))
    nodes = node_sets.solved(settings.solver, settings.joints, refined.T, at, _grid(settings, refined, FEWEST))
    return int(np.clip(FEWEST * WANTED * len(at) / max(len(nodes.q), 1), FEWEST, MOST))


def _grid(settings: CheckedSettings, refined: Refined, count: int) -> Array:
    """The same values at every waypoint, (m, count)."""
    return np.broadcast_to(grid_values(settings, refined.T, count), (len(refined.T), count))


def _nodes(settings: CheckedSettings, refined: Refined, count: int, *, closely: bool = False) -> tuple[Nodes, float]:
    """The nodes on the first grid of so many values, with those of narrow windows where asked for; the values' step."""
    grid = _grid(settings, refined, count)
    everything = node_sets.solved(
        settings.solver, settings.joints, refined.T, np.arange(len(refined.T)), grid, outside=closely
    )
    nodes = everything.chosen(np.flatnonzero(everything.counts.all(axis=1)))
    if closely:
        nodes += narrow(settings, refined.T, everything, grid[0])
    return _ends(settings, refined, nodes), float(grid[0, 1] - grid[0, 0])


def _search(settings: CheckedSettings, refined: Refined, nodes: Nodes) -> Search:
    """The search on the first grid, a guide for others: no motion is proven."""
    window = np.where(settings.joints.turn > 0.0, STEPS, np.inf)
    pricing = Pricing(settings.kind, settings.weights, window, refined.pieces)
    layers = nodes.layers(refined.T, refined.twists)
    graph = Graph.connected(settings.joints, layers, pricing, LOOSE, settings.solver.free_axis)
    add_margins(settings, graph)
    return Search(
        settings.solver, graph, None, settings.obstacles, settings.watch, reconfigure=settings.reconfigure
    )


def _ends(settings: CheckedSettings, refined: Refined, nodes: Nodes) -> Nodes:
    """The nodes, with the joint vectors that are given for the first and the last waypoint."""
    for given, at in ((settings.start, 0), (settings.end, len(refined.T) - 1)):
        if given is None:
            continue
        value = float(nearest_values(settings.solver, given[None], refined.T[at][None])[0, 0])
        here = node_sets.solved(
            settings.solver, settings.joints, refined.T, np.array([at]), np.array([[value]]), outside=True
        )
        apart = np.abs(settings.joints.step(here.q, given)).max(axis=1)
        column = int(here.column[np.argmin(apart)]) if len(apart) else 0
        nodes = nodes.chosen(nodes.at != at) + node_sets.at_vector(
            settings.solver, settings.joints, given, at, value, column
        )
    return nodes


def _plan(
    settings: CheckedSettings, path: Array, whole: Refined, refined: Refined, search: Search, step: float
) -> Plan | None:
    """The plan that the first grid leads to, at all waypoints or some of them."""
    columns = search.graph.layers.column[: search.graph.layers.first[1]]
    ways = [search.best(columns == column) for column in np.unique(columns)]
    guides = sorted((_guide(settings, way) for way in ways if way is not None), key=_order)
    # Branches that are images of one another cost the same: one of them is enough, unless it fails.
    first = [
        guide
        for k, guide in enumerate(guides)
        if guide.cost <= WORTH * guides[0].cost and (not k or guide.cost > guides[k - 1].cost * (1.0 + SAME))
    ]
    rest = [guide for guide in guides if not any(guide is each for each in first)]
    close = sorted((_improved(settings, refined, guide, step) for guide in first), key=_order)

    def finished(guide: Guide) -> Plan | None:
        last = _finished(settings, whole, refined, guide, step / FINER**3)
        return None if last is None else made(settings, path, whole, *last, alone=True)

    def others() -> tuple[Plan, ...]:
        found = [finished(guide) for guide in (*close, *(_improved(settings, refined, each, step) for each in rest))]
        return tuple(sorted((each for each in found if each is not None), key=lambda each: each.cost))

    best: Plan | None = None
    for k, guide in enumerate(close):
        # What a way costs at some waypoints is hardly more than what it costs at all of them.
        if best is not None and (len(best.changes), best.cost) <= _order(guide):
            break
        settings.watch.begin(f"following way {k + 1} of {len(guides)} from the first waypoint")
        plan = finished(guide)
        offer(settings, plan)
        if plan is not None and (best is None or (len(plan.changes), plan.cost) < (len(best.changes), best.cost)):
            best = plan
    for guide in rest:
        best = finished(_improved(settings, refined, guide, step)) if best is None else best
    return None if best is None else best.with_others(others)


def _label(settings: CheckedSettings) -> str:
    return "" if settings.solver.parameter is None else settings.solver.parameter.label


def _order(guide: Guide) -> tuple[int, float]:
    """By what ways are compared."""
    return int(guide.changes.sum()), guide.cost


def _improved(settings: CheckedSettings, refined: Refined, guide: Guide, step: float) -> Guide:
    """A way on ever finer grids around it."""
    for around in AROUND:
        step /= FINER
        for _ in range(PASSES):
            way = _around(settings, refined, guide, step, around, last=False).best()
            found = guide if way is None else _guide(settings, way)
            if not found.cost < guide.cost:
                break
            before, guide = guide.cost, found
            if not guide.cost < BETTER * before:
                break
        if _is_smooth(settings) and not guide.changes.any():
            return _smoothed(settings, refined, guide)
    return guide


def _finished(
    settings: CheckedSettings, whole: Refined, refined: Refined, guide: Guide, step: float
) -> tuple[Search, Way] | None:
    """The way at all waypoints, its motions proven and clear; None where there is none near the guide."""
    if len(refined.T) < len(whole.T):
        guide = guide.spread(refined.place, whole.place)
    for wider in (FINER**3, FINER**2):
        for _ in range(ROUGH_PASSES):
            way = _around(settings, whole, guide, step * wider, AROUND[-1], last=False).best()
            if way is None:
                return None
            before, guide = guide.cost, _guide(settings, way)
            if not guide.cost < BETTER * before:
                break
    if _is_smooth(settings) and not guide.changes.any():
        found = _proven(settings, whole, _smoothed(settings, whole, guide), step)
        if found is not None:
            return found
        # Smoothing knows no obstacles: the way may lead into one.
    return _proven(settings, whole, guide, step)


def _proven(settings: CheckedSettings, whole: Refined, guide: Guide, step: float) -> tuple[Search, Way] | None:
    """The way near a guide whose motions are proven and clear; None where there is none."""
    last: tuple[Search, Way] | None = None
    for wider in (FINER, 1):
        for turn in range(LAST_PASSES):
            around = AROUND[0] if last is None and turn else AROUND[-1]
            search = _around(settings, whole, guide, step * wider, around, last=True)
            way = search.best()
            if way is None and last is None and not turn:
                continue  # once more, wider
            if way is None:
                break
            before, guide, last = guide.cost, _guide(settings, way), (search, way)
            if not guide.cost < BETTER * before:
                break
        if last is None:
            return None
    return last


def _is_smooth(settings: CheckedSettings) -> bool:
    """Whether the cost is the sum of squares alone, which is what smoothing makes least."""
    return COSTS[settings.kind] == "l2" and not settings.limit_cost


def _smoothed(settings: CheckedSettings, refined: Refined, guide: Guide) -> Guide:
    if len(guide.q) < 2:
        return guide
    q, value = smoothed(settings, refined, guide.q, guide.value)
    steps = np.diff(q, axis=0)
    cost = float((settings.weights * steps * steps * refined.pieces[:, None]).sum())
    return guide._replace(q=q, value=value, cost=cost) if cost < guide.cost else guide


def _guide(settings: CheckedSettings, way: Way) -> Guide:
    layers = way.graph.layers
    parameter = settings.solver.parameter
    turns = parameter is not None and parameter.round
    return Guide(way.q, layers.value[way.nodes], layers.column[way.nodes], way.edges == CHANGE, way.cost, turns)


def _around(settings: CheckedSettings, refined: Refined, guide: Guide, step: float, around: int, last: bool) -> Search:
    """The search on a grid of values around a way."""
    solver, joints = settings.solver, settings.joints
    parameter = solver.parameter
    assert parameter is not None  # only such arms are planned for here
    values = guide.value[:, None] + step * np.arange(-around, around + 1)
    values = parameter.wrapped(values) if parameter.round else np.clip(values, *parameter.range)
    near = min(STEPS, NEAR + 2.0 * around * step)
    at = np.arange(len(refined.T))
    found = node_sets.solved(solver, joints, refined.T, at, values, centres=guide.q, near=near)
    nodes = _ends(settings, refined, found)
    graph = priced(settings, refined, nodes.layers(refined.T, refined.twists), MISMATCH if last else LOOSE)
    return Search(
        settings.solver,
        graph,
        settings.tolerance if last else None,
        settings.obstacles,
        settings.watch,
        reconfigure=settings.reconfigure,
    )
