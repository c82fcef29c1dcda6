"""What ``urdf-ik ik`` does: solve the target, keep what was asked for, check and write it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer

from urdf_ik.cli import answers, console, tables, targets
from urdf_ik.cli.errors import Status
from urdf_ik.cli.options import Format, Metric, Quality
from urdf_ik.cli.progress import Progress

if TYPE_CHECKING:
    from collections.abc import Callable

    from urdf_ik.arm import Arm
    from urdf_ik.cell import World
    from urdf_ik.cli.console import Angles
    from urdf_ik.ik.solutions import IKSolutions


@dataclass(frozen=True)
class Choice:
    """Which solutions to keep, as typed."""

    within_limits: bool
    collision_free: bool
    turns: bool
    nearest: str | None
    metric: Metric
    within: str | None
    best: Quality | None
    world: World | None

    def made_for(self, arm: Arm, angles: Angles) -> Callable[[IKSolutions], IKSolutions]:
        """What picks the solutions.

        Raises:
            typer.BadParameter: joint values that do not fit, or an option that goes with another.
        """
        reference = bounds = None
        if self.nearest is not None:
            reference = angles.typed(console.numbers(self.nearest, "--nearest", arm.joint_names))
            if self.best is not None:
                raise console.usage("--best and --nearest each keep a solution; give one of them", "--best")
        elif self.within is not None or self.metric is not Metric.L2:
            option = "--metric" if self.within is None else "--within"
            raise console.usage("it says how near to --nearest; give that, too", option)
        if self.within is not None:
            alone = len(self.within.replace(",", " ").split()) == 1
            typed = console.numbers(self.within, "--within", ("V",) if alone else arm.joint_names)
            bounds = angles.typed(np.broadcast_to(typed, (arm.dof,)))

        def pick(solutions: IKSolutions) -> IKSolutions:
            # In this order, since images of a solution neither change its collisions nor leave the limits.
            solutions = solutions.within_limits() if self.within_limits else solutions
            solutions = solutions.collision_free(self.world) if self.collision_free else solutions
            solutions = solutions.turns() if self.turns else solutions
            if self.best is not None:
                around = self.world if self.best is Quality.CLEARANCE else None
                solutions = solutions.best(self.best.value, world=around)
            if reference is None:
                return solutions
            return solutions.nearest(reference, metric=self.metric.value, within=bounds)

        return pick


@dataclass(frozen=True)
class Asked:
    """The options as typed."""

    target: targets.Asked
    redundancy: str | None
    choice: Choice
    check: bool | None


def run(arm: Arm, angles: Angles, asked: Asked, printed_as: Format, output: Path | None) -> None:
    """Write every solution.

    Raises:
        typer.BadParameter: an invalid target, or a file that cannot be written.
        typer.Exit: a pose has no solution.
    """
    pick = asked.choice.made_for(arm, angles)
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
            world=asked.choice.world,
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
