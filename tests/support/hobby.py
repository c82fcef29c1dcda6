"""A hobby arm of five servos, with decimals as CAD exporters write them, and what scipy finds for it."""

import numpy as np
from cases import Case
from chains import joint, robot
from numpy.typing import NDArray
from scipy.optimize import minimize

Array = NDArray[np.float64]
_JOINTS = (
    ("pan", "0.0388 0 0.0624", "0 0 1", 1.92),
    ("lift", "0.0304 0 0.0542", "0 1 0", 1.75),
    ("elbow", "0.028 0 0.1126", "0 1 0", 1.69),
    ("flex", "0.1349 0 0.0052", "0 1 0", 1.66),
    ("roll", "0.0611 0.0002 0", "1 0 0", 2.74),
)
LIMITS = '<limit lower="{}" upper="{}" effort="10" velocity="5"/>'
LINKS = ("base", "turret", "upper", "lower", "wrist", "jaw")


def urdf_of(joints: tuple[tuple[str, str, str, float], ...], tip: str) -> str:
    """Arm of joints (name, xyz, axis, limit), and the xyz of its tip, 'tool', behind them."""
    rows = [
        joint(name, "revolute", *LINKS[k : k + 2], xyz, axis=axis, more=LIMITS.format(-limit, limit))
        for k, (name, xyz, axis, limit) in enumerate(joints)
    ]
    return robot(*rows, joint("grip", "fixed", LINKS[len(joints)], "tool", tip, "0 1.5708 0"))


URDF = urdf_of(_JOINTS, "0.0981 -0.0002 0")

BESIDE = urdf_of(_JOINTS, "0.0981 0.0001 -0.008")
PAN, LIFT, ELBOW, FLEX, _ = _JOINTS
SPLIT = {
    "yaw, plane, roll": urdf_of((PAN, LIFT, ELBOW, FLEX, ("roll", "0.0611 0 0", "1 0 0", 2.74)), "0.0981 0 0"),
    "plane aside": urdf_of((PAN, ("lift", "0.03 0.012 0.054", "0 1 0", 1.75), ELBOW, FLEX), "0.11 0 0.02"),
    "wrist": urdf_of(
        (PAN, LIFT, ELBOW, ("roll", "0.08 0 0", "1 0 0", 2.7), ("bend", "0.06 0 0", "0 1 0", 1.7)), "0 0 0"
    ),
    "skew, roll": urdf_of(
        (PAN, ("lift", "0.03 0.02 0.05", "0.6 0.8 0", 2.0), ("elbow", "0.1 0 0.1", "0 0.28 0.96", 2.0), FLEX), "0 0 0"
    ),
}
"""Arms whose nearest postures have a closed form."""


def angle_between(A: Array, B: Array) -> float:
    """rad, between rotations (3, 3)."""
    return 2.0 * float(np.arcsin(min(1.0, np.linalg.norm(A - B) / np.sqrt(8.0))))


def least_angle(case: Case, T: Array, starts: Array, bounds: Array | None) -> float:
    """The least angle [rad] that scipy's SLSQP finds from ``starts`` with the tip at the position of T."""

    def chord(q: Array) -> float:
        return 3.0 - float(np.sum(case.oracle.pose(q)[:3, :3] * T[:3, :3]))

    place = {"type": "eq", "fun": lambda q: 3.0 * (case.oracle.pose(q)[:3, 3] - T[:3, 3])}
    least = np.inf
    for start in starts:
        answer = minimize(
            chord, start, method="SLSQP", constraints=[place], bounds=bounds, options={"maxiter": 200, "ftol": 1e-14}
        )
        reached = case.oracle.pose(answer.x)
        if np.linalg.norm(reached[:3, 3] - T[:3, 3]) < 1e-8:
            least = min(least, angle_between(reached[:3, :3], T[:3, :3]))
    return least
