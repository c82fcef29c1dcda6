"""Paths of arms with several redundancy parameters: all but one held along the path, then all of them moved together.

For each parameter in turn, the others are held at a few values each, and the path is planned over the one that is
left, as for any arm with one. The cheapest of these plans is a plan of the arm. Where the sum of squares is what is
minimised, the cheapest ones are then improved by Gauss and Newton's method on all parameters at once: every joint
vector moves in the directions in which the tip stays where it must, q + N a, N being those directions; the sum is a
quadratic function of all a, in which only neighbours meet. What comes out is proven like any other motion. It is the
cheapest in the neighbourhood of the plans that it began with; with other costs the held parameters stay constant.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice, product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from urdf_ik.ik import preparation
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.interval_search import span
from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.redundancy import FREE_AXIS, LOCKED_JOINT
from urdf_ik.paths.checked_settings import CheckedSettings
from urdf_ik.paths.planned_motion import EVERY_BRANCH, Plan, Stop
from urdf_ik.paths.planner.assembly import Refined, cut_coarse, made, offer, priced
from urdf_ik.paths.planner.graph import COSTS
from urdf_ik.paths.planner.joint_steps import Joints
from urdf_ik.paths.planner.nodes import Nodes
from urdf_ik.paths.planner.obstacles import Obstacles
from urdf_ik.paths.planner.redundant import COARSE_MOVE, COARSE_TURN
from urdf_ik.paths.planner.search import Search
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array

VALUES = 5
"""Values at which each of the others is held, its default among them."""
MOST = 16
"""Plans with parameters held, at most, for each parameter that is not."""
IMPROVED = 3
"""How many of the cheapest of these are improved."""
ROUNDS = 30
"""Steps of Newton's method at most."""
BETTER = 0.9999
"""It goes on while the sum falls below so much of what it was."""
LONGEST = 0.2
"""rad or m: the greatest step of a joint."""
CLOSE = 1e-6
"""rad or m: values of a start and of an end that differ by less are the same."""


class Held(NamedTuple):
    """The arm with some parameters held.

    Attributes:
        arm: with one parameter left.
        path: (m, 4, 4) m, what it follows.
        columns: (j,) joints that are held.
        values: (j,) rad or m.
    """

    solver: Solver
    path: Array
    columns: NDArray[np.intp]
    values: Array

    def whole(self, q: Array) -> Array:
        """Joint vectors (..., n) of the whole arm, from those of the arm that is left."""
        n = q.shape[-1] + len(self.columns)
        out = np.empty((*q.shape[:-1], n))
        out[..., np.delete(np.arange(n), self.columns)] = q
        out[..., self.columns] = self.values
        return out

    def left(self, values: Array) -> Array:
        """What is given for each joint (n,), without those that are held."""
        return np.asarray(np.delete(values, self.columns))


class Seen:
    """A collision model that is asked about joint vectors of the arm that is left."""

    def __init__(self, model: Any, held: Held) -> None:
        """Take the whole arm's model."""
        self._model, self._held = model, held

    def __getattr__(self, name: str) -> Any:
        asked = getattr(self._model, name)

        def answer(*vectors: Any, **options: Any) -> Any:
            return asked(*(self._held.whole(q) if isinstance(q, np.ndarray) else q for q in vectors), **options)

        return answer


def plan(settings: CheckedSettings, path: Array, plan_of_one: Callable[[CheckedSettings, Array], Plan]) -> Plan:
    """The plan of an arm with several parameters; ``plan_of_one`` plans for an arm with one."""
    found: list[Plan] = []
    stopped: Plan | None = None
    for held in _ways(settings, path):
        one = plan_of_one(_settings(settings, held), held.path)
        if one.found:
            found.append(replace(one, solver=settings.solver, poses=path,
                                 q=held.whole(one.q), motion=held.whole(one.motion),
                                 obstacles=settings.obstacles, others=None))  # fmt: skip
            offer(settings, found[-1])
        elif stopped is None or stopped.stops[0].waypoint < one.stops[0].waypoint:
            stopped = one
    if not found:
        nothing = np.empty((0, settings.solver.dof))
        stops = (_ends_differ(settings),) if stopped is None else stopped.stops
        return Plan(settings.solver, path, nothing, stops=stops, obstacles=settings.obstacles)
    found.sort(key=_order)
    if COSTS[settings.kind] == "l2" and not settings.limit_cost:
        better = (_improved(settings, path, each) for each in found[:IMPROVED] if not each.changes and len(each) > 1)
        found += [each for each in better if each is not None]
        found.sort(key=_order)
    others = tuple(found)
    return found[0].with_others(lambda: others)


