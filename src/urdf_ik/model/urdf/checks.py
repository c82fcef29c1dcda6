"""What one joint must hold for its kinematics to mean one thing, and the clean XML that says only that."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, NoReturn

from lxml import etree

from urdf_ik.errors import UrdfError, listed
from urdf_ik.model.xml import XACRO_HINT, child, has_xacro, is_xacro, tag, written_tag
from urdf_ik.support.text import nearest, quoted
from urdf_ik.support.tolerances import LARGEST

LEAST = 1e-15
"""Lengths that are a smaller share of the URDF's size, and smaller factors of mimics, are left over from rounding."""
MIN_AXIS = 1e-12
"""A shorter axis is what rounding leaves of zero, and gives no direction."""
_LONGEST = 1000
"""Characters of an attribute that holds numbers, at most: six times what three numbers with all their digits have."""
MOVABLE = ("revolute", "continuous", "prismatic")
TYPES = (*MOVABLE, "fixed", "floating", "planar")

# Decimal numbers only, as urdfdom takes them: float() would also take nan, inf, 1_000 and other scripts' digits.
_DECIMAL = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_NUMBER = re.compile(_DECIMAL, re.ASCII)
_SPACE = re.compile(r"[ \t\r\n]+")
_NUMBERS = re.compile(rf"[ \t\r\n]*{_DECIMAL}(?:[ \t\r\n]+{_DECIMAL})*[ \t\r\n]*", re.ASCII)


@dataclass(frozen=True)
class Place:
    """Where in which source a check stands, so that every error names it."""

    source: str
    element: Any
    label: str

    def fail(self, problem: str, *, hint: str, at: Any = None) -> NoReturn:
        """Raise the error, at a child of the place where ``at`` is given."""
        where, label = self.element, self.label
        if at is not None and at is not self.element:
            where, label = at, f"<{written_tag(at)}> of {self.label}"
        raise UrdfError(problem, source=self.source, line=where.sourceline, element=label, hint=hint)

    def numbers(self, element: Any, attribute: str, count: int, default: str | None = None) -> list[str]:
        """The attribute's ``count`` finite decimal numbers, as written."""
        text = element.get(attribute, default)
        if text is not None and len(text) > _LONGEST:
            problem = f"{attribute}={quoted(text)} has {len(text)} characters"
            self.fail(problem, hint="write numbers with at most 17 digits", at=element)
        if text is not None and _NUMBERS.fullmatch(text):
            good: list[str] = text.split()
            if len(good) == count and all(map(math.isfinite, map(float, good))):
                return good
        written = "a number" if count == 1 else f"{count} numbers"
        hint = f'write {attribute}="..." with {written}, such as "{" ".join(["0.5"] * count)}"'
        if text is None:
            self.fail(f"{attribute} is missing", hint=hint, at=element)
        if has_xacro(text):
            self.fail(f"{attribute}={quoted(text)} holds an unresolved xacro expression", hint=XACRO_HINT, at=element)
        values = [value for value in _SPACE.split(text) if value]
        for value in values:
            if not _NUMBER.fullmatch(value) or not math.isfinite(float(value)):
                hint = f"write {written}, finite and decimal, with spaces between them"
                self.fail(f"{attribute}={quoted(text)}: {quoted(value)} is no finite number", hint=hint, at=element)
        if len(values) != count:
            self.fail(f"{attribute}={quoted(text)} has {len(values)} values instead of {count}", hint=hint, at=element)
        return values

    def origin(self, element: Any) -> dict[str, str]:
        """Attributes of the ``<origin>`` that may stand in ``element``: xyz [m] and rpy [rad]."""
        origin = child(element, "origin")
        if origin is None:
            return {}
        if origin.get("quat_xyzw") is not None:
            # URDF 1.2 only: Pinocchio would read it there, and yourdfpy never.
            problem = f"quat_xyzw={quoted(origin.get('quat_xyzw'))} is read by some URDF readers only"
            self.fail(problem, hint="write the rotation as rpy, in rad", at=origin)
        values = {name: self.numbers(origin, name, 3, "0 0 0") for name in ("xyz", "rpy")}
        return {name: " ".join(self.in_range(origin, name, each)) for name, each in values.items()}

    def in_range(self, element: Any, attribute: str, values: list[str]) -> list[str]:
        """These values of the attribute, none of them beyond ``LARGEST``."""
        if any(abs(float(value)) > LARGEST for value in values):
            problem = f"{attribute}={quoted(element.get(attribute))} is beyond {LARGEST:g}, where no digit is left"
            self.fail(problem, hint="write lengths in m, and angles in rad", at=element)
        return values


@dataclass(frozen=True)
class RawJoint:
    """A joint whose attributes have been checked, before the tree has."""

    name: str
    type: str
    parent: str
    child: str
    origin: dict[str, str]
    axis: str | None
    lower: float
    upper: float
    velocity: float | None
    effort: float | None
    mimic: tuple[str, float, float] | None
    place: Place

    @property
    def line(self) -> int:
        """Line of the ``<joint>`` tag."""
        line: int = self.place.element.sourceline
        return line

    def write(self, robot: Any) -> None:
        """Append the joint to the clean tree, with nothing in it but kinematics."""
        joint = etree.SubElement(robot, "joint", name=self.name, type=self.type)
        etree.SubElement(joint, "parent", link=self.parent)
        etree.SubElement(joint, "child", link=self.child)
        if self.origin:
            etree.SubElement(joint, "origin", self.origin)
        if self.axis is not None:
            etree.SubElement(joint, "axis", xyz=self.axis)
        if self.effort is not None:
            limit = etree.SubElement(joint, "limit", effort=repr(self.effort), velocity=repr(self.velocity))
            if self.type != "continuous":
                limit.set("lower", repr(self.lower))
                limit.set("upper", repr(self.upper))
        if self.mimic is not None:
            driver, multiplier, offset = self.mimic
            etree.SubElement(joint, "mimic", joint=driver, multiplier=repr(multiplier), offset=repr(offset))


