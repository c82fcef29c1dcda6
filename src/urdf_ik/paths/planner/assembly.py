"""Steps that all planners share: cutting long segments, costs of motions, making the plan."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from urdf_ik.ik.solutions import limits
from urdf_ik.paths import waypoints
from urdf_ik.paths.path_settings import CheckedSettings
from urdf_ik.paths.planned_motion import Change, Plan, Stop
from urdf_ik.paths.planner.graph import CHANGE, MISMATCH, Graph, Route
from urdf_ik.paths.planner.nodes import Layers
from urdf_ik.paths.planner.search import Search
from urdf_ik.typing import Array

LONGEST_TURN, LONGEST_MOVE = 0.5, 0.15
"""Longer segments are cut into equal pieces before the arm is solved [rad, fraction of the arm's size]."""


@dataclass(frozen=True)
class Refined:
    """The given waypoints, and others between them.

    Attributes:
        T: (k, 4, 4) m.
        place: (k,) place along the path: 2.5 is half way from given waypoint 2 to given waypoint 3.
        pieces: (k - 1,) number of pieces of the given segment that each piece is part of.
        twists: (k - 1, 6) from each waypoint to the next: displacement [m] and rotation vector [rad] in base axes.
    """

    T: Array
    place: Array
    pieces: Array
    twists: Array


def cut(settings: CheckedSettings, path: Array, turn: float = LONGEST_TURN, move: float = LONGEST_MOVE) -> Refined:
    """Cut segments longer than ``turn`` [rad] or ``move`` [fraction of the arm's size] into equal pieces."""
    twists = waypoints.twists(path[:-1], path[1:])
    longest = np.maximum(
        np.linalg.norm(twists[:, :3], axis=1) / (move * settings.solver.chain.size),
        np.linalg.norm(twists[:, 3:], axis=1) / turn,
    )
    pieces = np.maximum(1, np.ceil(longest - 1e-9)).astype(np.int64)
    if len(path) == 1 or pieces.max() == 1:
        return Refined(path, np.arange(len(path), dtype=np.float64), np.ones(len(path) - 1), twists)
    segment = np.repeat(np.arange(len(pieces)), pieces)
    inside = np.arange(len(segment)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    share = inside / pieces[segment]
    T = waypoints.interpolated(path[segment], path[segment + 1], share)
    T[share == 0.0] = path[:-1]
    T, place = np.concatenate([T, path[-1:]]), np.append(segment + share, len(path) - 1.0)
    return Refined(T, place, pieces[segment].astype(np.float64), waypoints.twists(T[:-1], T[1:]))


def priced(
    settings: CheckedSettings, refined: Refined, layers: Layers, mismatch: tuple[float, float] = MISMATCH
) -> Graph:
    """A graph with all costs of the settings."""
    graph = Graph.connected(settings, layers, refined.pieces, settings.window, mismatch)
    if np.isfinite(settings.max_step).any() and len(graph.end):
        _, dq = graph.motion(np.arange(len(graph.end)))
        pieces = refined.pieces[layers.waypoint[graph.start_of(np.arange(len(graph.end)))]]
        graph.cost[(np.abs(dq) * pieces[:, None] > settings.max_step * (1.0 + 1e-9)).any(axis=1)] = np.inf
    add_limit_costs(settings, graph)
    return graph


def add_limit_costs(settings: CheckedSettings, graph: Graph) -> None:
    """Cost of being near a joint limit: the weight times (1 - margin)^2, margin being 1 in the middle of the range."""
    if not settings.limit_cost:
        return
    joints = graph.joints
    q = graph.layers.q[:, None] + joints.digits * joints.turn
    graph.image_cost = settings.limit_cost * (1.0 - limits.margin(q, settings.solver.limits)) ** 2


def not_found(settings: CheckedSettings, path: Array, stops: Iterable[Stop]) -> Plan:
    """A plan without joint vectors, with the reasons why the path stops."""
    nothing = np.empty((0, settings.solver.dof))
    return Plan(settings.solver, path, nothing, stops=tuple(stops), obstacles=settings.obstacles)


def made(
    settings: CheckedSettings, path: Array, refined: Refined, search: Search, route: Route, *, alone: bool = False
) -> Plan:
    """The plan of a route through the graph; ``alone``: without alternatives."""
    layers, obstacles = search.graph.layers, settings.obstacles
    q = route.q
    whole = np.flatnonzero(refined.place == np.round(refined.place))
    names = settings.solver.structure.branches
    column = layers.column[route.nodes]
    changes = []
    for k in np.flatnonzero(route.edges == CHANGE):
        free = None if obstacles is None else bool(obstacles.motions_free(q[k][None], q[k + 1][None])[0])
        waypoint = int(np.ceil(refined.place[k + 1]))
        changes.append(Change(waypoint, names[column[k]], names[column[k + 1]], free))

    def others() -> tuple[Plan, ...]:
        start_columns = layers.column[: layers.first[1]]
        routes = [search.best(start_columns == column) for column in np.unique(start_columns)]
        plans = [made(settings, path, refined, search, other, alone=True) for other in routes if other is not None]
        return tuple(sorted(plans, key=lambda plan: plan.cost))

    motion, place = route.motion(refined.place)
    return Plan(
        settings.solver,
        path,
        q[whole],
        tuple(names[k] for k in column[whole]),
        route.cost,
        tuple(changes),
        motion=motion,
        place=place,
        tolerance=settings.tolerance,
        obstacles=obstacles,
        others=None if alone else others,
    )


def offer(settings: CheckedSettings, plan: Plan | None) -> None:
    """Keep a plan of the whole search, in case the time limit passes before a better one is found."""
    whole = settings.solver is settings.whole[0] and settings.obstacles is settings.whole[1]
    if plan is None or not plan.found or not whole:
        return
    best = settings.watch.best
    if best is None or plan.order < best.order:
        settings.watch.best = plan
