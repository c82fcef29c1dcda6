"""Paths of arms with a redundancy parameter: a coarse grid of its values finds the way, finer ones improve it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from urdf_ik.motion import nodes as node_sets
from urdf_ik.motion.follow import add_margins, cut_coarse, made, priced
from urdf_ik.motion.graph import CHANGE, Graph, Pricing
from urdf_ik.motion.plan import Plan
from urdf_ik.motion.search import Search
from urdf_ik.motion.stops import stops_of
from urdf_ik.motion.straight import Tolerance
from urdf_ik.motion.windows import narrow
from urdf_ik.redundancy.sweep import span

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.motion.follow import Refined
    from urdf_ik.motion.graph import Way
    from urdf_ik.motion.nodes import Nodes
    from urdf_ik.motion.settings import Settings

    Array = NDArray[np.float64]

GRIDS = (64, 128, 256)
"""Values of the parameter on the first grid; on the next ones where the first finds no way."""
STRAYS = Tolerance(0.02, 0.1)
"""Share of the arm's size and rad by which a motion of the first grid may stray: it is only a guide."""
STEPS = 0.6
"""rad: the greatest step of a joint from one waypoint to the next on the first grid."""
COARSE_TURN, COARSE_MOVE = 0.15, 0.05
"""rad and share of the arm's size: longer segments are cut, so that a way of the first grid can be made straight."""
FINER, LEVELS = 4, 3
"""By what each grid is finer than the one before, and how many there are."""
AROUND = 4
"""Values to each side of the way on a finer grid."""
PASSES = 3
"""How often a finer grid is laid around the way that it gave, while the cost falls."""
BETTER = 0.99


class Guide(NamedTuple):
    """A way on a grid.

    Attributes:
        q: (k, n) rad or m.
        value: (k,) of the parameter.
        column: (k,) branches.
        changes: (k - 1,) where the branch is changed.
        cost: what it costs.
    """

    q: Array
    value: Array
    column: NDArray[np.int64]
    changes: NDArray[np.bool_]
    cost: float


def plan(settings: Settings, path: Array) -> Plan:
    """The plan of an arm with a redundancy parameter."""
    arm = settings.arm
    refined = cut_coarse(settings, path, COARSE_TURN, COARSE_MOVE)
    search = None
    for count in GRIDS:
        search, step = _first(settings, refined, count)
        found = _plan(settings, path, refined, search, step, None)
        if found is not None:
            return found
    assert search is not None  # there is at least one grid
    search.graph.solve(settings.reconfigure)
    return Plan(
        arm, path, np.empty((0, arm.dof)), stops=stops_of(settings, search, refined.T, refined.place),
        obstacles=settings.obstacles,
    )  # fmt: skip


def _first(settings: Settings, refined: Refined, count: int) -> tuple[Search, float]:
    """The search on the first grid of so many values, and their distance."""
    parameter = settings.arm.redundancy
    assert parameter is not None  # only such arms are planned for here
    low, high = span(settings.arm, parameter, refined.T)
    grid = np.linspace(low, high, count, endpoint=not parameter.round)
    m = len(refined.T)
    everything = node_sets.solved(
        settings.arm,
        settings.joints,
        refined.T,
        np.arange(m),
        np.broadcast_to(grid, (m, count)),
        outside=count > GRIDS[0],
    )
    nodes = everything.chosen(np.flatnonzero(everything.counts.all(axis=1)))
    if count > GRIDS[0]:
        nodes += narrow(settings, refined.T, everything, grid)
    nodes = _ends(settings, refined, nodes)
    strays = Tolerance(STRAYS.position * settings.arm.chain.size, STRAYS.rotation)
    layers = nodes.layers(refined.T)
    window = np.where(settings.joints.turn > 0.0, STEPS, np.inf)
    pricing = Pricing(settings.kind, settings.weights, window, refined.pieces)
    graph = Graph.connected(settings.joints, layers, pricing, strays)
    add_margins(settings, graph)
    return Search(graph, None, settings.obstacles, reconfigure=settings.reconfigure), float(grid[1] - grid[0])


