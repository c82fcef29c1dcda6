"""The command ``explain``."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.cell.collision_model import CollisionModel
from urdf_ik.cli import console, options, tables
from urdf_ik.cli.answers import flags
from urdf_ik.cli.arm_options import ArmOptions, angles_of, read_world
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import ReportFormat
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.typing import Array

_INTERVALS_SHOWN = 8


@dataclass(frozen=True)
class _Explained:
    """The answer to one pose in words.

    Attributes:
        pose: its number.
        solutions: how many joint vectors reach it.
        of_use: how many of these are inside the limits, after whole turns, and free of contacts.
        why: why there is none, or none of use; '' where there is one.
        each: a line on every solution, what stands in its way.
        intervals: where along the redundancy parameter there are solutions; empty without a single parameter.
        unchecked: why contacts were not checked; '' where they were.
    """

    pose: int
    solutions: int
    of_use: int
    why: str
    each: tuple[str, ...]
    intervals: tuple[str, ...]
    unchecked: str


def explain(
    *,
    typed: options.PoseOptions,
    seed: options.Seed = 0,
    task: options.Task = None,
    redundancy: options.Redundancy = None,
    world: options.World = None,
    chosen: ArmOptions,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Explain the answer to a pose: what reaches it, and what stands in the way of each solution.

    For each solution it says which joint is how far outside its limits, after whole turns, and which links touch.
    Where nothing reaches the pose it names the part of the arm that is too short, or the direction that joints do
    not control. With a redundancy parameter it lists the intervals that have solutions.

    Examples:
        urdf-ik explain zyyzyz_6r --xyz 0 0 4 --rpy 0 0 0
        urdf-ik explain ur5 --q 0.1,-1,1,0.2,0.3,0 --world cell.urdf
        urdf-ik explain my_arm.urdf --tip tool0 --poses stations.csv --json
        urdf-ik explain planar_2r --task planar-position --xyz 0.3 0 0

    Raises:
        typer.BadParameter: an invalid target.
    """
    from urdf_ik.cli import targets

    chosen.apart_from(typed)
    obstacles = read_world(world, chosen)
    arm = chosen.load(degrees)
    angles = angles_of(arm, degrees)
    asked = "pose" if task is None else task.value.replace("-", " ")
    target = targets.spread(arm, targets.target(arm, typed, None, seed, angles, asked), redundancy, angles)
    wanted = target.poses if asked == "pose" else targets.of_task(arm, target.poses, asked)
    arm = arm.for_task(asked)
    found = [
        _explained(arm, k, wanted[k], None if target.redundancy is None else target.redundancy[k], obstacles, angles)
        for k in range(len(wanted))
    ]
    facts = {"robot": arm.name, "base": arm.base, "tip": arm.tip, "task": asked}
    data = {**facts, "poses": [asdict(each) for each in found]}
    console.emit(data, lambda: _text(arm, target.note, found), printed_as)


def _explained(
    arm: Arm,
    k: int,
    wanted: Array,
    redundancy: Array | None,
    world: World | None,
    angles: Angles,
) -> _Explained:
    """The answer to one target in words."""
    solutions = arm.ik(wanted, redundancy=redundancy)
    bodies = arm.cell.collisions.in_world(world)
    inside = solutions.within_limits()
    usable = inside.collision_free(world) if bodies.has_geometry else inside
    why = solutions.explain() if not solutions.count else "" if usable.count else usable.explain()
    each = tuple(_line(arm, solutions, int(b), bodies, angles) for b in np.flatnonzero(solutions.valid))
    along: tuple[str, ...] = ()
    if solutions.solver.task == "pose" and len(arm.solver.parameters) == 1:
        along = tuple(map(str, arm.intervals(wanted)))
    unchecked = "" if bodies.has_geometry else bodies.missing
    return _Explained(k, int(solutions.count), int(usable.count), why, each, along, unchecked)


def _line(arm: Arm, solutions: IKSolutions, column: int, bodies: CollisionModel, angles: Angles) -> str:
    """One solution, and what stands in its way."""
    from urdf_ik.ik.solutions import limits

    q, chain = solutions.q[column], arm.chain
    _, out = limits.excess(q[None], arm.limits, chain.image_turns, limits.LIMIT_TOLERANCE)
    wrong = [
        f"{arm.joint_names[i]} {abs(angles.shown(out[0])[i]):.4g} {angles.units[i]} "
        f"{'above' if out[0, i] > 0.0 else 'below'} its limits"
        for i in np.flatnonzero(out[0])
    ]
    pairs = bodies.colliding_pairs(q) if bodies.has_geometry else ()
    wrong += [f"{one} touches {other}" for one, other in pairs]
    singular = flags(solutions.singular[column])
    wrong += [f"singular ({', '.join(singular)})"] if singular else []
    return f"{solutions.names[column]}: {'; '.join(wrong) or 'of use'}"


def _text(arm: Arm, note: str, found: list[_Explained]) -> str:
    """Lines for people, folded under themselves."""
    lines = [f"{arm.name}: {arm.base} to {arm.tip}, {arm.structure.family}", *tables.folded(note)]
    for one in found:
        count = f"{one.solutions} solution{'s' * (one.solutions != 1)}, {one.of_use} of use"
        count = count if one.solutions else "no solution"
        lines += ["", count if len(found) == 1 else f"pose {one.pose}: {count}"]
        lines += _folded(one.why)
        lines += [line for number, text in enumerate(one.each, 1) for line in _folded(f"{number} {text}")]
        if one.intervals:
            lines += ["", f"{arm.redundancy}", f"has {len(one.intervals)} intervals with solutions:"]
            lines += [line for text in one.intervals[:_INTERVALS_SHOWN] for line in _folded(text)]
            more = len(one.intervals) - _INTERVALS_SHOWN
            lines += [f"  and {more} more: --json lists them"] if more > 0 else []
        lines += _folded(f"contacts were not checked: {one.unchecked}") if one.unchecked else []
    return tables.render(*lines)


def _folded(text: str) -> list[str]:
    return tables.folded(text, "  ", "    ")
