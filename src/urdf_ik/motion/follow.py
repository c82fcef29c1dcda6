"""Following a path: the cheapest joint motion through all waypoints, over all branches and turns."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from urdf_ik.errors import PathError
from urdf_ik.motion import nodes as node_sets
from urdf_ik.motion import settings as settings_of
from urdf_ik.motion import waypoints
from urdf_ik.motion.graph import CHANGE, MISMATCH, Graph, Pricing
from urdf_ik.motion.obstacles import Obstacles
from urdf_ik.motion.plan import Change
from urdf_ik.motion.plan import Plan as Plan
from urdf_ik.motion.search import Search
from urdf_ik.motion.stops import stops_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.collision import World
    from urdf_ik.motion.graph import Layers, Way
    from urdf_ik.motion.nodes import Nodes
    from urdf_ik.motion.settings import Settings

    Array = NDArray[np.float64]
    Ints = NDArray[np.int64]

COARSE_TURN, COARSE_MOVE = 0.5, 0.15
"""rad and share of the arm's size: longer segments are cut before anything is looked at."""


class Refined(NamedTuple):
    """Waypoints with others between them.

    Attributes:
        T: (k, 4, 4) m.
        place: (k,) 2.5 is half way from waypoint 2 to waypoint 3.
        pieces: (k - 1,) in how many pieces the segment was cut that each piece belongs to.
    """

    T: Array
    place: Array
    pieces: Array


def follow(
    arm: Arm,
    T: Any,
    *,
    start: Any = None,
    end: Any = None,
    world: World | None = None,
    margin: float = 0.0,
    collisions: bool = True,
    cost: str = "l2",
    weights: Any = None,
    margins: float = 0.0,
    max_step: Any = None,
    tolerance: Any = None,
    reconfigure: bool = False,
) -> Plan:
    """See :meth:`urdf_ik.Arm.follow`."""
    path = waypoints.read(T)
    settings = settings_of.read(
        arm, path, start=start, end=end, obstacles=_obstacles(arm, world, margin, collisions), cost=cost,
        weights=weights, max_step=max_step, tolerance=tolerance, margins=margins, reconfigure=reconfigure,
    )  # fmt: skip
    plan = _plan(settings, path)
    if plan.found or not settings.looser:
        return plan
    looser = replace(settings, tolerance=settings.tolerance.times(settings_of.LOOSER))
    found = _plan(looser, path)
    return found if found.found else plan


def _plan(settings: Settings, path: Array) -> Plan:
    """The plan of these settings, found or not."""
    if settings.arm.redundancy is not None:
        from urdf_ik.motion import redundant

        return redundant.plan(settings, path)
    arm, joints = settings.arm, settings.joints
    refined = cut_coarse(settings, path)
    nodes = node_sets.with_representatives(arm, joints, refined.T, _nodes(settings, refined.T))
    graph = priced(settings, refined, nodes.layers(refined.T))
    graph.prove(arm, np.arange(len(graph.end)), settings.tolerance)
    search = Search(arm, graph, settings.tolerance, settings.obstacles, reconfigure=settings.reconfigure)
    way = search.best()
    return not_found(settings, path, refined, search) if way is None else made(settings, path, refined, search, way)


def not_found(settings: Settings, path: Array, refined: Refined, search: Search) -> Plan:
    """The plan that says what stops the path."""
    stops = stops_of(settings, search, refined.T, refined.place)
    return Plan(settings.arm, path, np.empty((0, settings.arm.dof)), stops=stops, obstacles=settings.obstacles)