def _order(each: Plan) -> tuple[int, float]:
    return len(each.changes), each.cost


def _ends_differ(settings: CheckedSettings) -> Stop:
    labels = ", ".join(parameter.label for parameter in settings.solver.parameters)
    return Stop(EVERY_BRANCH, 0, "jump", f"start and end differ in more than one of {labels}; all but one are held")


def _ways(settings: CheckedSettings, path: Array) -> Iterator[Held]:
    """The arm with all parameters held but one, for each that can be the one, at a few values each."""
    solver = settings.solver
    ends = [(q, T) for q, T in ((settings.start, path[0]), (settings.end, path[-1])) if q is not None]
    given = [nearest_values(solver, q[None], T[None])[0] for q, T in ends]
    for left in range(len(solver.parameters)):
        others = [k for k in range(len(solver.parameters)) if k != left]
        if any(solver.parameters[k].kind not in (LOCKED_JOINT, FREE_AXIS) for k in others):
            continue  # a swivel angle is not held
        choices = [_values(solver, k, given, path) for k in others]
        for values in islice(product(*choices), MOST):
            yield _held(solver, path, dict(zip(others, values, strict=True)))


def _values(solver: Solver, k: int, given: list[Array], path: Array) -> list[float]:
    """Values at which a parameter is held: those of the start and the end, where they are given and agree."""
    parameter = solver.parameters[k]
    if given:
        step = given[-1][k] - given[0][k]
        step = shortest(np.asarray(step)) if parameter.unit == "rad" else step
        return [float(given[0][k])] if abs(step) < CLOSE else []
    low, high = span(solver, parameter, path)
    spread = np.linspace(low, high, VALUES, endpoint=not parameter.round)
    apart = np.abs(spread - parameter.default)
    return [parameter.default, *(float(v) for v in spread[apart > 0.25 * (spread[1] - spread[0])])]


def _held(solver: Solver, path: Array, values: dict[int, float]) -> Held:
    joints = {solver.parameters[k].joint: v for k, v in values.items() if solver.parameters[k].kind == LOCKED_JOINT}
    turned, rest = path, solver
    for k, value in values.items():
        if solver.parameters[k].kind == FREE_AXIS and solver.free_axis is not None:
            rest, turned = solver.fixed, path @ solver.free_axis.rotation(value)
    columns = np.array(sorted(solver.joint_names.index(name) for name in joints), dtype=np.intp)
    if joints:
        rest = preparation.with_locked(rest, joints)
    return Held(rest, turned, columns, np.array([joints[solver.joint_names[k]] for k in columns]))


def _settings(settings: CheckedSettings, held: Held) -> CheckedSettings:
    obstacles = settings.obstacles
    if obstacles is not None:
        model: Any = Seen(obstacles.model, held)
        obstacles = Obstacles(model, obstacles.margin)
    return replace(
        settings, solver=held.solver, joints=Joints.of(held.solver.chain), obstacles=obstacles,
        weights=held.left(settings.weights), max_step=held.left(settings.max_step),
        start=None if settings.start is None else held.left(settings.start),
        end=None if settings.end is None else held.left(settings.end),
    )  # fmt: skip


def _improved(settings: CheckedSettings, path: Array, known: Plan) -> Plan | None:
    """A plan that is cheaper than one that is known, all parameters moving; None where none is found beside it."""
    whole = cut_coarse(settings, path, COARSE_TURN, COARSE_MOVE)
    place = whole.place
    q = np.column_stack([np.interp(place, known.place, column) for column in known.motion.T])
    q, good = _restored(settings, whole, q)
    if not good.all():
        return None
    q = _smoothed(settings, whole, q)
    names = settings.solver.structure.branches
    column = np.array([names.index(known.branches[k]) for k in np.round(place).astype(np.int64)])
    ones = np.ones(len(q), np.uint8)
    kept, lowest, counts = settings.joints.choose(q, ones)
    if len(kept) < len(q):
        return None
    nodes = Nodes(np.arange(len(q)), lowest, counts, column, np.zeros(len(q)), np.zeros(len(q), dtype=np.bool_))
    for given, at in ((settings.start, 0), (settings.end, len(q) - 1)):
        if given is not None:
            nodes.q[at], nodes.counts[at] = given, 1
    search = Search(settings.solver, priced(settings, whole, nodes.layers(whole.T, whole.twists)), settings.tolerance,
                    settings.obstacles, settings.watch)  # fmt: skip
    way = search.best()
    if way is None or way.cost >= known.cost:
        return None
    return made(settings, path, whole, search, way, alone=True)


