"""Follow a path: the cheapest joint motion through all waypoints, over all branches and turns.

The motion is proven between the waypoints and free of contacts. Where there is none, the answer says for every start
branch how far it gets and what stops it there. The status is 1 when there is no plan.

Examples:
    urdf-ik path zyyzyz_6r --poses seam.csv -o plan.csv --timed motion.csv
    urdf-ik path my_arm.urdf --tip tool0 -p seam.csv --world cell.urdf --margin 0.01 --reconfigure
    urdf-ik fk zyyzyz_6r --q 0,1,1,0,1,0 --q 0.2,1,1,0,1,0 -f csv | urdf-ik path zyyzyz_6r -p -
    urdf-ik path ur5 --q 0,-1,1,0,1,0 --q 0.1,-1,1,0,1,0 --no-collisions
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from typer import Option

from urdf_ik.cli import console, options, tables
from urdf_ik.cli.arm_options import ArmOptions, angles_of
from urdf_ik.cli.console import Angles
from urdf_ik.cli.errors import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.path_options import Followed, PathOptions, followed
from urdf_ik.errors import ArgumentError, escaped
from urdf_ik.paths import Plan
from urdf_ik.paths.timing import Timed
from urdf_ik.support import files

if TYPE_CHECKING:
    from rich.table import Table

SUFFIXES = (".csv", ".json", ".npz")
# Whether the straight joint motion of a change touches something.
_FREE = {None: "not checked", True: "free", False: "hits"}


def command(
    *,
    waypoints: options.PoseOptions,
    path: PathOptions,
    alternatives: Annotated[
        bool,
        Option("--alternatives", help="The best plan from every start branch, too.", rich_help_panel=PathOptions.GROUP),
    ] = False,
    chosen: ArmOptions,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
    output: Annotated[
        Path | None,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Write the plan: .csv, .json or .npz; always rad, m.",
            rich_help_panel=options.OUTPUT,
        ),
    ] = None,
    timed: Annotated[
        Path | None,
        Option(
            metavar="FILE",
            help="Write it in time, at the highest velocities: .csv, .json or .npz; always s, rad, m.",
            rich_help_panel=options.OUTPUT,
        ),
    ] = None,
) -> None:
    """Print the plan, or the reasons why there is none, and write the plan to a file.

    Raises:
        typer.BadParameter: options that make no sense.
        typer.Exit: there is no plan.
        UrdfIkError: a file that cannot be read or written.
    """
    for file, option in ((output, "--output"), (timed, "--timed")):
        if file is not None and file.suffix.lower() not in SUFFIXES:
            kinds = ", ".join(SUFFIXES)
            raise console.usage(f"{files.name_of(file)}: plans are written as {kinds}; name the file so", option)
        if file is not None:
            files.writable(file)
    chosen.apart_from(waypoints)
    arm = chosen.load(degrees)
    angles = angles_of(arm, degrees)
    found = followed(arm, angles, waypoints, path, chosen)
    plan = found.plan
    in_time, untimed = None, None
    try:
        in_time = plan.timed() if timed is not None and plan.found and not plan.changes else None
    except ArgumentError as error:  # the plan is worth having without its times
        untimed = error
    others = plan.alternatives if alternatives else ()
    if printed_as is ReportFormat.JSON:
        console.write(json_of(found, angles, in_time, others), None)
    else:
        console.write(text_of(found, angles, in_time, others), None)
    for file, content in ((output, plan), (timed, in_time)):
        if file is not None and content is not None and (plan.found or file.suffix.lower() == ".json"):
            getattr(content, f"to_{file.suffix.lower()[1:]}")(file)
            rows = len(plan.motion) if content is plan else len(in_time.t) if in_time is not None else 0
            console.say_written(file, f"{rows} joint vectors", "rad" if content is plan else "s, rad")
        elif file is not None:
            why = untimed or ("it changes its branch" if plan.found else "there is no plan")
            typer.echo(escaped(f"{file} was not written: {why}"), err=True)
    if untimed is not None:
        raise typer.Exit(Status.USAGE)
    if not plan.found:
        raise typer.Exit(Status.FAILED)


def text_of(found: Followed, angles: Angles, in_time: Timed | None, others: tuple[Plan, ...]) -> str:
    """The plan in a few lines and a table of its joints; or the reason why each branch stops."""
    plan, arm = found.plan, found.arm
    count = len(plan.poses)
    head = f"{arm.name}: {arm.base} to {arm.tip}, {count} waypoint{'' if count == 1 else 's'} from {found.source}"
    lines: list[Table | str] = [head]
    if found.world is not None:
        lines.append(f"world: {', '.join(found.world.names)}")
    if plan.unlooked:
        lines.append(plan.unlooked)
    if plan.unchecked:
        lines.append(f"contacts not checked: {plan.unchecked}")
    took = f"in {found.seconds:.2f} s"
    if not plan.found:
        rows = [[stop.branch, str(stop.waypoint), stop.cause, stop.reason] for stop in plan.stops]
        header = ["start branch", "before waypoint", "cause", "reason"]
        table = tables.grid(header, rows, left=["start branch", "cause", "reason"])
        return tables.render(*lines, f"no plan, {took}", "", table)
    lines += [f"found {took}", "", *_facts(found, angles, in_time), "", _joints(plan, angles)]
    if plan.changes:
        rows = [[str(c.waypoint), c.before, c.after, _FREE[c.free]] for c in plan.changes]
        header = ["before waypoint", "from", "to", "straight joint motion"]
        lines += ["", tables.grid(header, rows, left=["from", "to", "straight joint motion"])]
    if others:
        rows = [[o.branches[0], o.branches[-1], f"{o.cost:.6g}", *_short(o, angles)] for o in others]
        header = ["start branch", "end branch", "cost", "largest step", "room to limits", "clearance [m]"]
        lines += ["", tables.grid(header, rows, left=header[:2])]
    return tables.render(*lines)


def _facts(found: Followed, angles: Angles, in_time: Timed | None) -> list[str]:
    """Lines of a heading and a number."""
    plan = found.plan
    arm, changes = found.arm, len(plan.changes)
    kinds = {"l1": "sum of |dq|", "l2": "sum of dq^2", "max": "sum of the largest |dq|", "time": "s"}
    used = list(dict.fromkeys(plan.branches))
    facts = [("branch" if len(used) == 1 else "branches", "; ".join(used))]
    facts.append(("cost", f"{plan.cost:.6g} ({kinds[found.cost]})"))
    facts.append(("reconfigurations", str(changes)))
    between = len(plan.motion) - len(plan.q)
    if between:
        kept = "so that the tip keeps to the straight segments"
        facts.append(("waypoints added", f"{between}, {kept}"))
    strays = (f"{plan.tolerance[0]:g} m", f"{float(angles.angle(plan.tolerance[1])):.4g} {angles.unit}")
    facts.append(("tolerance", f"{' and '.join(strays)} from the straight segments, proven"))
    step = _largest_step(plan)
    if step is not None:
        k, joint = step
        value = abs(plan.q[k + 1, joint] - plan.q[k, joint])
        facts.append(
            ("largest step", f"{_shown(joint, value, angles)} of {arm.joint_names[joint]} to waypoint {k + 1}")
        )
    room, at, limited = _limit_room(plan)
    if limited is not None:
        text = f"{_shown(limited, room, angles)} of {arm.joint_names[limited]} at waypoint {at}"
        facts.append(("room to a limit", text))
    margins = plan.margins
    if plan.obstacles is not None and np.isfinite(margins.clearance).any():
        k = int(np.nanargmin(margins.clearance))
        pair = plan.obstacles.pair(plan.q[k])
        names = f" between {pair[0]} and {pair[1]}" if pair else ""
        facts.append(("least clearance", f"{margins.clearance[k]:.4f} m{names} at waypoint {k}"))
    k = int(np.argmin(margins.manipulability))
    facts.append(("manipulability", f"at least {margins.manipulability[k]:.4g}, at waypoint {k}"))
    if in_time is not None:
        facts.append(("time", f"{in_time.duration:.3f} s ({in_time.method})"))
    return [f"{name:<18}{text}" for name, text in facts]


def _joints(plan: Plan, angles: Angles) -> Table:
    digits = 2 if angles.degrees else 4
    q, limits = angles.shown(plan.q), angles.shown(plan.solver.limits.T).T
    steps = np.abs(np.diff(q, axis=0)).max(axis=0, initial=0.0)
    rows = [
        [
            name,
            angles.unit if angles.turning[k] else "m",
            *(tables.number(float(x), digits) for x in (q[0, k], q[-1, k], q[:, k].min(), q[:, k].max(), steps[k])),
            *(tables.number(float(x), digits) if np.isfinite(x) else "none" for x in limits[k]),
        ]
        for k, name in enumerate(plan.solver.joint_names)
    ]
    header = ["joint", "unit", "first", "last", "least", "most", "step", "lower", "upper"]
    return tables.grid(header, rows, left=["joint", "unit"])


def _short(plan: Plan, angles: Angles) -> list[str]:
    step, (room, _, joint) = _largest_step(plan), _limit_room(plan)
    clearance = plan.margins.clearance
    return [
        "-" if step is None else _shown(step[1], abs(np.diff(plan.q, axis=0)[step]), angles),
        "-" if joint is None else _shown(joint, room, angles),
        "-" if np.isnan(clearance).all() else f"{np.nanmin(clearance):.4f}",
    ]


def _largest_step(plan: Plan) -> tuple[int, int] | None:
    """Waypoint before the largest step of a joint, and the joint; None for a single waypoint."""
    if len(plan.q) < 2:
        return None
    steps = np.abs(np.diff(plan.q, axis=0))
    k, joint = np.unravel_index(int(np.argmax(steps)), steps.shape)
    return int(k), int(joint)


def _limit_room(plan: Plan) -> tuple[float, int, int | None]:
    """The least room to a limit [rad or m], its waypoint and its joint; without a joint where none has a limit."""
    low, high = plan.solver.limits.T
    room = np.minimum(plan.q - low, high - plan.q)
    k, joint = np.unravel_index(int(np.argmin(room)), room.shape)
    return float(room[k, joint]), int(k), int(joint) if np.isfinite(room[k, joint]) else None


def _shown(joint: int, value: float, angles: Angles) -> str:
    if not angles.turning[joint]:
        return f"{tables.number(value)} m"
    return f"{tables.number(float(angles.angle(value)), 2 if angles.degrees else 4)} {angles.unit}"


def json_of(found: Followed, angles: Angles, in_time: Timed | None, others: tuple[Plan, ...]) -> str:
    """The plan with its margins, or the reason why each branch stops."""
    plan, arm = found.plan, found.arm
    data: dict[str, Any] = {
        "robot": arm.name,
        "base": arm.base,
        "tip": arm.tip,
        "joints": arm.joint_names,
        "units": {"angle": angles.unit, "length": "m", "cost": "rad, m, s"},
        "waypoints": len(plan.poses),
        "seconds": found.seconds,
        "found": plan.found,
        "contacts": f"not checked: {plan.unchecked}" if plan.unchecked else "checked",
        "search": plan.unlooked or "complete",
        "stops": [stop._asdict() for stop in plan.stops],
    }
    if plan.found:
        margins = plan.margins
        data |= {
            "cost": plan.cost,
            "branches": plan.branches,
            "changes": [change._asdict() for change in plan.changes],
            "q": angles.shown(plan.q),
            "margins": {
                "limits": margins.limits,
                "clearance": margins.clearance,
                "manipulability": margins.manipulability,
            },
            "duration": None if in_time is None else in_time.duration,
            "alternatives": [
                {"first": each.branches[0], "last": each.branches[-1], "cost": each.cost, "q": angles.shown(each.q)}
                for each in others
            ],
        }
    return console.json_text(data)
