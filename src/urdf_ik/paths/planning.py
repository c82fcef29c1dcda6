"""``follow``: the cheapest joint motion through all waypoints, over all branches and turns."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from urdf_ik.cell.cell import Cell
from urdf_ik.ik.redundancy.values import nearest_values, only_parameter
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.ik.solver import Solver
from urdf_ik.paths import waypoints
from urdf_ik.paths.path_settings import END_TOLERANCE, LOOSER, CheckedSettings, Obstacles, PathSettings, checked
from urdf_ik.paths.planned_motion import EVERY_BRANCH, Plan, Stop, followed
from urdf_ik.paths.planner import nodes as node_sets
from urdf_ik.paths.planner import redundant
from urdf_ik.paths.planner.assembly import cut, made, not_found, offer, priced
from urdf_ik.paths.planner.nodes import WIDEST_STEP
from urdf_ik.paths.planner.search import Search
from urdf_ik.paths.planner.stops import stops_of
from urdf_ik.paths.planner.straightness import scaled
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN, shortest
from urdf_ik.support.watch import TimeIsUp
from urdf_ik.typing import Array


def follow(solver: Solver, cell: Cell, T: Any, **settings: Any) -> Plan:
    """The cheapest joint motion along a path, over all branches and turns, without a jump.

    From waypoint to waypoint the joints move linearly, and the tip provably stays within a tolerance of the
    straight segment. Where it would leave it, ``follow`` adds waypoints; ``Plan.motion`` holds them. A redundancy
    parameter is searched on a coarse grid, then on finer grids around the path found; the plan is the cheapest in
    that neighbourhood. With a free axis (:meth:`urdf_ik.Arm.with_free_axis`) the rotation about it does not count, and
    the plan never costs more than with the rotation fixed.

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
        UnsupportedArm: no solver takes this arm, or it has several redundancy parameters.
    """
    path, wanted = waypoints.read(T), PathSettings(**settings)
    if solver.require_member().parameters:
        only_parameter(solver, "follow")
    path = path if wanted.first is None else _nearest(solver, path, wanted.first, wanted.start)
    margin = inputs.number(wanted.margin, "margin", low=0.0, unit="m")
    bodies, unchecked = cell.to_check(wanted.collisions, wanted.world)
    obstacles = None if bodies is None else Obstacles(bodies, margin)
    path_settings = checked(solver, path, wanted, obstacles)
    try:
        plan = _within_limits(path_settings, _plan(path_settings, path))
        if not plan.found and path_settings.looser and any(stop.cause == "jump" for stop in plan.stops):
            # If there is no plan either, report its stops: the tolerance was not the cause.
            path_settings.watch.begin(f"looking for a plan within {LOOSER:g} times the tolerance")
            looser = replace(path_settings, tolerance=scaled(path_settings.tolerance, LOOSER))
            plan = _within_limits(looser, _plan(looser, path))
    except TimeIsUp:
        plan = _so_far(path_settings, path)
    finally:
        path_settings.watch.close()
    return followed(replace(plan, unchecked=unchecked))


def _nearest(solver: Solver, path: Array, first: str, start: Any) -> Array:
    """The poses of the nearest postures to waypoints, of each one so that misses and motions are least in all."""
    from urdf_ik.ik.closest import closest  # not needed by whole poses

    found = closest(solver, path, first=first, within_limits=True)
    joints, error = node_sets.Joints.from_chain(solver.chain), found.error
    missed = error.rotation if first == "position" else error.position / solver.chain.size
    layers = [(q[valid], each[valid] ** 2) for q, valid, each in zip(found.q, found.valid, missed, strict=True)]
    if start is not None:
        layers[0] = solver.chain.check(start)[None], np.zeros(1)
    total, before = layers[0][1], []
    for (a, _), (b, cost) in pairwise(layers):
        steps = joints.step(a[:, None], b)
        way = (
            total[:, None] + (steps * steps).sum(axis=-1) + np.where(np.abs(steps).max(axis=-1) > WIDEST_STEP, 1e6, 0.0)
        )
        before.append(way.argmin(axis=0))
        total = way.min(axis=0) + cost
    column, chosen = int(total.argmin()), []
    for (q, _), back in zip(layers[::-1], [*before[::-1], None], strict=True):
        chosen.append(q[column])
        column = column if back is None else int(back[column])
    return solver.chain.fk(np.array(chosen[::-1]))


def _so_far(settings: CheckedSettings, path: Array) -> Plan:
    """The best plan at the end of the time limit; without one, a plan that says so."""
    watch = settings.watch
    unlooked = watch.ended(f"while {watch.doing}: what comes after was")
    if watch.best is None:
        plan = not_found(settings, path, [Stop(EVERY_BRANCH, 0, "time", f"the search was {unlooked}")])
    else:
        plan = _within_limits(settings, replace(watch.best, others=lambda: ()))
    return replace(plan, unlooked=unlooked)


def _within_limits(settings: CheckedSettings, plan: Plan) -> Plan:
    """The cheapest of a plan and its alternatives that keeps to the joint limits and begins at ``start``."""
    joints = settings.joints
    uncounted = (joints.turn > 0.0) & (joints.counted == 0) & np.isfinite(settings.solver.limits).any(axis=1)
    if not plan.found or not uncounted.any():
        return plan
    if _first_beyond(settings, plan) is None:
        return replace(plan, others=lambda: tuple(p for p in plan.alternatives if _first_beyond(settings, p) is None))
    ends = [(p, _first_beyond(settings, p)) for p in plan.alternatives or (plan,)]
    kept = tuple(p for p, beyond in ends if beyond is None)
    if kept:
        return replace(kept[0], others=lambda: kept)
    stops = sorted((beyond for _, beyond in ends if beyond is not None), key=lambda stop: -stop.waypoint)
    return replace(not_found(settings, plan.poses, stops), motion=plan.motion[:0], place=plan.place[:0])


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
    if settings.solver.free_axis is not None:
        return _with_free_axis(settings, path)
    if settings.solver.parameter is not None:
        return redundant.plan(settings, path)
    solver, joints = settings.solver, settings.joints
    settings.watch.begin("solving every waypoint and looking for the cheapest way")
    refined = cut(settings, path)
    nodes = node_sets.solved(solver, joints, refined.T, np.arange(len(refined.T)), None)
    nodes = node_sets.with_ends(solver, joints, refined.T, nodes, [(settings.start, 0.0), (settings.end, 0.0)])
    nodes = node_sets.with_representatives(solver, joints, refined.T, nodes)
    graph = priced(settings, refined, nodes.layers(refined.T, refined.twists))
    search = Search(graph, proves=True)
    route = search.best()
    if route is not None:
        return made(settings, path, refined, search, route)
    graph.prove(np.arange(len(graph.end)))
    return not_found(settings, path, stops_of(settings, search, refined.T, refined.place))


def _with_free_axis(settings: CheckedSettings, path: Array) -> Plan:
    """The cheapest of the plans that turn about the free axis and the one that does not, so it never costs more."""
    fixed = _fixed(settings, path)
    offer(settings, fixed)
    turning = redundant.plan(settings, path)
    plans = [turning] if fixed is None else [turning, fixed, redundant.improved(settings, path, fixed)]
    plans = [plan for plan in plans if plan is not None and plan.found]
    if not plans:
        return turning
    best = min((plan for plan in plans if plan is not None), key=lambda plan: plan.order)
    return best if best is turning else replace(best, others=lambda: (best, *turning.alternatives))


def _fixed(settings: CheckedSettings, path: Array) -> Plan | None:
    """The plan with a constant rotation about the free axis: that of the start, else of the end, else zero."""
    solver, axis = settings.solver, settings.solver.free_axis
    assert axis is not None  # the arm has a free axis
    ends = [(q, T) for q, T in ((settings.start, path[0]), (settings.end, path[-1])) if q is not None]
    values = [nearest_values(solver, q[None], T[None])[0, 0] for q, T in ends]
    if values and abs(shortest(values[0] - values[-1])) > END_TOLERANCE:
        return None
    turned = path @ axis.rotation(values[0] if values else 0.0)
    plan = _plan(replace(settings, solver=solver.fixed), turned)
    return replace(plan, solver=solver, poses=path) if plan.found else None
