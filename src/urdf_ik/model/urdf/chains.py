"""The chains of a URDF's tree that may be meant by an arm, and its limbs by name."""

import itertools
import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice

from urdf_ik.errors import ChainError
from urdf_ik.model.urdf.checks import MOVABLE, Joint
from urdf_ik.support.text import meant

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_KINDS = {
    "finger": "finger thumb pinky knuckle distal proximal phalanx mcp pip dip",
    "wheel": "wheel caster roller steer",
    "leg": "leg hip knee ankle thigh calf foot toe haa hfe kfe shank shin crus tarsus",
    "head": "head neck eye eyes face gaze camera kinect",
    "arm": "arm shoulder elbow wrist forearm upperarm biceps hand sh el wr clavicle ubarm",
    "torso": "torso waist trunk spine chest lumbar thorax",
}
_WHEEL_JOINTS = 2
"""A limb with more joints is not a wheel, though it may end in one."""
_UNNAMED_ARM_JOINTS = 5
"""A limb whose names match no kind is an arm if it has at least so many joints."""
_KIND_OF = {word: kind for kind, words in _KINDS.items() for word in words.split()}
_SIDES = {"left": "left", "l": "left", "right": "right", "r": "right"}


@dataclass(frozen=True)
class Limb:
    """One limb of a robot.

    Attributes:
        name: such as 'left_arm', 'right_leg' or 'head'; different from all others.
        kind: 'arm', 'leg', 'head', 'finger', 'wheel', 'torso', or 'limb' where the names do not say.
        base: its first link, where it branches off from the other limbs.
        tip: its last link.
        joints: its movable joints without a mimic, base to tip.
    """

    name: str
    kind: str
    base: str
    tip: str
    joints: tuple[str, ...]


def _numbered(limbs: Collection[Limb]) -> tuple[Limb, ...]:
    """The limbs, those with the same name numbered."""
    counts, taken = Counter(limb.name for limb in limbs), Counter[str]()
    out = []
    for limb in limbs:
        taken[limb.name] += 1
        out.append(limb if counts[limb.name] == 1 else replace(limb, name=f"{limb.name}_{taken[limb.name]}"))
    return tuple(out)


def _kind(names: Sequence[str], joints: int) -> str:
    """The kind that most words of the names match; without a match, 'arm' or 'limb' by the number of joints."""
    votes = Counter(kind for name in names for word in _words(name) if (kind := _kind_of(word)))
    if joints > _WHEEL_JOINTS:
        del votes["wheel"]
    if votes:
        return votes.most_common(1)[0][0]
    return "arm" if joints >= _UNNAMED_ARM_JOINTS else "limb"


def _words(name: str) -> list[str]:
    return [word.lower() for word in _WORD.findall(name)]


def _kind_of(word: str) -> str | None:
    """The kind of limb that a word means, such as 'hip' or 'lhip'."""
    return _KIND_OF.get(word) or (_KIND_OF.get(word[1:]) if word[:1] in ("l", "r") else None)


def _name(names: Sequence[str], kind: str) -> str:
    sides: Counter[str] = Counter()
    for name in names:
        for word in set(_words(name)):
            if word in _SIDES:
                sides[_SIDES[word]] += 1
            elif word[0] in "lr" and word not in _KIND_OF and word[1:] in _KIND_OF:
                sides[_SIDES[word[0]]] += 1
    # At least half of the names must agree: one frame called 'left' does not make an arm a left arm.
    side, votes = sides.most_common(1)[0] if sides else ("", 0)
    return f"{side}_{kind}" if 2 * votes >= len(names) and side else kind


_FINGER_JOINTS = 3
"""A branch with more joints is not a finger, whatever its name."""
_SLIDING_JOINTS = 1
"""A prismatic joint beside others at the end of an arm is a finger if its branch has at most so many joints."""
_MOST_NAMES = 40
"""An error lists at most so many names of chains and limbs."""
_SHOWN = 8
"""An error describes at most so many chains."""
_HAND_AFTER = 3
"""A hand comes after at least so many joints."""

