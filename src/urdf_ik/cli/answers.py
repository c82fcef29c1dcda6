"""Checks of solutions, which run after the filters, and their form as JSON, CSV, npz and text."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World, missing_pinocchio
from urdf_ik.cli import tables
from urdf_ik.cli.console import Angles
from urdf_ik.ik.solutions import IKSolutions, Singular
from urdf_ik.ik.solutions.distances import measure
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.support.text import counted
from urdf_ik.typing import Array

SUMMARY_ABOVE = 20
"""A table shows the solutions of at most this many poses."""
_BATCH = 512
"""Solutions that Pinocchio measures between two reports of progress."""


@dataclass(frozen=True)
class _CheckedSolutions:
    """The solutions of N poses, each with its checks; an array is None where its check was not asked for.

    Attributes:
        arm: the arm that was solved.
        poses: (N, 4, 4) targets.
        solutions: a batch of N.
        angles: how angles are shown.
        within: (N, B) bool, inside the joint limits as it stands.
        turned: (N, B) bool, inside them after whole turns of some joints.
        free: (N, B) bool, free of self-collision.
        hits: the pairs of links that collide, by pose and column.
        unchecked: reason why self-collision could not be checked, '' where it was or need not be.
        errors: (N, B) m and (N, B) rad, as Pinocchio measures them, NaN where there is no solution.
        unmeasured: reason why the errors could not be measured, '' where they were or need not be.
        metric: name and unit of the distance from the joint vector that the solutions were chosen by; '' without one.
        distance: (N, B) that distance, as shown.
        difference: (N, B, n) of each joint from it, as shown.
        configurations: (N, B) as a maker's controller writes them.
    """

    arm: Arm
    poses: Array
    solutions: IKSolutions
    angles: Angles
    within: NDArray[np.bool_]
    turned: NDArray[np.bool_]
    free: NDArray[np.bool_] | None
    hits: Mapping[tuple[int, int], Sequence[tuple[str, str]]]
    unchecked: str
    errors: tuple[Array, Array] | None
    unmeasured: str
    metric: tuple[str, str] = ("", "")
    distance: Array | None = None
    difference: Array | None = None
    configurations: NDArray[np.str_] | None = None

    @property
    def counts(self) -> NDArray[np.intp]:
        """(N,) number of solutions of each pose."""
        return np.asarray(self.solutions.count)

    @property
    def has_turn(self) -> bool:
        """Whether a direction or a rotation is asked for."""
        solver = self.solutions.solver
        return bool(solver.asked.has_turn and solver.task != "planar position")

    @property
    def redundancy(self) -> Array | None:
        """(N,) or (N, k), the redundancy parameters of each pose, as shown."""
        values = self.solutions.redundancy
        if values is None:
            return None
        turns = np.array([parameter.unit == "rad" for parameter in self.arm.solver.parameters])
        return np.where(turns if len(turns) > 1 else turns[0], self.angles.angle(values), values)

    @property
    def columns(self) -> dict[str, NDArray[Any]]:
        """(N, B) each check that was made, by name."""
        out: dict[str, NDArray[Any]] = {"within_limits": self.within}
        out |= {} if self.free is None else {"collision_free": self.free}
        if self.errors is not None:
            out |= {"position_error": self.errors[0], "rotation_error": self.angles.angle(self.errors[1])}
        return out if self.distance is None else out | {"distance": self.distance}

    def from_reference(self, q_ref: Array, metric: str) -> Self:
        """These with their distances from a joint vector."""
        apart, turning, angles = self.solutions.difference(q_ref), self.angles.turning, self.angles
        far = measure(self.solutions.solver, metric, None, None).distance(apart)
        far = np.where(self.solutions.valid, far, np.nan)
        unit = "s" if metric == "time" else angles.unit if turning.all() else "rad and m" if turning.any() else "m"
        far = angles.angle(far) if unit == angles.unit else far
        return replace(self, metric=(metric, unit), distance=far, difference=angles.shown(apart))

    def to_dict(self) -> dict[str, Any]:
        """One object a pose, in order, each with its solutions."""
        values = self.redundancy
        return {
            "robot": self.arm.name,
            "base": self.arm.base,
            "tip": self.arm.tip,
            "joints": self.arm.joint_names,
            "units": {"angle": self.angles.unit, "length": "m"},
            "family": self.arm.structure.family,
            "poses": [
                {
                    "pose": pose,
                    **({} if values is None else {"redundancy": values[i]}),
                    "count": self.counts[i],
                    "solutions": [self._solution(i, b) for b in np.flatnonzero(self.solutions.valid[i]).tolist()],
                    **({} if self.counts[i] else {"explanation": self.solutions[i].explain()}),
                }
                for i, pose in enumerate(self.poses)
            ],
        }

    def _solution(self, i: int, b: int) -> dict[str, Any]:
        checks = {name: values[i, b] for name, values in self.columns.items()}
        out: dict[str, Any] = {
            "branch": self.solutions.names[i, b],
            "q": self.angles.vectors(self.solutions.q[i, b]),
            "singular": flags(self.solutions.singular[i, b]),
            "within_limits": checks["within_limits"],
        }
        if self.free is not None:
            out |= {"collision_free": checks["collision_free"], "collisions": self.hits.get((i, int(b)), ())}
        if self.errors is not None:
            out["error"] = {"position": checks["position_error"], "rotation": checks["rotation_error"]}
        if self.configurations is not None:
            out["configuration"] = self.configurations[i, b]
        if self.difference is not None:
            out |= {"distance": checks["distance"], "difference": self.difference[i, b]}
        return out

    def rows(self) -> Iterator[list[Any]]:
        """The header and a row a solution; numbers first, so that the text of the last columns can be left out."""
        count = len(self.arm.solver.parameters)
        within, *checks = self.columns
        parameters = ["redundancy"] * count if count < 2 else [f"redundancy_{k}" for k in range(1, count + 1)]
        last = ["singular", "branch", *(["configuration"] if self.configurations is not None else [])]
        yield ["pose", *self.arm.joint_names, within, *parameters, *checks, *last]
        q, values = self.angles.vectors(self.solutions.q), self.redundancy
        for i, b in np.argwhere(self.solutions.valid).tolist():
            found = [column[i, b].item() for column in self.columns.values()]
            own = [] if values is None else np.atleast_1d(values[i]).tolist()
            row = [int(value) if isinstance(value, bool) else value for value in (found[0], *own, *found[1:])]
            words = " ".join(flags(self.solutions.singular[i, b]))
            own_words = [] if self.configurations is None else [self.configurations[i, b]]
            yield [i, *q[i, b].tolist(), *row, words, self.solutions.names[i, b], *own_words]

    def arrays(self) -> dict[str, Any]:
        """The arrays as the package lays them out: NaN rows of ``q`` where a branch has no solution."""
        out = {
            "poses": self.poses,
            "q": self.angles.vectors(self.solutions.q),
            "valid": self.solutions.valid,
            "singular": self.solutions.singular,
            "branches": np.array(self.solutions.names, dtype=np.str_),
            "joint_names": np.array(self.arm.joint_names, dtype=np.str_),
            "angle_unit": np.array(self.angles.unit),
            "redundancy": self.redundancy,
            "difference": self.difference,
            "configurations": self.configurations,
        }
        return {name: values for name, values in out.items() if values is not None} | self.columns


def checked(
    arm: Arm,
    poses: Array,
    solutions: IKSolutions,
    angles: Angles,
    *,
    errors: bool,
    collisions: bool,
    world: World | None = None,
    tick: Callable[[int, int], None],
) -> _CheckedSolutions:
    """Check the solutions of poses (N, 4, 4); ``tick(done, total)`` reports how far the checks are.

    ``world``: obstacles that count as collisions.
    """
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
            position[i, b], rotation[i, b] = solutions.missed(reference.pose(q[i, b]), i)
            tick(start + len(i), len(todo))
    if collisions and len(todo):  # no shapes are made where nothing is to be checked
        body = arm.cell.collisions.in_world(world)
        unchecked = body.missing
        if body.has_geometry:
            free = np.zeros(valid.shape, dtype=np.bool_)
            for done, (i, b) in enumerate(todo):
                free[i, b] = not body.in_collision(q[i, b])
                if not free[i, b]:
                    hits[int(i), int(b)] = body.colliding_pairs(q[i, b])
                tick(done + 1, len(todo))
    return _CheckedSolutions(arm, poses, solutions, angles, within, turned, free, hits, unchecked, measured, unmeasured)


def flags(singular: int) -> list[str]:
    """Names of the singularities in a solution's flags: 'shoulder', 'elbow', 'wrist', 'other'."""
    return [str(flag.name).lower() for flag in Singular if flag & int(singular)] if singular else []


