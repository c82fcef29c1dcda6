"""``follow``: the cheapest joint motion through all waypoints, over all branches and turns."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.cell.cell import Cell
from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.ik.solver import Solver
from urdf_ik.paths import checked_settings as settings_of
from urdf_ik.paths import waypoints
from urdf_ik.paths.checked_settings import CheckedSettings
from urdf_ik.paths.followed_names import followed
from urdf_ik.paths.path_settings import PathSettings
from urdf_ik.paths.planned_motion import EVERY_BRANCH, Plan, Stop
from urdf_ik.paths.planner import nodes as node_sets
from urdf_ik.paths.planner import redundant, several_parameters
from urdf_ik.paths.planner.assembly import cut_coarse, made, not_found, offer, priced
from urdf_ik.paths.planner.nodes import Nodes
from urdf_ik.paths.planner.obstacles import Obstacles
from urdf_ik.paths.planner.search import Search
from urdf_ik.paths.planner.stops import stops_of
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN, shortest
from urdf_ik.support.watch import TimeIsUp
from urdf_ik.typing import Array

Ints = NDArray[np.int64]


def follow(solver: Solver, cell: Cell, T: Any, **settings: Any) -> Plan:
    """The cheapest joint motion along a path, over all branches and turns, without a jump.

    From waypoint to waypoint the joints move linearly, and the tip provably stays within a tolerance of the
    straight segment. Where it would leave it, ``follow`` adds waypoints; ``Plan.motion`` holds them. A redundancy
    parameter is searched on a coarse grid, then on finer grids around the path found; the plan is the cheapest in
    that neighbourhood. With a free axis (:meth:`urdf_ik.Arm.with_free_axis`) the rotation about it does not count, and
    the plan never costs more than with the rotation fixed. With several parameters, all but one are first held at a few
    values, then all are moved together: see :mod:`urdf_ik.paths.planner.several_parameters`.

    Args:
        solver: the arm's solver.
        cell: the arm's bodies.
        T: (m, 4, 4) m, waypoints; see :func:`urdf_ik.line`, :func:`urdf_ik.arc`, :func:`urdf_ik.polyline`.
        **settings: the fields of :class:`urdf_ik.paths.PathSettings`.

    Returns:
        See :class:`urdf_ik.Plan`; where ``found`` is false, ``explain()`` says how far each branch gets.

    Raises:
        ArgumentError: waypoints or a setting do not fit; the message names the valid values.
        PoseError: a waypoint is not a pose.
        UrdfError: a world is given, or ``collisions="require"``, and not all collision shapes can be read.
        UnsupportedArm: no solver takes this arm.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> T0 = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
        >>> T1 = T0.copy()
        >>> T1[1, 3] += 0.2
        >>> plan = follow(arm.solver, arm.cell, urdf_ik.line(T0, T1, 50), max_step=0.1)
        >>> plan.found, len(plan.q), len(set(plan.branches))
        (True, 50, 1)
    """
    path, given = waypoints.read(T), PathSettings(**settings)
    solver.require_member()
    margin = inputs.number(given.margin, "margin", low=0.0, unit="m")
    bodies, unchecked = cell.to_check(given.collisions, given.world)
    obstacles = None if bodies is None else Obstacles(bodies, margin)
    checked = settings_of.checked(solver, path, given, obstacles)
    try:
        plan = _within_limits(checked, _plan(checked, path))
        if not plan.found and checked.looser and any(stop.cause == "jump" for stop in plan.stops):
            # If there is no plan either, report its stops: the tolerance was not the cause.
            checked.watch.begin(f"looking for a plan within {settings_of.LOOSER:g} times the tolerance")
            looser = replace(checked, tolerance=checked.tolerance.times(settings_of.LOOSER))
            plan = _within_limits(looser, _plan(looser, path))
    except TimeIsUp:
        plan = _so_far(checked, path)
    finally:
        checked.watch.close()
    return followed(replace(plan, unchecked=unchecked))


def _so_far(settings: CheckedSettings, path: Array) -> Plan:
    """The best plan at the end of the time limit; without one, a plan that says so."""
    watch = settings.watch
    unlooked = watch.ended(f"while {watch.doing}: what comes after was")
    if watch.best is None:
        plan = not_found(settings, path, [Stop(EVERY_BRANCH, 0, "time", f"the search was {unlooked}")])
    else:
        plan = _within_limits(settings, watch.best.with_others(lambda: ()))
    return replace(plan, unlooked=unlooked)


def _within_limits(settings: CheckedSettings, plan: Plan) -> Plan:
    """The cheapest of a plan and its alternatives that keeps to the joint limits and begins at ``start``.

    The graph takes joints with many turns inside their limits for joints without limits (``Joints.counted``).
    """
    joints = settings.joints
    loose = (joints.turn > 0.0) & (joints.counted == 0) & np.isfinite(settings.solver.limits).any(axis=1)
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


def _first_beyond(settings: CheckedSettings, plan: Plan) -> Stop | None:
    """Where a plan, turned back to ``start`` by whole turns, first leaves the joint limits; None where it does not."""
    low, high = settings.solver.limits.T
    turned = 0.0 if settings.start is None else settings.start - plan.q[0]
    q = plan.motion + turned
    beyond = (q < low - LIMIT_TOLERANCE) | (q > high + LIMIT_TOLERANCE)
    if not beyond.any():
        return None
    row, k = np.argwhere(beyond)[0]
    name, turns = settings.solver.joint_names[k], (q[:, k].max() - q[:, k].min()) / TURN
    return Stop(
        plan.branches[0], int(np.ceil(plan.place[row])), "limit",
        f"{name} turns {turns:.4g} times, and its limits {np.degrees(low[k]):.4g}° and {np.degrees(high[k]):.4g}° have "
        "no room for that from where it starts",
    )  # fmt: skip


def _plan(settings: CheckedSettings, path: Array) -> Plan:
    """The plan of these settings, found or not."""
    if len(settings.solver.parameters) > 1:
        return several_parameters.plan(settings, path, _plan)
    if settings.solver.free_axis is not None:
        return _with_free_axis(settings, path)
    if settings.solver.parameter is not None:
        return redundant.plan(settings, path)
    solver, joints = settings.solver, settings.joints
    settings.watch.begin("solving every waypoint and looking for the cheapest way")
    refined = cut_coarse(settings, path)
    nodes = node_sets.with_representatives(solver, joints, refined.T, _nodes(settings, refined.T))
    graph = priced(settings, refined, nodes.layers(refined.T, refined.twists))
    search = Search(
        solver, graph, settings.tolerance, settings.obstacles, settings.watch, reconfigure=settings.reconfigure
    )
    way = search.best()
    if way is not None:
        return made(settings, path, refined, search, way)
    graph.prove(solver, np.arange(len(graph.end)), settings.tolerance)
    return not_found(settings, path, stops_of(settings, search, refined.T, refined.place))


def _with_free_axis(settings: CheckedSettings, path: Array) -> Plan:
    """The cheapest of plans that turn about the free axis and of the one that does not: it never costs more."""
    held = _held(settings, path)
    offer(settings, held)
    turning = redundant.plan(settings, path)
    plans = [turning] if held is None else [turning, held, redundant.beside(settings, path, held)]
    found = [plan for plan in plans if plan is not None and plan.found]
    if not found:
        return turning
    best = min(found, key=lambda plan: (len(plan.changes), plan.cost))
    return best if best is turning else best.with_others(lambda: (best, *turning.alternatives))


def _held(settings: CheckedSettings, path: Array) -> Plan | None:
    """The plan that keeps the rotation about a free axis as the start has it, else as the end, else at zero.

    None where there is none, or start and end differ in it.
    """
    solver, axis = settings.solver, settings.solver.free_axis
    assert axis is not None  # only such arms are asked
    given = [(q, T) for q, T in ((settings.start, path[0]), (settings.end, path[-1])) if q is not None]
    values = [nearest_values(solver, q[None], T[None])[0, 0] for q, T in given]
    if values and abs(shortest(values[0] - values[-1])) > settings_of.AT_WAYPOINT:
        return None
    turned = path @ axis.rotation(values[0] if values else 0.0)
    plan = _plan(replace(settings, solver=solver.fixed), turned)
    return replace(plan, solver=solver, poses=path) if plan.found else None


def _nodes(settings: CheckedSettings, T: Array) -> Nodes:
    """Solutions at waypoints; at the first and the last the joint vector that is given for it, if one is."""
    solver, joints = settings.solver, settings.joints
    found = node_sets.solved(solver, joints, T, np.arange(len(T)), None)
    for given, where in ((settings.start, 0), (settings.end, len(T) - 1)):
        if given is None:
            continue
        here = np.flatnonzero(found.at == where)
        apart = np.abs(joints.step(found.q[here], given)).max(axis=1)
        column = int(found.column[here[np.argmin(apart)]]) if len(here) else 0
        found = found.chosen(found.at != where) + node_sets.at_vector(solver, joints, given, where, 0.0, column)
    return found
