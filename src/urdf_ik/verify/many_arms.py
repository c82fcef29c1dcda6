"""Solutions of many arms for the same poses: one tidy table, and one picture of the reached poses."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from urdf_ik.arm import Arm, Robot, loaded
from urdf_ik.cell.world import World
from urdf_ik.errors import ArgumentError, MissingPackage, UrdfIkError
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.support import extras
from urdf_ik.support.report import Report, svg_of
from urdf_ik.support.text import Section
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array
from urdf_ik.verify.description import parameters_of
from urdf_ik.verify.sampling import contacts, solutions_of

NOT_CHECKED = "not checked"

SHADES = {
    "not reached": "#e0e0e0",
    "outside limits": "#f9a825",
    "contact": "#c62828",
    "free": "#2e7d32",
    "contacts not checked": "#7cb342",
}
"""Colours of the picture: what a branch can do at a pose."""

_AT_ONCE = 32
"""Poses that every arm solves before the time is looked at."""


class Row(NamedTuple):
    """One solution of one pose, or a pose that an arm does not reach.

    Attributes:
        arm: what the arm is called.
        pose: number of the pose.
        branch: the solution's branch; '' where the pose is not reached.
        reachable: whether the arm reaches the pose.
        in_limits: whether the solution, or an image of it a turn away, is inside the joint limits.
        limit_margin: distance [rad or m] of that image to the nearest limit, negative outside; NaN where unreached.
        manipulability: Yoshikawa's measure there; NaN where unreached.
        contact: True or False, or 'not checked'; '' where unreached.
    """

    arm: str
    pose: int
    branch: str = ""
    reachable: bool = False
    in_limits: bool = False
    limit_margin: float = float("nan")
    manipulability: float = float("nan")
    contact: bool | str = ""


@dataclass(frozen=True, repr=False)
class ManyArms(Report):
    """The answers of many arms to the same poses.

    Attributes:
        arms: what the arms are called, in the order given.
        poses: number of poses that were looked at.
        rows: one a solution, and one for each pose that an arm does not reach.
        notes: what was not checked, and why.
        unlooked: what the time limit left out; '' where every pose was looked at.
        unit: of ``limit_margin``: 'rad' or 'deg'; 'rad, m' where an arm has a prismatic joint.
    """

    JUDGES: ClassVar[bool] = False

    arms: tuple[str, ...]
    poses: int
    rows: tuple[Row, ...]
    notes: tuple[str, ...]
    unlooked: str = ""
    unit: str = "rad"

    def in_degrees(self) -> "ManyArms":
        """The same with margins in degrees; itself where an arm has a prismatic joint."""
        if self.unit != "rad":
            return self
        rows = tuple(row._replace(limit_margin=float(np.rad2deg(row.limit_margin))) for row in self.rows)
        return replace(self, rows=rows, unit="deg")

    def reached(self, arm: str) -> int:
        """Number of poses that an arm reaches, limits and contacts aside."""
        return len({row.pose for row in self.rows if row.arm == arm and row.reachable})

    def to_frame(self) -> Any:
        """The rows as a ``pandas.DataFrame``.

        Raises:
            MissingPackage: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise extras.missing("to_frame() needs pandas", "tables") from None
        return pandas.DataFrame([row._asdict() for row in self.rows], columns=list(Row._fields))

    def title(self) -> str:
        """The number of arms and poses."""
        return f"{len(self.arms)} arms, {self.poses} poses"

    def sections(self) -> tuple[Section, ...]:
        """A table with a line an arm: how many poses it reaches, inside its limits, free of contact."""
        rows = []
        for name in self.arms:
            own = [row for row in self.rows if row.arm == name]
            inside = [row for row in own if row.in_limits]
            margins: dict[int, float] = {}
            for row in inside:
                margins[row.pose] = max(row.limit_margin, margins.get(row.pose, -np.inf))
            unchecked = any(row.contact == NOT_CHECKED for row in own)
            free = len({row.pose for row in inside if row.contact is False})
            numbers = (self.reached(name), len(margins), NOT_CHECKED if unchecked else free)
            least = f"{min(margins.values()):.3g}" if margins else "-"
            rows.append((name, *map(str, numbers), str(sum(row.reachable for row in own)), least))
        header = ("arm", "reached", "within limits", "free of contact", "solutions", f"margin [{self.unit}]")
        first = Section("the same poses", header, tuple(rows), left=("arm",))
        return (first, *(self._branches(each) for each in self.arms if self.reached(each)))

    def _branches(self, name: str) -> Section:
        """A line a branch of an arm: poses inside the limits, in contact, usable; its least margin."""
        rows = []
        for branch in dict.fromkeys(row.branch for row in self.rows if row.arm == name and row.reachable):
            own = [row for row in self.rows if (row.arm, row.branch) == (name, branch)]
            inside = [row for row in own if row.in_limits]
            usable = [row for row in inside if row.contact is not True]
            unchecked = any(row.contact == NOT_CHECKED for row in own)
            touching = [row for row in own if row.contact is True]
            within, hit, count = (len({row.pose for row in some}) for some in (inside, touching, usable))
            least = f"{min(row.limit_margin for row in usable):.3g}" if usable else "-"
            counts = "?" if unchecked else str(hit), "all" if count == self.poses else str(count)
            rows.append((branch, str(within), *counts, least))
        rows.sort(key=lambda row: row[3] != "all")
        header = ("branch", "limits", "contact", "usable", f"margin [{self.unit}]")
        return Section(f"{name}: poses that a branch reaches", header, tuple(rows), left=("branch",))

    def lines(self) -> tuple[str, ...]:
        """What was not checked."""
        return self.notes

    def summary(self) -> str:
        """How many poses each arm reaches."""
        return ", ".join(f"{name} reaches {self.reached(name)} of {self.poses}" for name in self.arms)

    def _repr_html_(self) -> str:
        with suppress(MissingPackage):
            return super()._repr_html_() + self.svg()
        return super()._repr_html_()

    def svg(self) -> str:
        """A picture: a row an arm and branch, a column a pose, its colour what the arm can do there.

        Raises:
            MissingPackage: matplotlib is not installed.
        """
        try:
            from matplotlib.colors import ListedColormap
            from matplotlib.figure import Figure
            from matplotlib.patches import Patch
        except ImportError:
            raise extras.missing("svg() needs matplotlib", "plot") from None
        lines = list(dict.fromkeys((row.arm, row.branch) for row in self.rows if row.reachable))
        lines += [(name, "") for name in self.arms if not any(line[0] == name for line in lines)]
        lines.sort(key=lambda line: self.arms.index(line[0]))
        states = np.zeros((len(lines), self.poses))
        for row in self.rows:
            if row.reachable:
                states[lines.index((row.arm, row.branch)), row.pose] = list(SHADES).index(_state(row))
        figure = Figure(figsize=(9.0, 1.0 + 0.22 * len(lines)), layout="constrained")
        axes = figure.add_subplot(xlabel="pose")
        axes.pcolormesh(states, cmap=ListedColormap(list(SHADES.values())), vmin=-0.5, vmax=len(SHADES) - 0.5)
        labels = [f"{name}: {branch}" if branch else name for name, branch in lines]
        axes.set_yticks(np.arange(len(lines)) + 0.5, labels, fontsize=8)
        axes.invert_yaxis()
        handles = [Patch(color=shade, label=state) for state, shade in SHADES.items()]
        figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), fontsize=8)
        return svg_of(figure)


