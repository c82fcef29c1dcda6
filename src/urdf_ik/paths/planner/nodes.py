"""The joint vectors at each waypoint: the nodes of the planner's graph, and how the arm's joints turn between them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from urdf_ik import _core
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.solutions import limits
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.angles import TURN
from urdf_ik.typing import Array

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]
R = TypeVar("R", bound=tuple[Any, ...])

MOST_IMAGES = 5
"""A joint with more values 2 pi apart inside its limits than this is planned as if it had no limits."""
MOST_STATES = 1024
"""Most combinations of such values per node; above it, the joints with the most values lose their limits."""
SAME_VECTOR = 1e-6
"""Joint vectors that differ by less in every joint are one node [rad or m]."""
WIDEST_STEP = 0.5 * np.pi
"""Largest change of a joint within one linear motion [rad or m]."""
TANGENT_STEPS = 8
"""Most iterations when the singular solution nearest to a reference is looked for."""
ZERO_SINGULAR_VALUE = 1e-4
"""Singular values of the Jacobian below this fraction of the largest are taken as zero."""
WINDOW_HALVINGS = 6
"""Halvings of the step when a narrow window inside the joint limits is looked for."""
_BATCH = 1 << 22
"""Most numbers in the solutions of one call of the solver (32 MB)."""


@dataclass(frozen=True)
class Joints:
    """How the joints of an arm turn.

    Attributes:
        chain: the arm's joints.
        turn: (n,) rad between images (values a whole turn apart), 0 for a joint that slides.
        counted: (n,) uint8, whether the joint's images are distinct states.
        digits: (states, n) uint8, number of each joint's image in each state.
        strides: (n,) difference of the state's number between neighbouring images of a joint.
        core: the compiled functions.
    """

    chain: Chain
    turn: Array
    counted: NDArray[np.uint8]
    digits: NDArray[np.uint8]
    strides: Ints
    core: _core.PathGraph

    @classmethod
    def from_chain(cls, chain: Chain) -> "Joints":
        """The joints of a chain."""
        low, high = (np.ascontiguousarray(side) for side in chain.limits.T)
        turn = TURN * np.asarray(chain.image_turns, dtype=np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            images = np.where(turn > 0.0, np.floor((high - low + 2.0 * LIMIT_TOLERANCE) / turn) + 1.0, 1.0)
        counted = (turn > 0.0) & (images <= MOST_IMAGES)
        while np.prod(images, where=counted) > MOST_STATES:
            counted[np.argmax(np.where(counted, images, 0.0))] = False
        radix = np.where(counted, images, 1.0).astype(np.int64)
        strides = np.concatenate([np.cumprod(radix[::-1])[::-1][1:], [1]]).astype(np.int64)
        digits = np.indices(tuple(radix)).reshape(len(radix), -1).T.astype(np.uint8)
        flags = counted.astype(np.uint8)
        core = _core.PathGraph(low - LIMIT_TOLERANCE, high + LIMIT_TOLERANCE, turn, flags)
        return cls(chain, turn, flags, np.ascontiguousarray(digits), strides, core)

    def choose(
        self, q: Array, flags: NDArray[np.uint8], centres: Array | None = None, near: float = 0.0, outside: bool = False
    ) -> tuple[Ints, Array, NDArray[np.uint8]]:
        """Joint vectors inside the limits: their indices (k,), lowest images (k, n) and numbers of images (k, n).

        Args:
            q: (m, n) rad or m.
            flags: (m,) bit 0: a solution.
            centres: (c, n) rad or m, one for m / c consecutive joint vectors; those far from it are left out.
            near: largest distance of a turning joint from its centre [rad].
            outside: also return joint vectors outside the limits, with zero images.
        """
        kept, lowest, counts = np.empty(len(q), np.int64), np.empty(q.shape), np.empty(q.shape, np.uint8)
        count = self.core.choose(
            np.ascontiguousarray(q), np.ascontiguousarray(flags), centres, near, outside, kept, lowest, counts
        )
        return kept[:count], lowest[:count], counts[:count]

    def step(self, a: Array, b: Array) -> Array:
        """Shortest motion (..., n) from joint vectors a to b; turning joints take the short side of the circle."""
        turn = np.where(self.turn > 0.0, self.turn, 1.0)
        difference: Array = b - a
        return difference - np.where(self.turn > 0.0, np.round(difference / turn) * turn, 0.0)

    def central(self, q: Array) -> Array:
        """The images of joint vectors (..., n) that are nearest to the middle of the limits."""
        turn = np.where(self.turn > 0.0, self.turn, 1.0)
        middle = limits.middle(self.chain.limits)
        return np.asarray(q - np.where(self.turn > 0.0, np.round((q - middle) / turn) * turn, 0.0))

    def room(self, q: Array) -> Array:
        """Distance (k,) of joint vectors (k, n) from the limits, negative outside [rad or m]; of the best images."""
        return limits.room(self.central(q), self.chain.limits)


@dataclass
class Layers:
    """The nodes of a path, waypoint by waypoint.

    Attributes:
        T: (m, 4, 4) m, the waypoints.
        twists: (m - 1, 6) from each waypoint to the next: displacement [m] and rotation vector [rad] in base axes.
        first: (m + 1,) index of each waypoint's first node.
        q: (N, n) rad or m, the lowest image of each joint inside the limits.
        counts: (N, n) uint8, number of images of each joint.
        column: (N,) number of the branch.
        value: (N,) redundancy parameter, 0 for an arm without one.
    """

    T: Array
    twists: Array
    first: Ints
    q: Array
    counts: NDArray[np.uint8]
    column: Ints
    value: Array

    @property
    def waypoint(self) -> Ints:
        """(N,) waypoint of each node."""
        return np.repeat(np.arange(len(self.T)), np.diff(self.first))


class Nodes(NamedTuple):
    """Joint vectors at waypoints, in any order.

    Attributes:
        waypoint: (k,) number of the waypoint.
        q: (k, n) rad or m, the lowest image of each joint inside the limits.
        counts: (k, n) uint8, number of images of each joint.
        column: (k,) number of the branch.
        value: (k,) redundancy parameter.
        singular: (k,) whether the arm is singular there.
    """

    waypoint: Ints
    q: Array
    counts: NDArray[np.uint8]
    column: Ints
    value: Array
    singular: Mask

    def layers(self, T: Array, twists: Array) -> Layers:
        """Sort the nodes by waypoint: poses T (m, 4, 4), with the twists (m - 1, 6) from each to the next."""
        order = np.argsort(self.waypoint, kind="stable")
        first = np.searchsorted(self.waypoint[order], np.arange(len(T) + 1)).astype(np.int64)
        return Layers(T, twists, first, self.q[order], self.counts[order], self.column[order], self.value[order])


def chosen(record: R, which: Any) -> R:
    """The rows of a record of arrays that a mask or indices select."""
    make: Any = type(record)
    return make(*(column[which] for column in record))  # type: ignore[no-any-return]


def joined(records: Sequence[R]) -> R:
    """All rows of several records of arrays."""
    make: Any = type(records[0])
    return make(*(np.concatenate(columns) for columns in zip(*records, strict=True)))  # type: ignore[no-any-return]


def solved(
    solver: Solver,
    joints: Joints,
    T: Array,
    waypoints: Ints,
    values: Array | None,
    *,
    outside: bool = False,
    centres: Array | None = None,
    near: float = 0.0,
) -> Nodes:
    """All solutions inside the joint limits.

    Args:
        solver: the arm's solver.
        joints: the arm's joints.
        T: (m, 4, 4) m, poses of the path.
        waypoints: (k,) which of them to solve.
        values: (k, v) of the redundancy parameter, None for an arm without one.
        outside: also return solutions outside the limits, with zero images.
        centres: (k, n) joint vectors; solutions far from them are left out.
        near: largest distance of a turning joint from its centre [rad].
    """
    size = solver.dof * len(solver.structure.branches) * (1 if values is None else values.shape[1])
    share = max(1, _BATCH // size)
    parts = []
    for k in range(0, max(len(waypoints), 1), share):
        batch = waypoints[k : k + share]
        v = None if values is None else values[k : k + share]
        solutions = solve(solver, T[batch]) if v is None else solve(solver, T[batch, None], redundancy=v)
        flags = (solutions.valid | (solutions.singular << np.uint8(1))).reshape(-1)
        around = None if centres is None else centres[k : k + share]
        kept, q, counts = joints.choose(solutions.q.reshape(-1, solver.dof), flags, around, near, outside)
        pose, column = np.divmod(kept, solutions.valid.shape[-1])
        row, value = (pose, np.zeros(len(kept))) if v is None else (pose // v.shape[1], v.reshape(-1)[pose])
        parts.append(Nodes(batch[row], q, counts, column, value, flags[kept] > 1))
    return joined(parts)


def nearest_solutions(solver: Solver, joints: Joints, T: Array, q: Array, values: Array | None) -> tuple[Array, Array]:
    """The solutions (k, n) of poses T (k, 4, 4) nearest to joint vectors q (k, n), and their distances (k,).

    ``values`` (k, 1) are those of the redundancy parameter, None for an arm without one. The distance is the largest
    change of a joint [rad or m], infinite where a pose has no solution.
    """
    solutions = solve(solver, T, redundancy=None if values is None else values[:, 0])
    steps = joints.step(q[:, None], solutions.q)
    distance = np.where(solutions.valid, np.abs(steps).max(axis=2), np.inf)
    best = np.arange(len(q)), np.argmin(distance, axis=1)
    return q + np.nan_to_num(steps[best]), distance[best]


def with_ends(
    solver: Solver, joints: Joints, T: Array, nodes: Nodes, ends: Sequence[tuple[Array | None, float]]
) -> Nodes:
    """Replace the nodes of the first and the last waypoint by a prescribed start and end, where there is one.

    Args:
        solver: the arm's solver.
        joints: the arm's joints.
        T: (m, 4, 4) m, poses of the path.
        nodes: of all waypoints.
        ends: start and end: a joint vector (n,) or None, and its redundancy parameter.
    """
    for (q, value), waypoint in zip(ends, (0, len(T) - 1), strict=True):
        if q is None:
            continue
        values = np.array([[value]]) if solver.parameter is not None else None
        here = solved(solver, joints, T, np.array([waypoint]), values, outside=values is not None)
        distance = np.abs(joints.step(here.q, q)).max(axis=1)
        column = here.column[[np.argmin(distance)]] if len(distance) else np.zeros(1, np.int64)
        # The prescribed image is the only one.
        ones = np.ones((1, solver.dof), np.uint8)
        given = Nodes(np.array([waypoint]), q[None] + 0.0, ones, column, np.array([value]), np.zeros(1, np.bool_))
        nodes = joined((chosen(nodes, nodes.waypoint != waypoint), given))
    return nodes


def with_representatives(solver: Solver, joints: Joints, T: Array, nodes: Nodes) -> Nodes:
    """Add solutions at singular poses that continue the nodes of the neighbouring waypoints.

    Where a pose leaves a joint free, ``ik`` returns the representative nearest to a reference. For each singular
    stretch of the path the references are: the nodes before it, carried forward from waypoint to waypoint; the nodes
    after it, carried backward; and the straight joint motions from each node before it to the nearest one after it.
    """
    if not nodes.singular.any():
        return nodes
    order = np.argsort(nodes.waypoint, kind="stable")
    cuts = np.searchsorted(nodes.waypoint[order], np.arange(1, len(T)))
    layers = [[chosen(nodes, part)] for part in np.split(order, cuts)]
    singular = np.unique(nodes.waypoint[nodes.singular])
    for stretch in np.split(singular, np.flatnonzero(np.diff(singular) > 1) + 1):
        first, last = int(stretch[0]), int(stretch[-1])
        directions = [(range(first, last + 1), first - 1), (range(last, first - 1, -1), last + 1)]
        for waypoints, before in directions:
            # A path that begins or ends at a singular pose starts from the solutions there.
            carried = layers[before if 0 <= before < len(T) else waypoints[0]][0].q
            for waypoint in waypoints:
                carried = _continue(solver, joints, T[waypoint], waypoint, layers[waypoint], carried)
        if first > 0 and last + 1 < len(T):
            a, b = layers[first - 1][0].q, layers[last + 1][0].q
            for waypoint, references in zip(
                stretch.tolist(), _straight_motions(joints, a, b, len(stretch)), strict=True
            ):
                _continue(solver, joints, T[waypoint], waypoint, layers[waypoint], references)
    return joined([part for layer in layers for part in layer])


def _straight_motions(joints: Joints, a: Array, b: Array, count: int) -> Array:
    """Joint vectors (count, k, n) strictly between each of a (k, n) and the nearest of b."""
    if not len(a) or not len(b):
        return np.empty((count, 0, a.shape[1]))
    steps = joints.step(a[:, None], b)
    step = steps[np.arange(len(a)), np.abs(steps).max(axis=2).argmin(axis=1)]
    share = np.arange(1, count + 1) / (count + 1)
    return np.asarray(a + share[:, None, None] * step)


def _continue(solver: Solver, joints: Joints, T: Array, waypoint: int, here: list[Nodes], references: Array) -> Array:
    """Add to a waypoint's nodes the solutions nearest to references (k, n), and return them."""
    known = np.concatenate([part.q for part in here])
    carried = references[:0]
    for reference in references:
        nearest = _nearest_singular(solver, joints, T, waypoint, reference)
        # Too far for one motion, or already reached from another reference.
        if nearest is None or np.abs(joints.step(reference, nearest.q[0])).max() > WIDEST_STEP:
            continue
        if np.abs(joints.step(carried, nearest.q[0])).max(axis=1).min(initial=np.inf) <= SAME_VECTOR:
            continue
        carried = np.concatenate([carried, nearest.q])
        if np.abs(joints.step(known, nearest.q[0])).max(axis=1).min() > SAME_VECTOR:
            known = np.concatenate([known, nearest.q])
            here.append(nearest)
    return carried


