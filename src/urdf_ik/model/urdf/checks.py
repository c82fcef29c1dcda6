"""Checks of one joint: its attributes must define its kinematics uniquely; and its clean XML."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple, NoReturn, TypeVar

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from urdf_ik.errors import UrdfError
from urdf_ik.model.poses import pose, to_rpy
from urdf_ik.model.xml import XACRO_HINT, child, has_xacro, is_xacro, tag, written_tag
from urdf_ik.support.read_only import Frozen, frozen
from urdf_ik.support.text import meant
from urdf_ik.support.tolerances import LARGEST

CHAIN = "chains through it"
COLLISION = "collision checks"
TAKEN_FOR_FIXED = "the joint is fixed"
MOST_SHOWN = 20
"""An error lists at most so many defects."""


class Rule(NamedTuple):
    """One kind of defect: the element, the defect, the users that refuse it, and the assumption for all others."""

    element: str
    defect: str
    used_by: tuple[str, ...]
    assumed: str


RULES: dict[str, Rule] = {
    "robot name": Rule("`<robot>`", "no name", (), "it has an empty name"),
    "robot xacro": Rule("`<robot>`", "a left-over xacro instruction", (), "the instruction is ignored"),
    "link name": Rule("`<link>`", "no name", (), "the link is left out"),
    "link xacro": Rule("`<link>`", "a name with a xacro expression", (CHAIN,), "the name is taken as written"),
    "link twice": Rule("`<link>`", "a name that is taken", (CHAIN, COLLISION), "the second link is left out"),
    "joint name": Rule("`<joint>`", "no name, a reserved one or one that is taken", (CHAIN,), "another name"),
    "joint type": Rule("`<joint>`", "a type that is missing or unknown", (CHAIN,), TAKEN_FOR_FIXED),
    "joint xacro": Rule("`<joint>`", "a left-over xacro instruction", (CHAIN,), "the instruction is ignored"),
    "undeclared": Rule("`<parent>`, `<child>`", "a link without a `<link>`", (CHAIN,), "the link has no shapes"),
    "ends": Rule("`<parent>`, `<child>`", "missing, or no link named", (CHAIN, COLLISION), "the joint is left out"),
    "two parents": Rule("`<child>`", "a link with two parents", (CHAIN, COLLISION), "the second joint is left out"),
    "parts": Rule("`<link>`", "links in a circle, or apart from the robot", (CHAIN, COLLISION), "they are left out"),
    "origin": Rule("`<origin>` of a joint", "no finite numbers", (CHAIN, COLLISION), "zero"),
    "axis": Rule("`<axis>`", "no direction", (CHAIN,), TAKEN_FOR_FIXED),
    "limit": Rule("`<limit>`", "missing, or no finite bounds", (CHAIN,), TAKEN_FOR_FIXED),
    "bounds": Rule("`<limit>`", "lower above upper", (CHAIN,), "the two are swapped"),
    "turns": Rule("`<limit>`", "bounds of 30 to 720 rad, which may be degrees", (), "taken in rad"),
    "speeds": Rule("`<limit>`", "no velocity or effort", (), "no limit of speed or effort; Pinocchio gets 0"),
    "velocity": Rule("`<limit>`", "velocity negative or no number", (CHAIN,), "0, which is no limit"),
    "effort": Rule("`<limit>`", "effort negative or no number", (CHAIN,), "0, which is no limit"),
    "rates": Rule("`<limit>`", "acceleration or jerk not positive, or no number", (), "no limit"),
    "mimic": Rule("`<mimic>`", "no joint to follow, a circle, or no finite numbers", (CHAIN,), "it moves by itself"),
    "collision": Rule("`<collision>`", "no shape, or one that no reader takes", (COLLISION,), "it is left out"),
    "visual": Rule("`<visual>`", "no shape, or one that no reader takes", (), "it is left out"),
    "inertial": Rule("`<inertial>`", "no mass, no inertia or no numbers", (), "it is left out"),
    "srdf element": Rule("an SRDF's element", "a name that SRDF does not have", (), "it is ignored"),
    "srdf link": Rule("an SRDF's element", "a link that the URDF does not have", (), "it allows nothing"),
}
"""Every defect that does not refuse the whole file. The rows of docs/how-to/load.md are these."""


@dataclass(frozen=True)
class UrdfWarning:
    """A defect in a part of a URDF; an error is raised only if the part is used.

    Attributes:
        rule: the row of ``RULES``.
        error: the error that is raised if the part is used.
        joints: a chain that uses one of these joints, or one that mimics them, is refused.
        links: a chain through one of these links is refused.
        collides: whether collision checks are refused.
    """

    rule: str
    error: UrdfError
    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    collides: bool = False

    def __str__(self) -> str:
        error = self.error
        where = str(UrdfError(error.problem, source=error.source, line=error.line, element=error.element))
        return f"{where}; {self.assumed}"

    @property
    def assumed(self) -> str:
        """How the part was read, in words."""
        return RULES[self.rule].assumed

    @property
    def element(self) -> str:
        """The element at fault, such as ``<joint name="j2">``."""
        return self.error.element or ""

    def within(self, prefix: str) -> "UrdfWarning":
        """The same warning for a model whose joints and links have a prefix."""
        joints, links = (tuple(prefix + each for each in names) for names in (self.joints, self.links))
        return replace(self, joints=joints, links=links)


def in_words(warnings: Sequence[UrdfWarning]) -> list[str]:
    """Warnings, a line each; joints without velocity or effort share a line."""
    speeds = [each for each in warnings if each.rule == "speeds"]
    if len(speeds) < 2:
        return [str(each) for each in warnings]
    names = ", ".join(each.element.partition('name="')[2].removesuffix('">') for each in speeds)
    shared = f"{speeds[0].error.source}: {len(speeds)} joints state no velocity or effort: {names}; {speeds[0].assumed}"
    return [*(str(each) for each in warnings if each.rule != "speeds"), shared]


def together(errors: Sequence[UrdfError]) -> UrdfError:
    """One error for all defects of a file: the first, and after it the others with line, element and hint."""
    first = errors[0]
    if len(errors) == 1:
        return first
    others = [
        UrdfError(each.problem, source=f"line {each.line}" if each.line else "", element=each.element, hint=each.hint)
        for each in errors[1:MOST_SHOWN]
    ]
    unlisted = f"; and {len(errors) - MOST_SHOWN} more" if len(errors) > MOST_SHOWN else ""
    error = UrdfError(first.problem, source=first.source, line=first.line, element=first.element, hint=first.hint)
    error.args = (f"{first}; also {'; '.join(map(str, others))}{unlisted}",)
    return error


class Defects:
    """The defects of one file, in the order in which they are found."""

    def __init__(self) -> None:
        self.found: list[UrdfWarning] = []

    def add(
        self,
        rule: str,
        error: UrdfError,
        *,
        joints: Sequence[str] = (),
        links: Sequence[str] = (),
        collides: bool | None = None,
    ) -> None:
        """Record a defect; ``collides``, by default the rule's, says whether collision checks are refused."""
        stops = COLLISION in RULES[rule].used_by if collides is None else collides
        kept = error.with_traceback(None)
        self.found.append(UrdfWarning(rule, kept, tuple(joints), tuple(links), stops))


