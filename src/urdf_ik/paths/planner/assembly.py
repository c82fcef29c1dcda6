"""Steps that all planners share: cutting long segments, pricing motions, making the plan."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from urdf_ik.ik.solutions import limits
from urdf_ik.paths import waypoints
from urdf_ik.paths.checked_settings import CheckedSettings
from urdf_ik.paths.planned_motion import Change, Plan, Stop
from urdf_ik.paths.planner.graph import CHANGE, MISMATCH, Graph, Layers, Pricing, Way
from urdf_ik.paths.planner.search import Search
from urdf_ik.typing import Array

COARSE_TURN, COARSE_MOVE = 0.5, 0.15
"""rad and share of the arm's size: longer segments are cut into equal pieces before the arm is solved."""


@dataclass(frozen=True)
class Refined:
    """The given waypoints, and others between them.

    Attributes:
        T: (k, 4, 4) m.
        place: (k,) where each one is: 2.5 is half way from given waypoint 2 to given waypoint 3.
        pieces: (k - 1,) at each piece, how many equal ones the segment between two given waypoints was cut into.
    """

    T: Array
    place: Array
    pieces: Array

    @cached_property
    def twists(self) -> Array:
        """(k - 1, 6) from each waypoint to the next: displacement [m] and rotation vector [rad] in base axes."""
        return waypoints.twists(self.T[:-1], self.T[1:])


def not_found(settings: CheckedSettings, path: Array, stops: Iterable[Stop]) -> Plan:
    """The plan without joint vectors, which says what stops the path."""
    nothing = np.empty((0, settings.solver.dof))
    return Plan(settings.solver, path, nothing, stops=tuple(stops), obstacles=settings.obstacles)


def made(
    settings: CheckedSettings, path: Array, refined: Refined, search: Search, way: Way, *, alone: bool = False
) -> Plan:
    """The plan that a way through the graph is; ``alone``: without alternatives."""
    layers = search.graph.layers
    q = way.q
    whole = np.flatnonzero(refined.place == np.round(refined.place))
    names = settings.solver.structure.branches
    branches = tuple(names[layers.column[node]] for node in way.nodes[whole])
    changes = []
    for k in np.flatnonzero(way.edges == CHANGE):
        waypoint = int(np.ceil(refined.place[k + 1]))
        free = None if search.obstacles is None else bool(search.obstacles.motions_free(q[k][None], q[k + 1][None])[0])
        changes.append(
            Change(waypoint, names[layers.column[way.nodes[k]]], names[layers.column[way.nodes[k + 1]]], free)
        )

    def others() -> tuple[Plan, ...]:
        found = []
        columns = layers.column[: layers.first[1]]
        for column in np.unique(columns):
            other = search.best(columns == column)
            if other is not None:
                found.append(made(settings, path, refined, search, other, alone=True))
        return tuple(sorted(found, key=lambda plan: plan.cost))

    motion, place = way.motion(refined.place)
    return Plan(
        settings.solver, path, q[whole], branches, way.cost, tuple(changes), (), motion, place, _kept(settings),
        settings.obstacles, None if alone else others,
    )  # fmt: skip


def offer(settings: CheckedSettings, plan: Plan | None) -> None:
    """Keep a plan of the whole search for the case that the time limit passes before a better one is found."""
    if plan is None or not plan.found or settings.solver is not settings.whole[0]:
        return
    if settings.obstacles is not settings.whole[1]:
        return
    best = settings.watch.best
    if best is None or (len(plan.changes), plan.cost) < (len(best.changes), best.cost):
        settings.watch.best = plan


def _kept(settings: CheckedSettings) -> tuple[float, float]:
    return settings.tolerance.position, settings.tolerance.rotation


def priced(
    settings: CheckedSettings, refined: Refined, layers: Layers, mismatch: tuple[float, float] = MISMATCH
) -> Graph:
    """A graph with the costs of the settings, steps and nodes."""
    pricing = Pricing(settings.kind, settings.weights, settings.window, refined.pieces)
    graph = Graph.connected(settings.joints, layers, pricing, mismatch, settings.solver.free_axis)
    if np.isfinite(settings.max_step).any() and len(graph.end):
        _, dq = graph.motion(np.arange(len(graph.end)))
        pieces = refined.pieces[layers.at[graph.start_of(np.arange(len(graph.end)))]]
        graph.cost[(np.abs(dq) * pieces[:, None] > settings.max_step * (1.0 + 1e-9)).any(axis=1)] = np.inf
    add_margins(settings, graph)
    return graph


def add_margins(settings: CheckedSettings, graph: Graph) -> None:
    """The cost of being near a joint limit: weight times (1 - share of the way to the middle of the range)^2."""
    if not settings.limit_cost:
        return
    joints = graph.joints
    q = graph.layers.q[:, None] + joints.digits * joints.turn
    graph.image_cost = settings.limit_cost * (1.0 - limits.margin(q, settings.solver.limits)) ** 2


def cut_coarse(
    settings: CheckedSettings, path: Array, most_turn: float = COARSE_TURN, most_move: float = COARSE_MOVE
) -> Refined:
    """Longer segments cut into equal pieces."""
    apart = waypoints.twists(path[:-1], path[1:])
    longest = np.maximum(
        np.linalg.norm(apart[:, :3], axis=1) / (most_move * settings.solver.chain.size),
        np.linalg.norm(apart[:, 3:], axis=1) / most_turn,
    )
    pieces = np.maximum(1, np.ceil(longest - 1e-9)).astype(np.int64)
    if len(path) == 1 or pieces.max() == 1:
        return Refined(path, np.arange(len(path), dtype=np.float64), np.ones(len(path) - 1))
    segment = np.repeat(np.arange(len(pieces)), pieces)
    inside = np.arange(len(segment)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    share = inside / pieces[segment]
    T = waypoints.interpolated(path[segment], path[segment + 1], share)
    T[share == 0.0] = path[:-1]
    return Refined(
        np.concatenate([T, path[-1:]]), np.append(segment + share, len(path) - 1.0), pieces[segment].astype(np.float64)
    )