def made(settings: Settings, path: Array, refined: Refined, search: Search, way: Way, *, alone: bool = False) -> Plan:
    """The plan of a way."""
    graph, layers = search.graph, search.graph.layers
    q = way.q
    whole = np.flatnonzero(refined.place == np.round(refined.place))
    names = settings.arm.structure.branches
    branches = tuple(names[layers.column[node]] for node in way.nodes[whole])
    changes = []
    for k in np.flatnonzero(way.edges == CHANGE):
        waypoint = int(np.ceil(refined.place[k + 1]))
        free = None if search.obstacles is None else bool(search.obstacles.motions_free(q[k][None], q[k + 1][None])[0])
        changes.append(
            Change(waypoint, names[layers.column[way.nodes[k]]], names[layers.column[way.nodes[k + 1]]], free)
        )
    states = len(graph.joints.digits)
    value = float(graph.value.reshape(-1)[way.nodes[0] * states + way.images[0]])

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
        settings.arm, path, q[whole], branches, value, tuple(changes), (), motion, place, _kept(settings),
        settings.obstacles, None if alone else others,
    )  # fmt: skip


def _kept(settings: Settings) -> tuple[float, float]:
    return settings.tolerance.position, settings.tolerance.rotation


def priced(settings: Settings, refined: Refined, layers: Layers, mismatch: tuple[float, float] = MISMATCH) -> Graph:
    """A graph with the costs of the settings, steps and nodes."""
    pricing = Pricing(settings.kind, settings.weights, settings.window, refined.pieces)
    graph = Graph.connected(settings.joints, layers, pricing, mismatch)
    if np.isfinite(settings.max_step).any() and len(graph.end):
        _, dq = graph.motion(np.arange(len(graph.end)))
        pieces = refined.pieces[layers.at[graph.start_of(np.arange(len(graph.end)))]]
        graph.cost[(np.abs(dq) * pieces[:, None] > settings.max_step * (1.0 + 1e-9)).any(axis=1)] = np.inf
    add_margins(settings, graph)
    return graph


def add_margins(settings: Settings, graph: Graph) -> None:
    """The cost of being near a joint limit: weight times (1 - share of the way to the middle of the range)^2."""
    if not settings.margins:
        return
    low, high = settings.arm.limits.T
    joints = graph.joints
    q = graph.layers.q[:, None] + joints.digits * joints.turn
    bounded = np.isfinite(high - low)
    with np.errstate(invalid="ignore"):
        off = np.abs(2.0 * (q - low) / np.where(bounded, high - low, 1.0) - 1.0)
    graph.node_cost += settings.margins * np.where(bounded, off, 0.0).max(axis=2) ** 2


def _nodes(settings: Settings, T: Array) -> Nodes:
    """Solutions at waypoints; at the first and the last the joint vector that is given for it, if one is."""
    arm, joints = settings.arm, settings.joints
    found = node_sets.solved(arm, joints, T, np.arange(len(T)), None)
    for given, where in ((settings.start, 0), (settings.end, len(T) - 1)):
        if given is None:
            continue
        here = np.flatnonzero(found.at == where)
        apart = np.abs(joints.step(found.q[here], given)).max(axis=1)
        column = int(found.column[here[np.argmin(apart)]]) if len(here) else 0
        found = found.chosen(found.at != where) + node_sets.at_vector(arm, joints, given, where, 0.0, column)
    return found


def cut_coarse(
    settings: Settings, path: Array, most_turn: float = COARSE_TURN, most_move: float = COARSE_MOVE
) -> Refined:
    """Longer segments cut into equal pieces."""
    apart = waypoints.twists(path[:-1], path[1:])
    longest = np.maximum(
        np.linalg.norm(apart[:, :3], axis=1) / (most_move * settings.arm.chain.size),
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


def _obstacles(arm: Arm, world: World | None, margin: float, collisions: bool) -> Obstacles | None:
    if not 0.0 <= margin < np.inf:
        raise PathError(f"a margin of {margin} given; it must be zero or a positive number of m")
    if not collisions:
        if world is not None:
            raise PathError("collisions=False given with a world; leave one of the two out")
        return None
    model = arm.collision_model
    if world is None:
        return Obstacles(model, margin) if model.has_geometry else None
    return Obstacles(model.in_world(world), margin)
