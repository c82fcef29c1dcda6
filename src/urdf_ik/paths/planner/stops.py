"""The stops of a path without a plan: how far each branch of the first waypoint gets, and why it ends."""

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.explanation import explain
from urdf_ik.ik.redundancy.interval_search import span
from urdf_ik.ik.solver import Solver
from urdf_ik.paths.path_settings import CheckedSettings, Obstacles
from urdf_ik.paths.planned_motion import EVERY_BRANCH, Stop
from urdf_ik.paths.planner import nodes as node_sets
from urdf_ik.paths.planner.search import Search
from urdf_ik.paths.planner.straightness import keeps_straight, scaled
from urdf_ik.typing import Array

Ints = NDArray[np.int64]

MOST_DIAGNOSED = 16
"""At most this many states at the last reachable waypoint are diagnosed."""
CONTINUES = 10.0
"""A solution belongs to the branch if the motion to it stays within this many times the tolerance."""
COARSE_VALUES, FINE_VALUES = 64, 256
"""Values of the redundancy parameter at which a waypoint is tested: to find a closed one, and to confirm it."""
MOST_STRETCHES = 4
"""Number of colliding stretches whose midpoint is tested, longest first."""
VECTORS_AT_ONCE = 64
"""Joint vectors tested for contacts in one call; the test ends with the first one that is free."""


def stops_of(settings: CheckedSettings, search: Search, T: Array, place: Array) -> tuple[Stop, ...]:
    """The stop of every branch of the first waypoint that does not reach the end, the farthest first.

    Args:
        settings: of the path.
        search: a search that found nothing.
        T: (k, 4, 4) m, the waypoints of its graph.
        place: (k,) their places along the given path.
    """
    graph = search.graph
    layers, states = graph.layers, len(graph.joints.digits)
    names = settings.solver.structure.branches
    first = np.arange(layers.first[1])
    inside = (graph.joints.digits < layers.counts[first][:, None]).all(axis=2)
    exists = inside & np.isfinite(graph.node_cost[first])[:, None]
    if not exists.any():
        return _at_first(settings, search, T)
    begin = exists.any(axis=1)
    columns = np.unique(layers.column[first[begin]])
    bits = {int(column): np.uint64(1) << np.uint64(k) for k, column in enumerate(columns[:64])}
    marks = np.zeros((len(layers.q), states), np.uint64)
    for column, bit in bits.items():
        marks[first[layers.column[first] == column]] = bit
    marks[first] *= exists
    marks = _reached(settings, search, marks)
    stops = []
    for column, bit in bits.items():
        node, state = np.nonzero(marks & bit)
        if not len(node):  # all nodes of the branch are in contact
            stops.append((0.0, Stop(names[column], 0, "contact", _first_contact(search, column))))
            continue
        waypoint = layers.waypoint[node]
        last = int(waypoint.max())
        if last + 1 == len(T):
            continue
        here = np.flatnonzero(waypoint == last)[:MOST_DIAGNOSED]
        reason = _diagnosis(settings, search, T, last, node[here], state[here])
        stops.append((place[last], Stop(names[column], int(np.ceil(place[min(last + 1, len(T) - 1)])), *reason)))
    stops += [
        (0.0, Stop(names[column], 0, "contact", _first_contact(search, column)))
        for column in np.setdiff1d(layers.column[first], columns)
    ]
    stops.sort(key=lambda pair: -pair[0])
    return (*_out_of_all_reach(settings, search, T, place), *(stop for _, stop in stops))


def _first_contact(search: Search, column: int) -> str:
    """The bodies in contact at the first waypoint of a branch."""
    layers = search.graph.layers
    first = np.arange(layers.first[1])
    return _contact(search.obstacles, layers.q[first[layers.column[first] == column][0]])


