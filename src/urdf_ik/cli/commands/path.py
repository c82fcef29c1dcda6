"""The command ``path``; and the options of a path, which ``plot`` and ``view`` have too."""

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
import typer

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.cli import console, options, tables, targets
from urdf_ik.cli.arm_options import ArmOptions, read_world
from urdf_ik.cli.console import Angles, Progress, Status
from urdf_ik.cli.options import PoseOptions, ReportFormat
from urdf_ik.errors import ArgumentError
from urdf_ik.paths import path_settings
from urdf_ik.paths.path_settings import PathSettings
from urdf_ik.paths.planned_motion import Plan
from urdf_ik.paths.timing import Timed
from urdf_ik.support import files
from urdf_ik.support.text import counted

SUFFIXES = (".csv", ".json")
_KINDS = {"l1": "sum of |dq|", "l2": "sum of dq^2", "max": "sum of the largest |dq|", "time": "s"}
"""What each cost sums up."""
_TYPES: Mapping[str, tuple[Any, str | None]] = {
    "joint vector": (str, "Q1,Q2,..."),
    "number": (float, "VALUE"),
    "per joint": (str, "V|V1,V2,..."),
    "length and angle": (str, "M,RAD"),
    "flag": (bool, None),
    "choice": (StrEnum("Cost", {cost: cost for cost in path_settings.COSTS}), None),
    "part": (StrEnum("First", {part: part for part in ("position", "orientation")}), None),
    "world": (Path, None),
    "contacts": (bool, None),
}
"""The type and the metavariable of an option for a setting of each kind."""


@dataclass(frozen=True)
class PathOptions(options.Record):
    """The settings of a path, as typed; None for what is not there."""

    GROUP = "Path"
    settings: dict[str, Any]

    @classmethod
    def parameters(cls, command: Any) -> list[inspect.Parameter]:
        """An option for each setting; some have the words of an option that other commands have, too."""
        out = []
        for name, setting in path_settings.options().items():
            unit, (kind, metavar) = setting.metadata["unit"], _TYPES[setting.metadata["kind"]]
            words = f"{setting.metadata['help'].removesuffix('.')}{f' [{unit}]' if unit else ''}."
            text = options.Text([], unit.upper() if kind is float and unit else metavar, words, cls.GROUP, False)
            if name in ("world", "margin", "collisions"):
                text = options.texts(options.Shared)[name]
            out.append(options.parameter(name, kind | None, None, text, text.group))
        return out

    @classmethod
    def read(cls, values: dict[str, Any]) -> Self:
        """The settings of their options."""
        return cls(values)

    def in_rad(self, angles: Angles, chosen: ArmOptions, names: tuple[str, ...]) -> dict[str, Any]:
        """The settings with their values in rad and m."""
        out = {}
        for name, typed in self.settings.items():
            setting, option = path_settings.options()[name].metadata, f"--{name.replace('_', '-')}"
            kind, value = setting["kind"], typed
            if typed is None:
                continue
            if kind == "joint vector":
                value = angles.typed(console.numbers(typed, option, names))
            elif kind == "per joint":
                one = len(console.split(typed)) == 1
                value = np.broadcast_to(console.numbers(typed, option, (name,) if one else names), len(names))
                value = angles.typed(value) if setting["unit"] else value
            elif kind == "length and angle":
                length, angle = console.numbers(typed, option, ("m", angles.unit)).tolist()
                value = length, float(np.deg2rad(angle)) if angles.degrees else angle
            elif kind == "world":
                value = read_world(typed, chosen)
            elif kind == "contacts":
                value = "require" if typed else False
            elif kind in ("choice", "part"):
                value = typed.value
            out[name] = value
        return out


class _Followed(NamedTuple):
    """A plan, the arm that follows it, the file of its waypoints, its world, the cost that is least, and seconds."""

    arm: Arm
    plan: Plan
    source: str
    world: World | None
    cost: str
    seconds: float


