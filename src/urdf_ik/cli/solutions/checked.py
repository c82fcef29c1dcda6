"""Solutions with their checks, and their form as JSON, CSV and npz."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.cell import missing_pinocchio as without_pinocchio
from urdf_ik.cli import console
from urdf_ik.cli.console import Angles
from urdf_ik.cli.solutions import redundancy as parameters
from urdf_ik.ik.solutions import IKSolutions, Singular
from urdf_ik.ik.solutions.distances import measure
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE

# Solutions that Pinocchio measures between two reports of progress.
_BATCH = 512


@dataclass(frozen=True)
class Distances:
    """How far solutions are from a joint vector, in the units that are shown.

    Attributes:
        metric: the distance's name.
        each: (N, B) the distance, NaN where there is no solution.
        joints: (N, B, n) the difference of each joint.
        unit: of the distance; 'rad and m' where joints of both kinds count in it.
    """

    metric: str
    each: NDArray[np.float64]
    joints: NDArray[np.float64]
    unit: str


def distances_from(solutions: IKSolutions, q_ref: NDArray[np.float64], metric: str, angles: Angles) -> Distances:
    """The distances of solutions from a joint vector."""
    apart = solutions.difference(q_ref)
    each = np.where(solutions.valid, measure(solutions.solver, metric, None, None).distance(apart), np.nan)
    if metric == "time":
        unit = "s"
    elif angles.turning.all():
        each, unit = angles.angle(each), angles.unit
    else:
        unit = "rad and m" if angles.turning.any() else "m"
    return Distances(metric, each, angles.shown(apart), unit)


@dataclass(frozen=True)
class CheckedSolutions:
    """The solutions of N poses, each with its checks; an array is None where its check was not asked for.

    Attributes:
        arm: the arm that was solved.
        poses: (N, 4, 4) targets.
        solutions: a batch of N.
        names: (N, B) branch of each solution, with its turns.
        within: (N, B) bool, inside the joint limits as it stands.
        turned: (N, B) bool, inside them after whole turns of some joints.
        free: (N, B) bool, free of self-collision.
        hits: the pairs of links that collide, by pose and column.
        unchecked: reason why self-collision could not be checked, '' where it was or need not be.
        unmeasured: reason why the errors could not be measured, '' where they were or need not be.
        position_error: (N, B) m, as Pinocchio measures it, NaN where there is no solution.
        rotation_error: (N, B) rad, likewise.
        distances: from the joint vector that the solutions were chosen by; None where there was none.
    """

    arm: Arm
    poses: NDArray[np.float64]
    solutions: IKSolutions
    names: NDArray[np.object_]
    within: NDArray[np.bool_]
    turned: NDArray[np.bool_]
    free: NDArray[np.bool_] | None
    hits: Mapping[tuple[int, int], Sequence[tuple[str, str]]]
    unchecked: str
    position_error: NDArray[np.float64] | None
    rotation_error: NDArray[np.float64] | None
    unmeasured: str = ""
    distances: Distances | None = None

    @cached_property
    def valid(self) -> NDArray[np.bool_]:
        """(N, B) whether there is a solution."""
        return self.solutions.valid

    @cached_property
    def singular(self) -> NDArray[np.uint8]:
        """(N, B) bits of ``Singular``."""
        return self.solutions.singular

    @cached_property
    def counts(self) -> NDArray[np.intp]:
        """(N,) number of solutions of each pose."""
        return np.asarray(self.solutions.count)

    def places(self, pose: int) -> NDArray[np.intp]:
        """Columns that hold a solution of one pose."""
        return np.flatnonzero(self.valid[pose])


def solve(
    arm: Arm,
    poses: NDArray[np.float64],
    pick: Callable[[IKSolutions], IKSolutions],
    *,
    redundancy: NDArray[np.float64] | None = None,
    task: str = "pose",
    errors: bool,
    collisions: bool,
    world: World | None = None,
    tick: Callable[[int, int], None],
) -> CheckedSolutions:
    """Solve, filter with ``pick`` and check; ``tick(done, total)`` reports how far the checks are.

    ``redundancy``: (N,) rad or m, or None for the arm's default; ``task``: the part of the poses that is the target;
    ``world``: obstacles that count as collisions.
    """
    from urdf_ik.cli.solutions.targets import of_task

    targets = poses if task == "pose" else of_task(arm, poses, task)
    solutions = pick(arm.ik(targets, redundancy=redundancy, task=None if task == "pose" else task))
    q, valid = solutions.q, solutions.valid
    lower, upper = arm.limits.T
    within = valid & ((q >= lower - LIMIT_TOLERANCE) & (q <= upper + LIMIT_TOLERANCE)).all(axis=-1)
    turned = solutions.within_limits().valid & ~within
    position = rotation = free = None
    hits: dict[tuple[int, int], Sequence[tuple[str, str]]] = {}
    unchecked = ""
    todo = np.argwhere(valid)
    unmeasured = "" if not errors or without_pinocchio.installed() else without_pinocchio.UNCHECKED
    if errors and not unmeasured:
        reference = arm.cell.reference
        position, rotation = np.full(valid.shape, np.nan), np.full(valid.shape, np.nan)
        for start in range(0, len(todo), _BATCH):
            i, b = todo[start : start + _BATCH].T
            position[i, b], rotation[i, b] = (
                reference.errors(q[i, b], poses[i])
                if task == "pose"
                else arm.solver.control.errors(reference.pose(q[i, b]), targets[i])
            )
            tick(start + len(i), len(todo))
    if collisions:
        body = arm.cell.collisions.in_world(world)
        unchecked = body.missing
        if body.has_geometry:
            free = np.zeros(valid.shape, dtype=np.bool_)
            for done, (i, b) in enumerate(todo):
                free[i, b] = not body.in_collision(q[i, b])
                if not free[i, b]:
                    hits[int(i), int(b)] = body.colliding_pairs(q[i, b])
                tick(done + 1, len(todo))
    return CheckedSolutions(
        arm, poses, solutions, solutions.names, within, turned, free, hits, unchecked, position, rotation, unmeasured
    )


def flags(singular: int) -> list[str]:
    """Names of the singularities in a solution's flags: 'shoulder', 'elbow', 'wrist', 'other'."""
    return [str(flag.name).lower() for flag in Singular if flag & int(singular)] if singular else []


