"""Times of a UR5 among many obstacles: building a world, moving a body, clearances and motions.

    python benchmarks/worlds.py [--boxes 10 1000 100000] [--large]

The boxes, 5 cm on a side, fill a hall of 20 m x 20 m x 6 m but for a ball of 1.3 m about the arm's base. Each time is
the median of many calls: processor time, in ms. ``--large`` adds a cloud of 10 million points and a mesh of 2 million
triangles.
"""

from __future__ import annotations

import argparse
import itertools
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import urdf_ik

HALL, FREE, SIDE = np.array([10.0, 10.0, 3.0]), 1.3, 0.05
COLUMNS = ("build", "first query", "move", "move, query", "clearance", "0.2 rad", "1 rad", "follow")


def milliseconds(call: Callable[[], object], repeats: int) -> float:
    """Median processor time of a call [ms]."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return 1e3 * float(np.median(times))


def places(count: int, rng: np.random.Generator) -> np.ndarray:
    """Poses (count, 4, 4) of boxes in the hall, none within the free ball."""
    at = rng.uniform(-1.0, 1.0, (2 * count + 100, 3)) * HALL
    at = at[np.linalg.norm(at, axis=1) > FREE][:count]
    return urdf_ik.pose(at, rpy=rng.uniform(-3.0, 3.0, at.shape))


def joint_vectors(arm: urdf_ik.Arm, rng: np.random.Generator) -> np.ndarray:
    """Joint vectors (k, 6) at which the arm is clear of itself."""
    q = rng.uniform(-1.5, 1.5, (200, 6))
    return q[np.asarray(arm.clearance(q)) > 0.01]


def row(arm: urdf_ik.Arm, world: urdf_ik.World, q: np.ndarray, build: float, moves: np.ndarray) -> list[float]:
    """One row of the table, in the order of ``COLUMNS``."""
    name, turn = world.names[0], itertools.count()

    def move() -> None:
        world.move(name, moves[next(turn) % len(moves)])

    def moved_clearance() -> None:
        move()
        arm.clearance(q[0], world)

    def clearance() -> None:
        arm.clearance(q[next(turn) % len(q)], world)

    def motion(way: float) -> None:
        start = q[next(turn) % len(q)]
        arm.motion_is_free(start, start + way / 6.0**0.5, world)

    first = milliseconds(lambda: arm.clearance(q[0], world), 1)
    line = urdf_ik.line(arm.fk(q[0]), arm.fk(q[0] + 0.05), 10)
    return [
        build,
        first,
        milliseconds(move, 200),
        milliseconds(moved_clearance, 50),
        milliseconds(clearance, 200),
        milliseconds(lambda: motion(0.2), 50),
        milliseconds(lambda: motion(1.0), 20),
        milliseconds(lambda: arm.follow(line, start=q[0], world=world), 3),
    ]


def wavy_mesh(path: Path, side: int) -> None:
    """Write a binary PLY of 2 side^2 triangles: a wavy floor, 4 m on a side."""
    x, y = np.meshgrid(*[np.linspace(-2.0, 2.0, side + 1)] * 2, indexing="ij")
    points = np.stack([x, y, 0.05 * np.sin(9 * x) * np.cos(7 * y) - 0.4], axis=-1).reshape(-1, 3).astype("<f4")
    index = np.arange((side + 1) ** 2).reshape(side + 1, side + 1)
    a, b, c, d = (each.ravel() for each in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    faces = np.empty(2 * side**2, dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    lines = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(points)}",
        *(f"property float {axis}" for axis in "xyz"),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    path.write_bytes("\n".join(lines).encode() + points.tobytes() + faces.tobytes())


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--boxes", type=int, nargs="+", default=[10, 1000, 100_000])
    parser.add_argument("--large", action="store_true")
    given = parser.parse_args()
    arm, rng = urdf_ik.load("ur5"), np.random.default_rng(0)
    q = joint_vectors(arm, rng)
    print(f"UR5, times in ms; clearance without a world {milliseconds(lambda: arm.clearance(q[0]), 200):.3f}")
    print(f"{'world':>16}" + "".join(f"{name:>12}" for name in COLUMNS))

    def show(name: str, values: list[float]) -> None:
        print(f"{name:>16}" + "".join(f"{value:12.3f}" for value in values), flush=True)

    for count in given.boxes:
        poses, world = places(count, rng), urdf_ik.World()
        start = time.process_time()
        for i, pose in enumerate(poses):
            world.add(f"box {i}", urdf_ik.Box(SIDE), pose)
        build = 1e3 * (time.process_time() - start)
        show(f"{count} boxes", row(arm, world, q, build, poses))
    if not given.large:
        return
    lowered = np.tile(np.eye(4), (20, 1, 1))
    lowered[:, 2, 3] = np.linspace(0.0, -0.1, 20)
    with tempfile.TemporaryDirectory() as folder:
        wavy_mesh(Path(folder) / "floor.ply", 1000)
        directions = rng.normal(size=(10_000_000, 3))
        directions *= (rng.uniform(FREE, 2.0, len(directions)) / np.linalg.norm(directions, axis=1))[:, None]
        shapes: dict[str, Callable[[], urdf_ik.Mesh | urdf_ik.Points]] = {
            "2M triangles": lambda: urdf_ik.Mesh(Path(folder) / "floor.ply"),
            "10M points": lambda: urdf_ik.Points(directions, 0.005),
        }
        for name, make in shapes.items():
            world = urdf_ik.World()
            start = time.process_time()
            world.add("it", make())
            show(name, row(arm, world, q, 1e3 * (time.process_time() - start), lowered))


if __name__ == "__main__":
    main()
