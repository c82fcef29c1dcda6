#!/usr/bin/env python3
"""Paths followed: waypoints a second of ``arm.follow``, against plain ladder graphs, and what plans cost.

    python benchmarks/paths.py [--waypoints N] [--ladder N] [--repeats R] [--seed S] [--boxes K] [--best]

for example ``python benchmarks/paths.py --waypoints 200 --repeats 3``. Each path moves the tip as a smooth joint motion
does. ``follow`` finds the cheapest plan (l2) over all branches and turns, every motion proven. A ladder graph, in
numpy, takes the same solutions of each waypoint, of seven joints at values of the free one a degree apart as Descartes
samples them, and goes by the same costs; it proves nothing and ignores turns. Of seven joints it sees the first
waypoints only (``--ladder``), and its rate is that of these. ``x cost``: the plan's cost over the ladder's there.

The second table adds the arm's own collision shapes and a world of boxes. ``needed``: the time of the collision queries
that every planner has to make, of the waypoints and the motions of the plan found. ``asked``: of all that were made.

The third one compares costs with the best known, by ladder graphs of 400 values of the free joint that were run once;
``--best`` runs them again (minutes, some GB of memory) and prints ``BEST``.
"""

import argparse
import math
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bench
import numpy as np

import urdf_ik
from urdf_ik.paths.path_settings import Obstacles

# Catalogue names, and joint vectors [rad] that paths go around.
ARMS: dict[str, tuple[float, ...]] = {
    "ur5": (0.3, -1.2, 1.4, -0.6, 1.1, 0.2),
    "panda": (0.2, -0.4, 0.3, -1.9, 0.2, 1.8, 0.5),
    "srs_7r": (0.2, 0.6, 0.3, -1.2, 0.2, 0.9, 0.3),
}
SIZE = 0.3  # rad, of the waves that paths are made of
DEGREE = math.radians(1.0)
FINE = 400  # values of the free joint, of the best known
FINE_WAYPOINTS = 40
# Costs of the best known, by ``python benchmarks/paths.py --best``.
BEST: dict[tuple[str, int], float] = {
    ("panda", 0): 0.25342,
    ("panda", 1): 0.186923,
    ("panda", 2): 0.249232,
    ("srs_7r", 0): 0.243427,
    ("srs_7r", 1): 0.243473,
    ("srs_7r", 2): 0.228986,
}


@dataclass(frozen=True)
class Row:
    """What one way of planning took.

    Attributes:
        arm: catalogue name.
        way: how it was planned.
        waypoints: how many there were.
        seconds: the best repetition.
        cost: of the plan.
    """

    arm: str
    way: str
    waypoints: int
    seconds: float
    cost: float

    @property
    def rate(self) -> float:
        """Waypoints a second."""
        return self.waypoints / self.seconds


def joint_path(name: str, m: int, seed: int) -> np.ndarray:
    """Joint vectors (m, n) [rad] of a smooth motion around the arm's centre."""
    rng, s = np.random.default_rng(seed), np.linspace(0.0, 1.4 * np.pi, m)[:, None]
    phases = rng.uniform(0.0, 2.0 * np.pi, (2, len(ARMS[name])))
    Q: np.ndarray = np.array(ARMS[name]) + SIZE * np.sin(s + phases[0]) + 0.5 * SIZE * np.sin(2.0 * s + phases[1])
    return Q


def ladder(arm: urdf_ik.Arm, T: np.ndarray, values: np.ndarray | None) -> float:
    """The least sum of squares of joint steps over all solutions inside the limits; infinite where there is no way."""
    low, high = arm.limits.T
    cost, before = np.zeros(0), np.empty((0, arm.dof))
    solved = arm.ik(T) if values is None else None
    for k, pose in enumerate(T):
        if solved is not None:
            q = solved.q[k][solved.valid[k]]
        else:
            s = arm.ik(np.tile(pose, (len(values), 1, 1)), redundancy=values)
            q = s.q[s.valid]
        q = q[((q >= low) & (q <= high)).all(axis=1)]
        if not len(q):
            return math.inf
        if k == 0:
            cost = np.zeros(len(q))
        else:
            # |a - b|^2 = |a|^2 + |b|^2 - 2 a b, a product of matrices.
            squares = (before**2).sum(axis=1)[:, None] + (q**2).sum(axis=1) - 2.0 * before @ q.T
            cost = (cost[:, None] + squares.clip(0.0)).min(axis=0)
        before = q
    return float(cost.min())


