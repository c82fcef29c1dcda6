#!/usr/bin/env python3
"""Narrow windows: of how many poses each way finds a solution inside the joint limits, and how long that takes.

    python benchmarks/intervals.py [--poses N] [--seed S] [--scan N] [--urdf FILE --base LINK --tip LINK]

The poses are made from random joint vectors of which one joint stands within 2 % of its range from a limit, so that
each has a solution inside the limits, often for a small part of the redundancy parameter's values only. ``grid`` solves
at as many values as it says and takes what is inside; frankik, which knows the Panda only, solves at 60 values of joint
7 over its whole range; ssik's ``self_motion`` gives its arcs inside the limits. Times are those of one process, a pose
at a time where there is no call for many.

``--scan`` looks at that many of these poses every 1e-4 rad or m instead, and counts the values at which there are more
or fewer solutions inside the limits than intervals that hold the value. Values within 2e-6 of an end are left out.
``--urdf`` names another arm with one redundancy parameter.
"""

import argparse
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import numpy as np
from peers import Unavailable, frankik, ssik_robot
from seven_joints import IIWA, PANDA

import urdf_ik

LIMITS = {
    # Published limits [rad]: Franka Emika's data sheet, KUKA's for the LBR iiwa.
    "Panda": [(-2.8973, 2.8973), (-1.7628, 1.7628), (-2.8973, 2.8973), (-3.0718, -0.0698), (-2.8973, 2.8973),
              (-0.0175, 3.7525), (-2.8973, 2.8973)],
    "LBR iiwa 14": [(-2.96706, 2.96706), (-2.0944, 2.0944)] * 3 + [(-3.05433, 3.05433)],
}  # fmt: skip
NEAR = 0.02
STEP, AT_END = 1e-4, 2e-6
_WHOLE = 'lower="-3.1415926535897931" upper="3.1415926535897931"'


def limited(text: str, limits: list[tuple[float, float]]) -> str:
    """The URDF text with these limits, joint by joint."""
    for low, high in limits:
        text = text.replace(_WHOLE, f'lower="{low}" upper="{high}"', 1)
    return text


def near_limits(arm: urdf_ik.Arm, rng: np.random.Generator, count: int) -> np.ndarray:
    """Joint vectors (count, n) of which one joint is within ``NEAR`` of its range from a limit."""
    low, high = np.clip(arm.limits.T, -2.0 * np.pi, 2.0 * np.pi)  # joints that turn without end
    q = rng.uniform(low, high, (count, arm.dof))
    joint, upper = rng.integers(arm.dof, size=count), rng.integers(2, size=count) == 1
    away = NEAR * rng.uniform(size=count) * (high - low)[joint]
    q[np.arange(count), joint] = np.where(upper, high[joint] - away, low[joint] + away)
    return q


def ways(robot: str, arm: urdf_ik.Arm) -> dict[str, Callable[[np.ndarray], list[bool]]]:
    """Names of ways, and what says of poses (m, 4, 4) whether each has a solution inside the limits."""

    def grid(count: int) -> Callable[[np.ndarray], list[bool]]:
        assert arm.redundancy is not None
        values = np.linspace(*arm.redundancy.range, count, endpoint=not arm.redundancy.round)
        return lambda T: [bool(arm.ik(pose, redundancy=values).within_limits().count.any()) for pose in T]

    found: dict[str, Callable[[np.ndarray], list[bool]]] = {
        "urdf-ik, intervals": lambda T: (arm.intervals(T).count > 0).tolist(),
        "urdf-ik, grid of 16": grid(16),
        "urdf-ik, grid of 256": grid(256),
        "urdf-ik, grid of 4096": grid(4096),
    }
    try:
        if robot == PANDA.name:
            sampled = frankik(arm)
            found[f"{sampled.name}, 60 values"] = lambda T: [len(sampled.solve(pose)) > 0 for pose in T]
        bot = ssik_robot(arm)
        found[f"ssik {version('ssik')}, arcs"] = lambda T: [
            any(chart.in_limits() for chart in bot.self_motion(pose).charts) for pose in T
        ]
    except Unavailable as reason:
        print(f"other solvers: {reason}", file=sys.stderr)
    return found


def scan(arm: urdf_ik.Arm, T: np.ndarray) -> tuple[int, int, int]:
    """Solutions inside the limits at all values, values with more of them than intervals, and values with fewer."""
    parameter = arm.redundancy
    assert parameter is not None
    low, high = (-np.pi, np.pi) if parameter.round else parameter.range
    values = np.arange(low, high, STEP)
    solutions = missing = extra = 0
    for pose in T:
        holding, at_end = np.zeros(len(values), dtype=int), np.zeros(len(values), dtype=bool)
        for interval in arm.intervals(pose):
            for turn in (0.0, 2.0 * np.pi) if parameter.unit == "rad" else (0.0,):
                there = values + turn
                holding += (there >= interval.low) & (there <= interval.high)
                at_end |= (np.abs(there - interval.low) < AT_END) | (np.abs(there - interval.high) < AT_END)
        parts = np.array_split(values, len(values) // 8192 + 1)
        count = np.concatenate([arm.ik(pose, redundancy=part).within_limits().count for part in parts])
        solutions += int(count.sum())
        missing += int((count > holding)[~at_end].sum())
        extra += int((count < holding)[~at_end].sum())
    return solutions, missing, extra


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--scan", type=int, metavar="N", help="scan this many poses every 1e-4 rad or m")
    parser.add_argument("--urdf", type=Path, help="another arm; default: the Panda and the LBR iiwa 14")
    parser.add_argument("--base", help="base link of --urdf")
    parser.add_argument("--tip", help="tip link of --urdf")
    options = parser.parse_args()
    texts = {robot.name: (limited(robot.urdf, LIMITS[robot.name]), "base", "tool") for robot in (PANDA, IIWA)}
    if options.urdf is not None:
        texts = {options.urdf.stem: (options.urdf.read_text(), options.base, options.tip)}
    if options.scan is not None:
        print("| arm | poses | solutions at all values | values with more | values with fewer |")
        print("|---|---:|---:|---:|---:|")
    else:
        print("| arm | way | poses with a solution found | us a pose |")
        print("|---|---|---:|---:|")
    for name, (text, base, tip) in texts.items():
        arm = urdf_ik.load(text, base, tip)
        poses = options.scan or options.poses
        T = arm.fk(near_limits(arm, np.random.default_rng(options.seed), poses))
        if options.scan is not None:
            solutions, missing, extra = scan(arm, T)
            print(f"| {name} | {poses} | {solutions:,} | {missing} | {extra} |", flush=True)
            continue
        for way, find in ways(name, arm).items():
            find(T[:2])
            start = time.perf_counter()
            found = find(T)
            us = (time.perf_counter() - start) / len(T) * 1e6
            print(f"| {name} | {way} | {sum(found)} of {len(T)} | {us:,.0f} |", flush=True)


if __name__ == "__main__":
    main()
