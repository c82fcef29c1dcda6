"""A solver without a core, and solutions as a solver hands them over, for the tests of their container."""

from collections import namedtuple
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.solutions import IKSolutions

Array = NDArray[np.float64]
PI = np.pi


class Chain(namedtuple("Chain", "joint_types")):
    """What solutions ask of a chain."""

    @property
    def image_turns(self):
        """(n,) turns after which a joint is in the same posture."""
        return np.array([float(kind != "prismatic") for kind in self.joint_types])


Nearest = namedtuple("Nearest", "links distance")
FakeSolver = namedtuple("FakeSolver", "name joint_names limits dof chain arm parameters", defaults=((),))


class FakeArm:
    """What solutions ask of the arm that they came from: its cell, and why a pose has none."""

    def __init__(self) -> None:
        self.cell = Hits()
        self.redundancy = None

    def explain(self, T: Array, redundancy: float | None = None) -> str:
        """The fake arm's reason for a pose without solutions."""
        return f"x = {T[0, 3]:g} m is out of reach"


class Hits:
    """A collision model in which the arm collides where its first joint is negative; remembers what it was asked."""

    def __init__(self) -> None:
        self.asked: list[Array] = []

    def in_collision(self, q: Array, margin: float = 0.0) -> NDArray[np.bool_]:
        """(k, n) to (k,): whether the first joint's value is below the margin."""
        self.asked.append(q)
        return q[..., 0] < margin

    def nearest_pair(self, q: Array) -> Nearest:
        """The two bodies that there are, as far apart as the first joint's value."""
        return Nearest(("arm", "wall"), max(float(q[0]), 0.0))

    def in_world(self, world: "Hits | None") -> "Hits":
        """What stands for the arm in a world."""
        return self if world is None else world


KINDS = ("revolute", "prismatic", "continuous")
LIMITS = np.array([[-2 * PI, 2 * PI], [-0.5, 0.5], [-np.inf, np.inf]])
BRANCHES = ("front", "front, flip", "back", "back, flip")
ARM: Any = FakeSolver("fake", ("turn", "slide", "spin"), LIMITS, 3, Chain(KINDS), FakeArm())


def arm_with(limits: object, kinds: tuple[str, ...] = KINDS) -> Any:
    """The fake arm with other limits."""
    return ARM._replace(limits=np.array(limits, dtype=np.float64), chain=Chain(kinds), arm=FakeArm())


def made(q: object, arm: Any = ARM, x: object = 0.0, flags: int = 0) -> IKSolutions:
    """Solutions (..., 4, 3) as a solver hands them over: NaN rows are invalid."""
    rows = np.array(q, dtype=np.float64)
    valid = ~np.isnan(rows).any(axis=-1)
    T = np.zeros((*rows.shape[:-2], 4, 4)) + np.eye(4)
    T[..., 0, 3] = x
    return IKSolutions(arm, T, rows, np.where(valid, 1 + (flags << 1), 0).astype(np.uint8), BRANCHES)


NONE = [np.nan] * 3
ONE = made([[1.0, 0.2, 3.0], NONE, [-2.0, 0.1, -3.0], [0.5, 0.9, 0.0]])
BATCH = made(np.random.default_rng(0).uniform(-3, 3, (2, 5, 4, 3)) * [1, 0.3, 1], x=np.arange(10).reshape(2, 5))
