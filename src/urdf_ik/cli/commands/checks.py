"""The commands ``check``, ``compare`` and ``judge``."""

import string
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import typer

from urdf_ik.arm import Arm
from urdf_ik.arm.loading import read
from urdf_ik.cli import console, tables
from urdf_ik.cli.arm_options import ArmOptions, SeveralArms, angles_of, read_world
from urdf_ik.cli.console import Progress, Status
from urdf_ik.cli.options import PoseOptions, ReportFormat
from urdf_ik.errors import ChainError, UnsupportedArm, UrdfError, UrdfIkError
from urdf_ik.support import files
from urdf_ik.support.report import Report


def check(
    *,
    n: int = 200,
    seed: int = 0,
    complete: bool = False,
    proof: bool = False,
    collisions: bool | None = None,
    time_limit: float | None = None,
    chosen: ArmOptions,
    printed_as: ReportFormat = ReportFormat.TABLE,
) -> None:
    """Check an arm against Pinocchio: kinematics, every solution of random poses, collision.

    The status is 1 when a check failed, or when the time limit left something out.

    With --complete it looks for solutions that the solver missed: the general elimination, and Newton's method from
    random starts where the solver uses the elimination itself, answer the same poses, random ones and some 1e-1 to
    1e-8 rad from a singularity. Every difference is printed. The status is 1 when the solver lacks a solution or
    has one that Pinocchio does not confirm.

    With --proof it checks the solver's own proofs: the zeros of a determinant, in ball arithmetic and without code of
    the solver, accept or refuse every answer whose status is complete or clustered. It takes about half a second a
    pose and needs python-flint (the extra `proof`).

    ROBOT may be a folder: every URDF in it is checked, and one table shows the result of each.

    Examples:
        urdf-ik check zyyzyz_6r -n 50
        urdf-ik check ur5 --complete -n 20
        urdf-ik check ur5 --proof -n 3
        urdf-ik check my_arm.urdf --tip tool0 --no-collisions --json
        urdf-ik check lab/ --complete -n 2

    Options:
        complete: Instead: look for missing solutions in a second way, at N random, N nearly singular, N round poses.
        proof: Instead: check the proofs of N random, N nearly singular and N round poses.
    """
    from urdf_ik.verify import check_proof, completeness, crosscheck

    if complete and collisions is not None:
        raise console.usage("--complete compares solutions and nothing else", "--collisions")
    if proof and (complete or collisions is not None):
        raise console.usage("--proof checks proofs and nothing else", "--proof")
    if is_folder := Path(chosen.robot).is_dir():
        chosen.require_only(("base", "tip", "mesh_root"), f"{chosen.robot} is a folder")
    with Progress("checking") as progress:
        question: dict[str, Any] = {"n": n, "seed": seed, "time_limit": time_limit, "progress": progress.tick}
        question |= {} if complete else {"collision": collisions}

        def checked(arm: Arm) -> Report:
            if proof:
                solutions = arm.ik(arm.fk(completeness.planted(arm, n, seed)))
                return check_proof(arm, solutions, time_limit=time_limit, progress=progress.tick)  # type: ignore[no-any-return]
            return completeness.compare(arm, **question) if complete else crosscheck.check(arm, **question)

        report = None if is_folder else checked(chosen.load())
        arms = _of_folder(chosen, checked) if is_folder else []
    if report is not None:
        return console.conclude(report, printed_as, chosen.definition)
    passed = all(each["passed"] is not False for each in arms)
    shown = [{"file": each["file"], "result": each["result"]} for each in arms]
    console.emit(printed_as, {"passed": passed, "arms": arms}, lambda: tables.render(tables.outline({"arms": shown})))
    if not passed:
        raise typer.Exit(Status.FAILED)
    return None


def _of_folder(chosen: ArmOptions, check: Callable[[Arm], Report]) -> list[dict[str, Any]]:
    """The result of each URDF below a folder; ``passed`` is None for what is no arm, and where no check is for it."""
    folder = Path(chosen.robot)
    if not (files := sorted(folder.rglob("*.urdf"))):
        problem = "the folder holds no file that ends in .urdf"
        raise UrdfError(problem, source=str(folder), hint="name a folder of URDFs, or a single file")
    arms = []
    for file in files:
        passed: bool | None
        details = None
        try:
            report = check(replace(chosen, robot=str(file)).load())
            passed, words, details = report.passed, report.verdict(), report.to_dict()
        except UrdfIkError as error:
            no_arm = isinstance(error, ChainError) and not read(file, mesh_roots=chosen.mesh_root or ())[0].chains()
            passed, words = (None if no_arm or isinstance(error, UnsupportedArm) else False), str(error)
        arms.append({"file": str(file.relative_to(folder)), "passed": passed, "result": words, "report": details})
    return arms


