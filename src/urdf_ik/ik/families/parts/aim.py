"""What is asked for of the tip: a pose, or less of it where the joints control less."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.ik.families.parts.values import written_values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.kinematics.chain import Chain

    Array = NDArray[np.float64]

# What is asked for of the tip, in the order of the compiled solvers' ``Task``.
POSE, POSITION, AXIS, PLANAR_POSITION, PLANAR_POSE = range(5)


@dataclass(frozen=True)
class Aim:
    """What is asked for of the tip: ``kind``, the tip's axis that is aimed, in the tip, the plane's normal."""

    kind: int = POSE
    axis: Array | None = None
    normal: Array | None = None

    def written(self, chain: Chain) -> dict[str, Any]:
        """The arm as the URDF has it, and what is asked for, as the compiled solvers take them."""
        values = written_values(chain) | {"task": self.kind}
        for name, vector in (("aimed", self.axis), ("normal", self.normal)):
            if vector is not None:
                values[name] = np.array(vector, dtype=np.float64)
        return values
