"""Following a path: the cheapest joint motion through all waypoints, over all branches and turns."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.paths import settings as settings_of
from urdf_ik.paths import waypoints
from urdf_ik.paths.plan import Stop
from urdf_ik.paths.planner import nodes as node_sets
from urdf_ik.paths.planner import redundant, several_parameters
from urdf_ik.paths.planner.assembly import cut_coarse, made, not_found, priced
from urdf_ik.paths.planner.obstacles import Obstacles
from urdf_ik.paths.planner.search import Search
from urdf_ik.paths.planner.stops import stops_of
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN, shortest

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.cell import World
    from urdf_ik.paths.plan import Plan
    from urdf_ik.paths.planner.nodes import Nodes
    from urdf_ik.paths.settings import Settings

    Array = NDArray[np.float64]
    Ints = NDArray[np.int64]


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
    arm.ik(path[:0])  # refuses an arm that no solver takes
    settings = settings_of.read(
        arm, path, start=start, end=end, obstacles=_obstacles(arm, world, margin, collisions), cost=cost,
        weights=weights, max_step=max_step, tolerance=tolerance, margins=margins, reconfigure=reconfigure,
    )  # fmt: skip
    plan = _within_limits(settings, _plan(settings, path))
    if plan.found or not settings.looser or all(stop.cause != "jump" for stop in plan.stops):
        return plan
    # Where there is none either, its stops are what matters: a motion that bends too much was not the cause.
    looser = replace(settings, tolerance=settings.tolerance.times(settings_of.LOOSER))
    return _within_limits(looser, _plan(looser, path))


def _within_limits(settings: Settings, plan: Plan) -> Plan:
    """The cheapest of a plan and its alternatives that keeps to the joint limits and begins at ``start``.

    The graph takes joints with many turns inside their limits for joints without limits (``Joints.counted``).
    """
    joints = settings.joints
    loose = (joints.turn > 0.0) & (joints.counted == 0) & np.isfinite(settings.arm.limits).any(axis=1)
    if not plan.found or not loose.any():
        return plan
    if _first_beyond(settings, plan) is None:
        return plan.with_others(lambda: tuple(p for p in plan.alternatives if _first_beyond(settings, p) is None))
    ends = [(each, _first_beyond(settings, each)) for each in plan.alternatives or (plan,)]
    kept = tuple(each for each, beyond in ends if beyond is None)
    if kept:
        return kept[0].with_others(lambda: kept)
    stops = sorted((beyond for _, beyond in ends if beyond is not None), key=lambda stop: -stop.waypoint)
    return replace(plan, q=plan.q[:0], branches=(), changes=(), cost=np.inf, stops=tuple(stops),
                   motion=plan.motion[:0], place=plan.place[:0], others=None)  # fmt: skip


def _first_beyond(settings: Settings, plan: Plan) -> Stop | None:
    """Where a plan, turned back to ``start`` by whole turns, first leaves the joint limits; None where it does not."""
    low, high = settings.arm.limits.T
    turned = 0.0 if settings.start is None else settings.start - plan.q[0]
    q = plan.motion + turned
    beyond = (q < low - LIMIT_TOLERANCE) | (q > high + LIMIT_TOLERANCE)
    if not beyond.any():
        return None
    row, k = np.argwhere(beyond)[0]
    name, turns = settings.arm.joint_names[k], (q[:, k].max() - q[:, k].min()) / TURN
    return Stop(
        plan.branches[0], int(np.ceil(plan.place[row])), "limit",
        f"{name} turns {turns:.4g} times, and its limits {np.degrees(low[k]):.4g}° and {np.degrees(high[k]):.4g}° have "
        "no room for that from where it starts",
    )  # fmt: skip


def _plan(settings: Settings, path: Array) -> Plan:
    """The plan of these settings, found or not."""
    if len(settings.arm.redundancies) > 1:
        return several_parameters.plan(settings, path, _plan)
    if settings.arm.free_axis is not None:
        return _with_free_axis(settings, path)
    if settings.arm.redundancy is not None:
        return redundant.plan(settings, path)
    arm, joints = settings.arm, settings.joints
    refined = cut_coarse(settings, path)
    nodes = node_sets.with_representatives(arm, joints, refined.T, _nodes(settings, refined.T))
    graph = priced(settings, refined, nodes.layers(refined.T))
    search = Search(arm, graph, settings.tolerance, settings.obstacles, reconfigure=settings.reconfigure)
    way = search.best()
    if way is not None:
        return made(settings, path, refined, search, way)
    graph.prove(arm, np.arange(len(graph.end)), settings.tolerance)
    return not_found(settings, path, stops_of(settings, search, refined.T, refined.place))


def _with_free_axis(settings: Settings, path: Array) -> Plan:
    """The cheapest of plans that turn about the free axis and of the one that does not: it never costs more."""
    held = _held(settings, path)
    turning = redundant.plan(settings, path)
    plans = [turning] if held is None else [turning, held, redundant.beside(settings, path, held)]
    found = [plan for plan in plans if plan is not None and plan.found]
    if not found:
        return turning
    best = min(found, key=lambda plan: (len(plan.changes), plan.cost))
    return best if best is turning else best.with_others(lambda: (best, *turning.alternatives))


def _held(settings: Settings, path: Array) -> Plan | None:
    """The plan that keeps the rotation about a free axis as the start has it, else as the end, else at zero.

    None where there is none, or start and end differ in it.
    """
    arm, axis = settings.arm, settings.arm.free_axis
    assert axis is not None  # only such arms are asked
    given = [(q, T) for q, T in ((settings.start, path[0]), (settings.end, path[-1])) if q is not None]
    values = [arm.nearest_values(q[None], T[None])[0, 0] for q, T in given]
    if values and abs(shortest(values[0] - values[-1])) > settings_of.AT_WAYPOINT:
        return None
    turned = path @ axis.rotation(values[0] if values else 0.0)
    plan = _plan(replace(settings, arm=arm.fixed), turned)
    return replace(plan, arm=arm, poses=path) if plan.found else None


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


def _obstacles(arm: Arm, world: World | None, margin: float, collisions: bool) -> Obstacles | None:
    margin = inputs.number(margin, "margin", low=0.0, unit="m")
    if not inputs.flag(collisions, "collisions"):
        if world is not None:
            raise ArgumentError("collisions=False given with a world; leave one of the two out")
        return None
    model = arm.collision_model
    if world is None:
        return Obstacles(model, margin) if model.has_geometry else None
    return Obstacles(model.in_world(world), margin)