_T = TypeVar("_T")

MOVABLE = ("revolute", "continuous", "prismatic")
"""Types of joints that move a chain."""
TYPES = (*MOVABLE, "fixed", "floating", "planar")
_RATES = ("acceleration", "deceleration"), ("jerk",)

# Decimal numbers only, as urdfdom takes them: float() would also take nan, inf, 1_000 and other scripts' digits.
_DECIMAL = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_NUMBER = re.compile(_DECIMAL, re.ASCII)
_SPACE = re.compile(r"[ \t\r\n]+")
_NUMBERS = re.compile(rf"[ \t\r\n]*{_DECIMAL}(?:[ \t\r\n]+{_DECIMAL})*[ \t\r\n]*", re.ASCII)


@dataclass(frozen=True, eq=False)
class Joint(Frozen):
    """One joint of a URDF.

    Attributes:
        name: unique among the joints.
        type: 'revolute', 'continuous', 'prismatic', 'fixed', 'floating' or 'planar'.
        parent: link that carries the joint.
        child: link that the joint carries.
        origin: (4, 4) pose of the joint, and of the child link at zero, in the parent link [m], read-only.
        axis: (3,) unit direction in the joint's frame, read-only; (1, 0, 0) where the type has none.
        lower: lower bound [rad or m]; -inf where the type has none.
        upper: upper bound [rad or m]; inf where the type has none.
        velocity: greatest speed [rad/s or m/s], or None where none is given.
        effort: greatest torque or force [N m or N], or None where none is given.
        acceleration: greatest acceleration [rad/s^2 or m/s^2], or None where none is given (URDF 1.2).
        jerk: greatest jerk [rad/s^3 or m/s^3], or None where none is given (URDF 1.2).
        mimic: (joint followed, multiplier, offset [rad or m]), or None.
        line: line of its tag in the source.
        rpy: (3,) rad, roll, pitch and yaw of the origin as written; zeros where none are.
        axis_length: length of the axis as written, which ``axis`` is divided by.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: NDArray[np.float64]
    axis: NDArray[np.float64]
    lower: float
    upper: float
    velocity: float | None
    effort: float | None
    mimic: tuple[str, float, float] | None
    line: int
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis_length: float = 1.0
    acceleration: float | None = None
    jerk: float | None = None


@dataclass(frozen=True)
class Place:
    """Source and element under check; every error names them."""

    source: str
    element: Any
    label: str

    def error(self, problem: str, *, hint: str, at: Any = None) -> UrdfError:
        """The error of a defect in this element, or in its child ``at``."""
        where, label = self.element, self.label
        if at is not None and at is not self.element:
            where, label = at, f"<{written_tag(at)}> of {self.label}"
        return UrdfError(problem, source=self.source, line=where.sourceline, element=label, hint=hint)

    def fail(self, problem: str, *, hint: str, at: Any = None) -> NoReturn:
        """Raise :meth:`error`."""
        raise self.error(problem, hint=hint, at=at)

    def numbers(self, element: Any, attribute: str, count: int, default: str | None = None) -> list[str]:
        """The attribute's ``count`` finite decimal numbers, as written."""
        text = element.get(attribute, default)
        if text is not None and _NUMBERS.fullmatch(text):
            good: list[str] = text.split()
            if len(good) == count and all(map(math.isfinite, map(float, good))):
                return good
        written = "a number" if count == 1 else f"{count} numbers"
        hint = f'write {attribute}="..." with {written}, such as "{" ".join(["0.5"] * count)}"'
        if text is None:
            self.fail(f"{attribute} is missing", hint=hint, at=element)
        if has_xacro(text):
            self.fail(f"{attribute}={text!r} holds an unresolved xacro expression", hint=XACRO_HINT, at=element)
        values = [value for value in _SPACE.split(text) if value]
        for value in values:
            if not _NUMBER.fullmatch(value) or not math.isfinite(float(value)):
                hint = f"write {written}, finite and decimal, with spaces between them"
                self.fail(f"{attribute}={text!r}: {value!r} is no finite number", hint=hint, at=element)
        if len(values) != count:
            self.fail(f"{attribute}={text!r} has {len(values)} values instead of {count}", hint=hint, at=element)
        return values

    def origin(self, element: Any) -> dict[str, str]:
        """Attributes of the ``<origin>`` of ``element``: xyz [m] and rpy [rad]; empty without one."""
        origin = child(element, "origin")
        if origin is None:
            return {}
        values = {name: self.numbers(origin, name, 3, "0 0 0") for name in ("xyz", "rpy")}
        if (written := origin.get("quat_xyzw")) is not None:  # as urdfdom reads it
            if origin.getroottree().getroot().get("version", "1.0") == "1.0":
                problem = f"quat_xyzw={written!r} is ignored in URDF 1.0"
                self.fail(problem, hint='write <robot version="1.1">, or the rotation as rpy [rad]', at=origin)
            if origin.get("rpy") is not None:
                self.fail("both rpy and quat_xyzw", hint="write one of them", at=origin)
            x, y, z, w = map(float, self.numbers(origin, "quat_xyzw", 4))
            if not 1e-150 < math.hypot(x, y, z, w) < 1e150:
                self.fail(f"quat_xyzw={written!r} is no rotation", hint="write x y z w of length 1", at=origin)
            values["rpy"] = [repr(float(each)) for each in to_rpy(pose(np.zeros(3), quat_xyzw=(x, y, z, w)))]
        return {name: " ".join(self.in_range(origin, name, each)) for name, each in values.items()}

    def in_range(self, element: Any, attribute: str, values: list[str]) -> list[str]:
        """The values, unless one of them exceeds ``LARGEST``."""
        if any(abs(float(value)) > LARGEST for value in values):
            problem = f"{attribute}={element.get(attribute)!r} is beyond {LARGEST:g}, where no digit is left"
            self.fail(problem, hint="write lengths in m, and angles in rad", at=element)
        return values


