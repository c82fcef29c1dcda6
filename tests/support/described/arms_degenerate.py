"""URDF text of arms whose neighbouring axes are one, parallel, meeting or skew as it comes."""

import numpy as np
from arms_few import few_urdf

import urdf_ik

Array = np.typing.NDArray[np.float64]
_HALF = 0.5


def random_degenerate(rng: np.random.Generator) -> str:
    """Four to seven joints, a tenth of which slide; half of the axes keep the direction of the one before."""
    n = int(rng.integers(4, 8))
    kinds = "".join("P" if rng.random() < 0.1 else "R" for _ in range(n))
    axes, points = [np.array([0.0, 0.0, 1.0])], [np.zeros(3)]
    for _ in range(n - 1):
        keeps = rng.random() < _HALF
        other = np.eye(3)[rng.integers(3)] if rng.random() < _HALF else rng.normal(size=3)
        axes.append(rng.choice([-1.0, 1.0]) * axes[-1] if keeps else other / np.linalg.norm(other))
        away = rng.choice([0.0, 0.0, 1e-18, 1.0]) * rng.uniform(0.1, 0.3, 3) + rng.choice([0.0, 0.2]) * axes[-1]
        points.append(points[-1] + away)
    return few_urdf(kinds, np.array(axes), np.array(points), points[-1] + rng.choice([0.0, 0.1]), rng)


def planted(arm: urdf_ik.Arm, rng: np.random.Generator, m: int) -> Array:
    """Joint vectors (m, n) of an arm: one half at random, the other at right angles."""
    Q = rng.uniform(-np.pi, np.pi, (m, arm.dof))
    Q[m // 2 :] = rng.integers(-1, 3, (m - m // 2, arm.dof)) * np.pi / 2.0
    slides = arm.chain.prismatic
    Q[:, slides] *= 0.3 * arm.chain.size / np.pi
    return Q
