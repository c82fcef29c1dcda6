"""Arms as their URDF has them, and the ends of a solver's own frames, for the compiled solvers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.mimic import CoupledChain
from urdf_ik.support.tolerances import SolverTolerances
from urdf_ik.typing import Array

POSE, POSITION, AXIS, PLANAR_POSITION, PLANAR_POSE = range(5)
"""What the joints control of the tip, in the order of ``Task`` in src/core/kinematics/arm.hpp."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Written:
    """An arm of n joints; each turns about its frame's z axis or slides along it.

    Attributes:
        steps: (n + 1, 3, 4) motions from the base to joint 1's frame, and so on to the tip [m].
        slides: (n,) which joints slide.
        size: m, the length that tolerances are shares of.
        tolerances: what the solvers compare with.
        task: what the joints control of the tip: ``POSE`` or one of the constants beside it.
        aimed: (3,) the tip's axis that is aimed, in the tip; None: the task aims none.
        normal: (3,) of the plane in which the tip moves, in the base; None: the task has no plane.
    """

    steps: Array
    slides: Array
    size: float
    tolerances: SolverTolerances = field(default_factory=SolverTolerances)
    task: int = POSE
    aimed: Array | None = None
    normal: Array | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Driven:
    """An arm whose n joints drive m axes: joints that mimic others are axes, not joints.

    Attributes:
        steps: (m + 1, 3, 4) motions from the base to axis 1's frame, and so on to the tip [m].
        slides: (m,) which axes slide.
        size: m, the length that tolerances are shares of.
        axes: m, how many axes there are.
        gain: (m, n) by how much each axis moves for one unit of each joint [rad, m].
        unit: (n,) each joint's unit [rad, m].
        period: (n,) rad, after which each joint's motion repeats; 0: it does not.
        tolerances: what the solvers compare with.
    """

    steps: Array
    slides: Array
    size: float
    axes: int
    gain: Array
    unit: Array
    period: Array
    tolerances: SolverTolerances = field(default_factory=SolverTolerances)


@dataclass(frozen=True)
class Aim:
    """What the joints control of the tip.

    Attributes:
        kind: ``POSE`` or one of the constants beside it.
        axis: (3,) the tip's axis that is aimed, in the tip.
        normal: (3,) of the plane in which the tip moves, in the base.
    """

    kind: int = POSE
    axis: Array | None = None
    normal: Array | None = None

    def written(self, chain: Chain) -> Written:
        """The arm as its URDF has it, with this task."""
        axis, normal = (None if v is None else np.array(v, dtype=np.float64) for v in (self.axis, self.normal))
        return Written(
            steps=chain.motion.steps,
            slides=chain.prismatic.astype(np.float64),
            size=chain.size,
            task=self.kind,
            aimed=axis,
            normal=normal,
        )


WHOLE_POSE = Aim()


def written(chain: Chain) -> Written:
    """The arm as its URDF has it, for whole poses."""
    return WHOLE_POSE.written(chain)


def driven(chain: CoupledChain, units: Array) -> Driven:
    """An arm with joints that mimic others, as its URDF has it.

    Args:
        chain: the arm.
        units: (n,) rad or m, the units of the solver's joint values.
    """
    axes = written(chain.axes)
    return Driven(
        steps=axes.steps,
        slides=axes.slides,
        size=chain.size,
        axes=chain.axes.n,
        gain=np.ascontiguousarray(chain.gain * units),
        unit=units,
        period=2.0 * np.pi * chain.image_turns,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Ends:
    """Where a solver's own frames stand: the first one in the base, the last one in the tip.

    Attributes:
        base_rotation: (3, 3) from the base to frame 1.
        base_origin: (3,) m, of frame 1 in the base.
        tool_rotation: (3, 3) from the last frame to the tip.
        tool_point: (3,) m, the point that is solved for, in the tip.
    """

    base_rotation: Array
    base_origin: Array
    tool_rotation: Array
    tool_point: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeArm:
    """An arm of seven joints, from which ``_core.SelfMotion`` is made.

    Attributes:
        written: the arm as its URDF has it.
        given: index of the joint whose value is the redundancy parameter; -1: the swivel angle of an S-R-S arm.
        ends: the frames that the swivel angle is measured in; None: a joint is given.
    """

    written: Written
    given: int
    ends: Ends | None = None