def followed(
    arm: Arm, angles: Angles, waypoints: PoseOptions | targets.Target, path: PathOptions, chosen: ArmOptions
) -> _Followed:
    """Read the waypoints, if they are not read yet, and the world, and follow them."""
    settings = PathSettings(**path.in_rad(angles, chosen, arm.joint_names))
    with Progress("following the path") as progress:
        if isinstance(waypoints, PoseOptions):
            waypoints = targets.required(arm, waypoints, angles, "waypoints")
        plan = arm.follow(waypoints.poses, **vars(settings) | {"progress": progress.say})
    return _Followed(arm, plan, waypoints.source, settings.world, settings.cost, progress.seconds)


def path(
    *,
    waypoints: PoseOptions,
    path: PathOptions,
    alternatives: bool = False,
    chosen: ArmOptions,
    degrees: bool = False,
    printed_as: ReportFormat = ReportFormat.TABLE,
    output: Path | None = None,
    timed: Path | None = None,
) -> None:
    """Follow a path: the cheapest joint motion through all waypoints, over all branches and turns.

    The motion is proven between the waypoints and free of contacts. Where there is none, the answer says for every
    start branch how far it gets and what stops it there. The status is 1 when there is no plan.

    Examples:
        urdf-ik path zyyzyz_6r --poses seam.csv -o plan.csv --timed motion.csv
        urdf-ik path my_arm.urdf --tip tool0 -p seam.csv --world cell.urdf --margin 0.01 --reconfigure
        urdf-ik fk zyyzyz_6r --q 0,1,1,0,1,0 --q 0.2,1,1,0,1,0 -f csv | urdf-ik path zyyzyz_6r -p -
        urdf-ik path ur5 --q 0,-1,1,0,1,0 --q 0.1,-1,1,0,1,0 --no-collisions

    Options (Path):
        alternatives: The best plan from every start branch, too.

    Options (Output):
        output (-o FILE): Write the plan: .csv or .json; always rad, m.
        timed (FILE): Write it in time, at the highest velocities: .csv or .json; always s, rad, m.
    """
    for file, option in ((output, "--output"), (timed, "--timed")):
        if file is not None and file.suffix.lower() not in SUFFIXES:
            raise console.usage(f"{file}: plans are written as {', '.join(SUFFIXES)}; name the file so", option)
        if file is not None:
            files.writable(file)
    arm, angles = chosen.loaded(degrees, waypoints)
    found = followed(arm, angles, waypoints, path, chosen)
    plan = found.plan
    in_time, untimed = None, None
    try:
        in_time = plan.timed() if timed is not None and plan.found and not plan.changes else None
    except ArgumentError as error:  # the plan is worth having without its times
        untimed = error
    others = plan.alternatives if alternatives else ()
    data = _data(found, angles, in_time, others)
    console.emit(printed_as, data, lambda: _text(found, angles, in_time, data))
    for file, content in ((output, plan), (timed, in_time)):
        if file is not None and content is not None and (plan.found or file.suffix.lower() == ".json"):
            if file.suffix.lower() == ".json":
                files.write(file, content.to_json().encode())
            else:
                content.to_csv(file)
            rows = len(plan.motion) if content is plan else len(in_time.t) if in_time is not None else 0
            console.say(f"{file}: {rows} joint vectors; {'rad' if content is plan else 's, rad'}, m")
        elif file is not None:
            why = untimed or ("it changes its branch" if plan.found else "there is no plan")
            console.say(f"{file} was not written: {why}")
    if untimed is not None:
        raise typer.Exit(Status.USAGE)
    if not plan.found:
        raise typer.Exit(Status.FAILED)