def as_json(answer: CheckedSolutions, angles: Angles) -> str:
    """One object a pose, in order, each with its solutions."""
    return console.json_text(
        {
            "robot": answer.arm.name,
            "base": answer.arm.base,
            "tip": answer.arm.tip,
            "joints": answer.arm.joint_names,
            "units": {"angle": angles.unit, "length": "m"},
            "family": answer.arm.structure.family,
            "poses": [
                {
                    "pose": pose,
                    **_parameter(answer, angles, i),
                    "count": answer.counts[i],
                    "solutions": [_solution(answer, angles, i, b) for b in answer.places(i)],
                    **({} if answer.counts[i] else {"explanation": explanation(answer, i)}),
                }
                for i, pose in enumerate(answer.poses)
            ],
        }
    )


def explanation(answer: CheckedSolutions, pose: int) -> str:
    """Why a pose has no solution."""
    one: IKSolutions = answer.solutions[pose]
    return one.explain()


def as_csv(answer: CheckedSolutions, angles: Angles) -> str:
    """One line a solution; numbers first, so that the text of the last two columns can be left out."""
    header = ["pose", *answer.arm.joint_names, "within_limits"]
    header += parameters.headings(answer.arm)
    header += [] if answer.free is None else ["collision_free"]
    header += [] if answer.position_error is None else ["position_error", "rotation_error"]
    header += [] if answer.distances is None else ["distance"]
    return console.csv_text([*header, "singular", "branch"], _csv_rows(answer, angles))


def as_npz(answer: CheckedSolutions, angles: Angles) -> bytes:
    """The arrays as the package lays them out: NaN rows of ``q`` where a branch has no solution."""
    arrays: dict[str, Any] = {
        "poses": answer.poses,
        "q": angles.shown(answer.solutions.q),
        "valid": answer.valid,
        "singular": answer.singular,
        "branches": np.array(answer.names, dtype=np.str_),
        "joint_names": np.array(answer.arm.joint_names, dtype=np.str_),
        "angle_unit": np.array(angles.unit),
        "within_limits": answer.within,
    }
    if answer.solutions.redundancy is not None:
        arrays["redundancy"] = parameters.shown(answer.arm, answer.solutions.redundancy, angles)
    if answer.free is not None:
        arrays["collision_free"] = answer.free
    if answer.position_error is not None and answer.rotation_error is not None:
        arrays["position_error"] = answer.position_error
        arrays["rotation_error"] = angles.angle(answer.rotation_error)
    if answer.distances is not None:
        arrays["distance"], arrays["difference"] = answer.distances.each, answer.distances.joints
    return console.npz_bytes(arrays)


DATA: Mapping[str, Callable[[CheckedSolutions, Angles], str | bytes]] = {"json": as_json, "csv": as_csv, "npz": as_npz}


def _parameter(answer: CheckedSolutions, angles: Angles, i: int) -> dict[str, Any]:
    values = answer.solutions.redundancy
    return {} if values is None else {"redundancy": parameters.shown(answer.arm, values[i], angles)}


def _solution(answer: CheckedSolutions, angles: Angles, i: int, b: int) -> dict[str, Any]:
    out: dict[str, Any] = {
        "branch": answer.names[i, b],
        "q": angles.shown(answer.solutions.q[i, b]),
        "singular": flags(answer.singular[i, b]),
        "within_limits": answer.within[i, b],
    }
    if answer.free is not None:
        out["collision_free"] = answer.free[i, b]
        out["collisions"] = answer.hits.get((i, int(b)), ())
    if answer.position_error is not None and answer.rotation_error is not None:
        out["error"] = {
            "position": answer.position_error[i, b],
            "rotation": angles.angle(answer.rotation_error[i, b]),
        }
    if answer.distances is not None:
        out["distance"], out["difference"] = answer.distances.each[i, b], answer.distances.joints[i, b]
    return out


def _csv_rows(answer: CheckedSolutions, angles: Angles) -> Iterator[list[Any]]:
    q = angles.shown(answer.solutions.q)
    for i in range(len(answer.poses)):
        for b in answer.places(i):
            row: list[Any] = [i, *q[i, b].tolist(), int(answer.within[i, b])]
            row += [float(x) for value in _parameter(answer, angles, i).values() for x in np.atleast_1d(value)]
            if answer.free is not None:
                row.append(int(answer.free[i, b]))
            if answer.position_error is not None and answer.rotation_error is not None:
                row += [float(answer.position_error[i, b]), float(angles.angle(answer.rotation_error[i, b]))]
            row += [] if answer.distances is None else [float(answer.distances.each[i, b])]
            yield [*row, " ".join(flags(answer.singular[i, b])), answer.names[i, b]]