def grid(arm: urdf_ik.Arm, step: float) -> np.ndarray | None:
    """Values of the redundancy parameter a step apart; None for an arm without one."""
    if arm.redundancy is None:
        return None
    low, high = arm.redundancy.range
    return np.arange(low, high, step)


def free_paths(name: str, m: int, first: int, repeats: int, seed: int) -> list[Row]:
    """Rows without a world, the first ones of the ladder at the first waypoints."""
    arm = urdf_ik.load(name)
    T = arm.fk(joint_path(name, m, seed))
    values = grid(arm, DEGREE)
    first = m if values is None else first
    best: dict[str, float] = {"follow": math.inf, "ladder": math.inf}
    for k in range(repeats):
        best["follow"] = min(best["follow"], bench.seconds(lambda: arm.follow(T, collisions=False)))
        if values is None or k == 0:
            best["ladder"] = min(best["ladder"], bench.seconds(lambda: ladder(arm, T[:first], values)))
    plan, short = arm.follow(T, collisions=False), arm.follow(T[:first], collisions=False)
    assert plan.found, plan.explain()
    way = "ladder, the same solutions" if values is None else "ladder, 1 degree"
    return [
        Row(name, "follow", m, best["follow"], short.cost),
        Row(name, way, first, best["ladder"], ladder(arm, T[:first], values)),
    ]


