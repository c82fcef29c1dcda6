#!/usr/bin/env python3
"""Narrow windows: of how many poses each way finds a solution inside the joint limits, and how long that takes.

    python benchmarks/intervals.py [--poses N] [--seed S]

The poses are made from random joint vectors of which one joint stands within 2 % of its range from a limit, so that
each has a solution inside the limits, often for a small part of the redundancy parameter's values only. ``grid`` solves
at as many values as it says and takes what is inside; frankik, which knows the Panda only, solves at 60 values of joint
7 over its whole range; ssik's ``self_motion`` gives its arcs inside the limits. Times are those of one process, a pose
at a time where there is no call for many.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from seven_joints import IIWA, PANDA

import urdf_ik

try:
    import frankik
except ImportError:
    frankik = None

LIMITS = {
    # Published limits [rad]: Franka Emika's data sheet, KUKA's for the LBR iiwa.
    "Panda": [(-2.8973, 2.8973), (-1.7628, 1.7628), (-2.8973, 2.8973), (-3.0718, -0.0698), (-2.8973, 2.8973),
              (-0.0175, 3.7525), (-2.8973, 2.8973)],
    "LBR iiwa 14": [(-2.96706, 2.96706), (-2.0944, 2.0944)] * 3 + [(-3.05433, 3.05433)],
}  # fmt: skip
NEAR = 0.02
_WHOLE = 'lower="-3.1415926535897931" upper="3.1415926535897931"'


def limited(text: str, limits: list[tuple[float, float]]) -> str:
    """The URDF text with these limits, joint by joint."""
    for low, high in limits:
        text = text.replace(_WHOLE, f'lower="{low}" upper="{high}"', 1)
    return text


def near_limits(arm: urdf_ik.Arm, rng: np.random.Generator, count: int) -> np.ndarray:
    """Joint vectors (count, n) of which one joint is within ``NEAR`` of its range from a limit."""
    low, high = arm.limits.T
    q = rng.uniform(low, high, (count, arm.dof))
    joint, upper = rng.integers(arm.dof, size=count), rng.integers(2, size=count) == 1
    away = NEAR * rng.uniform(size=count) * (high - low)[joint]
    q[np.arange(count), joint] = np.where(upper, high[joint] - away, low[joint] + away)
    return q


def ways(robot: str, arm: urdf_ik.Arm, text: str) -> dict[str, Callable[[np.ndarray], list[bool]]]:
    """Names of ways, and what says of poses (m, 4, 4) whether each has a solution inside the limits."""

    def grid(count: int) -> Callable[[np.ndarray], list[bool]]:
        assert arm.redundancy is not None
        values = np.linspace(*arm.redundancy.range, count, endpoint=not arm.redundancy.round)
        return lambda T: [bool(arm.ik(pose, redundancy=values).within_limits().count.any()) for pose in T]

    def sampled(T: np.ndarray) -> list[bool]:
        return [bool(frankik.ik_sample_q7(pose, None, False, 60, 332.0, True)) for pose in T @ at_hand]

    found: dict[str, Callable[[np.ndarray], list[bool]]] = {
        "urdf-ik, intervals": lambda T: (arm.intervals(T).count > 0).tolist(),
        "urdf-ik, grid of 16": grid(16),
        "urdf-ik, grid of 256": grid(256),
        "urdf-ik, grid of 4096": grid(4096),
    }
    if robot == PANDA.name and frankik is not None:
        # Its end effector is the hand's, 0.1034 m beyond the flange.
        at_hand = np.linalg.inv(arm.fk(np.zeros(7))) @ frankik.fk(np.zeros(7))
        found[f"frankik {frankik.__version__}, 60 values"] = sampled
    try:
        import ssik
    except ImportError:
        print("ssik is not installed", file=sys.stderr)
        return found
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "arm.urdf")
        path.write_text(text)
        bot: Any = ssik.Manipulator.from_urdf(path, base="base", ee="tool")

    def arcs(T: np.ndarray) -> list[bool]:
        return [any(chart.in_limits() for chart in bot.self_motion(pose).charts) for pose in T]

    found[f"ssik {ssik.__version__}, arcs"] = arcs
    return found


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print("| arm | way | poses with a solution found | us a pose |")
    print("|---|---|---:|---:|")
    for robot in (PANDA, IIWA):
        text = limited(robot.urdf, LIMITS[robot.name])
        arm = urdf_ik.load(text, "base", "tool")
        T = arm.fk(near_limits(arm, np.random.default_rng(options.seed), options.poses))
        for name, way in ways(robot.name, arm, text).items():
            way(T[:2])
            start = time.perf_counter()
            found = way(T)
            us = (time.perf_counter() - start) / len(T) * 1e6
            print(f"| {robot.name} | {name} | {sum(found)} of {len(T)} | {us:,.0f} |", flush=True)


if __name__ == "__main__":
    main()