def _reached(settings: CheckedSettings, search: Search, first: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Marks (N, states) of the first waypoint's states, passed on to all states that are reached without contact."""
    graph = search.graph
    if search.obstacles is None or settings.solver.parameter is not None:
        return graph.reached(first)
    while True:
        marks = graph.reached(first * np.isfinite(graph.node_cost)[:, None])
        if search.check_nodes(np.flatnonzero((marks != 0).any(axis=1) & ~search.hits)):
            return marks


def _out_of_all_reach(settings: CheckedSettings, search: Search, T: Array, place: Array) -> tuple[Stop, ...]:
    """The first waypoint without any solution inside the limits, whichever route leads to it."""
    empty = np.flatnonzero(np.diff(search.graph.layers.first) == 0)
    if not len(empty):
        return ()
    k, joints = int(empty[0]), settings.joints
    waypoint = int(np.ceil(place[k]))
    everything = _solutions(settings, T, k, None)
    if not len(everything.q):
        return (Stop(EVERY_BRANCH, waypoint, "reach", _reach(settings.solver, T[k])),)
    best = int(np.argmax(joints.room(everything.q)))
    limits = _limits(settings, joints.central(everything.q[best]), everything.counts[best] == 0)
    return (Stop(EVERY_BRANCH, waypoint, "limit", f"no solution is inside the limits; of the nearest, {limits}"),)


def _reach(solver: Solver, T: Array) -> str:
    """Why a pose has no solution at the values of the parameter that were tried."""
    why = explain(solver, T)
    return f"out of reach: {why}" if why else f"reached only between the values of the {solver.parameter} looked at"


def _at_first(settings: CheckedSettings, search: Search, T: Array) -> tuple[Stop, ...]:
    """Why no branch can begin at the first waypoint."""
    solver, graph = settings.solver, search.graph
    everything = _solutions(settings, T, 0, None)
    if not len(everything.q):
        return (Stop(EVERY_BRANCH, 0, "reach", _reach(solver, T[0])),)
    names = solver.structure.branches
    stops = []
    here = np.arange(graph.layers.first[1])
    for column in np.unique(everything.column):
        own = here[graph.layers.column[here] == column]
        if len(own):
            stops.append(Stop(names[column], 0, "contact", _contact(search.obstacles, graph.layers.q[own[0]])))
            continue
        q = everything.q[everything.column == column]
        counts = everything.counts[everything.column == column]
        k = int(np.argmin((counts == 0).sum(axis=1)))
        stops.append(Stop(names[column], 0, "limit", _limits(settings, settings.joints.central(q[k]), counts[k] == 0)))
    return tuple(stops)


def _diagnosis(
    settings: CheckedSettings, search: Search, T: Array, last: int, nodes: Ints, states: Ints
) -> tuple[str, str]:
    """Why these states of a waypoint lead to none of the next one: the cause, and the reason in words."""
    solver, graph = settings.solver, search.graph
    joints = graph.joints
    values = graph.layers.value[nodes]
    candidates = _solutions(settings, T, last + 1, None if solver.parameter is None else np.unique(values))
    if not len(candidates.q):
        if solver.parameter is not None and len(_solutions(settings, T, last + 1, None).q):
            return "jump", f"its solutions end here: the next waypoint has none at this {solver.parameter.label}"
        return "reach", _reach(solver, T[last + 1])
    reasons, nearest_jump, wide = {}, np.inf, scaled(settings.tolerance, CONTINUES)
    for node, state in zip(nodes, states, strict=True):
        q = graph.layers.q[node] + joints.digits[state] * joints.turn
        steps = joints.step(q, candidates.q)
        size = np.abs(steps).max(axis=1)
        k = int(np.argmin(size))
        straight = keeps_straight(
            solver, q[None], steps[k][None], T, np.array([last]), graph.layers.twists[:, 3:], wide
        )
        if not straight[0]:
            if size[k] < nearest_jump:
                nearest_jump = float(size[k])
                joint = solver.joint_names[int(np.argmax(np.abs(steps[k])))]
                amount = _value(settings, joint, size[k])
                reasons["jump"] = (
                    f"its solutions end here: the next waypoint's nearest is a jump of {amount} in {joint}"
                )
            continue
        after = q + steps[k]
        low, high = solver.limits.T
        outside = (after < low - 1e-9) | (after > high + 1e-9)
        if outside.any():
            reasons["limit"] = _limits(settings, after, outside)
        elif (np.abs(steps[k]) > settings.max_step).any():
            joint = solver.joint_names[int(np.argmax(np.abs(steps[k]) / settings.max_step))]
            reasons["limit"] = f"{joint} would have to move more than max_step allows"
        elif search.obstacles is not None:
            reasons["contact"] = _contact(search.obstacles, after, q)
    for cause in ("contact", "limit", "jump"):
        if cause in reasons:
            return cause, reasons[cause]
    return "jump", "no motion to the next waypoint keeps to the straight segment"


def _solutions(settings: CheckedSettings, T: Array, waypoint: int, values: Array | None) -> node_sets.Nodes:
    """All solutions of a waypoint, inside the limits or not; at all values of the parameter where none are given."""
    parameter = settings.solver.parameter
    if parameter is not None:
        values = (np.linspace(*parameter.range, FINE_VALUES) if values is None else values)[None]
    return node_sets.solved(settings.solver, settings.joints, T, np.array([waypoint]), values, outside=True)


def _limits(settings: CheckedSettings, q: Array, outside: NDArray[np.bool_]) -> str:
    parts = []
    low, high = settings.solver.limits.T
    for k in np.flatnonzero(outside):
        joint = settings.solver.joint_names[k]
        limit = high[k] if abs(q[k] - high[k]) < abs(q[k] - low[k]) else low[k]
        wanted, most = _value(settings, joint, q[k]), _value(settings, joint, limit)
        parts.append(f"{joint} would have to be at {wanted}, its limit is {most}")
    return "; ".join(parts)


def _contact(obstacles: Obstacles | None, q: Array, before: Array | None = None) -> str:
    """The bodies in contact at a joint vector (n,), or on the way to it."""
    assert obstacles is not None  # without obstacles nothing is in contact
    pair, where = obstacles.pair(q), ""
    if before is not None and obstacles.free(q[None])[0]:
        pair = obstacles.model.motions_free(before[None], q[None], obstacles.margin).pairs[0]
        where = " on the way to the next waypoint"
    touch = "touch" if not obstacles.margin else f"come within {obstacles.margin:g} m of each other"
    return f"{pair[0]} and {pair[1]} {touch}{where}" if pair else f"links {touch}{where}"


def _value(settings: CheckedSettings, joint: str, x: float) -> str:
    slides = settings.solver.chain.prismatic[settings.solver.joint_names.index(joint)]
    return f"{x:.4g} m" if slides else f"{np.degrees(x):.4g}°"


def grid_values(settings: CheckedSettings, T: Array, count: int) -> Array:
    """Values (count,) over the whole range of the redundancy parameter, for poses (m, 4, 4)."""
    parameter = settings.solver.parameter
    assert parameter is not None  # grids are only for arms with a parameter
    low, high = span(settings.solver, parameter, T)
    return np.linspace(low, high, count, endpoint=not parameter.round)


def is_closed(settings: CheckedSettings, T: Array, count: int) -> bool:
    """Whether a pose (4, 4) has solutions inside the limits at ``count`` values, and all of them are in contact."""
    assert settings.obstacles is not None  # without obstacles nothing is in contact
    values = grid_values(settings, T[None], count)
    nodes = node_sets.solved(settings.solver, settings.joints, T[None], np.zeros(1, np.int64), values[None])
    # Neighbouring values make contact alike, so the order is random.
    q = nodes.q[np.random.default_rng(0).permutation(len(nodes.q))]
    parts = (q[k : k + VECTORS_AT_ONCE] for k in range(0, len(q), VECTORS_AT_ONCE))
    return len(q) > 0 and not any(settings.obstacles.free(part).any() for part in parts)


def closed_waypoint(settings: CheckedSettings, path: Array, q: Array) -> Stop | None:
    """The stop at a waypoint whose solutions are all in contact, whatever the route; None where none is found.

    The midpoint of each colliding stretch of a route (m, n) is tested. From a closed one, bisection leads towards the
    first closed waypoint of the stretch.
    """
    obstacles, parameter = settings.obstacles, settings.solver.parameter
    assert obstacles is not None and parameter is not None  # noqa: PT018 - closed waypoints need both
    touching = np.flatnonzero(~obstacles.free(q))
    stretches = [part for part in np.split(touching, np.flatnonzero(np.diff(touching) > 1) + 1) if len(part)]
    for stretch in sorted(stretches, key=len, reverse=True)[:MOST_STRETCHES]:
        low, closed = int(stretch[0]) - 1, int(stretch[len(stretch) // 2])
        if not is_closed(settings, path[closed], COARSE_VALUES):
            continue
        middle_of_stretch = closed
        while closed - low > 1:
            middle = (low + closed) // 2
            if is_closed(settings, path[middle], COARSE_VALUES):
                closed = middle
            else:
                low = middle
        for k in (closed, middle_of_stretch):
            if is_closed(settings, path[k], FINE_VALUES):
                values = f"{FINE_VALUES} values of the {parameter.label}"
                reason = f"something touches in every solution at {values}; in one of them {_contact(obstacles, q[k])}"
                return Stop(EVERY_BRANCH, k, "contact", reason)
    return None
