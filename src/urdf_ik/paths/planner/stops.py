"""The stops of a path without a plan: how far each branch of the first waypoint gets, and why it ends."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.explanation import explain
from urdf_ik.ik.solver import Solver
from urdf_ik.paths.checked_settings import CheckedSettings
from urdf_ik.paths.planned_motion import EVERY_BRANCH, Stop
from urdf_ik.paths.planner import nodes as node_sets
from urdf_ik.paths.planner.limit_windows import central, room
from urdf_ik.paths.planner.search import Search
from urdf_ik.paths.planner.straightness import keeps_straight
from urdf_ik.typing import Array

Ints = NDArray[np.int64]

_LOOKED_AT = 16
"""States at the farthest waypoint of which it is found out why they lead no farther."""
_LOOSE = 10.0
"""A solution continues a branch where the motion to it keeps to so many times the tolerance; else the branch ends."""


def stops_of(settings: CheckedSettings, search: Search, T: Array, place: Array) -> tuple[Stop, ...]:
    """Of every branch of the first waypoint, the one that gets farthest first; none of one that gets to the end.

    Args:
        settings: what the path was asked to keep to.
        search: after it found nothing.
        T: (k, 4, 4) m, the waypoints of its graph.
        place: (k,) where they are between the waypoints given.
    """
    graph = search.graph
    layers, states = graph.layers, len(graph.joints.digits)
    names = settings.solver.structure.branches
    first = np.arange(layers.first[1])
    exists = (graph.joints.digits < layers.counts[first][:, None]).all(axis=2) & np.isfinite(graph.node_cost[first])[
        :, None
    ]
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
        if not len(node):  # all of its nodes touch something
            stops.append((0.0, Stop(names[column], 0, "contact", _first_contact(search, column))))
            continue
        at = layers.at[node]
        last = int(at.max())
        if last + 1 == len(T):
            continue
        here = at == last
        stop = _stop(settings, search, T, last, node[here][:_LOOKED_AT], state[here][:_LOOKED_AT])
        stops.append((place[last], Stop(names[column], int(np.ceil(place[min(last + 1, len(T) - 1)])), *stop)))
    stops += [
        (0.0, Stop(names[column], 0, "contact", _first_contact(search, column)))
        for column in np.setdiff1d(layers.column[first], columns)
    ]
    stops.sort(key=lambda each: -each[0])
    return (*_out_of_all_reach(settings, search, T, place), *(stop for _, stop in stops))


def _first_contact(search: Search, column: int) -> str:
    """What touches at the first waypoint in a branch."""
    layers = search.graph.layers
    first = np.arange(layers.first[1])
    return _contact(search, layers.q[first[layers.column[first] == column][0]])


def _reached(settings: CheckedSettings, search: Search, first: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Marks (N, states) passed on from the first waypoint to all that is reached without touching anything.

    The search asks about the nodes of the cheapest ways only; what stops a way is the first contact on it. A joint that
    may have any value has too many nodes for all to be asked.
    """
    graph = search.graph
    if search.obstacles is None or settings.solver.parameter is not None:
        return graph.reached(first)
    asked = search.hits.copy()
    while True:
        marks = graph.reached(first * np.isfinite(graph.node_cost)[:, None])
        nodes = np.flatnonzero((marks != 0).any(axis=1) & ~asked)
        free = search.obstacles.free(graph.layers.q[nodes])
        if free.all():
            return marks
        asked[nodes] = True
        search.hits[nodes[~free]] = True
        graph.node_cost[nodes[~free]] = np.inf


def _out_of_all_reach(settings: CheckedSettings, search: Search, T: Array, place: Array) -> tuple[Stop, ...]:
    """The first waypoint that no branch reaches inside the limits, wherever the ways to it end."""
    empty = np.flatnonzero(np.diff(search.graph.layers.first) == 0)
    if not len(empty):
        return ()
    at = int(empty[0])
    waypoint = int(np.ceil(place[at]))
    everything = _solutions(settings, T, at, None)
    if not len(everything.q):
        return (Stop(EVERY_BRANCH, waypoint, "reach", _reach(settings.solver, T[at])),)
    best = int(np.argmax(room(settings, everything.q)))
    limits = _limits(settings, central(settings, everything.q[best]), everything.counts[best] == 0)
    return (Stop(EVERY_BRANCH, waypoint, "limit", f"no solution is inside the limits; of the nearest, {limits}"),)


def _reach(solver: Solver, T: Array) -> str:
    """Why no value that was looked at has a solution of a pose."""
    why = explain(solver, T)
    return f"out of reach: {why}" if why else f"reached only between the values of the {solver.parameter} looked at"