def as_text(answer: _CheckedSolutions, note: str) -> str:
    """The solutions of a few poses, or a summary of many."""
    arm, angles = answer.arm, answer.angles
    head = [f"{arm.name}: {arm.base} to {arm.tip}, {arm.structure.family}"]
    for words, text in (
        ("", note),
        ("redundancy: ", arm.redundancy),
        ("self-collision was not checked: ", answer.unchecked),
        ("errors were not measured: ", answer.unmeasured),
    ):
        head += tables.folded(f"{words}{text}") if text else []
    if len(answer.poses) > SUMMARY_ABOVE:
        return tables.render(*head, "", *_summary(answer))
    named = zip(arm.joint_names, angles.units, strict=True)
    legend = "joints: " + ", ".join(f"q{i} {name} [{unit}]" for i, (name, unit) in enumerate(named, 1))
    lines = [*head, *tables.folded(legend, further=" " * 8)]
    for i, pose in enumerate(answer.poses):
        heading = counted(int(answer.counts[i]), "solution") if answer.counts[i] else "no solution"
        if (values := answer.redundancy) is not None:
            each = zip(arm.solver.parameters, np.atleast_1d(values[i]) + 0.0, strict=True)
            parts = [f"{p.label} {x:.4f} {angles.unit if p.unit == 'rad' else 'm'}" for p, x in each]
            heading += f" at {', '.join(parts)}"
        where = "" if len(answer.poses) == 1 else f"pose {i}: "
        first, second = tables.pose_lines(pose)
        second = second if answer.has_turn else ""
        lines += ["", where + first, *filter(None, [second]), f"{heading}:", *_solutions(answer, i)]
    return tables.render(*lines)


