"""Solutions with their checks, and their form as JSON, CSV and npz."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World, missing_pinocchio
from urdf_ik.cli import console
from urdf_ik.cli.console import Angles
from urdf_ik.ik.solutions import IKSolutions, Singular
from urdf_ik.ik.solutions.distances import measure
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.typing import Array

_BATCH = 512
"""Solutions that Pinocchio measures between two reports of progress."""


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
    each: Array
    joints: Array
    unit: str


def distances_from(solutions: IKSolutions, q_ref: Array, metric: str, angles: Angles) -> Distances:
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
        within: (N, B) bool, inside the joint limits as it stands.
        turned: (N, B) bool, inside them after whole turns of some joints.
        free: (N, B) bool, free of self-collision.
        hits: the pairs of links that collide, by pose and column.
        unchecked: reason why self-collision could not be checked, '' where it was or need not be.
        errors: (N, B) m and (N, B) rad, as Pinocchio measures them, NaN where there is no solution.
        unmeasured: reason why the errors could not be measured, '' where they were or need not be.
        distances: from the joint vector that the solutions were chosen by; None where there was none.
    """

    arm: Arm
    poses: Array
    solutions: IKSolutions
    within: NDArray[np.bool_]
    turned: NDArray[np.bool_]
    free: NDArray[np.bool_] | None
    hits: Mapping[tuple[int, int], Sequence[tuple[str, str]]]
    unchecked: str
    errors: tuple[Array, Array] | None
    unmeasured: str = ""
    distances: Distances | None = None

    @property
    def counts(self) -> NDArray[np.intp]:
        """(N,) number of solutions of each pose."""
        return np.asarray(self.solutions.count)

    def places(self, pose: int) -> NDArray[np.intp]:
        """Columns that hold a solution of one pose."""
        return np.flatnonzero(self.solutions.valid[pose])

    def flags(self, pose: int, column: int) -> list[str]:
        """Names of a solution's singularities: 'shoulder', 'elbow', 'wrist', 'other'."""
        return flags(self.solutions.singular[pose, column])

    def explanation(self, pose: int) -> str:
        """Why a pose has no solution."""
        one: IKSolutions = self.solutions[pose]
        return one.explain()

    @property
    def counted(self) -> str:
        """How many solutions of how many poses."""
        total, poses = int(self.counts.sum()), len(self.counts)
        return f"{total} solution{'s' * (total != 1)} of {poses} pose{'s' * (poses != 1)}"


def solve(
    arm: Arm,
    poses: Array,
    pick: Callable[[IKSolutions], IKSolutions],
    *,
    redundancy: Array | None = None,
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
    from urdf_ik.cli.targets import of_task

    targets = poses if task == "pose" else of_task(arm, poses, task)
    solutions = pick(arm.ik(targets, redundancy=redundancy, task=None if task == "pose" else task))
    q, valid = solutions.q, solutions.valid
    lower, upper = arm.limits.T
    within = valid & ((q >= lower - LIMIT_TOLERANCE) & (q <= upper + LIMIT_TOLERANCE)).all(axis=-1)
    turned = solutions.within_limits().valid & ~within
    measured = free = None
    hits: dict[tuple[int, int], Sequence[tuple[str, str]]] = {}
    unchecked = ""
    todo = np.argwhere(valid)
    unmeasured = "" if not errors or missing_pinocchio.installed() else missing_pinocchio.UNCHECKED
    if errors and not unmeasured:
        reference = arm.cell.reference
        measured = position, rotation = np.full(valid.shape, np.nan), np.full(valid.shape, np.nan)
        for start in range(0, len(todo), _BATCH):
            i, b = todo[start : start + _BATCH].T
            if task == "pose":
                position[i, b], rotation[i, b] = reference.errors(q[i, b], poses[i])
            else:
                position[i, b], rotation[i, b] = arm.solver.control.errors(reference.pose(q[i, b]), targets[i])
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
    return CheckedSolutions(arm, poses, solutions, within, turned, free, hits, unchecked, measured, unmeasured)


def flags(singular: int) -> list[str]:
    """Names of the singularities in a solution's flags."""
    return [str(flag.name).lower() for flag in Singular if flag & int(singular)] if singular else []


def redundancy_shown(arm: Arm, value: Any, angles: Angles) -> Any:
    """Values of the redundancy parameters, (...) of one and (..., k) of k, in the units that the user reads."""
    turns = np.array([parameter.unit == "rad" for parameter in arm.solver.parameters])
    return np.where(turns if len(turns) > 1 else turns[0], angles.angle(value), value)


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
                    **({} if answer.counts[i] else {"explanation": answer.explanation(i)}),
                }
                for i, pose in enumerate(answer.poses)
            ],
        }
    )