def check_joint(place: Place, links: dict[str, Any]) -> RawJoint:
    """Check one ``<joint>`` by itself, and that its two links are declared.

    Raises:
        UrdfError: something about it is missing, unreadable or senseless.
    """
    element, name, kind = place.element, check_name(place), place.element.get("type")
    if name == "universe":
        place.fail("the joint name 'universe' is Pinocchio's own", hint="give the joint another name")
    if kind not in TYPES:
        problem = "type is missing" if kind is None else f"unknown type {quoted(kind)}"
        place.fail(problem, hint=f"one of {', '.join(TYPES)}")
    for part in element:
        if is_xacro(part):
            place.fail("an unresolved xacro instruction", hint=XACRO_HINT, at=part)
    parent, below = (_end(place, end, links) for end in ("parent", "child"))
    lower, upper, velocity, effort = _limits(place, kind)
    return RawJoint(
        name=name,
        type=kind,
        parent=parent,
        child=below,
        origin=place.origin(element),
        axis=_axis(place) if kind in MOVABLE else None,
        lower=lower,
        upper=upper,
        velocity=velocity,
        effort=effort,
        mimic=_mimic(place) if kind in MOVABLE else None,
        place=place,
    )


def check_name(place: Place) -> str:
    """Name of a link or joint."""
    name: str | None = place.element.get("name")
    if not name:
        place.fail("it has no name", hint='write name="...", different from all others')
    if has_xacro(name):
        place.fail("its name holds an unresolved xacro expression", hint=XACRO_HINT)
    return name


def label_of(element: Any) -> str:
    """A link or joint as messages call it."""
    name = element.get("name")
    return f"<{tag(element)}>" if name is None else f'<{tag(element)} name="{quoted(name)[1:-1]}">'


def _end(place: Place, end: str, links: dict[str, Any]) -> str:
    element = child(place.element, end)
    if element is None:
        place.fail(f"<{end}> is missing", hint=f'write <{end} link="..."/>')
    name: str | None = element.get("link")
    if not name:
        place.fail("link is missing", hint=f'write <{end} link="..."/>', at=element)
    if has_xacro(name):
        place.fail(f"link={quoted(name)} holds an unresolved xacro expression", hint=XACRO_HINT, at=element)
    if name not in links:
        close = nearest(name, links)
        hint = f"declare it with <link name={quoted(name)}/>" + (
            f", or did you mean {listed(close)}?" if close else ""
        )
        place.fail(f"link {quoted(name)} is not declared", hint=hint, at=element)
    return name


def _axis(place: Place) -> str:
    """Unit direction of the axis; yourdfpy leaves a prismatic joint's axis as long as it is written."""
    element = child(place.element, "axis")
    if element is None:
        return "1 0 0"
    values = place.numbers(element, "xyz", 3)
    x, y, z = map(float, values)
    length = math.hypot(x, y, z)
    if not length > MIN_AXIS:
        problem = f"xyz={quoted(element.get('xyz'))} is a zero axis"
        place.fail(problem, hint='write a direction, such as "0 0 1"', at=element)
    if abs(length - 1.0) < 1e-15:
        return " ".join(values)
    largest = max(abs(x), abs(y), abs(z))  # first, so that the length of a huge axis does not overflow
    x, y, z = x / largest, y / largest, z / largest
    length = math.hypot(x, y, z)
    return f"{x / length!r} {y / length!r} {z / length!r}"


def _limits(place: Place, kind: str) -> tuple[float, float, float | None, float | None]:
    """Lower, upper, velocity, effort; a bound that is not written is 0, as the URDF standard says."""
    element = child(place.element, "limit")
    if kind not in ("revolute", "prismatic") and (element is None or kind != "continuous"):
        return -math.inf, math.inf, None, None
    if element is None:
        place.fail(
            f"a {kind} joint without <limit>",
            hint='write <limit lower="..." upper="..." effort="..." velocity="..."/>'
            + (", or make it continuous" if kind == "revolute" else ""),
        )
    bounds = [float(place.numbers(element, name, 1, "0")[0]) for name in ("lower", "upper")]
    velocity, effort = (float(place.numbers(element, name, 1)[0]) for name in ("velocity", "effort"))
    for name, value in (("velocity", velocity), ("effort", effort)):
        if value < 0:
            place.fail(f"{name}={quoted(element.get(name))} is negative", hint="write zero or more", at=element)
    if 0.0 < velocity < LEAST:
        problem = f"velocity={quoted(element.get('velocity'))} is below {LEAST:g}, where the joint does not move"
        place.fail(problem, hint="write what it can do, or 0 for no limit", at=element)
    if kind == "continuous":
        return -math.inf, math.inf, velocity, effort
    lower, upper = bounds
    if lower > upper:
        place.fail(f"lower {lower:g} is greater than upper {upper:g}", hint="swap them, or correct a sign", at=element)
    return lower, upper, velocity, effort


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
    if 0.0 < abs(multiplier) < LEAST:
        problem = f"multiplier={quoted(element.get('multiplier'))} is below {LEAST:g}, where the joint does not move"
        place.fail(problem, hint="write 0, or a fixed joint", at=element)
    return driver, multiplier, offset
