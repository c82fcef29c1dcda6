"""The commands ``freeze`` and ``verify``, which write and read lock files."""

import os
from dataclasses import replace
from pathlib import Path

import typer

from urdf_ik.arm import Arm
from urdf_ik.cli import console
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.cli.console import Progress, Status
from urdf_ik.cli.options import PoseOptions, ReportFormat, ReviewFormat
from urdf_ik.errors import ChainError, UrdfIkError
from urdf_ik.support import files
from urdf_ik.verify import baselines, review
from urdf_ik.verify.baselines import Lock, Verification, lock_beside
from urdf_ik.verify.differences import Tolerance, ignored
from urdf_ik.verify.review import VerifiedFile


def freeze(
    *,
    lock_file: Path | None = None,
    typed: PoseOptions,
    collisions: bool | None = None,
    chosen: ArmOptions,
    printed_as: ReportFormat = ReportFormat.TABLE,
) -> None:
    """Freeze an arm: write its answers of today to a lock file for version control.

    The lock file holds joints, axes, limits, shapes, Pinocchio's poses and every solution of 50 poses, as text of
    at most 200 kB. Poses of yours are kept as well. Contacts are kept where all shapes can be read; --collisions
    makes it an error where they cannot. `urdf-ik verify` says later what is different.

    Without a lock file it is NAME.lock.json beside the robot, where `urdf-ik verify` and `pytest --urdf` look for it.

    Examples:
        urdf-ik freeze my_arm.urdf
        urdf-ik freeze ur5 ur5.lock.json
        urdf-ik freeze my_arm.urdf my_arm.lock.json --tip tool0 --poses stations.csv

    Positional:
        lock_file ([LOCK]): The lock file to write, such as arm.lock.json.

    """
    from urdf_ik.cli import targets

    file = lock_file or lock_beside(chosen.robot)
    if lock_file is None and file.exists():
        raise console.usage(f"{file} is there already: name it to write it anew, or urdf-ik verify --update", "LOCK")
    files.writable(file)
    arm, angles = chosen.loaded(False, typed)
    target = targets.given(arm, typed, angles)
    own = None if target is None else target.poses
    with Progress("solving poses") as progress:
        contacts = collisions is None or ("require" if collisions else False)
        lock = baselines.freeze(arm, own, collisions=contacts, progress=progress.tick)
    lock.save(file)
    about = {"robot": arm.name, "base": arm.base, "tip": arm.tip, "poses": len(lock.poses), "file": str(file)}
    console.emit(printed_as, about | {"unlooked": ""}, lambda: f"{repr(lock)[1:-1]}, in {file}\n")


def verify(
    *,
    chosen: ArmOptions,
    further: list[str] | None = None,
    locks: Path | None = None,
    tolerance_mm: float | None = None,
    tolerance_deg: float | None = None,
    ignore: str | None = None,
    update: bool = False,
    time_limit: float | None = None,
    printed_as: ReviewFormat = ReviewFormat.TABLE,
) -> None:
    """Verify arms against their lock files.

    It names the joint, link or limit that is different, by how many mm and degrees, and the solutions that were lost or
    gained at which poses. The status is 1 when something is different, or when the time limit left poses out.

    Without a lock file it is NAME.lock.json beside the robot. Base, tip and held joints are those of the lock file
    where they are not given. A tool, a free axis or a redundancy joint has to be given again.

    github prints annotations at the lines of the file, and appends the Markdown to the job's summary; sarif is for code
    scanning.

    Examples:
        urdf-ik verify my_arm.urdf my_arm.lock.json
        urdf-ik verify my_arm.urdf my_arm.lock.json --tolerance-mm 0.1 --ignore visuals,collisions
        urdf-ik verify left.urdf right.urdf --locks locks --format github
        urdf-ik verify my_arm.urdf my_arm.lock.json --update

    Positional:
        further ([LOCK | ROBOT...]): Its lock file; or more robots, each with a lock file of its name.

    Options:
        locks (DIR): Folder of the lock files NAME.lock.json. Default: beside each robot.
        update: Then write the lock file anew; the status is 0.

    Options (Output):
        printed_as (--format -f): How to print it; github: annotations.
    """
    Tolerance.read(tolerance_mm, tolerance_deg)
    ignored(ignore or ())
    more = further or []
    named = len(more) == 1 and (more[0].endswith(".json") or ".lock" in more[0])
    paths = {robot: lock_beside(robot, locks) for robot in [chosen.robot, *([] if named else more)]}
    if named:
        paths[chosen.robot] = Path(more[0])
    done: list[VerifiedFile] = []
    texts: list[str] = []
    unread: UrdfIkError | None = None
    with Progress("comparing poses") as progress:
        for robot, path in paths.items():
            result: Verification | UrdfIkError
            definitions: tuple[str, ...] = ()
            try:
                lock = Lock.load(path)
                arm, definition = _loaded(replace(chosen, robot=robot), lock)
                definitions = definition, f"lock = urdf_ik.verify.Lock.load({str(path)!r})"
                result = lock.verify(
                    arm,
                    tolerance_mm=tolerance_mm,
                    tolerance_deg=tolerance_deg,
                    ignore=ignore or (),
                    time_limit=time_limit,
                    progress=progress.tick,
                )
                if update:
                    own = [pose.matrix for pose in lock.poses if pose.kind == "own"]
                    baselines.freeze(arm, own or None).save(path)
                    console.say(f"updated: {path}")
            except _ChainGone as error:
                result = error
            except UrdfIkError as error:
                if printed_as in ("table", "json"):
                    raise
                result = unread = error
            done.append(VerifiedFile(robot if Path(robot).is_file() else str(path), result))
            texts.append(console.replayed(done[-1], *definitions))
    _print(done, "".join(texts), printed_as)
    if unread is not None:
        raise unread
    if not (update or all(each.passed for each in done)):
        raise typer.Exit(Status.FAILED)


class _ChainGone(ChainError):
    """The links of the lock are not in the URDF any more."""


def _print(done: list[VerifiedFile], text: str, printed_as: ReviewFormat) -> None:
    """Print the results, for people as ``text``; GitHub also gets a summary of the job."""
    summary = os.environ.get("GITHUB_STEP_SUMMARY")
    if printed_as == "github" and summary:
        with open(summary, "a", encoding="utf-8") as file:
            file.write(review.markdown(done))
    if printed_as in ("table", "json"):
        data = [each.to_dict() for each in done]
        console.emit(printed_as, data[0] if len(data) == 1 else data, lambda: text)
    else:
        console.write(getattr(review, printed_as)(done))


def _loaded(chosen: ArmOptions, lock: Lock) -> tuple[Arm, str]:
    """The arm, its base, tip and held joints those of the lock where no option names them; and its definition."""
    held = [f"{name}={value!r}" for name, value in lock.arm.locked] if chosen.lock is None else chosen.lock
    asked = chosen.base or chosen.tip or chosen.chain
    if chosen.chain is None and chosen.srdf is None:
        base = lock.arm.base if chosen.base is None else chosen.base
        tip = lock.arm.tip if chosen.tip is None else chosen.tip
        chosen = replace(chosen, base=base, tip=tip)
    chosen = replace(chosen, lock=held or None)
    try:
        return chosen.load(), chosen.definition
    except ChainError as error:
        if asked is not None:
            raise
        raise _ChainGone(f"{lock.arm.base} to {lock.arm.tip} of the lock is gone: {error}") from None
