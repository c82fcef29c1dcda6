"""The differences between two descriptions of an arm, each with the joint or link that it is about."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from urdf_ik.cell.pinocchio_reference import pose_errors
from urdf_ik.errors import ArgumentError
from urdf_ik.model.poses import pose
from urdf_ik.support import inputs
from urdf_ik.typing import Array
from urdf_ik.verify.description import MISSING, Description, Shape, Step, matrix

KINDS = ("kinematics", "limits", "names", "collisions", "visuals")
"""Kinds of differences; each but the first can be ignored."""

_MOST_LENGTH = 1e6
_MOST_PLACES, _MOST_SHAPES = 6, 3
_ROUNDED_LIMIT = 1e-4
"""Limits nearer than this [rad] differ by their decimals alone: 3.1416 and pi, not 3.14."""


@dataclass(frozen=True)
class Tolerance:
    """Tolerances up to which values count as the same.

    Attributes:
        distance: [m].
        angle: [rad].
        limit: of a joint limit [rad or m], relative to the limit if it is beyond 1 rad or 1 m.
    """

    distance: float = 1e-9
    angle: float = 1e-9
    limit: float = 1e-9

    @classmethod
    def read(cls, mm: object = None, deg: object = None) -> Self:
        """From millimetres and degrees; None: the default."""
        out = cls()
        if mm is not None:
            out = replace(out, distance=inputs.number(mm, "tolerance_mm", low=0.0, high=_MOST_LENGTH, unit="mm") / 1e3)
        if deg is not None:
            angle = math.radians(inputs.number(deg, "tolerance_deg", low=0.0, high=180.0, unit="deg"))
            out = replace(out, angle=angle, limit=max(cls.limit, angle))
        return out


DEFAULT = Tolerance()


@dataclass(frozen=True)
class Difference:
    """One thing that is not the same.

    Attributes:
        kind: one of ``KINDS``, or 'solutions'.
        name: the joint or link that it is about; '' where it is about the whole arm.
        words: what is different.
        distance: how far [m], 0 where that says nothing.
        angle: how far [rad].
        replay: Python that shows it, '' where the words say it all.
    """

    kind: str
    name: str
    words: str
    distance: float = 0.0
    angle: float = 0.0
    replay: str = ""

    def __str__(self) -> str:
        return f"{self.name}: {self.words}" if self.name else self.words


def ignored(kinds: str | Iterable[str]) -> frozenset[str]:
    """Kinds of differences that do not count, as a list or as text with commas."""
    parts = kinds.replace(",", " ").split() if isinstance(kinds, str) else list(kinds)
    for part in parts:
        if part not in KINDS[1:]:
            raise ArgumentError(f"{part!r} cannot be ignored; what can: {', '.join(KINDS[1:])}")
    return frozenset(parts)


def summed(differing: Sequence[Difference]) -> tuple[str, ...]:
    """Differences, a line each; those of many shapes in one line, and limits that were rounded, too."""
    rounded = [d for d in differing if d.kind == "limits" and 0.0 < d.angle < _ROUNDED_LIMIT]
    lines: list[str] = []
    if len(rounded) > 1:
        differing = [difference for difference in differing if difference not in rounded]
        most = math.degrees(max(difference.angle for difference in rounded))
        lines.append(f"{len(rounded)} limits differ by at most {most:.1g} deg (rounded)")
    for kind in dict.fromkeys(difference.kind for difference in differing):
        alike = [difference for difference in differing if difference.kind == kind]
        named = [difference for difference in alike if difference.name]
        if kind not in ("collisions", "visuals") or len(named) <= _MOST_SHAPES:
            lines += map(str, alike)
            continue
        links = list(dict.fromkeys(difference.name for difference in named))
        shown = ", ".join(links[:_MOST_PLACES]) + (", ..." if len(links) > _MOST_PLACES else "")
        lines.append(f"{shown}: {len(named)} {kind[:-1]} shapes differ; the first: {named[0].words}")
        lines += [str(difference) for difference in alike if not difference.name]
    return tuple(lines)


def within(change: tuple[float, float], tolerance: Tolerance) -> bool:
    """Whether a change [m, rad] is tolerated."""
    return change[0] <= tolerance.distance and change[1] <= tolerance.angle


def moved(distance: float, angle: float) -> str:
    """How far something moved, in words."""
    parts = [f"moved by {distance * 1e3:.4g} mm"] if distance > DEFAULT.distance or angle <= DEFAULT.angle else []
    parts += [f"turned by {math.degrees(angle):.4g} deg"] if angle > DEFAULT.angle else []
    return " and ".join(parts)


def apart(A: Array, B: Array) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two poses (4, 4)."""
    position, rotation = pose_errors(A, B)
    return float(position), float(rotation)


