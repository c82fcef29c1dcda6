"""State: the arm, the target and every solution with its marks, as the viewer shows them; independent of viser.

A :class:`State` does not change; each of the functions below returns the one that follows. The page mirrors it.
"""

from dataclasses import dataclass, replace

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.arm.example import example
from urdf_ik.cell import CollisionModel, World
from urdf_ik.errors import UrdfIkError
from urdf_ik.ik.redundancy import Intervals
from urdf_ik.ik.solutions import IKSolutions, Singular, distances
from urdf_ik.typing import Array

# rad or m: the arm stands at a solution that is this close to it.
_SAME = 1e-6


@dataclass(frozen=True, eq=False)
class Ghost:
    """One solution, with all that is to be said about it.

    Attributes:
        q: (n,) rad or m: the image inside the joint limits where there is one.
        branch: its name.
        column: index of the branch.
        outside: whether a joint is outside its limits.
        colliding: whether links touch that must not; None where the URDF has nothing to check.
        singular: where the arm is singular there.
    """

    q: Array
    branch: str
    column: int
    outside: bool
    colliding: bool | None
    singular: Singular

    @property
    def marks(self) -> tuple[str, ...]:
        """What speaks against it: 'limits', 'collision', 'singular: wrist'."""
        names = [flag.name.lower() for flag in Singular if flag in self.singular and flag.name]
        singular = [f"singular: {', '.join(names)}"] if names else []
        return (*["limits"] * self.outside, *["collision"] * bool(self.colliding), *singular)


@dataclass(frozen=True, eq=False)
class State:
    """An arm at a joint vector, a target, and the solutions that reach it.

    Attributes:
        arm: the arm.
        q: (n,) rad or m, where it stands.
        target: (4, 4) m, pose of the tip that is asked for, in the base.
        redundancy: value of the redundancy parameter, (k,) of k of them; None for an arm without one.
        ghosts: every solution of the target, by branch.
        reason: why there is no solution, or no solution inside the limits; else ''.
        note: what could not be checked, in words; else ''.
        world: obstacles, or None.
        model: what answers about contacts, with the world's obstacles; None where the URDF has nothing to check.
        intervals: where along its one redundancy parameter the target has solutions inside the limits; None for an
            arm without one, or one whose intervals are not known.
    """

    arm: Arm
    q: Array
    target: Array
    redundancy: float | Array | None
    ghosts: tuple[Ghost, ...]
    reason: str
    note: str
    world: World | None = None
    model: CollisionModel | None = None
    intervals: Intervals | None = None

    @property
    def drawn(self) -> tuple[Ghost, ...]:
        """The ghosts that are drawn: all but the one that the arm stands at."""
        return tuple(ghost for k, ghost in enumerate(self.ghosts) if k != self.chosen)

    @property
    def chosen(self) -> int | None:
        """Index of the ghost that the arm stands at, if it does."""
        at = self.nearest(self.ghosts)
        return None if at is None or self._far(self.ghosts[at].q) > _SAME else at

    def nearest(self, ghosts: tuple[Ghost, ...]) -> int | None:
        """Index of the one that is nearest to where the arm stands."""
        return min(range(len(ghosts)), key=lambda k: self._far(ghosts[k].q), default=None)

    def _far(self, q: Array) -> float:
        return float(np.linalg.norm(distances.difference(q, self.q, ~self.arm.chain.prismatic)))


def start(arm: Arm, world: World | None = None) -> State:
    """An arm where it shows most of what it can do; see :func:`urdf_ik.arm.example.example`."""
    best, note = example(arm), ""
    model = arm.cell.collisions.in_world(world) if arm.cell.collisions.has_geometry else None
    if model is None:
        note = f"Self-collision is not checked: {arm.cell.collisions.missing}"
    here = State(arm, best, arm.fk(best), None, (), "", note, world, model)
    return with_joints(here, best)


def with_target(state: State, target: Array) -> State:
    """The target moved to the pose ``target`` (4, 4) [m]; the arm follows to the nearest solution inside its limits."""
    return _followed(_solved(_moved(replace(state, target=target))))


def with_redundancy(state: State, value: float, which: int = 0) -> State:
    """A redundancy parameter set to ``value`` [rad or m]; the arm follows."""
    values: float | Array = value
    if isinstance(state.redundancy, np.ndarray):  # of several, the others stay
        values = np.array(state.redundancy)
        values[which] = value
    return _followed(_solved(replace(state, redundancy=values)))


def with_joints(state: State, q: Array) -> State:
    """The arm moved to ``q`` (n,) rad or m, and the target with it."""
    arm = state.arm
    values = arm.redundancy_of(q) if arm.solver.parameters else None
    value = float(values) if values is not None and not values.ndim else values
    return _solved(_moved(replace(state, q=q, target=arm.fk(q), redundancy=value)))


def with_joint(state: State, index: int, value: float) -> State:
    """One joint set to ``value`` [rad or m], and the target moved with the arm."""
    q = state.q.copy()
    q[index] = value
    return with_joints(state, q)


def with_branch(state: State, column: int) -> State:
    """The arm moved to the solution of that branch; where the target has no such solution, nothing changes."""
    found = [ghost for ghost in state.ghosts if ghost.column == column]
    return replace(state, q=found[0].q) if found else state


def with_next(state: State, step: int) -> State:
    """The arm moved to the next solution of its target inside the limits, by branch; ``step`` -1: to the one before."""
    inside = [ghost for ghost in state.ghosts if not ghost.outside]
    if not inside:
        return state
    at = state.nearest(tuple(inside))
    there = state.chosen is not None and at is not None and state.ghosts[state.chosen] is inside[at]
    return replace(state, q=inside[((at or 0) + step * there) % len(inside)].q)


def _moved(state: State) -> State:
    """The intervals of a target that has moved."""
    if len(state.arm.solver.parameters) != 1:
        return state
    try:
        return replace(state, intervals=state.arm.intervals(state.target))
    except UrdfIkError:  # of a joint that others mimic, say
        return replace(state, intervals=None)


def _followed(state: State) -> State:
    """The arm at the nearest solution inside its limits; where there is no such solution it stays."""
    inside = tuple(ghost for ghost in state.ghosts if not ghost.outside)
    at = state.nearest(inside)
    return state if at is None else replace(state, q=inside[at].q)


def _solved(state: State) -> State:
    """The solutions of the state's target, marked."""
    try:
        found = _solve(state)
    except UrdfIkError as error:  # no solver takes the arm: its joints can still be moved
        return replace(state, ghosts=(), reason=str(error))
    kept = found.within_limits()
    valid = np.flatnonzero(found.valid)
    inside = kept.valid[valid]
    q = np.where(inside[:, None], kept.q[valid], found.q[valid])
    hits = np.atleast_1d(state.model.in_collision(q)) if state.model is not None and len(q) else None
    ghosts = tuple(
        Ghost(q[k], found.branches[column], int(column), not inside[k], None if hits is None else bool(hits[k]),
              Singular(int(found.singular[column])))
        for k, column in enumerate(valid)
    )  # fmt: skip
    return replace(state, ghosts=ghosts, reason="" if inside.any() else kept.explain())


def _solve(state: State) -> IKSolutions:
    arm, T = state.arm, state.target
    if arm.task == "pose":
        return arm.ik(T, state.q, redundancy=state.redundancy)
    return arm.ik(arm.solver.control.target_of(T), state.q, task=arm.task)
