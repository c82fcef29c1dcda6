"""Limbs of a robot with several chains, named after their joints and links: arms, legs, heads, fingers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_KINDS = {
    "finger": "finger thumb pinky knuckle distal proximal phalanx mcp pip dip",
    "wheel": "wheel caster roller steer",
    "leg": "leg hip knee ankle thigh calf foot toe haa hfe kfe shank shin crus tarsus",
    "head": "head neck eye eyes face gaze camera kinect",
    "arm": "arm shoulder elbow wrist forearm upperarm biceps hand sh el wr clavicle ubarm",
    "torso": "torso waist trunk spine chest lumbar thorax",
}
LONGEST_WHEEL = 2
"""A limb with more joints is not a wheel, though it may end in one."""
ARM_JOINTS = 5
"""A limb whose names match no kind is an arm if it has at least so many joints."""
_KIND_OF = {word: kind for kind, words in _KINDS.items() for word in words.split()}
_SIDES = {"left": "left", "l": "left", "right": "right", "r": "right"}
_ENDS = {"front": "front", "f": "front", "fore": "front", "rear": "rear", "hind": "rear", "back": "rear", "h": "rear"}
_CORNERS = {
    f"{side}{end}"[::order]: (_SIDES[side], where)
    for side in "lr"
    for end, where in {"f": "front", "h": "rear", "r": "rear", "b": "rear"}.items()
    for order in (1, -1)
    if side != end or end != "r"
}
_CORNERS["rr"] = ("right", "rear")
_DIGITS = ("thumb", "index", "middle", "ring", "pinky", "little")


@dataclass(frozen=True)
class Limb:
    """One limb of a robot.

    Attributes:
        name: such as 'left_arm', 'right_front_leg', 'head' or 'left_thumb_finger'; different from all others.
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


@dataclass(frozen=True)
class Ending:
    """A limb before it is named: its base, tip and joints, and the names of its joints and links.

    For a finger, ``arm`` holds the joint and link names of the arm that carries it.
    """

    base: str
    tip: str
    joints: tuple[str, ...]
    names: tuple[str, ...]
    arm: tuple[str, ...] = ()

    @property
    def kind(self) -> str:
        """The kind that most words of the names match; without a match, 'arm' or 'limb' by the number of joints."""
        if self.arm:
            return "finger"
        votes = Counter(kind for name in self.names for word in _words(name) if (kind := _kind_of(word)))
        if len(self.joints) > LONGEST_WHEEL:
            del votes["wheel"]
        if votes:
            return votes.most_common(1)[0][0]
        return "arm" if len(self.joints) >= ARM_JOINTS else "limb"


def named(endings: Sequence[Ending]) -> tuple[Limb, ...]:
    """The limbs, each with a unique name, in the given order."""
    limbs: list[Limb] = []
    kinds = [each.kind for each in endings]
    wanted = [(kind, _name(each, kind)) for each, kind in zip(endings, kinds, strict=True)]
    counts = Counter(name for _, name in wanted)
    taken: Counter[str] = Counter()
    for each, (kind, name) in zip(endings, wanted, strict=True):
        taken[name] += 1
        own = name if counts[name] == 1 else f"{name}_{taken[name]}"
        limbs.append(Limb(own, kind, each.base, each.tip, each.joints))
    return tuple(limbs)


def _words(name: str) -> list[str]:
    return [word.lower() for word in _WORD.findall(name)]


def _kind_of(word: str) -> str | None:
    """The kind of limb that a word means, such as 'hip' or 'lhip'."""
    return _KIND_OF.get(word) or (_KIND_OF.get(word[1:]) if word[:1] in ("l", "r") else None)


def _name(ending: Ending, kind: str) -> str:
    sides: Counter[str] = Counter()
    ends: Counter[str] = Counter()
    digits = Counter(word for name in ending.names for word in _words(name) if word in _DIGITS)
    for name in ending.arm or ending.names:
        for word in set(_words(name)):
            if word in _CORNERS:
                side, end = _CORNERS[word]
                sides[side] += 1
                ends[end] += 1
            elif word in _SIDES:
                sides[_SIDES[word]] += 1
            elif word[0] in "lr" and word not in _KIND_OF and word[1:] in _KIND_OF:
                sides[_SIDES[word[0]]] += 1
            elif word in _ENDS and len(word) > 1:
                ends[_ENDS[word]] += 1
    # At least half of the names must agree: one frame called 'front' does not make an arm a front arm.
    half = len(ending.arm or ending.names) / 2.0
    parts = [found.most_common(1)[0][0] for found in (sides, ends) if found and found.most_common(1)[0][1] >= half]
    if kind == "finger" and digits:
        parts.append(digits.most_common(1)[0][0])
    return "_".join([*parts, kind])