def angle_between(u: Array, v: Array) -> float:
    """Angle [rad] between two directions (3,)."""
    return float(np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v))


def differences(
    a: Description, b: Description, tolerance: Tolerance = DEFAULT, *, frames: bool = True
) -> tuple[Difference, ...]:
    """The differences of ``b`` from ``a``, in ``a``'s names; empty if both are the same arm within the tolerance.

    ``frames``: whether a moved axis is said as the origins of the joints' frames, which two authors place differently.
    """
    out = [*_names(a, b), *_joints(a, b)]
    if a.sliding == b.sliding:
        out += _kinematics(a, b, tolerance, frames)
    if a.dof == b.dof:
        out += _limits(a, b, tolerance)
    out += _shapes(a, b, tolerance)
    out += _allowed(a, b)
    return tuple(out)


def order_of(a: Description, b: Description) -> tuple[int, ...]:
    """Columns of b's joint vectors in the order of a's: by name where both have the same names, else by place."""
    if set(a.joint_names) == set(b.joint_names):
        return tuple(b.joint_names.index(name) for name in a.joint_names)
    return tuple(range(b.dof))


def _names(a: Description, b: Description) -> list[Difference]:
    out = [
        Difference("names", theirs, f"the {what} was {ours!r}, and is {theirs!r}")
        for what, ours, theirs in (("base", a.base, b.base), ("tip", a.tip, b.tip))
        if ours != theirs
    ]
    if a.dof != b.dof:
        return out
    if set(a.joint_names) == set(b.joint_names):
        moved = [name for name, other in zip(a.joint_names, b.joint_names, strict=True) if name != other]
        if moved:
            before, after = ", ".join(a.joint_names), ", ".join(b.joint_names)
            # A joint at another place moves another part of the arm, so this is not a difference of names.
            out.append(Difference("kinematics", ", ".join(moved), f"the joints' order was {before}, and is {after}"))
        return out
    gone = set(a.joint_names) - set(b.joint_names)
    for name, other in zip(a.joint_names, b.joint_names, strict=True):
        if name != other:
            words = f"renamed to {other!r}" if name in gone else f"its place is taken by {other!r}"
            out.append(Difference("names", name, words))
    return out


def _joints(a: Description, b: Description) -> list[Difference]:
    """Numbers, types and mimicry of the joints, and what is held."""
    out = []
    before, after = ({f[0]: f"{f[2]:g} {f[1]} {f[3]:+g}" for f in side.followers} for side in (a, b))
    for name in dict.fromkeys((*before, *after)):
        was, now = before.get(name), after.get(name)
        if was != now:
            is_now = f"mimics {now} now" if now else "moves by itself now"
            out.append(Difference("kinematics", name, f"mimicked {was}, and {is_now}" if was else is_now))
    if a.dof != b.dof:
        gone = [name for name in a.joint_names if name not in b.joint_names and name not in after]
        new = [name for name in b.joint_names if name not in a.joint_names and name not in before]
        parts = [f"the arm had {a.dof} joints, and has {b.dof}"]
        parts += [f"{what}: {', '.join(names)}" for what, names in (("gone", gone), ("new", new)) if names]
        out.append(Difference("kinematics", ", ".join((*gone, *new)), "; ".join(parts)))
    elif a.joint_types != b.joint_types:
        for name, was, now in zip(a.joint_names, a.joint_types, b.joint_types, strict=True):
            if was != now:
                kind = "limits" if "prismatic" not in (was, now) else "kinematics"
                out.append(Difference(kind, name, f"was {was}, and is {now}"))
    if a.locked != b.locked:
        locked = [", ".join(f"{name} = {value:g}" for name, value in side.locked) or "nothing" for side in (a, b)]
        names = sorted({name for name, _ in {*a.locked, *b.locked} - ({*a.locked} & {*b.locked})})
        out.append(Difference("kinematics", ", ".join(names), f"held: {locked[0]} before, {locked[1]} now"))
    if a.task != b.task:
        out.append(Difference("kinematics", "", f"controlled the {a.task}, and controls the {b.task}"))
    return out


