"""Solutions of many arms for the same poses: one tidy table, and one picture of the reached poses."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any, NamedTuple

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, MissingPackage, UrdfIkError, printable
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.support import inputs
from urdf_ik.support.display import html_of, short
from urdf_ik.support.text import Section
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array
from urdf_ik.verify import arms as of_arms
from urdf_ik.verify.baselines.pose_sampling import contacts
from urdf_ik.verify.reports import Written

NOT_CHECKED = "not checked"
UNREACHED, OUTSIDE, TOUCHING, FREE, UNKNOWN = "not reached", "outside limits", "contact", "free", "contacts not checked"
"""Labels of a branch at a pose in the picture."""

_SHADES = {UNREACHED: "#e0e0e0", OUTSIDE: "#f9a825", TOUCHING: "#c62828", FREE: "#2e7d32", UNKNOWN: "#7cb342"}
_ROW, _WIDTH, _LABEL = 16, 640, 260
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
    branch: str
    reachable: bool
    in_limits: bool
    limit_margin: float
    manipulability: float
    contact: bool | str


@dataclass(frozen=True, repr=False)
class ManyArms(Written):
    """The answers of many arms to the same poses.

    Attributes:
        arms: what the arms are called, in the order given.
        poses: number of poses that were looked at.
        rows: one a solution, and one for each pose that an arm does not reach.
        notes: what was not checked, and why.
        unlooked: what the time limit left out; '' where every pose was looked at.

    Example:
        >>> import urdf_ik
        >>> a, b = urdf_ik.load("planar_2r"), urdf_ik.load("planar_2r_unit")
        >>> found = urdf_ik.compare_many([a, b], a.fk([[0.3, -0.5], [0.2, -1.0]]))
        >>> len(found.rows), found.reached("planar_2r")
        (8, 2)
    """

    arms: tuple[str, ...]
    poses: int
    rows: tuple[Row, ...]
    notes: tuple[str, ...]
    unlooked: str = ""

    def reached(self, arm: str) -> int:
        """Number of poses that an arm reaches, limits and contacts aside.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.compare_many([arm], arm.fk([[0.3, -0.5]])).reached("planar_2r")
            1
        """
        return len({row.pose for row in self.rows if row.arm == arm and row.reachable})

    def to_frame(self) -> Any:
        """The rows as a ``pandas.DataFrame``.

        Raises:
            MissingPackage: pandas is not installed.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.compare_many([arm], arm.fk([[0.3, -0.5]])).to_frame().columns[:3].tolist()
            ['arm', 'pose', 'branch']
        """
        try:
            import pandas
        except ImportError:
            raise MissingPackage("to_frame() needs pandas: pip install 'urdf-ik[tables]'") from None
        return pandas.DataFrame([row._asdict() for row in self.rows], columns=list(Row._fields))

    def section(self) -> Section:
        """A line an arm: how many poses it reaches, inside its limits, free of contact.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.compare_many([arm], arm.fk([[0.3, -0.5]])).section().rows[0][:4]
            ('planar_2r', '1', '1', '1')
        """
        rows = []
        for name in self.arms:
            own = [row for row in self.rows if row.arm == name]
            inside = [row for row in own if row.in_limits]
            free = {row.pose for row in inside if row.contact is False}
            unchecked = any(row.contact == NOT_CHECKED for row in own)
            margin = [max(r.limit_margin for r in inside if r.pose == pose) for pose in {r.pose for r in inside}]
            rows.append((
                name, str(self.poses), str(self.reached(name)), str(len({row.pose for row in inside})),
                NOT_CHECKED if unchecked else str(len(free)), str(sum(row.reachable for row in own)),
                f"{min(margin):.3g}" if margin else "-",
            ))  # fmt: skip
        header = ("arm", "poses", "reached", "within limits", "free of contact", "solutions", "least best margin")
        return Section("the same poses", header, tuple(rows), self._remarks, left=("arm",))

    @property
    def _remarks(self) -> tuple[str, ...]:
        return (*((self.unlooked,) if self.unlooked else ()), *self.notes)

    def __str__(self) -> str:
        return str(self.section())

    def __repr__(self) -> str:
        lines = [f"{row[0]}: {row[2]} of {row[1]} reached, {row[3]} within limits, {row[4]} free of contact"
                 for row in self.section().rows]  # fmt: skip
        return short(f"{len(self.arms)} arms, {self.poses} poses", [*self._remarks, *lines])

    def _repr_html_(self) -> str:
        return html_of(f"{len(self.arms)} arms, {self.poses} poses", "", True, [self.section()]) + self.svg()

    def svg(self) -> str:
        """A picture: a row an arm and branch, a column a pose, its colour what the arm can do there.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.compare_many([arm], arm.fk([[0.3, -0.5]])).svg()[:4]
            '<svg'
        """
        lines = list(dict.fromkeys((row.arm, row.branch) for row in self.rows if row.reachable))
        lines += [(name, "") for name in self.arms if not any(line[0] == name for line in lines)]
        lines.sort(key=lambda line: self.arms.index(line[0]))
        at = {(row.arm, row.branch, row.pose): _state(row) for row in self.rows}
        step = (_WIDTH - 1) / max(1, self.poses)
        parts = []
        for k, (name, branch) in enumerate(lines):
            y = k * _ROW
            label = escape(printable(f"{name}: {branch}" if branch else name, 44))
            parts.append(f'<text x="0" y="{y + _ROW - 5}" font-size="11">{label}</text>')
            states = [at.get((name, branch, pose), UNREACHED) for pose in range(self.poses)]
            start = 0
            for end in range(1, self.poses + 1):
                if end == self.poses or states[end] != states[start]:
                    x, width = _LABEL + start * step, (end - start) * step
                    parts.append(f'<rect x="{x:.1f}" y="{y + 1}" width="{width:.1f}" height="{_ROW - 2}" '
                                 f'fill="{_SHADES[states[start]]}"/>')  # fmt: skip
                    start = end
        bottom = len(lines) * _ROW + 4
        for k, (state, shade) in enumerate(_SHADES.items()):
            x = 4 + k * 170
            parts.append(f'<rect x="{x}" y="{bottom}" width="10" height="10" fill="{shade}"/>'
                         f'<text x="{x + 14}" y="{bottom + 10}" font-size="11">{state}</text>')  # fmt: skip
        size = f'width="{_LABEL + _WIDTH}" height="{bottom + 16}"'
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" font-family="sans-serif" '
            f'aria-label="what each arm reaches along the poses">{"".join(parts)}</svg>'
        )


def compare_many(
    arms: Mapping[str, Arm] | Iterable[Arm],
    poses: Any,
    *,
    collisions: str | bool = True,
    time_limit: float | None = None,
    progress: Progress | None = None,
) -> ManyArms:
    """Solve the same poses with many arms.

    Args:
        arms: the arms; a dictionary names them, else they go by their robots' names.
        poses: (..., 4, 4) m, each in every arm's own base.
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
        ArgumentError: ``time_limit`` is no number of seconds, or ``progress`` no function.

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
        shapes_of[name], unchecked = arm.cell.to_check(collisions)
        if unchecked:
            notes.append(f"{name}: contacts {NOT_CHECKED}: {unchecked}")
        if of_arms.parameters_of(arm):
            notes.append(f"{name}: solved at the default of its redundancy parameter, {of_arms.parameters_of(arm)[0]}")
    rows: dict[str, list[Row]] = {name: [] for name in named}
    unsolved: dict[str, str] = {}
    looked_at = 0
    while looked_at < len(T) and not watch.is_over:
        some = range(looked_at, min(looked_at + _AT_ONCE, len(T)))
        for name, arm in named.items():
            try:
                if name not in unsolved:
                    rows[name] += _rows(name, arm, T, some, shapes_of[name])
            except UrdfIkError as error:
                unsolved[name] = f"{name}: {error}"
        looked_at = some.stop
        watch.step(looked_at, len(T))
    for name in unsolved:
        rows[name] = [_unreached(name, pose) for pose in range(looked_at)]
    left_out = f"with {looked_at} of {len(T)} poses: the others were"
    return ManyArms(
        tuple(named),
        looked_at,
        tuple(row for own in rows.values() for row in own),
        (*notes, *unsolved.values()),
        "" if looked_at == len(T) else watch.ended(left_out),
    )