def boxes(arm: urdf_ik.Arm, Q: np.ndarray, count: int, seed: int) -> urdf_ik.World:
    """A world of boxes around the arm, none nearer to the joint motion Q (m, n) than 2 cm."""
    rng, world = np.random.default_rng(seed), urdf_ik.World()
    some = Q[:: max(1, len(Q) // 40)]
    between_links = arm.clearance(some)
    while len(world) < count:
        pose = urdf_ik.pose(rng.uniform(-1.0, 1.0, 3) * (1.0, 1.0, 0.9) + (0.0, 0.0, 0.4), rpy=rng.uniform(-3, 3, 3))
        box = urdf_ik.Box(tuple(rng.uniform(0.05, 0.3, 3)))
        one = urdf_ik.World()
        one.add("box", box, pose)
        if (arm.clearance(some, world=one) >= np.minimum(between_links, 0.02)).all():
            world.add(f"box {len(world)}", box, pose)
    return world


@contextmanager
def clocked() -> Iterator[dict[str, float]]:
    """Seconds and numbers of the collision queries that are made meanwhile."""
    spent = {"seconds": 0.0, "joint vectors": 0.0, "motions": 0.0}
    free, motions_free = Obstacles.free, Obstacles.motions_free

    def timed_free(self: Obstacles, q: np.ndarray) -> np.ndarray:
        start = time.perf_counter()
        answer = free(self, q)
        spent["seconds"] += time.perf_counter() - start
        spent["joint vectors"] += len(q)
        return answer

    def timed_motions(self: Obstacles, q0: np.ndarray, q1: np.ndarray) -> np.ndarray:
        start = time.perf_counter()
        answer = motions_free(self, q0, q1)
        spent["seconds"] += time.perf_counter() - start
        spent["motions"] += len(q0)
        return answer

    Obstacles.free, Obstacles.motions_free = timed_free, timed_motions  # type: ignore[method-assign]
    try:
        yield spent
    finally:
        Obstacles.free, Obstacles.motions_free = free, motions_free  # type: ignore[method-assign]


def in_a_cell(name: str, m: int, count: int, repeats: int, seed: int) -> str:
    """A table's row: the arm's shapes and a world of boxes."""
    arm = urdf_ik.load(name)
    Q = joint_path(name, m, seed)
    T, world = arm.fk(Q), boxes(arm, Q, count, seed)
    model = Obstacles(arm.cell.collisions.in_world(world), 0.0)
    best, needed, asked = math.inf, math.inf, {}
    for _ in range(repeats):
        with clocked() as spent:
            start = time.perf_counter()
            plan = arm.follow(T, world=world)
            seconds = time.perf_counter() - start
        if not plan.found:
            return f"| {name} | {m} | no plan: {plan.stops[0]} |"
        if seconds < best:
            best, asked = seconds, dict(spent)

        def least() -> None:
            model.free(plan.q)  # noqa: B023 - called at once
            model.motions_free(plan.motion[:-1], plan.motion[1:])  # noqa: B023

        needed = min(needed, bench.seconds(least))
    return (
        f"| {name} | {m} | {1e3 * best:.0f} | {m / best:.0f} | {1e3 * needed:.0f} | {best / needed:.2f} "
        f"| {1e3 * asked['seconds']:.0f} | {asked['joint vectors']:.0f} + {asked['motions']:.0f} |"
    )


def best_known(name: str, seed: int) -> float:
    """The cost of the best way over a grid of ``FINE`` values."""
    arm = urdf_ik.load(name)
    T = arm.fk(joint_path(name, FINE_WAYPOINTS, seed))
    assert arm.redundancy is not None  # only such arms are asked for
    return ladder(arm, T, np.linspace(*arm.redundancy.range, FINE))


def main(arguments: list[str] | None = None) -> int:
    """Run the comparison and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waypoints", type=int, default=1000, help="waypoints of a path (default 1000)")
    parser.add_argument("--ladder", type=int, default=20, help="of these, seen by the ladder graphs (default 20)")
    parser.add_argument("--repeats", type=int, default=5, help="alternating repetitions, the best counts (default 5)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the paths and the worlds (default 0)")
    parser.add_argument("--boxes", type=int, default=20, help="boxes of a world (default 20)")
    parser.add_argument("--best", action="store_true", help="only run the grids of the best known costs again")
    options = parser.parse_args(arguments)
    if not 2 <= options.ladder <= options.waypoints or options.repeats < 1 or options.boxes < 1:
        parser.error("two waypoints for the ladder at least and no more than the path has, one repetition, one box")
    redundant = [name for name in ARMS if urdf_ik.load(name).redundancy is not None]
    if options.best:
        print({(name, seed): round(best_known(name, seed), 6) for name in redundant for seed in range(3)})
        return 0
    print("| arm, without a world | planned by | waypoints | ms | waypoints a second | times as fast | x cost |")
    print("|---|---|---:|---:|---:|---:|---:|")
    for name in ARMS:
        rows = free_paths(name, options.waypoints, options.ladder, options.repeats, options.seed)
        for row in rows:
            print(
                f"| {row.arm} | {row.way} | {row.waypoints} | {1e3 * row.seconds:.0f} | {row.rate:.0f} "
                f"| {row.rate / rows[-1].rate:.1f} | {row.cost / rows[-1].cost:.3f} |",
                flush=True,
            )
    columns = ("waypoints", "ms", "waypoints a second", "needed [ms]", "x needed", "asked [ms]", "vectors + motions")
    print(f"\n| arm, in a cell | {' | '.join(columns)} |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for name in ARMS:
        print(in_a_cell(name, options.waypoints, options.boxes, min(options.repeats, 3), options.seed), flush=True)
    print(f"\n| arm | seed | cost | best of {FINE} values | x best |")
    print("|---|---:|---:|---:|---:|")
    for (name, seed), cost in BEST.items():
        arm = urdf_ik.load(name)
        plan = arm.follow(arm.fk(joint_path(name, FINE_WAYPOINTS, seed)), collisions=False)
        print(f"| {name} | {seed} | {plan.cost:.5f} | {cost:.5f} | {plan.cost / cost:.3f} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