def compare(
    *,
    arms: SeveralArms,
    typed: PoseOptions,
    world: Path | None = None,
    n: int = 200,
    seed: int = 0,
    tolerance_mm: float | None = None,
    tolerance_deg: float | None = None,
    ignore: str | None = None,
    align: bool = False,
    exit_code: bool = False,
    time_limit: float | None = None,
    degrees: bool = False,
    printed_as: ReportFormat = ReportFormat.TABLE,
    output: Path | None = None,
) -> None:
    """Compare arms, or URDFs of one arm (another tool, a calibrated copy).

    It compares structure, frames, limits, shapes, reach, the number of solutions for the same poses and the joint
    values branch by branch, and says how far B's tool is off when B gets A's joint vectors. What is the same to
    rounding is called the same.

    With poses of yours it lists for every arm and branch how many of them it reaches, inside the limits and free of
    contact; --world adds obstacles, in every arm's base.

    An option is for all arms; with a letter it is for one of them: --tip tool0, or --tip B=flange.

    Examples:
        urdf-ik compare zyyzyz_6r puma_560
        urdf-ik compare zyyzyz_6r my_arm.urdf --exit-code --tolerance-mm 0.5
        urdf-ik compare zyyzyz_6r my_arm.urdf --tip B=tool0 -n 100
        urdf-ik compare ur5 ur10 puma_560 -n 20
        urdf-ik compare ur5 ur10 --poses seam.csv --world cell.urdf --tool-cylinder 0.02,0.15 -o seam.svg
        urdf-ik compare my_arm.urdf my_arm.xml --align --ignore visuals,collisions

    Options:
        align: Fit base, tip, joint zeros and signs of the others first; names do not count then.
        exit_code: End with status 1 where arms differ.
        time_limit (S): How long the table of the typed poses may take.

    Options (Output):
        output (-o FILE): Write it here; .svg: the picture of the typed poses.
    """
    from urdf_ik.cli import targets
    from urdf_ik.verify import comparison, many_arms

    chosen = arms.each()
    for each in chosen:
        each.apart_from(typed)
    picture = output is not None and output.suffix.lower() == ".svg"
    loaded = [each.load(degrees) for each in chosen]
    target = targets.given(loaded[0], typed, angles_of(loaded[0], degrees))
    own = None if target is None else target.poses
    if own is None and (picture or world is not None):
        raise console.usage("the picture and the obstacles are for poses of yours: --poses FILE, --q, --xyz", "--poses")
    obstacles = read_world(world, chosen[0])
    tolerances: dict[str, Any] = {"tolerance_mm": tolerance_mm, "tolerance_deg": tolerance_deg, "ignore": ignore or ()}
    tolerances["align"] = align
    with Progress("comparing") as progress:
        found = [
            comparison.compare(loaded[0], other, n=n, seed=seed, poses=own, **tolerances, progress=progress.tick)
            for other in loaded[1:]
        ]
        reports: list[Any] = list(found)
        if own is not None:
            names = [f"{a} {Path(name).name}" for a, name in zip(string.ascii_uppercase, arms.robots, strict=False)]
            by_name = dict(zip(names, loaded, strict=True))
            table = many_arms.compare_many(by_name, own, world=obstacles, time_limit=time_limit, progress=progress.tick)
            reports.append(table.in_degrees() if degrees else table)
    data: Any = found[0].to_json()
    if len(reports) > 1:
        poses = None if own is None else reports[-1].to_dict()
        data = {"comparisons": [each.to_dict() for each in found], "poses": poses}
    if picture and output is not None:
        files.write(output, reports.pop().svg().encode())
        console.say(f"written: {output}")
        output = None
    console.emit(printed_as, data, lambda: "\n".join(f"{each}\n" for each in reports), output)
    if exit_code and not all(each.same for each in found):
        raise typer.Exit(Status.FAILED)


def judge(
    *,
    solver: str,
    n: int = 50,
    seed: int = 0,
    within_limits: bool = False,
    chosen: ArmOptions,
    printed_as: ReportFormat = ReportFormat.TABLE,
    output: Path | None = None,
) -> None:
    """Judge another solver on an arm: the solutions that it has wrong, misses or doubles.

    It is asked at N poses of each kind: random, round joint angles, tool down, near singularities and at them.
    Pinocchio measures every solution, and each fault comes with the pose to replay. The status is 1 when there is a
    fault.

    A process reads {"T": 4x4} and answers {"q": [[...], ...]}, a line each, in the arm's order of joints.

    Examples:
        urdf-ik judge ur5 --solver my_solver.py:solve
        urdf-ik judge my_arm.urdf --tip tool0 --solver "process:./my_solver" -n 200 --json

    Options:
        solver (SPEC): module:function, file.py:function, or process:COMMAND (a line of JSON a pose).
        within_limits: The solver returns only what is inside the limits.
    """
    from urdf_ik.verify import judging

    arm = chosen.load()
    with judging.opened(solver) as solve, Progress("judging poses") as progress:
        found = judging.judge(
            arm,
            solve,
            n=n,
            seed=seed,
            within_limits=within_limits,
            name=str(getattr(solve, "__name__", solver)),
            progress=progress.tick,
        )
    console.conclude(found, printed_as, chosen.definition, output)
