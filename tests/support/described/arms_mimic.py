"""URDF text of arms in which joints mimic others: random members of linkages, telescopes and arbitrary chains."""

import math
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from arms import X, Y, Z
from arms_few import few_urdf


@dataclass(frozen=True)
class Linkage:
    """A class of arms.

    Attributes:
        kinds: R or P, one an axis.
        axes: directions at q = 0; '?' any.
        mimics: axis, from 0, to (axis that it follows, multiplier); offsets are random.
        together: pairs of axes that coincide.
        images: turns after which each independent joint is back.
    """

    kinds: str
    axes: str
    mimics: dict[int, tuple[int, float]]
    together: tuple[tuple[int, int], ...] = ()
    images: tuple[float, ...] = ()


LINKAGES = {
    "planar, forearm kept": Linkage("RRR", "zzz", {1: (0, -1.0)}, (), (1, 1)),
    "planar, tool kept": Linkage("RRR", "zzz", {2: (1, -1.0)}, (), (1, 1)),
    "planar 4R, one follows": Linkage("RRRR", "zzzz", {2: (1, -1.0)}, (), (1, 1, 1)),
    "halves": Linkage("RRR", "zzz", {1: (0, -1.5)}, ((1, 2),), (2, 1)),
    "thirds": Linkage("RRR", "zyx", {2: (0, 1.0 / 3.0)}, (), (3, 1)),
    "one joint moves all": Linkage("RRR", "???", {1: (0, 2.0), 2: (1, -1.0)}, (), (1,)),
    "palletizer": Linkage("RRRR", "zyyy", {3: (2, -1.0)}, (), (1, 1, 1)),
    "palletizer, tool kept upright": Linkage("RRRRR", "zyyyy", {3: (1, -1.0), 4: (2, -1.0)}, ((3, 4),), (1, 1, 1)),
    "palletizer with wrist": Linkage("RRRRRR", "zyyyyz", {3: (1, -1.0), 4: (2, -1.0)}, ((3, 4),), (1, 1, 1, 1)),
    "telescope": Linkage("RRPP", "zyxx", {3: (2, 1.0)}, (), (1, 1, 0)),
    "slide driven by a turn": Linkage("RRP", "zyx", {2: (1, 0.1)}, (), (1, 0)),
    "any axes": Linkage("RRRR", "????", {2: (0, -1.0)}, (), (1, 1, 1)),
    "of no fraction": Linkage("RRR", "zyy", {2: (1, math.sqrt(0.5))}, (), (1, 0)),
}


def linkage(name: str, seed: int) -> str:
    """URDF text of a random member, links ``base`` and ``tool``, joints joint_1 and so on."""
    build, rng = LINKAGES[name], np.random.default_rng([seed, *name.encode()])
    named = {letter: rng.choice([-1.0, 1.0]) * axis for letter, axis in zip("xyz", (X, Y, Z), strict=True)}
    n = len(build.kinds)
    axes = np.array([named[a] if a in named else rng.normal(size=3) for a in build.axes])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    points = np.cumsum(rng.uniform(-0.5, 0.5, (n, 3)), axis=0)
    for a, b in build.together:
        points[b] = points[a] + rng.uniform(-0.2, 0.2) * axes[a]
        axes[b] = axes[a]
    for follower, (driver, _) in build.mimics.items():
        if build.kinds[follower] == build.kinds[driver] == "P":
            axes[follower] = axes[driver]  # the stages of a telescope move the same way
    text = few_urdf(build.kinds, axes, points, points[-1] + rng.uniform(-0.3, 0.3, 3), rng)
    for follower, (driver, multiplier) in build.mimics.items():
        text = mimicking(text, follower + 1, f"joint_{driver + 1}", multiplier, float(rng.uniform(-1.0, 1.0)))
    return text


def mimicking(text: str, joint: int, driver: str, multiplier: float, offset: float = 0.0) -> str:
    """URDF text in which the joint with this number mimics another."""
    robot, element = _found(text, joint)
    ElementTree.SubElement(element, "mimic", joint=driver, multiplier=repr(multiplier), offset=repr(offset))
    return ElementTree.tostring(robot, encoding="unicode")


def limited(text: str, joint: int, lower: float, upper: float) -> str:
    """URDF text in which the joint with this number has these limits; none at all where they are infinite."""
    robot, element = _found(text, joint)
    for limit in element.findall("limit"):
        element.remove(limit)
    element.set("type", "revolute" if math.isfinite(upper) else "continuous")
    if math.isfinite(upper):
        ElementTree.SubElement(element, "limit", lower=repr(lower), upper=repr(upper), effort="1", velocity="1")
    return ElementTree.tostring(robot, encoding="unicode")


def _found(text: str, joint: int) -> tuple[ElementTree.Element, ElementTree.Element]:
    robot = ElementTree.fromstring(text)
    return robot, next(each for each in robot.iter("joint") if each.get("name") == f"joint_{joint}")