def _smoothed(settings: CheckedSettings, refined: Refined, q: Array) -> Array:
    """Joint vectors (k, n) moved to where the sum of squared steps is least nearby, the tip where it was."""
    factor = np.sqrt(settings.weights) * np.sqrt(refined.pieces)[:, None]
    fixed = np.zeros(len(q), dtype=np.bool_)
    fixed[0], fixed[-1] = settings.start is not None, settings.end is not None
    low, high = settings.solver.limits.T
    least = _sum(q, factor)
    for _ in range(ROUNDS):
        N = _idle(settings, refined, q)
        N[fixed] = 0.0
        step = np.einsum("knj,kj->kn", N, _newton(q, N, factor))
        longest = np.abs(step).max()
        step *= min(1.0, LONGEST / longest) if longest else 1.0
        best = None
        for share in (1.0, 0.5, 0.25, 0.1):
            tried, good = _restored(settings, refined, q + share * step)
            good &= ((tried >= low) & (tried <= high)).all(axis=1)
            if settings.obstacles is not None:
                good[good] = settings.obstacles.free(tried[good])
            tried = np.where(good[:, None] & ~fixed[:, None], tried, q)
            total = _sum(tried, factor)
            if total < least:
                best = total, tried
                break
        if best is None:
            break
        before, (least, q) = least, best
        if not least < BETTER * before:
            break
    return q


def _sum(q: Array, factor: Array) -> float:
    return float(((np.diff(q, axis=0) * factor) ** 2).sum())


def _newton(q: Array, N: Array, factor: Array) -> Array:
    """(k, j) how far to go along the idle directions (k, n, j) to the minimum of the sum."""
    k, _, j = N.shape
    left, right = N[:-1] * factor[:, :, None], N[1:] * factor[:, :, None]
    gap = np.diff(q, axis=0) * factor
    diagonal, towards = np.zeros((k, j, j)), np.zeros((k, j))
    diagonal[:-1] += np.einsum("kni,knj->kij", left, left)
    diagonal[1:] += np.einsum("kni,knj->kij", right, right)
    towards[:-1] += np.einsum("kni,kn->ki", left, gap)
    towards[1:] -= np.einsum("kni,kn->ki", right, gap)
    beside = -np.einsum("kni,knj->kij", left, right)
    # The small share keeps the system solvable where a whole way can slide, or a vector stays.
    diagonal += 1e-9 * np.eye(j) * max(float(np.abs(diagonal).max()), 1e-12)
    banded = np.zeros((2 * j, k * j))
    for a in range(j):
        for b in range(j):
            if a <= b:
                banded[2 * j - 1 + a - b, b::j] = diagonal[:, a, b]
            banded[j - 1 + a - b, j + b :: j] = beside[:, a, b]
    return np.asarray(solveh_banded(banded, towards.ravel(), check_finite=False)).reshape(k, j)


def _idle(settings: CheckedSettings, refined: Refined, q: Array) -> Array:
    """(k, n, j) orthonormal directions in which joint vectors may move while the tip stays where it must."""
    J = _jacobian(settings, refined, q)
    return np.ascontiguousarray(np.swapaxes(np.linalg.svd(J)[2], 1, 2)[:, :, -len(settings.solver.parameters) :])


def _jacobian(settings: CheckedSettings, refined: Refined, q: Array) -> Array:
    """(k, 6, n), without what does not count; lengths as shares of the arm's size."""
    solver = settings.solver
    J = solver.chain.jacobian(q)
    if solver.free_axis is not None:
        J = solver.free_axis.reduced(refined.T[:, :3, :3], J)
    return np.concatenate([J[:, :3] / solver.chain.size, J[:, 3:]], axis=1)


def _restored(settings: CheckedSettings, refined: Refined, q: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Joint vectors (k, n) brought to their waypoints, solved anew, and which of them got there."""
    solver = settings.solver
    values: Any = nearest_values(solver, q, refined.T)
    solutions = solve(solver, refined.T, redundancy=values if values.shape[1] > 1 else values[:, 0])
    steps = settings.joints.step(q[:, None], solutions.q)
    apart = np.where(solutions.valid, np.abs(steps).max(axis=2), np.inf)
    column = np.argmin(apart, axis=1)
    rows = np.arange(len(q))
    return q + np.nan_to_num(steps[rows, column]), apart[rows, column] < LONGEST
