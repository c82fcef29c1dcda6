#!/usr/bin/env python3
"""Arms with seven joints: all solutions at sixteen values of the redundancy parameter, against ssik.

    python benchmarks/seven_joints.py [--poses N] [--repeats R] [--seed S]

Both solve the same poses of the same URDF text in the same process; repetitions alternate and the best one counts. ssik
chooses the values of the parameter itself (sixteen swivel angles; for the Panda a number of its own in each interval),
so that the number of solutions differs: the ratios are of the time a solution takes. ``built`` is the module that
``ssik build`` generates. ssik has no call for many poses; urdf-ik's is given all of them.
"""

import argparse
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from bench import seconds
from peers import Unavailable, ssik
from robots import ZERO, Robot, Z, serial

import urdf_ik

VALUES = 16
_RIGHT = math.pi / 2

# Franka Emika: its published DH table in Craig's convention, with the flange.
PANDA = Robot(
    "Panda",
    serial(
        "panda",
        [
            ((0.0, 0.0, 0.333), ZERO),
            (ZERO, (-_RIGHT, 0.0, 0.0)),
            ((0.0, -0.316, 0.0), (_RIGHT, 0.0, 0.0)),
            ((0.0825, 0.0, 0.0), (_RIGHT, 0.0, 0.0)),
            ((-0.0825, 0.384, 0.0), (-_RIGHT, 0.0, 0.0)),
            (ZERO, (_RIGHT, 0.0, 0.0)),
            ((0.088, 0.0, 0.0), (_RIGHT, 0.0, 0.0)),
            ((0.0, 0.0, 0.107), ZERO),
        ],
        [Z] * 7,
    ),
    "spherical shoulder",
)

# KUKA LBR iiwa 14: its published lengths.
IIWA = Robot(
    "LBR iiwa 14",
    serial(
        "iiwa14",
        [
            ((0.0, 0.0, 0.1575), ZERO),
            ((0.0, 0.0, 0.2025), (_RIGHT, 0.0, math.pi)),
            ((0.0, 0.2045, 0.0), (_RIGHT, 0.0, math.pi)),
            ((0.0, 0.0, 0.2155), (_RIGHT, 0.0, 0.0)),
            ((0.0, 0.1845, 0.0), (-_RIGHT, math.pi, 0.0)),
            ((0.0, 0.0, 0.2155), (_RIGHT, 0.0, 0.0)),
            ((0.0, 0.081, 0.0), (-_RIGHT, math.pi, 0.0)),
            ((0.0, 0.0, 0.045), ZERO),
        ],
        [Z] * 7,
    ),
    "S-R-S",
)

ROBOTS = (PANDA, IIWA)


@dataclass(frozen=True)
class Row:
    """What one solver did on one arm.

    Attributes:
        robot: the arm.
        solver: the solver, and how it was called.
        us: microseconds a pose, all values of the parameter.
        solutions: solutions a pose, on average.
        worst: the greatest error of all solutions [m or rad], as Pinocchio measures it.
    """

    robot: str
    solver: str
    us: float
    solutions: float
    worst: float

    @property
    def us_each(self) -> float:
        """Microseconds a solution."""
        return self.us / self.solutions


def measure(robot: Robot, poses: int = 200, repeats: int = 7, seed: int = 0) -> list[Row]:
    """All rows of one arm; ssik's are missing where it is."""
    rng = np.random.default_rng(seed)
    targets = np.array([robot.reference.pose(q) for q in rng.uniform(-2.0, 2.0, (poses, 7))])
    arm = urdf_ik.load(robot.urdf, "base", "tool")
    assert arm.redundancy is not None
    values = np.linspace(*arm.redundancy.range, VALUES, endpoint=False)
    ways: dict[str, Callable[[], Any]] = {
        "urdf-ik, one pose a call": lambda: [arm.ik(target, redundancy=values).q for target in targets],
        "urdf-ik, all poses in one call": lambda: arm.ik(targets[:, None], redundancy=values, threads=1).q,
    }
    try:
        peer = ssik(arm)
        ways[peer.name] = lambda: [peer.solve(target) for target in targets[:20]]
    except Unavailable as reason:
        print(f"ssik: {reason}", file=sys.stderr)
    best = dict.fromkeys(ways, math.inf)
    answers = {name: work() for name, work in ways.items()}  # warms up, too
    for _ in range(repeats):
        for name, work in ways.items():
            best[name] = min(best[name], seconds(work) / len(answers[name]))
    found = {name: [_rows(answer) for answer in answers[name]] for name in ways}
    counts = {name: float(np.mean([len(q) for q in found[name]])) for name in ways}
    return [
        Row(
            robot.name,
            name,
            1e6 * best[name],
            counts[name],
            max(robot.reference.error(q, target) for qs, target in zip(found[name], targets, strict=False) for q in qs),
        )
        for name in ways
    ]


def _rows(q: np.ndarray) -> np.ndarray:
    """Solutions (k, 7) without rows of NaN."""
    flat = np.asarray(q).reshape(-1, 7)
    return flat[~np.isnan(flat).any(axis=1)]


def main(arguments: list[str] | None = None) -> int:
    """Run the comparison and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=200, help="poses (default 200)")
    parser.add_argument("--repeats", type=int, default=7, help="alternating repetitions (default 7)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the poses (default 0)")
    options = parser.parse_args(arguments)
    if options.poses < 1 or options.repeats < 1:
        parser.error("one pose and one repetition at least")
    print("| arm | solver | us a pose | solutions a pose | us a solution | worst error | times as fast |")
    print("|---|---|---:|---:|---:|---:|---:|")
    for robot in ROBOTS:
        rows = measure(robot, options.poses, options.repeats, options.seed)
        slowest = max(row.us_each for row in rows)
        for row in rows:
            print(
                f"| {row.robot} | {row.solver} | {row.us:.1f} | {row.solutions:.1f} | {row.us_each:.3f} "
                f"| {row.worst:.1e} | {slowest / row.us_each:.1f} |"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