def compare_many(
    arms: Mapping[str, Robot] | Iterable[Robot],
    poses: Any,
    *,
    world: World | None = None,
    collisions: str | bool = True,
    time_limit: float | None = None,
    progress: Progress | None = None,
) -> ManyArms:
    """Solve the same poses with many arms.

    Args:
        arms: the arms, or what :func:`urdf_ik.load` takes; a dictionary names them, else they go by their robots'
            names.
        poses: (..., 4, 4) m, each in every arm's own base.
        world: the obstacles, placed in every arm's own base; the shapes of all arms have to be readable then.
        collisions: whether to check contacts: True where the shapes can be read, with a warning where they cannot;
            'require' to fail there; False: no.
        time_limit: s after which no more poses are looked at; ``unlooked`` says how many were left out.
        progress: called with the number of poses behind us, and of all.

    Returns:
        The table; ``to_frame()`` for pandas, ``svg()`` for a picture.

    Raises:
        ArgumentError: no arm is given.
        PoseError: one of ``poses`` is no pose.
        UrdfError: ``collisions="require"``, and not all shapes of an arm can be read.
        ArgumentError: ``time_limit`` is no number of seconds.

    Example:
        >>> import urdf_ik
        >>> a, b = urdf_ik.load("zyyzyz_6r"), urdf_ik.load("puma_560")
        >>> found = compare_many({"before": a, "after": b}, a.fk([[0.3, -0.5, 0.8, 0.4, 0.7, -0.2]]))
        >>> found.reached("before"), found.reached("after")
        (1, 0)
    """
    named, watch = _named(arms), Watch(time_limit, progress)
    T = check_poses(as_pose_array(poses)).reshape(-1, 4, 4)
    shapes_of, notes = {}, []
    for name, arm in named.items():
        shapes_of[name], unchecked = arm.cell.to_check(collisions, world)
        if unchecked:
            notes.append(f"{name}: contacts {NOT_CHECKED}: {unchecked}")
        if parameters_of(arm):
            notes.append(f"{name}: solved at the default of its redundancy parameter, {parameters_of(arm)[0]}")
    rows: dict[str, list[Row]] = {name: [] for name in named}
    unsolved: dict[str, str] = {}
    looked_at = 0
    for some in watch.parts(len(T), _AT_ONCE):
        for name, arm in named.items():
            try:
                if name not in unsolved:
                    rows[name] += _rows(name, arm, T, some, shapes_of[name])
            except UrdfIkError as error:
                unsolved[name] = f"{name}: {error}"
        looked_at = some.stop
    for name in unsolved:
        rows[name] = [Row(name, pose) for pose in range(looked_at)]
    every = tuple(row for own in rows.values() for row in own)
    slides = any(kind == "prismatic" for arm in named.values() for kind in arm.chain.joint_types)
    unit = "rad, m" if slides else "rad"
    return ManyArms(tuple(named), looked_at, every, (*notes, *unsolved.values()), watch.unlooked, unit)