_FINGER = re.compile(
    r"finger|knuckle|gripper|jaw|claw|thumb|mors|grip_|_grip|(?<![a-z])(index|middle|ring|pinky|little)(?![a-z])",
    re.IGNORECASE,
)
_WRIST = re.compile(r"rot|roll|pitch|yaw|wrist|base|mount", re.IGNORECASE)
# Names of tool frames, the most specific first.
_TOOL_FRAMES = (
    re.compile(r"(^|[_/])tcp\d?([_/]|$)", re.IGNORECASE),
    re.compile(r"(^|[_/])tool0([_/]|$)", re.IGNORECASE),
    re.compile(r"(^|[_/])(ee|eef|end_?effector)(_?link|_?frame)?$", re.IGNORECASE),
    re.compile(r"(^|[_/])tool_?(frame|link)$", re.IGNORECASE),
)
_FLANGE = re.compile(r"(^|[_/])flange([_/]|$)", re.IGNORECASE)


@dataclass(frozen=True)
class Candidate:
    """A candidate chain.

    Attributes:
        name: its name; 'left' or 'right' if the names of the URDF say so, else the tip's name.
        base: base link.
        tip: tip link.
        joints: its movable joints without a mimic, base to tip.
        frames: the other links that are fixed to its last moving link.
        before: movable joints between the root and the base, which it shares with other chains.
        chosen: whether it is the default if neither base nor tip is given.
        reason: why this link is the tip, or why the tip is ambiguous, in words.
    """

    name: str
    base: str
    tip: str
    joints: tuple[str, ...]
    frames: tuple[str, ...]
    before: tuple[str, ...]
    chosen: bool
    reason: str

    def __str__(self) -> str:
        count = len(self.joints)
        return f"{self.base} to {self.tip}, {count} joint{'' if count == 1 else 's'}"


@dataclass(frozen=True, eq=False)
class _Body:
    """Links that are fixed to each other, and the movable joints that carry them and that they carry."""

    links: tuple[str, ...]
    carrier: Joint | None
    carried: tuple[Joint, ...]


