"""Paths of arms with several redundancy parameters: all but one are fixed at first, then all move together.

For each parameter in turn the others are fixed at a few values each, and the path is planned over the remaining one, as
for an arm with one parameter. If the cost is the sum of squares, the cheapest plans are improved by Gauss-Newton steps
in all parameters: every joint vector moves by N a, where N spans the null space of the task's Jacobian. To first order
the sum is a quadratic function of all a that couples only neighbours. The result is proven like any other motion; it is
the cheapest in the neighbourhood of its initial plan. With other costs the fixed parameters stay constant.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice, product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.redundancy.interval_search import span
from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.ik.solver import Solver, with_locked
from urdf_ik.kinematics.chain.redundancy import FREE_AXIS, LOCKED_JOINT
from urdf_ik.paths.path_settings import END_TOLERANCE, CheckedSettings, Obstacles
from urdf_ik.paths.planned_motion import EVERY_BRANCH, Plan, Stop
from urdf_ik.paths.planner.assembly import cut, made, not_found, offer, priced
from urdf_ik.paths.planner.nodes import Joints, Nodes
from urdf_ik.paths.planner.redundant import DENSE_MOVE, DENSE_TURN
from urdf_ik.paths.planner.search import Search
from urdf_ik.paths.planner.smoothing import restored, smoothed
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array

FIXED_VALUES = 5
"""Number of values at which a parameter is fixed, in addition to its default."""
MOST_PLANS = 16
"""Most plans with the same parameter free."""
MOST_IMPROVED = 3
"""Number of plans that are improved in all parameters, cheapest first."""


class _Fixed(NamedTuple):
    """The arm with some parameters fixed.

    Attributes:
        solver: of the arm with the one parameter that remains.
        path: (m, 4, 4) m, its waypoints.
        columns: (j,) joints that are fixed.
        values: (j,) rad or m.
    """

    solver: Solver
    path: Array
    columns: NDArray[np.intp]
    values: Array

    def whole(self, q: Array) -> Array:
        """Joint vectors (..., n) of the whole arm, from those of the remaining joints."""
        n = q.shape[-1] + len(self.columns)
        out = np.empty((*q.shape[:-1], n))
        out[..., np.delete(np.arange(n), self.columns)] = q
        out[..., self.columns] = self.values
        return out

    def remaining(self, values: Array) -> Array:
        """The entries (n - j,) of values (n,) that belong to the remaining joints."""
        return np.asarray(np.delete(values, self.columns))


class _Model:
    """The whole arm's collision model, called with joint vectors of the remaining joints."""

    def __init__(self, model: Any, fixed: _Fixed) -> None:
        self._model, self._fixed = model, fixed

    def __getattr__(self, name: str) -> Any:
        method = getattr(self._model, name)

        def call(*vectors: Any, **options: Any) -> Any:
            return method(*(self._fixed.whole(q) if isinstance(q, np.ndarray) else q for q in vectors), **options)

        return call


def plan(settings: CheckedSettings, path: Array, plan_of_one: Callable[[CheckedSettings, Array], Plan]) -> Plan:
    """The plan of an arm with several parameters; ``plan_of_one`` plans for an arm with one."""
    plans: list[Plan] = []
    stopped: Plan | None = None
    for fixed in _choices(settings, path):
        part = plan_of_one(_settings(settings, fixed), fixed.path)
        if part.found:
            plans.append(
                replace(
                    part,
                    solver=settings.solver,
                    poses=path,
                    q=fixed.whole(part.q),
                    motion=fixed.whole(part.motion),
                    obstacles=settings.obstacles,
                    others=None,
                )
            )
            offer(settings, plans[-1])
        elif stopped is None or stopped.stops[0].waypoint < part.stops[0].waypoint:
            stopped = part
    if not plans:
        labels = ", ".join(parameter.label for parameter in settings.solver.parameters)
        reason = f"start and end differ in more than one of {labels}; all but one are held"
        return not_found(settings, path, [Stop(EVERY_BRANCH, 0, "jump", reason)] if stopped is None else stopped.stops)
    plans.sort(key=lambda plan: plan.order)
    if settings.smooth:
        better = [_improved(settings, path, p) for p in plans[:MOST_IMPROVED] if not p.changes and len(p) > 1]
        plans += [plan for plan in better if plan is not None]
        plans.sort(key=lambda plan: plan.order)
    alternatives = tuple(plans)
    return replace(plans[0], others=lambda: alternatives)


