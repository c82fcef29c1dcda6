"""What compiled solvers are made from: named values, such as an arm as its URDF has it and the ends of its frames."""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.mimic import CoupledChain
from urdf_ik.support.tolerances import SolverTolerances
from urdf_ik.typing import Array

POSE, POSITION, AXIS, PLANAR_POSITION, PLANAR_POSE = range(5)
"""What the joints control of the tip, in the order of ``Task`` in src/core/arm/arm.hpp."""


class Numbers(SimpleNamespace):
    """The named values of a struct of the compiled core, whose header explains each.

    For a solver ``kind`` is its name, and the header is in src/core/families. The core names a value that is missing;
    docs/_static/compiled-arm.schema.json lists those of every kind.
    """

    def but(self, **changed: Any) -> "Numbers":
        """The same with other values."""
        return Numbers(**{**vars(self), **changed})


class Aim(NamedTuple):
    """What the joints control of the tip.

    Attributes:
        kind: ``POSE`` or one of the constants beside it.
        axis: (3,) the tip's axis that is aimed, in the tip.
        normal: (3,) of the plane in which the tip moves, in the base.
    """

    kind: int = POSE
    axis: Array | None = None
    normal: Array | None = None


WHOLE_POSE = Aim()


def written(chain: Chain, aim: Aim = WHOLE_POSE) -> Numbers:
    """The arm as its URDF has it: ``Written`` of the core."""
    axis, normal = (None if v is None else np.array(v, dtype=np.float64) for v in (aim.axis, aim.normal))
    return Numbers(
        steps=chain.motion.steps,
        slides=chain.prismatic.astype(np.float64),
        size=chain.size,
        tolerances=SolverTolerances(),
        task=aim.kind,
        aimed=axis,
        normal=normal,
    )


def driven(chain: CoupledChain, units: Array) -> Numbers:
    """An arm with joints that mimic others, as its URDF has it: ``Coupled`` of the core.

    Args:
        chain: the arm.
        units: (n,) rad or m, the units of the solver's joint values.
    """
    axes = written(chain.axes)
    return Numbers(
        steps=axes.steps,
        slides=axes.slides,
        size=chain.size,
        axes=chain.axes.n,
        gain=np.ascontiguousarray(chain.gain * units),
        unit=units,
        period=2.0 * np.pi * chain.image_turns,
        tolerances=SolverTolerances(),
    )


def ends(base_rotation: Array, base_origin: Array, tool_rotation: Array, tool_point: Array) -> Numbers:
    """The first and the last of a solver's own frames: ``Ends`` of the core.

    Args:
        base_rotation: (3, 3) from the base to frame 1.
        base_origin: (3,) m, of frame 1 in the base.
        tool_rotation: (3, 3) from the last frame to the tip.
        tool_point: (3,) m, the point that is solved for, in the tip.
    """
    return Numbers(
        base_rotation=np.ascontiguousarray(base_rotation),
        base_origin=base_origin.copy(),
        tool_rotation=np.ascontiguousarray(tool_rotation),
        tool_point=tool_point,
    )