def _ends(settings: Settings, refined: Refined, nodes: Nodes) -> Nodes:
    """The nodes, with the joint vectors that are given for the first and the last waypoint."""
    for given, at in ((settings.start, 0), (settings.end, len(refined.T) - 1)):
        if given is None:
            continue
        value = float(settings.arm.redundancy_of(given))
        here = node_sets.solved(
            settings.arm, settings.joints, refined.T, np.array([at]), np.array([[value]]), outside=True
        )
        apart = np.abs(settings.joints.step(here.q, given)).max(axis=1)
        column = int(here.column[np.argmin(apart)]) if len(apart) else 0
        nodes = nodes.chosen(nodes.at != at) + node_sets.at_vector(
            settings.arm, settings.joints, given, at, value, column
        )
    return nodes


def _plan(
    settings: Settings,
    path: Array,
    refined: Refined,
    search: Search,
    step: float,
    starts: NDArray[np.bool_] | None,
) -> Plan | None:
    """The plan that the first grid leads to; of those that begin at some of its nodes."""
    way = search.best(starts)
    if way is None:
        return None
    guide = _guide(way)
    last: tuple[Search, Way] | None = None
    for level in range(1, LEVELS + 1):
        step /= FINER
        for _ in range(PASSES):
            finer = _around(settings, refined, guide, step, level == LEVELS)
            better = finer.best()
            if better is None:
                break
            last, before = (finer, better), guide.cost
            guide = _guide(better)
            if not guide.cost < BETTER * before:
                break
        else:
            continue
        if better is None and level == LEVELS:
            return None
    if last is None:
        return None
    plan = made(settings, path, refined, *last, alone=True)
    columns = search.graph.layers.column[: search.graph.layers.first[1]]

    def others() -> tuple[Plan, ...]:
        found = [_plan(settings, path, refined, search, FINER**LEVELS * step, columns == c) for c in np.unique(columns)]
        return tuple(sorted((each for each in found if each is not None), key=lambda each: each.cost))

    return plan if starts is not None else plan.with_others(others)


def _guide(way: Way) -> Guide:
    layers = way.graph.layers
    state = int(way.nodes[0]) * len(way.graph.joints.digits) + int(way.images[0])
    value = float(way.graph.value.reshape(-1)[state])
    return Guide(way.q, layers.value[way.nodes], layers.column[way.nodes], way.edges == CHANGE, value)


def _around(settings: Settings, refined: Refined, guide: Guide, step: float, last: bool) -> Search:
    """The search on a grid of values around a way."""
    arm, joints = settings.arm, settings.joints
    parameter = arm.redundancy
    assert parameter is not None  # only such arms are planned for here
    values = guide.value[:, None] + step * np.arange(-AROUND, AROUND + 1)
    values = parameter.wrapped(values) if parameter.round else np.clip(values, *parameter.range)
    nodes = node_sets.solved(arm, joints, refined.T, np.arange(len(refined.T)), values)
    apart = np.abs(joints.step(guide.q[nodes.at], nodes.q))[:, joints.turn > 0.0].max(axis=1, initial=0.0)
    nodes = _ends(settings, refined, nodes.chosen(apart < STEPS))
    graph = priced(
        settings, refined, nodes.layers(refined.T), settings.tolerance if last else _loosened(settings, step)
    )
    return Search(graph, settings.tolerance if last else None, settings.obstacles, reconfigure=settings.reconfigure)


def _loosened(settings: Settings, step: float) -> Tolerance:
    """How far a motion may stray on a grid that is not the last: it falls with the square of the step."""
    size = settings.arm.chain.size
    return Tolerance(
        max(settings.tolerance.position, min(STRAYS.position, 2.0 * step * step) * size),
        max(settings.tolerance.rotation, min(STRAYS.rotation, 10.0 * step * step)),
    )
