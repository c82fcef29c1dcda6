"""The ``urdf-ik`` command, see ``app`` for its parts."""

from __future__ import annotations

import sys
from pathlib import Path

import typer

from urdf_ik.cli import options
from urdf_ik.cli.chosen_arm import ChosenArm, TypedPath, TypedPose, angles_of, on_an_arm
from urdf_ik.cli.chunked.places import Places
from urdf_ik.cli.errors import Status, unwritten
from urdf_ik.cli.options import Picture, ReportFormat, Value
from urdf_ik.cli.program import app, help_text


@app.command(
    help=help_text(
        "Show an arm: its joints, how neighbouring axes lie to each other, and how it is solved.",
        "urdf-ik info zyyzyz_6r",
        "urdf-ik info my_arm.urdf --base base_link --tip tool0 --format json",
        "urdf-ik info panda --lock panda_joint3=30deg",
        "urdf-ik info my_arm.urdf --chains",
    )
)
@on_an_arm
def info(
    *,
    chains: options.Chains = False,
    chosen: ChosenArm,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print what is known of the arm."""
    from urdf_ik.cli import console
    from urdf_ik.cli.commands import chains as chains_command
    from urdf_ik.cli.commands import info as info_command

    if chains:
        show = chains_command.as_json if printed_as is ReportFormat.JSON else chains_command.as_text
        return console.write(show(chosen.model(), chosen.base), None)
    arm = chosen.load()
    write = info_command.as_json if printed_as is ReportFormat.JSON else info_command.as_text
    return console.write(write(arm, angles_of(arm, degrees)), None)


@app.command(
    help=help_text(
        "Forward kinematics: the tip's pose in the base, for each joint vector.",
        "urdf-ik fk zyyzyz_6r --q 0.1,-0.2,0.3,0,0.5,0",
        "urdf-ik fk ur5 --file vectors.csv --degrees --format csv",
        "urdf-ik fk ur5 --q 0,-1,1,0,1,0 -f json | urdf-ik ik ur5 --poses -",
    )
)
@on_an_arm
def fk(
    *,
    q: options.Vectors = None,
    file: options.VectorFile = None,
    chosen: ChosenArm,
    degrees: options.Degrees = False,
    printed_as: options.DataFormat = None,
    output: options.Output = None,
) -> None:
    """Print the tip's pose."""
    from urdf_ik.cli.commands import fk as fk_command

    written = options.format_for(printed_as, output, terminal=options.is_terminal(sys.stdout))
    fk_command.run(chosen, q or (), file, degrees, written, output)


@app.command(
    help=help_text(
        "Inverse kinematics: every solution of a pose, with its branch, checks and error as Pinocchio measures it.\n\n"
        "The target is a typed pose (--xyz with an orientation), the tip at a joint vector (--q), poses from a file "
        "(--poses) or random ones (--random). With none of them it is the arm's example: among 256 seeded joint "
        "vectors inside the limits, the one whose pose has most solutions.\n\n"
        "A file holds 4x4 matrices or x,y,z,qx,qy,qz,qw, as npy, npz, json or csv. More than 20 poses are summed up "
        "in the table; csv, json and npz hold them all. The status is 1 when a pose has no solution.",
        "urdf-ik ik zyyzyz_6r",
        "urdf-ik ik dh_6r --xyz 0.5,0.11,0.26 --quat-xyzw 0,0,0.8,0.6",
        "urdf-ik ik ur5 --q 0.1,-1,1,0.2,0.3,0 --within-limits --collision-free --world cell.urdf",
        "urdf-ik ik ur5 --q 0.1,-1,1,0.2,0.3,0 --nearest 0,-1,1,0,0,0 --metric time --within 0.5",
        "urdf-ik ik ur5 --random 1000 --format npz --output solutions.npz",
        "urdf-ik ik panda --xyz 0.4,0,0.3 --rpy 3.14,0,0 --redundancy 0,0.4,0.8",
    )
)
@on_an_arm
def ik(
    *,
    typed: TypedPose,
    q: options.Planted = None,
    poses: options.PoseFile = None,
    random: options.Random = None,
    seed: options.Seed = 0,
    redundancy: options.Redundancy = None,
    turns: options.Turns = False,
    within_limits: options.WithinLimits = False,
    collision_free: options.CollisionFree = False,
    world: options.Cell = None,
    nearest: options.Nearest = None,
    metric: options.Measured = options.Metric.L2,
    within: options.Within = None,
    best: options.Best = None,
    check: options.Checked = None,
    chosen: ChosenArm,
    degrees: options.Degrees = False,
    printed_as: options.DataFormat = None,
    output: options.Output = None,
) -> None:
    """Print every solution."""
    from urdf_ik.cli import paths, targets
    from urdf_ik.cli.commands import ik as ik_command

    written = options.format_for(printed_as, output, terminal=options.is_terminal(sys.stdout))
    chosen.without_stdin(poses, "--poses")
    target = targets.Asked(typed, q or (), poses, random, seed)
    cell = paths.cell(world, chosen)
    choice = ik_command.Choice(within_limits, collision_free, turns, nearest, metric, within, best, cell)
    asked = ik_command.Asked(target, redundancy, choice, check)
    arm = chosen.load()
    ik_command.run(arm, angles_of(arm, degrees), asked, written, output)


@app.command(
    help=help_text(
        "Check an arm against Pinocchio: kinematics, every solution of random poses, collision. "
        "The status is 1 when a check failed.\n\n"
        "With --complete it looks for solutions that the solver missed: the general elimination, and Newton's method "
        "from random starts where the solver uses the elimination itself, answer the same poses, random ones and some "
        "1e-1 to 1e-8 rad from a singularity. Every difference is printed. The status is 1 when the solver lacks a "
        "solution or has one that Pinocchio does not confirm.\n\n"
        "ROBOT may be a folder: every URDF in it is checked, and one table tells what came of each.",
        "urdf-ik check zyyzyz_6r -n 200",
        "urdf-ik check ur5 --complete -n 80",
        "urdf-ik check my_arm.urdf --tip tool0 --no-collision --format json",
        "urdf-ik check lab/ --complete -n 2 --store night --workers 2",
    )
)
@on_an_arm
def check(
    *,
    n: options.Count = 200,
    seed: options.Seed = 0,
    complete: options.Complete = False,
    collision: options.Collision = None,
    work: Places,
    chosen: ChosenArm,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print the report of the cross-check, or of the comparison of two ways to all solutions."""
    from urdf_ik.cli import console
    from urdf_ik.cli.progress import Progress
    from urdf_ik.verify import completeness, crosscheck

    if complete and collision is not None:
        raise console.usage("--complete compares solutions and nothing else", "--collision")
    if Path(chosen.robot).is_dir():
        from urdf_ik.cli.chunked import survey

        if not survey.run(chosen, n, seed, complete, collision, work, printed_as is ReportFormat.JSON):
            raise typer.Exit(Status.FAILED)
        return
    if work != Places():
        raise console.usage("a store is for the arms of a folder, and this is one arm", "--store")
    arm = chosen.load()
    report: crosscheck.Report | completeness.Completeness
    if complete:
        with Progress("comparing poses", "solving in two ways") as progress:
            report = completeness.compare(arm, n=n, seed=seed, progress=progress.tick)
    else:
        with Progress("checking poses", "checking against Pinocchio") as progress:
            report = crosscheck.check(arm, n=n, seed=seed, collision=collision, progress=progress.tick)
    console.write(report.to_json() if printed_as is ReportFormat.JSON else f"{report}\n", None)
    if not report.passed:
        raise typer.Exit(Status.FAILED)


@app.command(
    help=help_text(
        "Denavit-Hartenberg table of an arm, or an arm from a table (CSV or JSON).",
        "urdf-ik dh dh_6r --convention modified",
        "urdf-ik dh ur5 --degrees -o ur5.csv",
        "urdf-ik dh ur5 --degrees -f csv",
        "urdf-ik dh ur5.csv -o my_ur5.urdf",
    )
)
def dh(
    file: options.TableOrRobot,
    convention: options.Convention = None,
    snap: options.Snap = None,
    base: options.Base = None,
    tip: options.Tip = None,
    degrees: options.Degrees = False,
    printed_as: options.TableFormat = None,
    output: options.Output = None,
) -> None:
    """Print or write the table, or the URDF."""
    from urdf_ik.cli.commands import dh as dh_command

    dh_command.run(ChosenArm(file, base, tip), convention, snap, degrees, printed_as, output)


@app.command(
    help=help_text(
        "Follow a path: the cheapest joint motion through all waypoints, over all branches and turns, proven between "
        "the waypoints and free of contacts; or, for every start branch, how far it gets and what stops it there. "
        "The status is 1 when there is no plan.",
        "urdf-ik path zyyzyz_6r --waypoints seam.csv --out plan.csv --timed motion.csv",
        "urdf-ik path my_arm.urdf --tip tool0 -w seam.csv --world cell.urdf --margin 0.01 --reconfigure",
        "urdf-ik fk zyyzyz_6r --q 0,1,1,0,1,0 --q 0.2,1,1,0,1,0 -f csv | urdf-ik path zyyzyz_6r -w -",
    )
)
@on_an_arm
def path(
    *,
    path: TypedPath,
    alternatives: options.Starts = False,
    chosen: ChosenArm,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
    output: options.PlanFile = None,
    timed: options.TimedFile = None,
) -> None:
    """Print the plan, or what stops it."""
    from urdf_ik.cli.commands import path as path_command

    path_command.run(
        chosen,
        path,
        degrees=degrees,
        alternatives=alternatives,
        as_json=printed_as is ReportFormat.JSON,
        output=output,
        timed=timed,
    )


@app.command(
    help=help_text(
        "Draw an arm, all branches of a pose side by side or overlaid, joint limits with all turns of the solutions, "
        "the workspace, the arm with sliders for its joints, or a path: each joint's values in all branches along it, "
        "limits and contacts, and the plan. Without --output it opens a window.\n\n"
        "Branches are those of a typed pose, of the tip at a joint vector (--q), or of the arm's example. The "
        "workspace of two turning joints is exact; any other is one layer of a map.",
        "urdf-ik plot zyyzyz_6r branches -o all_branches.png",
        "urdf-ik plot planar_2r workspace --q 0.5,-1 -o two_link_workspace.png",
        "urdf-ik plot dh_6r limits -o limits.svg",
        "urdf-ik plot planar_2r sliders -o sliders.png",
        "urdf-ik plot zyyzyz_6r path --waypoints seam.csv -o path.png",
        "urdf-ik plot srs_7r intervals --q 0.3,0.5,-0.4,0.9,0.2,-0.6,0.1 -o intervals.png",
    )
)
@on_an_arm
def plot(
    *,
    what: options.What = Picture.ARM,
    q: options.At = None,
    typed: TypedPose,
    seed: options.Seed = 0,
    shapes: options.Shapes = False,
    map_file: options.Map = None,
    axis: options.Across = "z",
    at: options.Layer = 0.0,
    show: options.Shown = Value.REACH,
    path: TypedPath,
    chosen: ChosenArm,
    degrees: options.Degrees = False,
    output: options.PictureFile = None,
) -> None:
    """Write a picture, or open a window."""
    from urdf_ik.cli import targets
    from urdf_ik.cli.commands import plot as plot_command

    target = targets.Asked(typed, () if q is None else (q,), None, None, seed)
    asked = plot_command.Asked(target, path, shapes, map_file, axis, at, show.value)
    plot_command.run(chosen, degrees, what, asked, output)


@app.command(
    help=help_text(
        "Show an arm in the browser: every solution of a target to drag, sliders for the joints. With --waypoints, a "
        "plan to be played along its path, or where each branch ends; with --world, obstacles; with --map, a layer of "
        "a workspace map as coloured points, and the boundary of what is reached. Ctrl-C ends it.",
        "urdf-ik view ur5",
        "urdf-ik view my_arm.urdf --tip tool0 --mesh-root meshes --port 9000",
        "urdf-ik view panda -o panda.html",
        "urdf-ik view zyyzyz_6r --waypoints seam.csv --world cell.urdf",
        "urdf-ik view zyyzyz_6r --map map.npz --show solutions",
    )
)
@on_an_arm
def view(
    *,
    path: TypedPath,
    map_file: options.Map = None,
    axis: options.FirstAcross = None,
    at: options.FirstLayer = None,
    show: options.Shown = Value.REACH,
    chosen: ChosenArm,
    degrees: options.Degrees = False,
    host: options.Host = "127.0.0.1",
    port: options.Port = None,
    dark: options.Dark = False,
    output: options.Page = None,
) -> None:
    """Serve the page."""
    from urdf_ik.cli.commands import view as view_command

    layer = view_command.Layer(map_file, axis, at, show.value)
    view_command.run(chosen, path, layer, degrees, host, port, output, dark=dark)


def main() -> None:
    """Entry point of the ``urdf-ik`` command."""
    try:
        try:
            app()
        finally:  # help and version are printed before any command runs
            if sys.stdout is not None and not sys.stdout.closed:
                sys.stdout.flush()
    except KeyboardInterrupt:
        sys.exit(Status.INTERRUPTED)
    except OSError as error:
        sys.exit(unwritten(error))