class Written(NamedTuple):
    """A joint's element, and its ``<origin>`` and ``<axis>`` in the clean XML, digit for digit."""

    place: Place
    origin: dict[str, str]
    axis: str | None


def write_joint(robot: Any, joint: Joint, written: Written) -> None:
    """Append a joint to the clean tree, with its kinematics only."""
    element = etree.SubElement(robot, "joint", name=joint.name, type=joint.type)
    etree.SubElement(element, "parent", link=joint.parent)
    etree.SubElement(element, "child", link=joint.child)
    if written.origin:
        etree.SubElement(element, "origin", written.origin)
    if written.axis is not None:
        etree.SubElement(element, "axis", xyz=written.axis)
    if joint.effort is not None:
        bounds = () if joint.type == "continuous" else ("lower", "upper")
        rates = [name for name in ("acceleration", "jerk") if getattr(joint, name) is not None]
        limits = {name: repr(getattr(joint, name)) for name in ("effort", "velocity", *bounds, *rates)}
        etree.SubElement(element, "limit", limits)
    if joint.mimic is not None:
        driver, multiplier, offset = joint.mimic
        etree.SubElement(element, "mimic", joint=driver, multiplier=repr(multiplier), offset=repr(offset))


def check_joint(
    place: Place, links: dict[str, Any], taken: Mapping[str, Joint], defects: Defects
) -> tuple[Joint, Written] | None:
    """Check one ``<joint>`` and record its defects; None if it does not name two links.

    A link that it names and that the file does not declare is added to ``links``.
    """
    element = place.element
    name = _joint_name(place, taken, defects)

    def part(rule: str, read: Callable[[], _T], otherwise: _T) -> _T:
        try:
            return read()
        except UrdfError as error:
            defects.add(rule, error, joints=(name,))
            return otherwise

    kind = part("joint type", lambda: _type(place), "fixed")
    part("joint xacro", lambda: _require_no_xacro(place), None)
    ends = part("ends", lambda: (_end(place, "parent"), _end(place, "child")), None)
    if ends is None:
        return None
    for end, link in zip(("parent", "child"), ends, strict=True):
        if link not in links:
            defects.add("undeclared", _undeclared(place, end, link, links), joints=[name], links=[link])
            links[link] = etree.Element("link", name=link)
    origin: dict[str, str] = part("origin", lambda: place.origin(element), {})
    axis = part("axis", lambda: _axis(place), None) if kind in MOVABLE else None
    limits = part("limit", lambda: _bounds(place, kind), None)
    if limits is None or (axis is None and kind in MOVABLE):
        kind, axis, limits = "fixed", None, (-math.inf, math.inf)
    limit = child(element, "limit") if kind in MOVABLE else None
    velocity = effort = acceleration = jerk = None
    if limit is not None:
        if missing := [each for each in ("velocity", "effort") if limit.get(each) is None]:
            error = place.error(f"no {' and no '.join(missing)}", hint=f'write {missing[0]}="..."', at=limit)
            defects.add("speeds", error)
        velocity, effort = (part(each, partial(_capacity, place, limit, each), 0.0) for each in ("velocity", "effort"))
        acceleration, jerk = (_rate(place, limit, names, defects) for names in _RATES)
        if kind == "revolute" and any(30.0 <= abs(bound) <= 720.0 for bound in limits):
            (low, high), (least, most) = limits, map(math.radians, limits)
            problem = f"bounds of {low:g} and {high:g} rad are {(high - low) / math.tau:.0f} turns"
            hint = f"if these are degrees, write {least:.5g} and {most:.5g}"
            defects.add("turns", place.error(f"{problem}; are they degrees?", hint=hint, at=limit))
    lower, upper = limits
    if lower > upper:
        hint = "swap them, or correct a sign; where no limit is meant, as PyBullet reads it, write type='continuous'"
        error = place.error(f"lower {lower:g} is greater than upper {upper:g}", hint=hint, at=limit)
        defects.add("bounds", error, joints=[name])
        lower, upper = upper, lower
    roll, pitch, yaw = map(float, origin.get("rpy", "0 0 0").split())
    direction = np.array([float(number) for number in (axis or "1 0 0").split()])
    axis_length = float(np.linalg.norm(direction))
    joint = Joint(
        name=name,
        type=kind,
        parent=ends[0],
        child=ends[1],
        origin=frozen(pose([float(x) for x in origin.get("xyz", "0 0 0").split()], rpy=(roll, pitch, yaw))),
        axis=frozen(direction / axis_length),
        lower=lower,
        upper=upper,
        velocity=velocity,
        effort=effort,
        acceleration=acceleration,
        jerk=jerk,
        mimic=part("mimic", lambda: _mimic(place), None) if kind in MOVABLE else None,
        line=element.sourceline,
        rpy=(roll, pitch, yaw),
        axis_length=axis_length,
    )
    return joint, Written(place, origin, axis)


