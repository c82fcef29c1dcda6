"""The command ``ik``, and its choice of solutions."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import typer

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.cli import console, options, targets
from urdf_ik.cli.arm_options import ArmOptions, read_world
from urdf_ik.cli.console import Angles, Progress, Status
from urdf_ik.cli.options import Format, PartOfPose, PoseOptions
from urdf_ik.cli.targets import Target
from urdf_ik.ik.configurations import VENDORS
from urdf_ik.ik.explanation import in_mm
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.ik.solutions.distances import Metric, Quality, Wish, check_quality
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.ik.task import POSE, Task
from urdf_ik.typing import Array

First = Literal["position", "orientation"]


@dataclass(frozen=True)
class _Choice(options.Record):
    """Options that choose solutions, as typed.

    Options:
        within_limits: Keep those inside the limits.
        collision_free: Keep those free of self-collision, and of --world.
        turns: Add the +-2 pi images inside the limits.
        nearest (Q1,Q2,...): Keep the one nearest to this joint vector.
        metric: Distance of --nearest: all joints, the largest one, or time.
        max_step (V|V1,V2,...): Drop those with a joint further from --nearest.
        best: Keep the one farthest from limits, singularity or contact.
        wish (LINK|LINK=X,Y,Z): Keep the one with this link highest, or nearest to a place (m, base), inside the limits.
        configuration (MAKER[ TEXT]): Show each as a controller writes it: abb, fanuc, kuka, motoman, staubli; with
            text, as in 'fanuc NUT 0 0 0', keep those.
    """

    GROUP = "Solutions"
    within_limits: bool = False
    collision_free: bool = False
    turns: bool = False
    nearest: str | None = None
    metric: Metric = "l2"
    max_step: str | None = None
    best: Quality | None = None
    wish: str | None = None
    configuration: str | None = None

    @property
    def maker(self) -> str:
        """The maker of --configuration; '' without one."""
        maker = (self.configuration or "").partition(" ")[0].lower()
        if maker and maker not in VENDORS:
            raise console.usage(f"{maker!r} is no maker; one of {', '.join(VENDORS)}", "--configuration")
        return maker

    def reference(self, arm: Arm, angles: Angles) -> Array | None:
        """(n,) rad or m, the joint vector of --nearest."""
        if self.nearest is None:
            return None
        return angles.typed_vectors(console.numbers(self.nearest, "--nearest", arm.joint_names))

    def at_the_nearest(self, arm: Arm, target: Target, angles: Angles) -> Target:
        """The target with the redundancy parameters of the solution for --nearest or --wish, contacts aside.

        Where values were typed, or poses were given as joint vectors, these stay.
        """
        reference, wish = self.reference(arm, angles), self.wished(arm)
        if target.redundancy is not None or not arm.solver.parameters:
            return target
        if wish is not None:
            found, why = arm.ik(targets.of_task(arm, target.poses)).best(wish), "best by --wish"
        elif reference is not None:
            found = arm.ik_nearest(target.poses, reference, metric=self.metric, within_limits=self.within_limits)
            why = "nearest to --nearest"
        else:
            return target
        note = f"{target.note}; redundancy parameter: all values searched for the solution {why}"
        return replace(target, redundancy=found.redundancy, note=note)

    def wished(self, arm: Arm) -> Wish | None:
        """The wish of --wish."""
        if self.wish is None:
            return None
        link, _, place = self.wish.partition("=")
        wish = Wish(link, tuple(console.numbers(place, "--wish", ("X", "Y", "Z"))) if place else None)
        check_quality(wish, arm.chain)
        return wish

    def filter_for(self, arm: Arm, angles: Angles, world: World | None) -> Callable[[IKSolutions], IKSolutions]:
        """The function that filters solutions by these options, before errors and contacts are measured."""
        reference, wish, bounds, maker = self.reference(arm, angles), self.wished(arm), None, self.maker
        if (reference is not None) + (self.best is not None) + (self.wish is not None) > 1:
            raise console.usage("--best, --wish and --nearest each keep a solution; give one of them", "--best")
        if reference is None and (self.max_step is not None or self.metric != "l2"):
            option = "--metric" if self.max_step is None else "--max-step"
            raise console.usage("it says how near to --nearest; give that, too", option)
        if self.max_step is not None:
            names = ("V",) if len(console.split(self.max_step)) == 1 else arm.joint_names
            bounds = angles.typed(np.broadcast_to(console.numbers(self.max_step, "--max-step", names), (arm.dof,)))

        def pick(solutions: IKSolutions) -> IKSolutions:
            # In this order, since images of a solution neither change its collisions nor leave the limits.
            solutions = solutions.within_limits() if self.within_limits else solutions
            solutions = solutions.collision_free(world) if self.collision_free else solutions
            solutions = solutions.turns() if self.turns else solutions
            if wanted := (self.configuration or "").partition(" ")[2].strip():
                solutions = solutions.with_configuration(wanted, maker)
            if self.best is not None:
                around = world if self.best == "clearance" else None
                solutions = solutions.best(self.best, world=around)
            if wish is not None:
                solutions = solutions.best(wish)
            if reference is None:
                return solutions
            return solutions.nearest(reference, metric=self.metric, within=bounds)

        return pick


@dataclass(frozen=True)
class Nearest(options.Record):
    """Options for targets that cannot be reached exactly, as typed.

    Options:
        closest: The nearest postures, with what they miss.
        first: What --closest misses by as little as possible. Default: position.
        tolerance (M,RAD): What a solution may miss. Default: the decimals of typed poses, else 1e-9.
    """

    GROUP = "Poses"
    closest: bool = False
    first: First | None = None
    tolerance: str | None = None

    @property
    def asked(self) -> bool:
        """Whether the nearest postures are asked for."""
        return self.closest or self.first is not None

    def solve(
        self,
        arm: Arm,
        target: Target,
        angles: Angles,
        task: tuple[str, Any],
        near: Array | None,
        *,
        within_limits: bool,
    ) -> tuple[IKSolutions, str]:
        """The solutions of poses, or the nearest postures, and a note on what they miss; searches try ``near``, too."""
        if self.asked:
            asked = Task.read(*task)
            found = arm.ik_closest(target.poses, first=self.first, task=asked, within_limits=within_limits)
            how = "" if found.certain.all() else " that a search found"
            return found, f"the nearest postures{how}, the best first{in_mm(arm.solver, target.poses[0])}"
        wanted = targets.of_task(arm, target.poses)
        near = None if arm.solver.asked == POSE or arm.solver.parameters else near
        found, tolerance = arm.ik(wanted, near, redundancy=target.redundancy), target.tolerance
        if arm.solver.parameters and target.redundancy is None:
            return at_other_values(arm, found)
        if self.tolerance is not None:
            pair = console.numbers(self.tolerance, "--tolerance", ("m", "rad"))
            tolerance = (float(pair[0]), float(angles.typed(pair[1]) if angles.degrees else pair[1]))
        exact = tolerance is None or arm.solver.parameters or arm.solver.targets is not None
        if exact or tolerance is None or bool((found.count > 0).all()):
            return found, ""
        return near_poses(arm, found, tolerance, angles)


def at_other_values(arm: Arm, found: IKSolutions) -> tuple[IKSolutions, str]:
    """Solutions at the default values, or where none is inside the limits at others; and a note on that."""
    shown = arm.ik(found.poses, redundancy=arm.values_inside(found.poses))
    moved = np.asarray(shown.redundancy != found.redundancy).reshape(len(found.count), -1).any(axis=1)
    if not moved.any():
        return found, ""
    which = "" if moved.all() else f" of {int(moved.sum())} of the poses"
    return shown, f"no solution{which} is inside the limits at the default redundancy; others were searched"


def near_poses(arm: Arm, found: IKSolutions, tolerance: tuple[float, float], angles: Angles) -> tuple[IKSolutions, str]:
    """Solutions of a batch, where there are none those within a tolerance m, rad; and a note on what these miss."""
    from urdf_ik.ik.tolerance import joined

    open_ = np.flatnonzero(found.count == 0)
    near = arm.ik(found.poses[open_], tolerance=tolerance)
    if not near.count.any():
        return found, ""
    both = joined(found, open_, near)
    off = [float(np.nanmax(each)) for each in near.error]
    most = f"{tolerance[0]:.1e} m, {angles.angle(tolerance[1]):.1e} {angles.unit}"
    return (
        both,
        f"missed by at most {off[0]:.1e} m, {angles.angle(off[1]):.1e} {angles.unit}, as the decimals allow ({most})",
    )


def ik(
    *,
    typed: PoseOptions,
    random: int | None = None,
    seed: int = 0,
    task: PartOfPose | None = None,
    axis: str | None = None,
    redundancy: str | None = None,
    nearest_posture: Nearest,
    choice: _Choice,
    world: Path | None = None,
    check: bool | None = None,
    chosen: ArmOptions,
    degrees: bool = False,
    pendant: bool = False,
    printed_as: Format | None = None,
    output: Path | None = None,
) -> None:
    """Inverse kinematics: every solution of a pose, with its branch, checks and error as Pinocchio measures it.

    The target is a typed pose (--xyz with an orientation), the tip at a joint vector (--q), poses of a file
    (--poses) or random ones (--random). Without these it is the arm's example: of 256 seeded joint vectors the one
    whose pose has most solutions. The table summarizes more than 20 poses. The status is 1 when a pose has no
    solution.

    Examples:
        urdf-ik ik dh_6r --xyz 0.5 0.11 0.26 --quat-xyzw 0 0 0.8 0.6
        urdf-ik ik planar_2r --task planar-position --xyz 0.1,0.05,0
        urdf-ik ik so101 --task position --xyz 0.2,0.1,0.05 --within-limits
        urdf-ik ik so101 --task position --axis x --xyz 0.2,0.1,0.05 --rpy 0,1.57,0
        urdf-ik ik ur5 --q 0.1,-1,1,0.2,0.3,0 --collision-free --world cell.urdf
        urdf-ik ik ur5 --q 0.1,-1,1,0.2,0.3,0 --nearest 0,-1,1,0,0,0 --max-step 0.5
        urdf-ik ik so101 --xyz 0.2,0.1,0.05 --rpy 0,1.57,0 --closest --within-limits
        urdf-ik ik ur5 --random 1000 --output solutions.npz
        urdf-ik ik puma_560 --q 0.1,-1,1,0.2,0.3,0 --configuration fanuc
        urdf-ik ik panda --xyz 0.4,0,0.3 --rpy 3.14,0,0 --redundancy 0,0.4,0.8

    Options (Poses):
        random (-n N): Random poses.

    Options (Solutions):
        check: Pinocchio's errors and contacts, or neither. Default: both up to 20 poses, then errors.
    """
    from urdf_ik.cli import answers

    chosen_format = options.format_for(printed_as, output, terminal=options.is_terminal(sys.stdout))
    obstacles = read_world(world, chosen)
    arm, angles = chosen.loaded(degrees, typed, pendant)
    keep = choice.filter_for(arm, angles, obstacles)
    with Progress("checking solutions") as progress:
        asked, direction = targets.task_of(task, axis)
        whole = arm
        if not nearest_posture.asked:
            arm = arm.for_task(asked, direction)
        target = targets.target(arm, typed, random, seed, angles, asked)
        target = targets.spread(arm, target, redundancy, angles)
        target = choice.at_the_nearest(arm, target, angles)
        wanted, near = (asked, direction), choice.reference(arm, angles)
        solved, note = nearest_posture.solve(arm, target, angles, wanted, near, within_limits=choice.within_limits)
        task_words = "" if solved.solver.asked == POSE else f"task: {solved.solver.asked}"
        searched = task_words and not note and not solved.certain.all()
        past = 0.0 if near is None else np.maximum(arm.limits[:, 0] - near, near - arm.limits[:, 1])
        beyond = [
            name for name, far in zip(arm.joint_names, past * np.ones(arm.dof), strict=True) if far > LIMIT_TOLERANCE
        ]
        outside = f"--nearest is outside the limits of {', '.join(beyond)}; turns inside come first" if beyond else ""
        others = "found by search, so that there may be others" if searched else ""
        parts = (target.note, task_words, note, others, outside)
        target = replace(target, note="; ".join(part for part in parts if part))
        answer = answers.checked(
            whole if arm.solver.targets is not None else arm,
            target.poses,
            keep(solved),
            angles,
            errors=check is not False,
            collisions=len(target.poses) <= answers.SUMMARY_ABOVE if check is None else check,
            world=obstacles,
            tick=progress.tick,
        )
    if (reference := choice.reference(arm, angles)) is not None:
        answer = answer.from_reference(reference, choice.metric)
    if choice.maker:
        answer = replace(answer, configurations=answer.solutions.configuration(choice.maker))
    counts, table = answer.counts.tolist(), chosen_format is Format.TABLE
    total = f"{sum(counts)} solution{'s' * (sum(counts) != 1)} of {len(counts)} pose{'s' * (len(counts) != 1)}"
    console.emit(
        chosen_format,
        answer.to_dict,
        lambda: answers.as_text(answer, target.note),
        output,
        rows=answer.rows,
        arrays=answer.arrays,
        about=f"{total}; {angles.unit}, m",
    )
    if answer.unmeasured and not table:
        console.say(f"errors and contacts were not checked: {answer.unmeasured}")
    if unsolved := counts.count(0):
        if not table:
            console.say(f"{unsolved} of {len(counts)} poses have no solution")
        if arm.dof < 6 and asked == "pose" and not nearest_posture.asked:
            console.say(
                f"{arm.dof} joints reach few whole poses; the nearest posture: --closest; a part: --task position"
            )
        raise typer.Exit(Status.FAILED)