def _named(arms: Mapping[str, Robot] | Iterable[Robot]) -> dict[str, Arm]:
    """The arms by their names; where two robots have the same name, the second gets a number."""
    named: dict[str, Arm] = {}
    pairs = arms.items() if isinstance(arms, Mapping) else ((None, arm) for arm in arms)
    for called, robot in pairs:
        arm = loaded(robot)
        name = arm.name if called is None else str(called)
        names = (name, *(f"{name} ({i})" for i in range(2, len(named) + 2)))
        named[next(each for each in names if each not in named)] = arm
    if not named:
        raise ArgumentError("no arm given; one or more are needed")
    return named


def _rows(name: str, arm: Arm, T: Array, some: range, shapes: Any) -> list[Row]:
    """The rows of some of the poses (m, 4, 4)."""
    found = solutions_of(arm, T[some.start : some.stop])
    within = found.within_limits()
    out = []
    for k, pose in enumerate(some):
        columns = np.flatnonzero(found.valid[k])
        out += [] if len(columns) else [Row(name, pose)]
        # The image inside the limits where there is one.
        inside = within.valid[k, columns]
        q = np.where(inside[:, None], within.q[k, columns], found.q[k, columns])
        margins, measures = np.atleast_1d(arm.limit_margin(q)), np.atleast_1d(arm.manipulability(q))
        each = zip(found.names[k, columns], inside, margins, measures, contacts(shapes, q), strict=True)
        for branch, within_limits, margin, measure, touching in each:
            # What is too near to tell counts as a contact.
            contact = NOT_CHECKED if shapes is None else touching is not False
            out.append(Row(name, pose, str(branch), True, bool(within_limits), float(margin), float(measure), contact))
    return out


def _state(row: Row) -> str:
    """One of ``SHADES``, of a reached pose."""
    if not row.in_limits:
        return "outside limits"
    return "contacts not checked" if row.contact == NOT_CHECKED else "contact" if row.contact else "free"
