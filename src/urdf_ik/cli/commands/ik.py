"""What ``urdf-ik ik`` does: solve the target, keep what was asked for, check and write it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from urdf_ik.cli import answers, console, tables, targets
from urdf_ik.cli.errors import Status
from urdf_ik.cli.options import Format
from urdf_ik.cli.progress import Progress

if TYPE_CHECKING:
    from urdf_ik.arm import Arm
    from urdf_ik.cli.console import Angles
    from urdf_ik.solutions import IKSolutions


@dataclass(frozen=True)
class Asked:
    """The options as typed."""

    target: targets.Asked
    redundancy: str | None
    within_limits: bool
    collision_free: bool
    turns: bool
    nearest: str | None
    check: bool | None


def run(arm: Arm, angles: Angles, asked: Asked, printed_as: Format, output: Path | None) -> None:
    """Write every solution.

    Raises:
        typer.BadParameter: an invalid target, or a file that cannot be written.
        typer.Exit: a pose has no solution.
    """
    near = None if asked.nearest is None else angles.typed(console.numbers(asked.nearest, "--nearest", arm.joint_names))

    def pick(solutions: IKSolutions) -> IKSolutions:
        # In this order, since images of a solution neither change its collisions nor leave the limits.
        solutions = solutions.within_limits() if asked.within_limits else solutions
        solutions = solutions.collision_free() if asked.collision_free else solutions
        solutions = solutions.turns() if asked.turns else solutions
        return solutions if near is None else solutions.nearest(near)

    with Progress("checking solutions", "solving") as progress:
        target = targets.spread(arm, targets.target(arm, asked.target, angles), asked.redundancy, angles)
        few = len(target.poses) <= tables.SUMMARY_ABOVE
        answer = answers.solve(
            arm,
            target.poses,
            pick,
            redundancy=target.redundancy,
            errors=asked.check is not False,
            collisions=few if asked.check is None else asked.check,
            tick=progress.tick,
        )
    if printed_as is Format.TABLE:
        console.write(tables.answer_text(answer, angles, target.note, to_file=output is not None), output)
    else:
        console.write(answers.DATA[printed_as](answer, angles), output)
    if unsolved := int((answer.counts == 0).sum()):
        if printed_as is not Format.TABLE:
            typer.echo(f"{unsolved} of {len(answer.counts)} poses have no solution", err=True)
        raise typer.Exit(Status.FAILED)