def as_csv(answer: CheckedSolutions, angles: Angles) -> str:
    """One line a solution; numbers first, so that the text of the last two columns can be left out."""
    count = len(answer.arm.solver.parameters)
    header = ["pose", *answer.arm.joint_names, "within_limits"]
    header += ["redundancy"] * count if count < 2 else [f"redundancy_{k}" for k in range(1, count + 1)]
    header += [] if answer.free is None else ["collision_free"]
    header += [] if answer.errors is None else ["position_error", "rotation_error"]
    header += [] if answer.distances is None else ["distance"]
    rows = []
    for i in range(len(answer.poses)):
        parameters = [float(x) for value in _parameter(answer, angles, i).values() for x in np.atleast_1d(value)]
        for one in (_solution(answer, angles, i, b) for b in answer.places(i)):
            row = [i, *one["q"].tolist(), int(one["within_limits"]), *parameters]
            row += [int(one["collision_free"])] if "collision_free" in one else []
            row += [float(error) for error in one.get("error", {}).values()]
            row += [float(one["distance"])] if "distance" in one else []
            rows.append([*row, " ".join(one["singular"]), one["branch"]])
    return console.csv_text([*header, "singular", "branch"], rows)


def as_npz(answer: CheckedSolutions, angles: Angles) -> bytes:
    """The arrays as the package lays them out: NaN rows of ``q`` where a branch has no solution."""
    solutions = answer.solutions
    arrays: dict[str, Any] = {
        "poses": answer.poses,
        "q": angles.shown(solutions.q),
        "valid": solutions.valid,
        "singular": solutions.singular,
        "branches": np.array(solutions.names, dtype=np.str_),
        "joint_names": np.array(answer.arm.joint_names, dtype=np.str_),
        "angle_unit": np.array(angles.unit),
        "within_limits": answer.within,
    }
    if solutions.redundancy is not None:
        arrays["redundancy"] = redundancy_shown(answer.arm, solutions.redundancy, angles)
    if answer.free is not None:
        arrays["collision_free"] = answer.free
    if answer.errors is not None:
        arrays["position_error"], arrays["rotation_error"] = answer.errors[0], angles.angle(answer.errors[1])
    if answer.distances is not None:
        arrays["distance"], arrays["difference"] = answer.distances.each, answer.distances.joints
    return console.npz_bytes(arrays)


DATA: Mapping[str, Callable[[CheckedSolutions, Angles], str | bytes]] = {"json": as_json, "csv": as_csv, "npz": as_npz}


def _parameter(answer: CheckedSolutions, angles: Angles, i: int) -> dict[str, Any]:
    values = answer.solutions.redundancy
    return {} if values is None else {"redundancy": redundancy_shown(answer.arm, values[i], angles)}


def _solution(answer: CheckedSolutions, angles: Angles, i: int, b: int) -> dict[str, Any]:
    out: dict[str, Any] = {
        "branch": answer.solutions.names[i, b],
        "q": angles.shown(answer.solutions.q[i, b]),
        "singular": answer.flags(i, b),
        "within_limits": answer.within[i, b],
    }
    if answer.free is not None:
        out["collision_free"] = answer.free[i, b]
        out["collisions"] = answer.hits.get((i, int(b)), ())
    if answer.errors is not None:
        out["error"] = {"position": answer.errors[0][i, b], "rotation": angles.angle(answer.errors[1][i, b])}
    if answer.distances is not None:
        out["distance"], out["difference"] = answer.distances.each[i, b], answer.distances.joints[i, b]
    return out
