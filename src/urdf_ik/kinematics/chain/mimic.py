"""Chains whose joints mimic others: value = multiplier * q[driver] + offset.

The joint vector holds the drivers alone, in the order in which the chain first needs them, base to tip; a mimic of a
mimic follows the joint at the end of the row, and a driver beside the chain counts by what it drives in it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.kinematics.chain.serial import Chain
from urdf_ik.model.urdf import Joint, UrdfModel
from urdf_ik.support.tolerances import STILL
from urdf_ik.typing import Array

MOST_TURNS = 12
"""Multipliers are read as fractions with denominators up to this."""
_SAME = 1e-12


@dataclass(frozen=True)
class CoupledChain(Chain):
    """A chain whose m axes follow n joints: the axes' values are ``gain`` q, offsets being part of the zero position.

    ``H`` (m, 3) and ``P`` (m + 1, 3) are the axes'; names, types and limits are those of the n joints.

    Attributes:
        axes: the chain of the m axes, each a joint of its own.
        gain: (m, n) axis values per joint value, rad or m per rad or m.
    """

    axes_alone: Chain = field(repr=False, kw_only=True)
    gain: NDArray[np.float64] = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self.gain.setflags(write=False)

    @property
    def axes(self) -> Chain:
        """The chain of the m axes, each a joint of its own."""
        return self.axes_alone

    @property
    def directions(self) -> Array:
        """(n, 3) unit direction of the first axis that each joint moves, as it turns."""
        first = np.argmax(self.gain != 0.0, axis=0)
        signs = np.where(self.gain[first, np.arange(self.n)] < 0.0, -1.0, 1.0)
        return np.asarray(signs[:, None] * self.H[first])

    @property
    def image_turns(self) -> Array:
        """(n,) turns after which a joint has brought all its axes round; 0 where it never does."""
        return np.array([self._turns(j) for j in range(self.n)], dtype=np.float64)

    def _turns(self, joint: int) -> int:
        turns = 1
        for factor, slides in zip(self.gain[:, joint], self.axes.prismatic, strict=True):
            if factor == 0.0:
                continue
            share = Fraction(factor).limit_denominator(MOST_TURNS)
            if self.joint_types[joint] == "prismatic" or slides or abs(float(share) - factor) > _SAME * abs(factor):
                return 0
            turns = math.lcm(turns, share.denominator)
        return turns if turns <= MOST_TURNS else 0

    def spread(self, q: Array) -> Array:
        """Values (..., m) of the axes for joint vectors (..., n)."""
        # Number by number, not as a product of matrices: its digits depend on how many there are.
        out = np.zeros((*q.shape[:-1], len(self.gain)))
        for j in range(self.n):
            out += q[..., j, None] * self.gain[:, j]
        return out

    def fk(self, q: ArrayLike) -> Array:
        """Pose of the tip in the base: see :meth:`Chain.fk`."""
        return self.axes.fk(self.spread(self.check(q, padded=True)))

    def jacobian(self, q: ArrayLike) -> Array:
        """Geometric Jacobian (..., 6, n): a joint's column is the sum of those of the axes that it drives."""
        return np.asarray(self.axes.jacobian(self.spread(self.check(q, padded=True))) @ self.gain)

    def with_screws(self, H: Array, P: Array, R_tip: Array) -> Chain:
        """The same joints with other axes: see :meth:`Chain.with_screws`."""
        alone = replace(self.axes_alone, H=H, P=P, R_tip=R_tip)
        return replace(self, H=H.copy(), P=P.copy(), R_tip=R_tip.copy(), axes_alone=alone)

    def reversed(self) -> Chain:
        """The same joints from tip to base: see :meth:`Chain.reversed`."""
        back = self.axes.reversed()
        return _joined(
            back, self.gain[::-1, ::-1].copy(), self.joint_names[::-1], self.joint_types[::-1], self.limits[::-1].copy()
        )

    def at_rest(self, q: Array, free: Sequence[int]) -> Chain:
        """The chain of the joints ``free`` and what they drive: see :meth:`Chain.at_rest`."""
        driven = np.flatnonzero(self.gain[:, free].any(axis=1))
        return _joined(
            self.axes.at_rest(self.spread(q), driven.tolist()),
            self.gain[driven][:, free],
            tuple(self.joint_names[k] for k in free),
            tuple(self.joint_types[k] for k in free),
            self.limits[free],
        )


def follows(multiplier: float) -> bool:
    """Whether a joint that mimics another with this multiplier moves."""
    return abs(multiplier) > STILL


def coupled(model: UrdfModel, axes: Chain, movable: list[Joint]) -> Chain:
    """The chain of the independent joints.

    Args:
        model: the URDF.
        axes: chain of all movable joints, mimicking ones too, as if each were free; its tree is the URDF's.
        movable: these joints of the URDF.
    """
    rows = [model.driver(joint) for joint in movable]
    kept = [k for k, (_, multiplier, _) in enumerate(rows) if follows(multiplier)]
    drivers = list({rows[k][0].name: rows[k][0] for k in kept}.values())
    names = tuple(driver.name for driver in drivers)
    gain = np.zeros((len(kept), len(names)))
    for row, k in zip(gain, kept, strict=True):
        row[names.index(rows[k][0].name)] = rows[k][1]
    # An axis seen from below turns the other way round; its joint's value is the same.
    moved = axes.at_rest(np.array([offset for _, _, offset in rows]), kept)
    moved = replace(moved, followers=tuple(each for each in axes.followers if follows(each.multiplier)))
    limits = np.array([_limits(driver, movable, rows) for driver in drivers]).reshape(-1, 2)
    return _joined(moved, gain, names, tuple(driver.type for driver in drivers), limits)


def _limits(driver: Joint, movable: list[Joint], rows: list[tuple[Joint, float, float]]) -> tuple[float, float]:
    """The driver's limits as far as the joints that mimic it may follow."""
    own = (-math.inf, math.inf) if driver.type == "continuous" else (driver.lower, driver.upper)
    lower, upper = own
    for joint, (leader, multiplier, offset) in zip(movable, rows, strict=True):
        bounded = joint.type != "continuous" and joint.lower < joint.upper
        if leader.name == driver.name and joint.name != driver.name and follows(multiplier) and bounded:
            ends = sorted(((joint.lower - offset) / multiplier, (joint.upper - offset) / multiplier))
            lower, upper = max(lower, ends[0]), min(upper, ends[1])
    return (lower, upper) if lower <= upper else own


def _joined(axes: Chain, gain: Array, names: tuple[str, ...], types: tuple[str, ...], limits: Array) -> Chain:
    """The chain of joints that drive the axes; a plain one where each drives one axis, as far as it moves itself."""
    slides = np.array([kind == "prismatic" for kind in types], dtype=np.bool_)
    if (
        gain.shape == (len(names),) * 2
        and (np.abs(gain) == np.eye(len(names))).all()
        and (slides == axes.prismatic).all()
    ):
        H = np.diag(gain)[:, None] * axes.H
        return replace(axes, joint_names=names, joint_types=types, H=H, limits=limits.copy())
    same = {each.name: getattr(axes, each.name) for each in fields(axes) if each.init}
    own = {"joint_names": names, "joint_types": types, "limits": limits.copy()}
    return CoupledChain(**{**same, **own}, axes_alone=axes, gain=gain)