def _solutions(answer: _CheckedSolutions, pose: int) -> list[str]:
    """Every solution of one pose: branch, joint values, checks; in two tables where one would be too wide."""
    angles, names = answer.angles, answer.solutions.names[pose]
    places = np.flatnonzero(answer.solutions.valid[pose]).tolist()
    if not places:
        return ["", answer.solutions[pose].explain()]
    q, branches = angles.vectors(answer.solutions.q[pose]), _branch_columns([names[b] for b in places])
    digits = 2 if angles.degrees else 4
    values = [
        {"#": k, **branches[k - 1], **{f"q{i}": tables.number(x, digits) for i, x in enumerate(q[b], 1)}}
        for k, b in enumerate(places, 1)
    ]
    checks = [_checks(answer, pose, b) for b in places]
    notes = [""] * bool(answer.hits)
    for k, b in enumerate(places, 1):
        if pairs := answer.hits.get((pose, b)):
            notes.append(f"{k} hits: {', '.join(f'{first} - {second}' for first, second in pairs)}")
    if answer.distance is not None and answer.difference is not None:
        notes.append("")
        for b in places:
            apart, (metric, unit) = np.abs(answer.difference[pose, b]), answer.metric
            k = int(np.argmax(apart))
            far = f"from --nearest: {answer.distance[pose, b]:.4g} {unit} ({metric})"
            notes.append(f"{far}; farthest joint: q{k + 1}, {apart[k]:.4g} {angles.units[k]}")
    whole = tables.outline({"rows": [row | check for row, check in zip(values, checks, strict=True)]})
    if not tables.fits(whole):
        numbered = [{"#": k, **check} for k, check in enumerate(checks, 1)]
        whole = tables.outline({"values": values, "checks": numbered})
    return [*whole, *notes]


def _checks(answer: _CheckedSolutions, pose: int, b: int) -> dict[str, str]:
    """The checks of a solution by the heads of their columns."""
    row = {} if answer.configurations is None else {"configuration": str(answer.configurations[pose, b])}
    row["in limits"] = "yes" if answer.within[pose, b] else "by turns" if answer.turned[pose, b] else "no"
    if answer.free is not None:
        row["collision"] = "free" if answer.free[pose, b] else "hits"
    row["singular"] = ", ".join(flags(answer.solutions.singular[pose, b])) or "no"
    if answer.errors is not None:
        position, rotation = answer.columns["position_error"], answer.columns["rotation_error"]
        row["error [m]"] = f"{position[pose, b]:.1e}"
        if answer.has_turn:
            row[f"error [{answer.angles.unit}]"] = f"{rotation[pose, b]:.1e}"
    return row


def _summary(answer: _CheckedSolutions) -> list[str]:
    """Many poses in a few lines: how many were solved, how many solutions they have, the worst error."""
    counts, columns = answer.counts, answer.columns
    solved, total = int((counts > 0).sum()), int(counts.sum())
    lines = [f"{len(counts)} poses, {solved} solved, {len(counts) - solved} without a solution, {total} solutions"]
    shares = {"within limits": answer.within, "within limits by whole turns": answer.turned}
    shares |= {} if answer.free is None else {"free of self-collision": answer.free}
    shares["singular"] = (answer.solutions.singular != 0) & answer.solutions.valid
    lines += [f"{name}: {int(flags.sum())} of {total} solutions" for name, flags in shares.items()]
    if answer.errors is not None and total:
        position, rotation = (np.nanmax(columns[name]) for name in ("position_error", "rotation_error"))
        turn = f", {rotation:.1e} {answer.angles.unit}" if answer.has_turn else ""
        lines.append(f"worst error as Pinocchio measures it: {position:.1e} m{turn}")
    if (far := answer.distance) is not None and total:
        where, (metric, unit) = np.unravel_index(int(np.nanargmax(far)), far.shape)[0], answer.metric
        lines.append(f"farthest from --nearest ({metric}): {np.nanmax(far):.4g} {unit}, pose {where}")
    if solved < len(counts):
        first = int(np.flatnonzero(counts == 0)[0])
        lines.append(f"first pose without a solution: {first}: {answer.solutions[first].explain()}")
    numbers, poses = np.unique(counts, return_counts=True)
    shown = (40 * poses / poses.max()).round().astype(int).clip(min=1)
    rows = [{"solutions": c, "poses": p, "share": "#" * k} for c, p, k in zip(numbers, poses, shown, strict=True)]
    return [*lines, *tables.outline({"histogram": rows})]


def _branch_columns(branches: Sequence[str]) -> list[dict[str, str]]:
    """Names like 'shoulder front, elbow up' as columns 'shoulder' and 'elbow'; other names as one column."""
    parts = [dict(part.partition(" ")[::2] for part in name.split(", ")) for name in branches]
    if all(each.keys() == parts[0].keys() and all(each.values()) for each in parts):
        return parts
    return [{"branch": name} for name in branches]