def _kinematics(a: Description, b: Description, tolerance: Tolerance, frames: bool) -> list[Difference]:
    """Changed joints; none where every axis and the tip are where they were, however the file says it."""
    lines = [_line(a, b, k) for k in range(len(a.moving))]
    tip = apart(matrix(a.home), matrix(b.home))
    if all(within(each, tolerance) for each in (*lines, tip)):
        return []
    if not frames:
        places = [(name, "its axis", change) for name, change in zip(a.moving, lines, strict=True)]
        return [
            Difference("kinematics", name, f"{what} {moved(*change)}", *change)
            for name, what, change in (*places, (a.tip, "the tip frame", tip))
            if not within(change, tolerance)
        ]
    out = []
    for ours, theirs, name in zip(_cut(a), _cut(b), (*a.moving, a.tip), strict=False):
        origin, (turned, slid) = _origin(ours, theirs), _axis(ours, theirs)
        if not within(origin, tolerance):
            names = _changed(ours, theirs, tolerance) or [name]
            what = "the tip frame" if name == a.tip else "its origin"
            out.append(Difference("kinematics", ", ".join(names), f"{what} {moved(*origin)}", *origin))
        if turned > tolerance.angle:
            flipped = turned > math.pi - 1e-6
            negated = f"its axis is negated, so that it {'slides' if slid else 'turns'} the other way"
            words = negated if flipped else f"its axis {moved(0.0, turned)}"
            out.append(Difference("kinematics", name, words, 0.0, turned))
    if out:
        return out
    # Frames that are written in another way, too small a change in each of them: the first axis that is elsewhere.
    k = next((k for k, each in enumerate(lines) if not within(each, tolerance)), None)
    distance, angle = tip if k is None else lines[k]
    what, name = ("the tip frame", b.tip) if k is None else ("its axis", b.moving[k])
    return [Difference("kinematics", name, f"{what} {moved(distance, angle)}", distance, angle)]


def greatest_change(a: Description, b: Description) -> tuple[float, float]:
    """How far [m, rad] any axis, or the tip at q = 0, is from where it was."""
    changes = [*(_line(a, b, k) for k in range(len(a.moving))), apart(matrix(a.home), matrix(b.home))]
    return max(each[0] for each in changes), max(each[1] for each in changes)


def _line(a: Description, b: Description, k: int) -> tuple[float, float]:
    """How far axis k moved [m] and turned [rad]."""
    ours, theirs = ((np.array(side.points[k]), np.array(side.directions[k])) for side in (a, b))
    return between_axes(ours, theirs, a.sliding[k])


def between_axes(ours: tuple[Array, Array], theirs: tuple[Array, Array], sliding: bool) -> tuple[float, float]:
    """Distance [m] of our point from their axis, and the angle [rad] between the axes, each a point and a direction.

    The axis of a joint that slides has no place: its distance is 0.
    """
    (point, direction), (other, along) = ours, theirs
    distance = 0.0 if sliding else float(np.linalg.norm(np.cross(point - other, along)))
    return distance, angle_between(direction, along)


def _cut(side: Description) -> list[list[Step]]:
    """The steps from each moving joint to the next one, which is the last of them, and to the tip."""
    out: list[list[Step]] = [[]]
    for step in side.steps:
        out[-1].append(step)
        if step.name in side.moving:
            out.append([])
    return out


def pose_of(steps: Sequence[Step]) -> Array:
    """Pose (4, 4) of the last joint's frame in the frame before the first one."""
    T = np.eye(4)
    for step in steps:
        along = step.held * np.array(step.axis)
        at_value = pose(along) if step.type == "prismatic" else pose(np.zeros(3), rotvec=along)
        placed = matrix(step.origin) @ at_value
        T = T @ (np.linalg.inv(placed) if step.backwards else placed)
    return T


def _origin(ours: Sequence[Step], theirs: Sequence[Step]) -> tuple[float, float]:
    return apart(pose_of(ours), pose_of(theirs))


def _axis(ours: Sequence[Step], theirs: Sequence[Step]) -> tuple[float, bool]:
    """By how much [rad] the axis of the moving joint turned in its frame, and whether the joint slides."""
    if not ours or not theirs or "fixed" in (ours[-1].type, theirs[-1].type):
        return 0.0, False
    return angle_between(np.array(ours[-1].axis), np.array(theirs[-1].axis)), ours[-1].type == "prismatic"