def _joint_name(place: Place, taken: Mapping[str, Joint], defects: Defects) -> str:
    """The joint's name, or one made from its line number if it has no valid and unique name."""
    name, other = place.element.get("name"), None
    try:
        check_name(place)
        if name == "universe":
            place.fail("the joint name 'universe' is Pinocchio's own", hint="give the joint another name")
        if (other := taken.get(name)) is not None:
            problem = f"the joint name {name!r} is taken by line {other.line}"
            place.fail(problem, hint="give each joint a different name")
    except UrdfError as error:
        own = f"{name or 'joint'} (line {place.element.sourceline})"
        while own in taken:
            own += "'"
        defects.add("joint name", error, joints=[own] if other is None else [own, other.name])
        return own
    return str(name)


def _type(place: Place) -> str:
    kind: str | None = place.element.get("type")
    if kind not in TYPES:
        problem = "type is missing" if kind is None else f"unknown type {kind!r}"
        place.fail(problem, hint=f"one of {', '.join(TYPES)}")
    return kind


def _require_no_xacro(place: Place) -> None:
    for part in place.element:
        if is_xacro(part):
            place.fail("an unresolved xacro instruction", hint=XACRO_HINT, at=part)


def check_name(place: Place) -> str:
    """Name of a link or joint."""
    name: str | None = place.element.get("name")
    if not name:
        place.fail("it has no name", hint='write name="...", different from all others')
    if has_xacro(name):
        place.fail("its name holds an unresolved xacro expression", hint=XACRO_HINT)
    return name