def _text(found: _Followed, angles: Angles, in_time: Timed | None, data: dict[str, Any]) -> str:
    """The plan in a few lines and a table of its joints; or the reason why each branch stops."""
    plan, arm = found.plan, found.arm
    head = f"{arm.name}: {arm.base} to {arm.tip}, {counted(len(plan.poses), 'waypoint')} from {found.source}"
    about: dict[str, Any] = {"world": "" if found.world is None else ", ".join(found.world.names)}
    about |= {"search": plan.unlooked, "contacts": f"not checked: {plan.unchecked}" if plan.unchecked else ""}
    if not plan.found:
        about |= {"plan": f"none, in {found.seconds:.2f} s", "stops": data["stops"]}
        return tables.render(head, tables.outline(about))
    q, limits, margins = angles.shown(plan.q), angles.shown(plan.solver.limits.T), plan.margins
    columns = {"first": q[0], "last": q[-1], "least": q.min(axis=0), "most": q.max(axis=0)}
    columns["step"] = np.abs(np.diff(q, axis=0)).max(axis=0, initial=0.0)
    columns |= dict(zip(("lower", "upper"), limits, strict=True))
    joints = [
        {"joint": name, "unit": angles.units[k]}
        | {head: "none" if np.isinf(column[k]) else tables.number(column[k]) for head, column in columns.items()}
        for k, name in enumerate(plan.solver.joint_names)
    ]
    strays = f"{plan.tolerance[0]:g} m and {float(angles.angle(plan.tolerance[1])):.4g} {angles.unit}"
    about |= {
        "branches": "; ".join(dict.fromkeys(plan.branches)),
        "cost": f"{_cost(found, plan, angles):.6g} ({_KINDS[found.cost]})",
        "reconfigurations": len(plan.changes),
        "tolerance": f"{strays} from the straight segments, proven",
        "least clearance [m]": float(np.fmin.reduce(plan.margins.clearance)),
        "manipulability": f"at least {margins.manipulability.min():.4g}",
        "time": "" if in_time is None else f"{in_time.duration:.3f} s ({in_time.method})",
        "found": f"in {found.seconds:.2f} s",
    }
    tabled = {"joints": joints, "changes": data["changes"], "alternatives": data["alternatives"]}
    return tables.render(head, tables.outline(about | tabled))


def _cost(found: _Followed, plan: Plan, angles: Angles) -> float:
    """The cost as shown: of an arm that turns only, in the unit of its angles."""
    if found.cost == "time" or not angles.turning.all():
        return plan.cost
    return float(angles.angle(angles.angle(plan.cost) if found.cost == "l2" else plan.cost))


def _data(found: _Followed, angles: Angles, in_time: Timed | None, others: tuple[Plan, ...]) -> dict[str, Any]:
    """The plan with its margins, or the reason why each branch stops."""
    plan, arm = found.plan, found.arm
    turned = angles.degrees and angles.turning.all() and found.cost != "time"
    unit = ("deg^2" if found.cost == "l2" else "deg") if turned else "rad, m, s"
    data: dict[str, Any] = {
        "robot": arm.name,
        "base": arm.base,
        "tip": arm.tip,
        "joints": arm.joint_names,
        "units": {"angle": angles.unit, "length": "m", "cost": unit},
        "waypoints": len(plan.poses),
        "seconds": found.seconds,
        "found": plan.found,
        "contacts": f"not checked: {plan.unchecked}" if plan.unchecked else "checked",
        "search": plan.unlooked or "complete",
        "stops": [stop._asdict() for stop in plan.stops],
    }
    if plan.found:
        margins = {name: getattr(plan.margins, name) for name in ("limits", "clearance", "manipulability")}
        low, high = plan.solver.limits.T
        room = np.minimum(plan.q - low, high - plan.q)
        least = np.argmin(room, axis=1)[:, None]
        data |= {
            "cost": _cost(found, plan, angles),
            "branches": plan.branches,
            "changes": [change._asdict() for change in plan.changes],
            "q": angles.shown(plan.q),
            "margins": margins | {"limits": np.take_along_axis(angles.shown(room), least, axis=1)[:, 0]},
            "duration": None if in_time is None else in_time.duration,
            "alternatives": [
                {"first": each.branches[0], "last": each.branches[-1]}
                | {"cost": _cost(found, each, angles), "q": angles.shown(each.q)}
                for each in others
            ],
        }
    return data