def _at_first(settings: CheckedSettings, search: Search, T: Array) -> tuple[Stop, ...]:
    """Why there is no way to begin."""
    solver, graph = settings.solver, search.graph
    everything = _solutions(settings, T, 0, None)
    if not len(everything.q):
        return (Stop(EVERY_BRANCH, 0, "reach", _reach(solver, T[0])),)
    names = solver.structure.branches
    stops = []
    here = np.arange(graph.layers.first[1])
    for column in np.unique(everything.column):
        mine = here[graph.layers.column[here] == column]
        if len(mine):
            stops.append(Stop(names[column], 0, "contact", _contact(search, graph.layers.q[mine[0]])))
            continue
        q = everything.q[everything.column == column]
        counts = everything.counts[everything.column == column]
        k = int(np.argmin((counts == 0).sum(axis=1)))
        stops.append(Stop(names[column], 0, "limit", _limits(settings, central(settings, q[k]), counts[k] == 0)))
    return tuple(stops)


def _stop(settings: CheckedSettings, search: Search, T: Array, last: int, nodes: Ints, states: Ints) -> tuple[str, str]:
    """Why these states of a waypoint lead to none of the next one: the cause, and the same in words."""
    solver, graph = settings.solver, search.graph
    joints = graph.joints
    values = graph.layers.value[nodes]
    candidates = _solutions(settings, T, last + 1, None if solver.parameter is None else np.unique(values))
    if not len(candidates.q):
        if solver.parameter is not None and len(_solutions(settings, T, last + 1, _all_values(settings)).q):
            return "jump", f"its solutions end here: the next waypoint has none at this {solver.parameter.label}"
        return "reach", _reach(solver, T[last + 1])
    found = {}
    nearest_jump = np.inf
    for node, state in zip(nodes, states, strict=True):
        q = graph.layers.q[node] + joints.digits[state] * joints.turn
        steps = joints.step(q, candidates.q)
        size = np.abs(steps).max(axis=1)
        k = int(np.argmin(size))
        straight = keeps_straight(
            solver.chain, q[None], steps[k][None], T, np.array([last]), graph.layers.twists[:, 3:],
            settings.tolerance.times(_LOOSE), solver.free_axis,
        )  # fmt: skip
        if not straight[0]:
            if size[k] < nearest_jump:
                nearest_jump = float(size[k])
                joint = solver.joint_names[int(np.argmax(np.abs(steps[k])))]
                amount = _value(settings, joint, size[k])
                found["jump"] = f"its solutions end here: the next waypoint's nearest is a jump of {amount} in {joint}"
            continue
        after = q + steps[k]
        low, high = solver.limits.T
        outside = (after < low - 1e-9) | (after > high + 1e-9)
        if outside.any():
            found["limit"] = _limits(settings, after, outside)
        elif (np.abs(steps[k]) > settings.max_step).any():
            joint = solver.joint_names[int(np.argmax(np.abs(steps[k]) / settings.max_step))]
            found["limit"] = f"{joint} would have to move more than max_step allows"
        elif search.obstacles is not None:
            found["contact"] = _contact(search, after, q)
    for cause in ("contact", "limit", "jump"):
        if cause in found:
            return cause, found[cause]
    return "jump", "no motion to the next waypoint keeps to the straight segment"


def _solutions(settings: CheckedSettings, T: Array, at: int, values: Array | None) -> node_sets.Nodes:
    """All solutions of a waypoint, inside the limits or not."""
    if settings.solver.parameter is not None:
        values = (_all_values(settings) if values is None else values)[None]
    return node_sets.solved(settings.solver, settings.joints, T, np.array([at]), values, outside=True)


def _all_values(settings: CheckedSettings) -> Array:
    parameter = settings.solver.parameter
    assert parameter is not None  # an arm without one is not asked
    return np.linspace(*parameter.range, 256)


def _limits(settings: CheckedSettings, q: Array, outside: NDArray[np.bool_]) -> str:
    parts = []
    low, high = settings.solver.limits.T
    for k in np.flatnonzero(outside):
        joint = settings.solver.joint_names[k]
        limit = high[k] if abs(q[k] - high[k]) < abs(q[k] - low[k]) else low[k]
        wanted, most = _value(settings, joint, q[k]), _value(settings, joint, limit)
        parts.append(f"{joint} would have to be at {wanted}, its limit is {most}")
    return "; ".join(parts)


def _contact(search: Search, q: Array, before: Array | None = None) -> str:
    assert search.obstacles is not None  # without obstacles nothing is in contact
    model, margin = search.obstacles
    if before is not None and search.obstacles.free(q[None])[0]:
        motion = model.motions_free(before[None], q[None], margin)
        pair = motion.pairs[0]
        where = " on the way to the next waypoint"
    else:
        pair, where = search.obstacles.pair(q), ""
    touch = "touch" if not margin else f"come within {margin:g} m of each other"
    return f"{pair[0]} and {pair[1]} {touch}{where}" if pair else f"links {touch}{where}"


def _value(settings: CheckedSettings, joint: str, x: float) -> str:
    slides = settings.solver.chain.prismatic[settings.solver.joint_names.index(joint)]
    return f"{x:.4g} m" if slides else f"{np.degrees(x):.4g}°"