@dataclass(frozen=True, eq=False)
class Chains:
    """The chains below one link.

    Attributes:
        base: the first link of every chain.
        joints: the joints, in the file's order.
    """

    base: str
    joints: tuple[Joint, ...]
    _carried: dict[str, list[Joint]] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        for joint in self.joints:
            self._carried.setdefault(joint.parent, []).append(joint)

    def candidates(self) -> tuple[Candidate, ...]:
        """Candidate chains, the longest first; none is chosen if the choice is ambiguous."""
        ways = [way for way in self._ways() if len(way) > 1]
        ways.sort(key=lambda way: -_actuated(way))
        if not ways or not _actuated(ways[0]):
            return ()
        # Chains with more than half of the longest one's joints compete with it: another arm does, a head does not.
        rivals = [way for way in ways if 2 * _actuated(way) > _actuated(ways[0])]
        names = _side_names(rivals)
        starts = [0 if len(rivals) == 1 else _common(rivals), *(_common([ways[0], way]) for way in ways[len(rivals) :])]
        starts[:1] *= len(rivals)
        return tuple(
            self._candidate(way, start, len(rivals) == 1 and k == 0, names[k] if k < len(names) else "")
            for k, (way, start) in enumerate(zip(ways, starts, strict=True))
        )

    def limbs(self) -> tuple[Limb, ...]:
        """Every limb, from its branching point on, in the file's order; fingers of hands are none."""
        ways = [way for way in self._ways() if _actuated(way)]
        limbs: dict[tuple[str, str], Limb] = {}
        for k, way in enumerate(ways):
            others = [other for j, other in enumerate(ways) if j != k]
            shared = [_common([way, other]) for other in others]
            # A branch with one joint, such as a camera's, does not start a new limb.
            forks = {at for at, other in zip(shared, others, strict=True) if _actuated(other[at + 1 :]) > 1}
            stops = [0, *sorted(forks - {0, len(way) - 1}), len(way) - 1]
            for start, end in itertools.pairwise(stops):
                last, own = end == len(way) - 1, way[start + 1 : end + 1]
                if last or _actuated(own) >= _HAND_AFTER:
                    limb = self._limb([way[start], *own])
                    limbs.setdefault((limb.base, limb.tip), limb)
        return _numbered(limbs.values())

    def _limb(self, way: Sequence[_Body]) -> Limb:
        """The limb along bodies; the first body is its fixed base."""
        carriers = [body.carrier for body in way[1:] if body.carrier is not None]
        joints = tuple(joint.name for joint in carriers if _moves(joint))
        names = (*joints, *(joint.child for joint in carriers))
        kind, tip = _kind(names, len(joints)), self._tip(way[-1])[0] or way[-1].links[0]
        return Limb(_name(names, kind), kind, way[0].links[0], tip, joints)

    def _body(self, link: str, carrier: Joint | None) -> _Body:
        """``link`` and the links that fixed joints carry below it."""
        links, carried = [link], []
        for each in links:
            for joint in self._carried.get(each, ()):
                if joint.type == "fixed":
                    links.append(joint.child)
                else:
                    carried.append(joint)
        return _Body(tuple(links), carrier, tuple(carried))

    @cached_property
    def _heights(self) -> dict[str, int]:
        """Greatest number of joints without a mimic on a path down from each link."""
        links = [self.base]
        for link in links:  # the list grows during the loop: parents before children
            links += [joint.child for joint in self._carried.get(link, ())]
        heights: dict[str, int] = {}
        for link in reversed(links):
            carried = self._carried.get(link, ())
            heights[link] = max((int(_moves(joint)) + heights[joint.child] for joint in carried), default=0)
        return heights

    def _ways(self) -> list[list[_Body]]:
        """Paths from the base down to the ends of arms; a floating or planar joint starts a new path."""
        ways: list[list[_Body]] = []
        # Without recursion: a chain may be as long as MAX_LINKS.
        waiting: list[tuple[_Body, int, list[_Body]]] = [(self._body(self.base, None), 0, [])]
        while waiting:
            body, depth, way = waiting.pop()
            on: list[tuple[_Body, int, list[_Body]]] = []
            for joint in body.carried:
                below = self._body(joint.child, joint)
                if joint.type not in MOVABLE:
                    on.append((below, 0, []))
                elif not self._is_finger(joint, len(body.carried), depth):
                    on.append((below, depth + int(_moves(joint)), [*way, body]))
            waiting += reversed(on)
            if not on:
                ways.append([*way, body])
        return ways

    def _is_finger(self, joint: Joint, beside: int, depth: int) -> bool:
        """Whether a joint moves a finger and not the arm: one of several joints in a hand, or the last of an arm."""
        height = int(_moves(joint)) + self._heights[joint.child]
        if beside > 1 and not height:
            return True
        if depth < _HAND_AFTER:
            return False
        if beside > 1:
            named = _FINGER.search(joint.name) or _FINGER.search(joint.child)
            return height <= (_FINGER_JOINTS if named else _SLIDING_JOINTS * (joint.type == "prismatic"))
        return height <= 1 and bool(_FINGER.search(joint.name)) and not _WRIST.search(joint.name)

    def _candidate(self, way: Sequence[_Body], start: int, chosen: bool, name: str) -> Candidate:
        tip, reason = self._tip(way[-1])
        before, own = (
            tuple(body.carrier.name for body in part if body.carrier is not None and _moves(body.carrier))
            for part in (way[: start + 1], way[start + 1 :])
        )
        shown = tip or way[-1].links[0]
        return Candidate(
            name=name or shown,
            base=way[start].links[0],
            tip=shown,
            joints=own,
            frames=tuple(link for link in way[-1].links if link != shown),
            before=before,
            chosen=chosen and tip is not None,
            reason=reason,
        )

    def _tip(self, body: _Body) -> tuple[str | None, str]:
        """The tool frame among links that are fixed to each other, and the reason; None if it is ambiguous."""
        if len(body.links) == 1:
            return body.links[0], "the last link"
        for pattern in _TOOL_FRAMES:
            if found := [link for link in body.links if pattern.search(link)]:
                return (found[0], "named as a tool frame") if len(found) == 1 else (None, "several tool frames")
        leaves = [link for link in body.links if not self._carried.get(link)]
        if len(leaves) == 1:
            return leaves[0], "the only link at the end"
        if not leaves:  # every link carries a finger
            ends = [link for link in body.links if all(below.type != "fixed" for below in self._carried[link])]
            if len(ends) == 1:
                return ends[0], "the only link at the end of those that are fixed to it"
        if found := [link for link in body.links if _FLANGE.search(link)]:
            return (found[0], "named as a flange") if len(found) == 1 else (None, "several flanges")
        origins = {joint.child: joint.origin[:3, 3] for joint in self.joints}
        apart = [link for link in leaves if origins[link].any()]
        if len(apart) == 1:
            return apart[0], "the only frame away from the last link's own"
        return None, f"{len(body.links)} links, all fixed to {body.links[0]!r}"


