"""The command ``explain``."""

from pathlib import Path
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.cell.collision_model import CollisionModel
from urdf_ik.cli import console, tables
from urdf_ik.cli.answers import flags
from urdf_ik.cli.arm_options import ArmOptions, read_world
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import PartOfPose, PoseOptions, ReportFormat
from urdf_ik.ik.solutions import IKSolutions, limits
from urdf_ik.support.text import counted
from urdf_ik.typing import Array


def explain(
    *,
    typed: PoseOptions,
    seed: int = 0,
    task: PartOfPose | None = None,
    axis: str | None = None,
    redundancy: str | None = None,
    world: Path | None = None,
    chosen: ArmOptions,
    degrees: bool = False,
    printed_as: ReportFormat = ReportFormat.TABLE,
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
    """
    from urdf_ik.cli import targets

    obstacles = read_world(world, chosen)
    arm, angles = chosen.loaded(degrees, typed)
    asked, direction = targets.task_of(task, axis)
    arm = arm.for_task(asked, direction)
    target = targets.spread(arm, targets.target(arm, typed, None, seed, angles, asked), redundancy, angles)
    wanted, values = targets.of_task(arm, target.poses), target.redundancy
    found = [
        {"pose": k, **_explained(arm, wanted[k], None if values is None else values[k], obstacles, angles)}
        for k in range(len(wanted))
    ]
    data = {"robot": arm.name, "base": arm.base, "tip": arm.tip, "task": asked, "poses": found}
    console.emit(printed_as, data, lambda: _text(arm, target.note, found))


def _explained(arm: Arm, wanted: Array, redundancy: Array | None, world: World | None, angles: Angles) -> Any:
    """The answer to one target in words."""
    solutions = arm.ik(wanted, redundancy=redundancy)
    bodies = arm.cell.collisions.in_world(world)
    inside = solutions.within_limits()
    usable = inside.collision_free(world) if bodies.has_geometry else inside
    single = len(arm.solver.parameters) == 1 and arm.solver.require_member().self_motion is not None
    return {
        "solutions": int(solutions.count),
        "of_use": int(usable.count),
        "why": solutions.explain() if not solutions.count else "" if usable.count else usable.explain(),
        "each": [_line(arm, solutions, int(b), bodies, angles) for b in np.flatnonzero(solutions.valid)],
        "intervals": list(map(str, arm.intervals(wanted))) if single else [],
        "unchecked": "" if bodies.has_geometry else bodies.missing,
    }


def _line(arm: Arm, solutions: IKSolutions, column: int, bodies: CollisionModel, angles: Angles) -> str:
    """One solution, and what stands in its way."""
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


def _text(arm: Arm, note: str, found: list[dict[str, Any]]) -> str:
    """Lines for people, folded under themselves."""
    lines = [f"{arm.name}: {arm.base} to {arm.tip}, {arm.structure.family}", *tables.folded(note)]
    for one in found:
        number, intervals = one["solutions"], one["intervals"]
        count = f"{counted(number, 'solution')}, {one['of_use']} of use" if number else "no solution"
        lines += ["", count if len(found) == 1 else f"pose {one['pose']}: {count}"]
        words = [one["why"], *(f"{k} {text}" for k, text in enumerate(one["each"], 1))]
        if intervals:
            words += ["", f"{arm.redundancy}", f"has {len(intervals)} intervals with solutions:", *intervals]
        words += [f"contacts were not checked: {one['unchecked']}"] if one["unchecked"] else []
        lines += [line for text in words for line in tables.folded(text, "  ", "    ")]
    return tables.render(lines)