def label_of(element: Any) -> str:
    """The name of a link or joint in messages."""
    name = element.get("name")
    return f"<{tag(element)}>" if name is None else f'<{tag(element)} name="{name}">'


def _end(place: Place, end: str) -> str:
    element = child(place.element, end)
    if element is None:
        place.fail(f"<{end}> is missing", hint=f'write <{end} link="..."/>')
    name: str | None = element.get("link")
    if not name:
        place.fail("link is missing", hint=f'write <{end} link="..."/>', at=element)
    return name


def _undeclared(place: Place, end: str, name: str, links: Mapping[str, Any]) -> UrdfError:
    element = child(place.element, end)
    if has_xacro(name):
        problem = f"link={name!r} holds an unresolved xacro expression"
        return place.error(problem, hint=XACRO_HINT, at=element)
    hint = f"declare it with <link name={name!r}/>{meant(name, links)}"
    return place.error(f"link {name!r} is not declared", hint=hint, at=element)


def _axis(place: Place) -> str:
    """Unit direction of the axis; yourdfpy does not normalize the axis of a prismatic joint."""
    element = child(place.element, "axis")
    if element is None:
        return "1 0 0"
    values = place.numbers(element, "xyz", 3)
    x, y, z = map(float, values)
    largest = max(abs(x), abs(y), abs(z))
    if not 1e-150 < largest < 1e150:  # where the squares that others divide by vanish or overflow
        problem = f"xyz={element.get('xyz')!r} is {f'an axis of length {largest:g}' if largest else 'a zero axis'}"
        place.fail(problem, hint='write a direction, such as "0 0 1"', at=element)
    if abs(math.hypot(x, y, z) - 1.0) < 1e-15:
        return " ".join(values)
    x, y, z = x / largest, y / largest, z / largest  # the length then neither overflows nor underflows
    length = math.hypot(x, y, z)
    return f"{x / length!r} {y / length!r} {z / length!r}"