def doubt(source: str, candidates: Sequence[Candidate], limbs: Sequence[Limb], chain: str | None) -> ChainError:
    """The error for an ambiguous chain, or for a name that no chain or several chains have."""
    if chain is not None:
        every = dict.fromkeys([*(each.name for each in candidates), *(limb.name for limb in limbs)])
        names = ", ".join(map(repr, islice(every, _MOST_NAMES)))
        near = meant(chain, [limb.name for limb in limbs])
        count = sum(each.name == chain for each in candidates)
        called = f"{count} chains are" if count else "no chain is"
        return ChainError(f"{source}: {called} called {chain!r}{near}; there are {names}")
    longest = len(candidates[0].before) + len(candidates[0].joints)
    rivals = [each for each in candidates if 2 * (len(each.before) + len(each.joints)) > longest]
    if len(rivals) == 1:
        tips = [candidates[0].tip, *candidates[0].frames]
        why = f"the joints are {', '.join(candidates[0].joints)}, but their end has {candidates[0].reason}"
        return ChainError(f"{source}: the tip is ambiguous: {why}; name one with tip=...", tips)
    named = "; ".join(f"{each.name!r}: {each}" for each in rivals[:_SHOWN])
    more = f"; and {len(rivals) - _SHOWN} more" if len(rivals) > _SHOWN else ""
    by_limb = ", ".join(f"{limb.name} ({len(limb.joints)})" for limb in limbs)
    why = f"{len(rivals)} movable chains come into question: {named}{more}"
    way_out = f"name one with chain=... or tip=...; limbs and their joints: {by_limb}"
    return ChainError(f"{source}: {why}; {way_out}", [each.tip for each in candidates])


def _moves(joint: Joint) -> bool:
    return joint.type in MOVABLE and joint.mimic is None


def _actuated(way: Sequence[_Body]) -> int:
    return sum(body.carrier is not None and _moves(body.carrier) for body in way)


def _common(ways: Sequence[Sequence[_Body]]) -> int:
    """Index of the last body that all ways share."""
    count = 0
    for bodies in zip(*ways, strict=False):
        if len({body.links[0] for body in bodies}) > 1:
            break
        count += 1
    return max(count - 1, 0)


def _side_names(ways: Sequence[Sequence[_Body]]) -> list[str]:
    """'left' and 'right' if the last joints or links of two paths have these names, else an empty list."""
    found = []
    for way in ways:
        names = [way[-1].links[0], *(body.carrier.name for body in way[-1:] if body.carrier is not None)]
        words = {word for name in names for word in re.split(r"[^a-z]+", name.lower())}
        found += sorted({side for word, side in _SIDES.items() if word in words})
    return found if len(ways) == len(found) == len(set(found)) else []