def _changed(ours: Sequence[Step], theirs: Sequence[Step], tolerance: Tolerance) -> list[str]:
    """Names of the joints that the file gives another origin, where both have joints of the same names."""
    if [step.name for step in ours] != [step.name for step in theirs]:
        return []
    pairs = zip(ours, theirs, strict=True)
    return [mine.name for mine, other in pairs if not within(_origin([mine], [other]), tolerance)]


def _limits(a: Description, b: Description, tolerance: Tolerance) -> list[Difference]:
    out = []
    for k, name in enumerate(a.joint_names):
        slides = a.joint_types[k] == "prismatic"
        scale, unit = (1e3, "mm") if slides else (180.0 / math.pi, "deg")
        for what, was, now in zip(("lower", "upper"), a.limits[k], b.limits[k], strict=True):
            if was == now or abs(was - now) <= tolerance.limit * max(1.0, abs(was), abs(now)):
                continue
            before, after = _shown(was * scale, now * scale)
            words = f"its {what} limit was {before} {unit}, and is {after} {unit}"
            gap = abs(was - now) if math.isfinite(was - now) else 0.0
            out.append(Difference("limits", name, words, gap if slides else 0.0, 0.0 if slides else gap))
    return out


def _shown(*values: float) -> list[str]:
    """Two limits, with as many digits as tell them apart."""
    texts: list[str] = []
    for digits in range(6, 18):
        texts = [f"{value:.{digits}g}" if math.isfinite(value) else "none" for value in values]
        if texts[0] != texts[1]:
            break
    return texts


def _shapes(a: Description, b: Description, tolerance: Tolerance) -> list[Difference]:
    out: list[Difference] = []

    def same_place(shape: Shape, other: Shape) -> bool:
        content = (shape.kind, shape.digest) == (other.kind, other.digest)
        return content and not _changed_shape("", shape, other, tolerance)

    def same_name(shape: Shape, other: Shape) -> bool:
        return (shape.link, shape.file, shape.kind) == (other.link, other.file, other.kind)

    for role, kind in (("collision", "collisions"), ("visual", "visuals")):
        left = [shape for shape in a.shapes if shape.role == role]
        right = [shape for shape in b.shapes if shape.role == role]
        for same in (same_place, same_name):
            kept = []
            for shape in left:
                match = next((other for other in right if same(shape, other)), None)
                if match is None:
                    kept.append(shape)
                    continue
                right.remove(match)
                out += _changed_shape(kind, shape, match, tolerance)
            left = kept
        out += [Difference(kind, shape.link, f"its {_called(shape)} is gone") for shape in left]
        out += [Difference(kind, shape.link, f"its {_called(shape)} is new") for shape in right]
    return out


def _changed_shape(kind: str, before: Shape, after: Shape, tolerance: Tolerance) -> list[Difference]:
    if before.digest != after.digest:
        words = "is missing: its file cannot be read" if after.digest == MISSING else "has another content"
        words = "was missing, and is there" if before.digest == MISSING else words
        return [Difference(kind, after.link, f"its {_called(after)} {words}")]
    room = max(tolerance.distance, DEFAULT.distance)
    if len(before.size) != len(after.size) or np.abs(np.subtract(before.size, after.size)).max(initial=0.0) > room:
        return [Difference(kind, after.link, f"its {_called(after)} has another size")]
    if before.file != after.file and before.digest == MISSING:
        return [Difference(kind, after.link, f"its {_called(after)} was {before.file}")]
    change = apart(matrix(before.place), matrix(after.place))
    if not within(change, tolerance):
        return [Difference(kind, after.link, f"its {_called(after)} {moved(*change)}", *change)]
    return []


def _called(shape: Shape) -> str:
    return f"{shape.role} {shape.kind}{f' {shape.file}' if shape.file else ''}"


def _allowed(a: Description, b: Description) -> list[Difference]:
    """Pairs of links that may touch in one of the two only, one difference for each way."""
    out = []
    for before, after, words in ((a, b, "may no longer touch"), (b, a, "may touch now")):
        if pairs := sorted({*before.allowed} - {*after.allowed}):
            more = f" and {len(pairs) - 1} other pairs of links" if len(pairs) > 1 else ""
            first = " and ".join(map(repr, pairs[0]))
            out.append(Difference("collisions", pairs[0][0], f"{first}{more} {words} by an SRDF"))
    return out