def _bounds(place: Place, kind: str) -> tuple[float, float]:
    """Lower and upper bound; a missing one is 0, as the URDF standard says."""
    element, bounded = child(place.element, "limit"), kind in ("revolute", "prismatic")
    if element is None and bounded:
        hint = 'write <limit lower="..." upper="..." effort="..." velocity="..."/>'
        hint += ", or make it continuous" * (kind == "revolute")
        place.fail(f"a {kind} joint without <limit>", hint=hint)
    if element is None or kind not in MOVABLE:
        return -math.inf, math.inf
    lower, upper = (float(place.numbers(element, name, 1, "0")[0]) for name in ("lower", "upper"))
    return (lower, upper) if bounded else (-math.inf, math.inf)


def _capacity(place: Place, limit: Any, name: str) -> float:
    """The joint's greatest velocity or effort; 0, which is no limit, where it is not given."""
    value = float(place.numbers(limit, name, 1, "0")[0])
    if value < 0:
        place.fail(f"{name}={limit.get(name)!r} is negative", hint="write zero or more", at=limit)
    return value


def _rate(place: Place, limit: Any, names: tuple[str, ...], defects: Defects) -> float | None:
    """The least of the attributes ``names`` that are given, all of them positive."""
    values = []
    for name in names:
        if limit.get(name) is not None:
            try:
                value = float(place.numbers(limit, name, 1)[0])
                if not value > 0.0:
                    place.fail(f"{name}={limit.get(name)!r} is not positive", hint="write more than zero", at=limit)
                values.append(value)
            except UrdfError as error:
                defects.add("rates", error)
    return min(values, default=None)


def _mimic(place: Place) -> tuple[str, float, float] | None:
    element = child(place.element, "mimic")
    if element is None:
        return None
    driver = element.get("joint")
    if not driver:
        place.fail("joint is missing", hint='write <mimic joint="..."/> with the joint to follow', at=element)
    multiplier, offset = (
        float(place.in_range(element, name, place.numbers(element, name, 1, default))[0])
        for name, default in (("multiplier", "1"), ("offset", "0"))
    )
    return driver, multiplier, offset