def _choices(settings: CheckedSettings, path: Array) -> Iterator[_Fixed]:
    """The arm with all parameters fixed but one, for each parameter that can remain, at a few values each."""
    solver = settings.solver
    ends = [(q, T) for q, T in ((settings.start, path[0]), (settings.end, path[-1])) if q is not None]
    end_values = [nearest_values(solver, q[None], T[None])[0] for q, T in ends]
    for free in range(len(solver.parameters)):
        others = [k for k in range(len(solver.parameters)) if k != free]
        if any(solver.parameters[k].kind not in (LOCKED_JOINT, FREE_AXIS) for k in others):
            continue  # a swivel angle cannot be fixed
        choices = [_values(solver, k, end_values, path) for k in others]
        for values in islice(product(*choices), MOST_PLANS):
            yield _fixed(solver, path, dict(zip(others, values, strict=True)))


def _values(solver: Solver, k: int, end_values: list[Array], path: Array) -> list[float]:
    """Values at which a parameter is fixed: that of a given start and end, none where these differ."""
    parameter = solver.parameters[k]
    if end_values:
        step = end_values[-1][k] - end_values[0][k]
        step = shortest(np.asarray(step)) if parameter.unit == "rad" else step
        return [float(end_values[0][k])] if abs(step) < END_TOLERANCE else []
    low, high = span(solver, parameter, path)
    spread = np.linspace(low, high, FIXED_VALUES, endpoint=not parameter.round)
    distance = np.abs(spread - parameter.default)
    return [parameter.default, *(float(v) for v in spread[distance > 0.25 * (spread[1] - spread[0])])]


def _fixed(solver: Solver, path: Array, values: dict[int, float]) -> _Fixed:
    joints = {solver.parameters[k].joint: v for k, v in values.items() if solver.parameters[k].kind == LOCKED_JOINT}
    turned, rest = path, solver
    for k, value in values.items():
        if solver.parameters[k].kind == FREE_AXIS and solver.free_axis is not None:
            rest, turned = solver.fixed, path @ solver.free_axis.rotation(value)
    columns = np.array(sorted(solver.joint_names.index(name) for name in joints), dtype=np.intp)
    if joints:
        rest = with_locked(rest, joints)
    return _Fixed(rest, turned, columns, np.array([joints[solver.joint_names[k]] for k in columns]))


def _settings(settings: CheckedSettings, fixed: _Fixed) -> CheckedSettings:
    obstacles = settings.obstacles
    if obstacles is not None:
        model: Any = _Model(obstacles.model, fixed)
        obstacles = Obstacles(model, obstacles.margin)
    return replace(
        settings,
        solver=fixed.solver,
        joints=Joints.from_chain(fixed.solver.chain),
        obstacles=obstacles,
        weights=fixed.remaining(settings.weights),
        max_step=fixed.remaining(settings.max_step),
        start=None if settings.start is None else fixed.remaining(settings.start),
        end=None if settings.end is None else fixed.remaining(settings.end),
    )


def _improved(settings: CheckedSettings, path: Array, known: Plan) -> Plan | None:
    """A plan near a known one that is cheaper since all parameters move, or None."""
    dense = cut(settings, path, DENSE_TURN, DENSE_MOVE)
    place = dense.place
    q = np.column_stack([np.interp(place, known.place, column) for column in known.motion.T])
    q, good = restored(settings, dense, q)
    if not good.all():
        return None
    q = smoothed(settings, dense, q)
    names = settings.solver.structure.branches
    column = np.array([names.index(known.branches[k]) for k in np.round(place).astype(np.int64)])
    kept, lowest, counts = settings.joints.choose(q, np.ones(len(q), np.uint8))
    if len(kept) < len(q):
        return None
    nodes = Nodes(np.arange(len(q)), lowest, counts, column, np.zeros(len(q)), np.zeros(len(q), dtype=np.bool_))
    for end, k in ((settings.start, 0), (settings.end, len(q) - 1)):
        if end is not None:
            nodes.q[k], nodes.counts[k] = end, 1
    unchanged = replace(settings, reconfigure=False)
    search = Search(priced(unchanged, dense, nodes.layers(dense.T, dense.twists)), proves=True)
    route = search.best()
    if route is None or route.cost >= known.cost:
        return None
    return made(settings, path, dense, search, route, alone=True)
