"""Following a path: the cheapest joint motion through all waypoints, over all branches and turns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from urdf_ik.errors import PathError
from urdf_ik.motion import nodes as node_sets
from urdf_ik.motion import settings as settings_of
from urdf_ik.motion import waypoints
from urdf_ik.motion.graph import CHANGE, Graph, Pricing
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
    from urdf_ik.motion.straight import Tolerance

    Array = NDArray[np.float64]
    Ints = NDArray[np.int64]

FINEST = 6
"""How often a segment is cut in halves until the motions on it are proven or ruled out."""
WIDEST = 0.5 * np.pi
"""rad: the greatest step over a whole segment that may be one motion; over half of it, less."""
SHRINKS = 0.75
"""What the greatest step shrinks by when a segment is cut in halves. At a fold it shrinks by the root of a half."""
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
    if arm.redundancy is not None:
        from urdf_ik.motion import redundant

        return redundant.plan(settings, path)
    refined, nodes, graph = _graph(settings, path)
    search = Search(graph, settings.tolerance, settings.obstacles, reconfigure=reconfigure)
    way = search.best()
    if way is None:
        return Plan(
            arm, path, np.empty((0, arm.dof)), stops=stops_of(settings, search, refined.T, refined.place),
            obstacles=settings.obstacles,
        )  # fmt: skip
    return made(settings, path, refined, search, way)


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

    return Plan(
        settings.arm, path, q[whole], branches, value, tuple(changes), (), q, refined.place, settings.obstacles,
        None if alone else others,
    )  # fmt: skip


def priced(settings: Settings, refined: Refined, layers: Layers, tolerance: Tolerance) -> Graph:
    """A graph with the costs of the settings, steps and nodes."""
    pricing = Pricing(settings.kind, settings.weights, settings.window, refined.pieces)
    graph = Graph.connected(settings.joints, layers, pricing, tolerance)
    if np.isfinite(settings.max_step).any() and len(graph.end):
        _, dq = graph.motion(np.arange(len(graph.end)))
        pieces = refined.pieces[layers.at[graph.start]]
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


def _graph(settings: Settings, path: Array) -> tuple[Refined, Nodes, Graph]:
    """The graph of a path of an arm without a redundancy parameter, all edges proven or ruled out."""
    refined = cut_coarse(settings, path)
    nodes = _nodes(settings, refined.T, np.arange(len(refined.T)))
    for depth in range(FINEST + 1):
        layers = node_sets.with_representatives(settings.arm, settings.joints, refined.T, nodes).layers(refined.T)
        graph = priced(settings, refined, layers, settings.tolerance)
        graph.prove(np.arange(len(graph.end)), settings.tolerance)
        cut = np.empty(0, np.int64) if depth == FINEST else _to_cut(graph, refined)
        if not len(cut):
            break
        refined, nodes = _cut(settings, refined, nodes, cut)
    return refined, nodes, graph


def _nodes(settings: Settings, T: Array, at: Ints) -> Nodes:
    """Solutions at waypoints; at the first and the last the joint vector that is given for it, if one is."""
    arm, joints = settings.arm, settings.joints
    found = node_sets.solved(arm, joints, T, at, None)
    for given, where in ((settings.start, 0), (settings.end, len(T) - 1)):
        if given is None or where not in at:
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


def _to_cut(graph: Graph, refined: Refined) -> Ints:
    """Segments with a node that leads nowhere although the nearest of the next waypoint may be its successor."""
    layers, joints = graph.layers, graph.joints
    alive = np.isfinite(graph.cost)
    leads = np.zeros(len(layers.q), dtype=np.bool_)
    led = leads.copy()
    leads[graph.start[alive]] = True
    led[graph.end[alive]] = True
    at = layers.at
    lost = np.flatnonzero(~leads & (at < len(refined.T) - 1))
    lost_before = np.flatnonzero(~led & (at > 0))
    segments = np.intersect1d(at[lost], at[lost_before] - 1)
    cut = []
    turns = joints.turn > 0.0
    for k in segments:
        a = np.arange(layers.first[k], layers.first[k + 1])
        b = np.arange(layers.first[k + 1], layers.first[k + 2])
        a, b = a[~leads[a]], b[~led[b]]
        apart = np.abs(joints.step(layers.q[a, None], layers.q[None, b]))[..., turns].max(axis=2, initial=0.0)
        mutual = (apart == apart.min(axis=1, keepdims=True)) & (apart == apart.min(axis=0, keepdims=True))
        if (apart[mutual] <= WIDEST * SHRINKS ** np.log2(refined.pieces[k])).any():
            cut.append(k)
    return np.array(cut, dtype=np.int64)


def _cut(settings: Settings, refined: Refined, nodes: Nodes, segments: Ints) -> tuple[Refined, Nodes]:
    """Segments cut in halves, and the nodes of all waypoints."""
    T, place, pieces = refined
    middle = waypoints.interpolated(T[segments], T[segments + 1], np.full(len(segments), 0.5))
    new_T = np.insert(T, segments + 1, middle, axis=0)
    new_place = np.insert(place, segments + 1, 0.5 * (place[segments] + place[segments + 1]))
    halves = pieces.copy()
    halves[segments] *= 2.0
    moved = np.arange(len(T)) + np.searchsorted(segments, np.arange(len(T)), side="left")
    added = segments + 1 + np.arange(len(segments))
    old = nodes._replace(at=moved[nodes.at])
    fresh = node_sets.solved(settings.arm, settings.joints, new_T, added, None)
    return Refined(new_T, new_place, np.insert(halves, segments, halves[segments])), old + fresh


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
