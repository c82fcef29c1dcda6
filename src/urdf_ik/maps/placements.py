"""Inverse reachability: where to put an arm's base, so that it reaches given poses or follows a given path.

>>> import urdf_ik
>>> arm = urdf_ik.load("zyyzyz_6r")
>>> targets = arm.fk([[0.3, -0.5, 0.8, 0.4, 0.7, -0.2], [0.5, -0.4, 0.9, 0.1, 0.6, 0.3]])
>>> found = urdf_ik.maps.placement(arm, targets, bounds=[[-0.5, -0.5, 0.0], [0.5, 0.5, 0.0]], step=0.25)
>>> best = found.best()
>>> best.reached, bool(best.margin > 0.0)
(2, True)
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.maps.grid import Grid, checked_bounds
from urdf_ik.maps.store import Progress, Variable, about_arm, digest, require_memory
from urdf_ik.maps.workspaces.creation import Counting
from urdf_ik.model.poses import as_pose_array, pose
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN
from urdf_ik.support.tolerances import DEFAULT, LARGEST
from urdf_ik.typing import Array, Threads

__all__ = ["SHOWN", "Place", "PlacementMap", "placement"]

SCORES = {
    "reached": Variable(np.uint32, "heading", "number of targets that are reached"),
    "solutions": Variable(np.uint16, "heading", "least number of solutions of any target"),
    "branches": Variable(np.uint16, "heading", "number of branches that reach every target"),
    "margin": Variable(np.float32, "heading", "least limit margin of any target, of its best solution"),
    "clearance": Variable(np.float32, "heading", "least clearance of any target, of its best solution", "m"),
    "followed": Variable(np.uint8, "heading", "1 where the path is followed without a jump"),
    "cost": Variable(np.float32, "heading", "least cost of following the path"),
}
"""The scores of a base position; a score of all targets is 0, or NaN, where one of them is not reached."""
_RANKING = (("reached", 1), ("followed", 1), ("margin", 1), ("cost", -1), ("branches", 1), ("clearance", 1))
"""Scores in the order in which they decide which place is better, with the sign that makes more better."""
SHOWN = {name: score.words for name, score in SCORES.items()}
"""Names of the scores, with their descriptions."""


class Place(NamedTuple):
    """A base position with its scores; see :class:`PlacementMap`.

    Attributes:
        pose: (4, 4) m, the base link in the cell.
        reached: number of targets that are reached.
        solutions: least number of solutions of any target.
        branches: number of branches that reach every target.
        margin: least limit margin of any target; NaN where one is not reached.
        clearance: m, the least of any target; NaN where one is not reached or it was not computed.
        followed: whether the path is followed; None where the targets are no path.
        cost: of following it; NaN where it is not followed.
    """

    pose: Array
    reached: int
    solutions: int
    branches: int
    margin: float
    clearance: float = float("nan")
    followed: bool | None = None
    cost: float = float("nan")


@dataclass(frozen=True, eq=False)
class PlacementMap:
    """Base positions x headings, with how targets are reached from there.

    Attributes:
        about: the arm and the question.
        grid: positions of the base link in the cell, the voxels' centres (X, Y, Z).
        headings: (H,) rad, turns of the base link about the cell's z axis.
        mount: (3, 3) the base link's rotation at heading zero.
        targets: (m, 4, 4) m, in the cell.
        arrays: the scores by name.
        reached: (X, Y, Z, H) number of targets that are reached; like each name of ``SCORES``, None where it was not
            computed.
        solutions: least number of solutions of any target; 0 where one is not reached.
        branches: number of branches that reach every target.
        margin: of each target the greatest limit margin of its solutions, of these the least: 0 at a limit and 1 in
            the middle of all; NaN where a target is not reached.
        clearance: m, the same of the clearance.
        followed: 1 where the path is followed without a jump.
        cost: the cost of that, NaN where it is not followed.
    """

    about: dict[str, Any]
    grid: Grid
    headings: Array
    mount: Array = field(repr=False)
    targets: Array = field(repr=False)
    arrays: Mapping[str, NDArray[Any]] = field(repr=False)

    def __getattr__(self, name: str) -> Any:
        if name not in SCORES:
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
        return self.arrays.get(name)

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.grid.shape))
        best = f"at best {int(self.reached.max())} of {len(self.targets)} targets reached"
        return f"<PlacementMap of {self.about['robot']}: {shape} positions x {len(self.headings)} headings, {best}>"

    def values(self, what: str = "reached") -> Array:
        """One score at every position and heading (X, Y, Z, H), NaN where it means nothing.

        Raises:
            ArgumentError: there is no such score, or nobody asked for it.
        """
        if what not in self.arrays:
            raise ArgumentError(f"the map contains no {what!r}; it contains {', '.join(self.arrays)}")
        scores = self.arrays[what]
        if what == "reached":
            return np.asarray(scores, dtype=np.float64)
        return np.where(self.reached == len(self.targets), scores, np.nan).astype(np.float64)

    def best(self) -> Place:
        """The best place; see :meth:`places`."""
        return self.places(1)[0]

    def places(self, count: int = 5) -> tuple[Place, ...]:
        """The best places, best first.

        They are ranked by the number of targets that are reached; then by whether the path is followed; then by the
        limit margin; then by the path's cost, or the number of branches that reach everything; then by the clearance.

        Raises:
            ArgumentError: fewer than one is asked for.
        """
        count = inputs.whole(count, "count", low=1)
        keys = [
            np.nan_to_num(np.asarray(sign * self.arrays[name], np.float64), nan=-np.inf).ravel()
            for name, sign in _RANKING
            if name in self.arrays
        ]
        order = np.lexsort(keys[::-1])[::-1][:count]
        return tuple(self._place(index) for index in np.array(np.unravel_index(order, self.reached.shape)).T.tolist())

    def base(self, index: Sequence[int]) -> Array:
        """(4, 4) m, pose of the base link in the cell at a position and heading (4,) of the map."""
        *place, heading = index
        position = [self.grid.coordinates(axis)[at] for axis, at in enumerate(place)]
        return base_pose(position, float(self.headings[heading]), self.mount)

    def _place(self, index: Sequence[int]) -> Place:
        scores = {name: array[tuple(index)].item() for name, array in self.arrays.items()}
        if "followed" in scores:
            scores["followed"] = bool(scores["followed"])
        return Place(self.base(index), **scores)


def base_pose(position: ArrayLike, heading: float, mount: Array) -> Array:
    """(4, 4) pose of the base link in the cell."""
    T = pose(position, rotvec=[0.0, 0.0, heading])
    T[:3, :3] = T[:3, :3] @ mount
    return T


MOST_TURNS = 3600
"""Headings at each position."""
MOST_POSITIONS = 10**9
"""Positions of the base, at one heading."""
FREE_VALUES = 16
"""Values of a redundancy parameter at which a target is solved; of a path all are searched."""
_CHUNK = 4096  # poses that are solved at a time
_ROUNDING = 1e-9  # share of a step by which the bounds may be off a whole number of steps


def placement(
    arm: Arm,
    T: Any,
    *,
    bounds: ArrayLike,
    step: float,
    turns: int = 1,
    mount: ArrayLike | None = None,
    path: bool = False,
    world: World | None = None,
    margin: float = 0.0,
    collisions: bool | None = None,
    threads: Threads = 1,
    progress: Progress | None = None,
) -> PlacementMap:
    """Score every base position on a grid by how the arm reaches targets from there: inverse reachability.

    A target counts as reached where a solution is within the limits and, where collisions are looked for, free of them.
    An arm with a redundancy parameter is asked at sixteen values of it; for a path, ``arm.follow`` searches
    them all, and is asked from every position that reaches all waypoints.

    Args:
        arm: the arm.
        T: (m, 4, 4) m, targets in the cell; the waypoints of a path in their order.
        bounds: (2, 3) m, lower and upper corner of the positions of the base link in the cell; equal numbers for an
            axis mean one position on it.
        step: m from one position to the next.
        turns: number of headings at each position, evenly spaced turns about the cell's z axis from zero on.
        mount: (3, 3) rotation of the base link in the cell at heading zero, such as that of an arm that hangs from the
            ceiling; default: none.
        path: whether the targets are a path.
        world: obstacles, placed in the cell.
        margin: m that bodies must stay apart.
        collisions: whether collisions are looked for; default: where there is a world.
        threads: number of threads that solve, or 'auto'.
        progress: called with the number of finished positions, and of all.

    Raises:
        ArgumentError: invalid bounds, step, number of turns or mount; or a map that does not fit in memory.
        PoseError: a target is no pose.
        UnsupportedArm: no solver takes this arm.
        UrdfError: the URDF has no collision shapes, and collisions are looked for.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> line = urdf_ik.line(urdf_ik.pose([1.0, -0.2, 1.0]), urdf_ik.pose([1.0, 0.2, 1.0]), 20)
        >>> found = placement(arm, line, bounds=[[-0.5, 0, 0], [0.5, 0, 0]], step=0.5, path=True)
        >>> found.followed[:, 0, 0, 0].tolist()
        [1, 0, 0]
    """
    if not arm.structure.branches:
        raise UnsupportedArm(f"{arm.name}: no solver for this arm yet. {arm.structure}")
    targets = np.ascontiguousarray(as_pose_array(T).reshape(-1, 4, 4))
    if not len(targets):
        raise ArgumentError("no targets given; one is the least")
    if world is not None and collisions is False:
        raise ArgumentError("a world is given with collisions=False; leave one of the two out")
    collisions = world is not None if collisions is None else collisions
    turns, grid = inputs.whole(turns, "turns", low=1, high=MOST_TURNS), _positions(bounds, step)
    headings, R = TURN * np.arange(turns) / turns, _mount(mount)
    margin = inputs.number(margin, "margin", low=0.0, unit="m")
    without = (set() if collisions else {"clearance"}) | (set() if path else {"followed", "cost"})
    names = [name for name in SCORES if name not in without]
    bases = _Bases(arm, targets, world, path, margin, collisions, inputs.threads(threads))
    needed = grid.count * turns * sum(np.dtype(SCORES[name].kind).itemsize for name in names)
    hint = "take a larger step, fewer turns or narrower bounds"
    require_memory(needed, f"{grid.count:.4g} base positions x {turns} headings", hint)
    arrays: dict[str, NDArray[Any]] = {
        name: np.full((*grid.shape, turns), SCORES[name].fill, SCORES[name].kind) for name in names
    }
    for done, place in enumerate(np.ndindex(grid.shape), 1):
        position = [grid.coordinates(axis)[k] for axis, k in enumerate(place)]
        for k, heading in enumerate(headings.tolist()):
            into_base = np.linalg.inv(base_pose(position, heading, R)).astype(np.float64)
            for name, value in bases.scores(into_base).items():
                arrays[name][(*place, k)] = value
        if progress is not None:
            progress(done, grid.count)
    for array in arrays.values():
        array.setflags(write=False)
    about = {
        **about_arm(arm, arm.cell.collisions.checked_pairs if collisions else None, world),
        "targets": {"count": len(targets), "sha256": digest(targets.tobytes())},
        "grid": grid.described(),
        "headings": headings.tolist(),
        "mount": R.tolist(),
        "is_path": path,
        "margin": margin,
        "holds": names,
    }
    return PlacementMap(about, grid, headings, R, targets, arrays)


class _Bases:
    """The scores of poses of the base."""

    def __init__(
        self,
        arm: Arm,
        targets: Array,
        world: World | None,
        is_path: bool,
        margin: float,
        collisions: bool,
        threads: int,
    ) -> None:
        self.arm, self.targets, self.is_path, self.margin = arm, targets, is_path, margin
        self.collisions, self.threads = collisions, threads
        self._cell = tuple(world or ())
        self._world = None if world is None else World()
        for name, shape, placed in self._cell:
            self._world.add(name, shape, placed)  # type: ignore[union-attr]

    def scores(self, into_base: Array) -> dict[str, float]:
        """The scores of one pose of the base; ``into_base`` is the cell's pose in it."""
        in_base, world = into_base @ self.targets, self._world
        for obstacle in self._cell:
            world.move(obstacle.name, into_base @ obstacle.pose)  # type: ignore[union-attr]
        counts: list[Any] = []
        margins, clearances, common = np.inf, np.inf, np.ones(len(self.arm.structure.branches), np.bool_)
        for start in range(0, len(in_base), _CHUNK):
            counting = self._counting(in_base[start : start + _CHUNK])
            counting.keep_within_limits()
            if self.collisions:
                counting.keep_free(world, self.margin)
            counts.append(counting.counts())
            if counts[-1].all():
                margins = min(margins, float(counting.greatest(counting.margin()).min()))
                kept = counting.kept.reshape(len(counting.kept), -1, len(common))
                common &= kept.any(axis=1).all(axis=0)
                if self.collisions:
                    clearances = min(clearances, float(counting.greatest(counting.clearance(world)).min()))
        solutions = np.concatenate(counts)
        found: dict[str, float] = {"reached": int((solutions > 0).sum())}
        if not solutions.all():
            return found
        found |= {"solutions": int(solutions.min()), "branches": int(common.sum()), "margin": margins}
        if self.collisions:
            found["clearance"] = clearances
        if self.is_path:
            plan = self.arm.follow(in_base, world=world, margin=self.margin, collisions=self.collisions)
            found |= {"followed": int(plan.found), "cost": plan.cost if plan.found else float("nan")}
        return found

    def _counting(self, in_base: Array) -> Counting:
        """The solutions of poses (k, 4, 4), at all values of the redundancy parameters."""
        parameters = self.arm.solver.parameters
        if not parameters:
            solved = self.arm.ik(in_base, threads=self.threads)
            return Counting(self.arm, solved.q, solved.valid)
        spread = [np.linspace(*one.range, FREE_VALUES, endpoint=not one.round) for one in parameters]
        values = spread[0]
        if len(spread) > 1:
            values = np.stack(np.meshgrid(*spread, indexing="ij"), axis=-1).reshape(-1, len(spread))
        solved = self.arm.ik(in_base[:, None], redundancy=values, threads=self.threads)
        count = len(in_base)
        return Counting(self.arm, solved.q.reshape(count, -1, self.arm.dof), solved.valid.reshape(count, -1))


def _positions(bounds: ArrayLike, step: float) -> Grid:
    """Positions from the lower corner to the upper one, as voxels around them."""
    lower, upper = checked_bounds(bounds, flat=True)
    step = inputs.number(step, "step", low=1.0 / LARGEST, unit="m")
    counts = np.floor((upper - lower) / step + _ROUNDING) + 1.0
    if not counts.prod() <= MOST_POSITIONS:
        raise ArgumentError(
            f"bounds {[lower.tolist(), upper.tolist()]} with a step of {step:g} m are {counts.prod():.3g} positions, "
            f"and at most {MOST_POSITIONS:,} are looked at; take a larger step"
        )
    return Grid(np.asarray(lower - 0.5 * step), float(step), tuple(int(count) for count in counts))


def _mount(mount: ArrayLike | None) -> Array:
    R = np.eye(3) if mount is None else np.array(mount, dtype=np.float64)
    if R.shape != (3, 3) or np.abs(R @ R.T - np.eye(3)).max(initial=0.0) > DEFAULT.rotation or np.linalg.det(R) < 0.0:
        raise ArgumentError(
            f"mount={R.tolist()} given; a rotation matrix (3, 3) is needed, such as urdf_ik.pose(...)[:3, :3]"
        )
    return R