def _nearest_singular(solver: Solver, joints: Joints, T: Array, waypoint: int, reference: Array) -> Nodes | None:
    """The singular solution of a pose nearest to a reference (n,), or None."""
    target, nearest = reference, None
    for _ in range(TANGENT_STEPS):
        solutions = solve(solver, T, target)
        singular = (solutions.singular > 0).astype(np.uint8)
        if not singular.any():
            break
        column, q, counts = joints.choose(solutions.q, singular)
        if not len(q):
            break
        k = int(np.argmin(np.abs(joints.step(reference, q)).max(axis=1)))
        row = slice(k, k + 1)
        nearest = Nodes(np.array([waypoint]), q[row], counts[row], column[row], np.zeros(1), np.ones(1, np.bool_))
        _, size, directions = np.linalg.svd(solver.chain.jacobian(q[k]), full_matrices=False)
        free = directions[size <= ZERO_SINGULAR_VALUE * size[0]]
        along = free.T @ (free @ joints.step(q[k], reference))
        if np.abs(along).max(initial=0.0) <= SAME_VECTOR:
            break
        target = q[k] + along
    return nearest


def in_narrow_windows(solver: Solver, joints: Joints, T: Array, everything: Nodes, grid: Array) -> Nodes:
    """Nodes inside the joint limits that lie between two grid values, at both of which the branch is outside.

    Along each branch the distance to the limits is a function of the parameter. A maximum between two grid values at
    which it is not positive is located by bisection, and kept where it is positive.

    Args:
        solver: the arm's solver.
        joints: the arm's joints.
        T: (m, 4, 4) m, waypoints.
        everything: all solutions on the grid, also those outside the limits.
        grid: (v,) ascending values of the parameter.
    """
    count = len(grid)
    step = grid[1] - grid[0]
    branches = len(solver.structure.branches)
    table = np.full((len(T), branches, count + 2), -np.inf)
    index = np.searchsorted(grid, everything.value - 0.5 * step) % count
    table[everything.waypoint, everything.column, index + 1] = joints.room(everything.q)
    if solver.parameter is not None and solver.parameter.round:
        table[..., 0], table[..., -1] = table[..., -2], table[..., 1]
    here, before, after = table[..., 1:-1], table[..., :-2], table[..., 2:]
    alone = ~np.isfinite(before) | ~np.isfinite(after)
    with np.errstate(invalid="ignore"):  # infinity less infinity, where a branch has no solution
        slope = np.maximum(
            np.where(np.isfinite(before), here - before, 0.0), np.where(np.isfinite(after), here - after, 0.0)
        )
        peak = (here < 0.0) & np.isfinite(here) & (here >= before) & (here >= after)
        peak &= (here + slope > 0.0) | alone
    waypoint, column, k = np.nonzero(peak)
    if not len(waypoint):
        return chosen(everything, np.zeros(0, dtype=np.intp))
    rows = np.arange(len(waypoint))
    value, best, width = grid[k], here[waypoint, column, k], step
    for _ in range(WINDOW_HALVINGS):
        width *= 0.5
        trial = value[:, None] + width * np.array([-1.0, 0.0, 1.0])
        solutions = solve(solver, T[waypoint, None], redundancy=trial)
        q, valid = solutions.q[rows, :, column], solutions.valid[rows, :, column]
        rooms = np.full(trial.shape, -np.inf)
        rooms[valid] = joints.room(q[valid])
        rooms[:, 1] = np.maximum(rooms[:, 1], best)
        pick = np.argmax(rooms, axis=1)
        value, best = trial[rows, pick], rooms[rows, pick]
    inside = np.flatnonzero(best > 0.0)
    order = inside[np.argsort(waypoint[inside], kind="stable")]
    kept = solved(solver, joints, T, waypoint[order], value[order, None])
    wanted = set(zip(waypoint[order].tolist(), column[order].tolist(), strict=True))
    pairs = zip(kept.waypoint.tolist(), kept.column.tolist(), strict=True)
    return chosen(kept, np.array([pair in wanted for pair in pairs], dtype=np.bool_))