def _named(arms: Mapping[str, Arm] | Iterable[Arm]) -> dict[str, Arm]:
    if hasattr(arms, "items"):
        named = dict(inputs.mapping(arms, "arms", "an arm for each name"))
    else:
        held: Sequence[Arm] = list(inputs.items(arms, "arms", "arms, as urdf_ik.load returns them,"))
        named = {}
        for k, arm in enumerate(held):
            inputs.arm(arm, f"arms[{k}]")
            names = (arm.name, *(f"{arm.name} ({i})" for i in range(2, len(held) + 2)))
            named[next(name for name in names if name not in named)] = arm
    if not named:
        raise ArgumentError("no arm given; one or more are needed")
    for name, arm in named.items():
        inputs.arm(arm, f"arms[{name!r}]")
    return {str(name): arm for name, arm in named.items()}


def _rows(name: str, arm: Arm, T: Array, some: range, shapes: Any) -> list[Row]:
    """The rows of some of the poses (m, 4, 4)."""
    found = of_arms.solutions_of(arm, T[some.start : some.stop])
    within = found.within_limits()
    valid, inside, all_q, inner, names = found.valid, within.valid, found.q, within.q, found.names
    out = []
    for k, pose in enumerate(some):
        columns = np.flatnonzero(valid[k])
        if not len(columns):
            out.append(_unreached(name, pose))
            continue
        # The image inside the limits where there is one.
        q = np.where(inside[k, columns, None], inner[k, columns], all_q[k, columns])
        touching = contacts(shapes, q)
        margins, measures = np.atleast_1d(arm.limit_margin(q)), np.atleast_1d(arm.manipulability(q))
        for i, column in enumerate(columns):
            contact: bool | str | None = touching[i]
            if contact is None:
                contact = NOT_CHECKED if shapes is None else True
            out.append(Row(name, pose, str(names[k, column]), True, bool(inside[k, column]),
                           float(margins[i]), float(measures[i]), contact))  # fmt: skip
    return out


def _unreached(name: str, pose: int) -> Row:
    return Row(name, pose, "", False, False, float("nan"), float("nan"), "")


def _state(row: Row) -> str:
    if not row.reachable:
        return UNREACHED
    if not row.in_limits:
        return OUTSIDE
    return UNKNOWN if row.contact == NOT_CHECKED else TOUCHING if row.contact else FREE
