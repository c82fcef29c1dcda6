"""URDF text of 6R arms with a hollow wrist: seven axes, the fifth and the sixth driven by one joint."""

import numpy as np
from arms import serial_urdf
from arms_mimic import mimicking
from numpy.typing import NDArray

Array = NDArray[np.float64]

# ABB's IRB 5400 with its dimensions as published (m, rad); the wrist's angles are rounded, so that axes 4 and 7 pass
# each other at some 0.05 mm.
IRB_5400 = (
    ((0.0, 0.0, 0.0), 0.0, "0 0 1"),
    ((0.300, 0.0, 0.660), 0.0, "0 1 0"),
    ((0.0, 0.0, 1.200), 0.0, "0 1 0"),
    ((1.339, 0.0, 0.186), 0.0, "1 0 0"),
    ((0.0693, 0.0, 0.0), 0.6109, "1 0 0"),
    ((0.106246, 0.0, 0.074394), -1.2217, "1 0 0"),
    ((0.0672, 0.0, -0.0470), 0.6109, "1 0 0"),
)


def hollow(kind: str, seed: int = 0) -> str:
    """URDF text, links ``base`` and ``tool``, joints joint_1 to joint_7; joint_6 mimics joint_5.

    Args:
        kind: 'irb_5400' as published; 'mirrored', an exact and otherwise random wrist of that kind; 'one point', where
            axes 4 to 7 meet; 'half', the same with a multiplier of -0.5.
        seed: of what is random.
    """
    rng = np.random.default_rng([seed, *kind.encode()])
    rows = list(IRB_5400)
    if kind != "irb_5400":
        bend, first, middle = rng.uniform(0.45, 0.75), rng.uniform(0.05, 0.1), rng.uniform(0.1, 0.15)
        middle = 0.0 if kind in ("one point", "half") else middle
        first = 0.0 if kind in ("one point", "half") else first
        # From where axes 4 and 5 meet, along axis 5 to axis 6, and back to the line of axis 4.
        rows[1] = ((rng.uniform(-0.3, 0.3), rng.uniform(-0.1, 0.1), 0.6), 0.0, "0 1 0")
        rows[2] = ((rng.uniform(-0.1, 0.1), 0.0, rng.uniform(0.8, 1.2)), 0.0, "0 1 0")
        rows[4] = ((first, 0.0, 0.0), bend, "1 0 0")
        rows[5] = ((middle, 0.0, 0.0), -2.0 * bend, "1 0 0")
        rows[6] = ((middle, 0.0, 0.0), bend, "1 0 0")
    origins = [*((xyz, (0.0, pitch, 0.0)) for xyz, pitch, _ in rows), ((0.1, 0.02, -0.03), (0.3, 1.57079632679, 0.1))]
    axes = [tuple(map(float, axis.split())) for _, _, axis in rows]
    text = serial_urdf("hollow", origins, [*axes, None], limits=[(-6.3, 6.3)] * 8)
    return mimicking(text, 6, "joint_5", -0.5 if kind == "half" else -1.0, 0.2 if kind == "half" else 0.0)
