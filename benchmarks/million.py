#!/usr/bin/env python3
"""Count what urdf-ik loses: a million poses an arm, every returned solution measured by Pinocchio.

    python benchmarks/million.py [--md] [--poses N] [--processes P] [--seed S] [--robot NAME ...]

For each arm joint vectors are drawn, nine tenths over the whole torus, one tenth at multiples of 90 degrees, exactly or
1e-12 to 1e-2 rad beside, where the Jacobian is regular; Pinocchio makes their poses. Counted are planted joint vectors
that are not among the solutions, poses whose answers are not certain to be complete, and pairs of solutions that are
one; the greatest errors are those of all
solutions of all poses, each through Pinocchio's own forward kinematics. What was lost is printed with its joint vector.
Poses are drawn and solved in chunks, so memory does not grow with their number, and any number of processes gives the
same counts. The status is 1 when something was lost, doubled or off by more than 1e-9 m or rad.
"""

import argparse
import multiprocessing
import sys
import time
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from robots import CALIBRATED_UR10E, CRX, HC10, KINOVA, RANDOM_6R, ReferenceModel

CHUNK = 1000  # poses
EXACT = 1e-9  # m and rad: the contract of ik
SAME = 1e-6  # rad, where the Jacobian is well conditioned
DUPLICATE = 1e-8  # rad
MANY, FEW = 1_000_000, 10_000
ROUND = 10  # one of so many poses is round
REGULAR = 0.01  # least singular value of a round joint vector, lengths in m

# Name, what urdf_ik.load takes (None: the robot of that name in robots.py), and how many poses.
ARMS = {
    "z y y z y z": ("zyyzyz_6r", MANY),
    "UR5": ("ur5", MANY),
    CALIBRATED_UR10E.name: (CALIBRATED_UR10E.urdf, MANY),
    KINOVA.name: (KINOVA.urdf, FEW),
    CRX.name: (CRX.urdf, FEW),
    HC10.name: (HC10.urdf, FEW),
    RANDOM_6R.name: (RANDOM_6R.urdf, FEW),
}


@dataclass
class Tally:
    """What was found on some poses of an arm.

    Attributes:
        poses: how many.
        solutions: how many solutions were returned, each of them measured.
        lost: planted joint vectors (6,) [rad] that are not among the solutions, each with the distance [rad] to the
            nearest one and the Jacobian's smallest singular value.
        uncertain: poses whose answers are not certain to be complete.
        duplicates: pairs of solutions that are one.
        position: greatest position error [m].
        rotation: greatest rotation error [rad].
        seconds: time that the solver took, of the reference's not a part.
    """

    poses: int = 0
    solutions: int = 0
    lost: list[tuple[np.ndarray, float, float]] = field(default_factory=list)
    uncertain: int = 0
    duplicates: int = 0
    position: float = 0.0
    rotation: float = 0.0
    seconds: float = 0.0

    def add(self, other: "Tally") -> None:
        """Count other poses in."""
        self.poses += other.poses
        self.solutions += other.solutions
        self.lost += other.lost
        self.uncertain += other.uncertain
        self.duplicates += other.duplicates
        self.position = max(self.position, other.position)
        self.rotation = max(self.rotation, other.rotation)
        self.seconds += other.seconds

    @property
    def passed(self) -> bool:
        """Whether the contract holds."""
        return not self.lost and not self.duplicates and max(self.position, self.rotation) <= EXACT


@lru_cache(maxsize=1)
def _prepared(name: str) -> tuple[Any, ReferenceModel]:
    """The arm and Pinocchio's model of the same URDF; once a process."""
    import urdf_ik

    source, _ = ARMS[name]
    arm = urdf_ik.load(source)
    arm.ik(arm.fk(np.zeros(6)))  # loads the kernels, which is not to be timed
    return arm, ReferenceModel(arm.model.xml.decode(), arm.base, arm.tip)


def measure(task: tuple[str, int, int, int]) -> Tally:
    """One chunk: (arm's name, seed, number of the chunk, poses in it)."""
    name, seed, chunk, size = task
    arm, reference = _prepared(name)
    Q = _drawn(arm, np.random.default_rng([seed, chunk]), size)
    T = reference.poses(Q)
    start = time.perf_counter()
    solutions = arm.ik(T)
    seconds = time.perf_counter() - start
    q, valid = np.asarray(solutions.q), np.asarray(solutions.valid)
    pose_of, _ = np.nonzero(valid)
    position, rotation = _errors(reference.poses(q[valid]), T[pose_of])
    gap = np.where(valid, _apart(q, Q[:, None]), np.inf).min(axis=1)
    lost = []
    for i in np.flatnonzero(gap > SAME):
        # Near a singularity rounding in the pose moves the solutions by more: by 1e-11 over the conditioning.
        sigma = reference.sigma_min(Q[i])
        if gap[i] > SAME + min(1e-11 / max(sigma, 1e-300), 1e-2):
            lost.append((Q[i], float(gap[i]), sigma))
    return Tally(
        poses=size,
        solutions=len(pose_of),
        lost=lost,
        uncertain=int(np.count_nonzero(~solutions.certain)),
        duplicates=_duplicates(q),
        position=float(position.max(initial=0.0)),
        rotation=float(rotation.max(initial=0.0)),
        seconds=seconds,
    )


def _drawn(arm: Any, rng: np.random.Generator, size: int) -> np.ndarray:
    """(size, 6) rad: joint vectors all over the torus, then round ones."""
    Q = rng.uniform(-np.pi, np.pi, (size, 6))
    candidates = rng.integers(-1, 3, (size, 6)) * (np.pi / 2.0)
    regular = np.linalg.svd(arm.jacobian(candidates), compute_uv=False)[:, -1] > REGULAR
    chosen = candidates[regular][: size // ROUND]
    noise = 10.0 ** rng.uniform(-12.0, -2.0, (len(chosen), 1)) * rng.integers(0, 2, (len(chosen), 1))
    if len(chosen):
        Q[-len(chosen) :] = chosen + noise * rng.uniform(-1.0, 1.0, chosen.shape)
    return Q


def _apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Largest angle (...) [rad] between joint vectors (..., 6), modulo 2 pi; NaN where one of them is."""
    apart: np.ndarray = np.abs((a - b + np.pi) % (2.0 * np.pi) - np.pi).max(axis=-1)
    return apart


def _duplicates(q: np.ndarray) -> int:
    """Number of pairs of solutions (m, B, 6) that are one."""
    pairs = ((i, j) for j in range(q.shape[1]) for i in range(j))
    return int(sum(np.count_nonzero(_apart(q[:, i], q[:, j]) < DUPLICATE) for i, j in pairs))


def _errors(ours: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position [m] and rotation [rad] (k,) between poses (k, 4, 4)."""
    turn = np.swapaxes(ours[:, :3, :3], 1, 2) @ wanted[:, :3, :3]
    across = np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]])
    angle = np.arctan2(np.linalg.norm(across, axis=0), np.trace(turn, axis1=1, axis2=2) - 1.0)
    return np.linalg.norm(ours[:, :3, 3] - wanted[:, :3, 3], axis=1), angle


COLUMNS = (
    "arm",
    "poses",
    "solutions, all measured",
    "planted ones lost",
    "not certain",
    "duplicates",
    "greatest error [m]",
    "greatest error [rad]",
    "us a pose",
)


def _cells(name: str, tally: Tally) -> list[str]:
    """The row of a table."""
    return [
        name,
        f"{tally.poses:,}",
        f"{tally.solutions:,}",
        str(len(tally.lost)),
        str(tally.uncertain),
        str(tally.duplicates),
        f"{tally.position:.1e}",
        f"{tally.rotation:.1e}",
        f"{1e6 * tally.seconds / tally.poses:.2f}",
    ]


def _run(name: str, poses: int, seed: int, pool: Any, bar: Progress) -> Tally:
    """All poses of one arm, in chunks over the processes."""
    total, done = Tally(), bar.add_task(name, total=poses)
    sizes = [min(CHUNK, poses - start) for start in range(0, poses, CHUNK)]
    tasks = ((name, seed, chunk, size) for chunk, size in enumerate(sizes))
    # In order, so that the same seed prints the same lines.
    for tally in pool.imap(measure, tasks):
        total.add(tally)
        bar.advance(done, tally.poses)
        for q, gap, sigma in tally.lost:
            vector = ", ".join(repr(float(x)) for x in q)
            bar.console.print(
                f"{name}: lost q = [{vector}], nearest {gap:.1e} rad, sigma_min {sigma:.1e}",
                highlight=False,
                soft_wrap=True,
            )
    bar.remove_task(done)
    return total


def _show(rows: list[list[str]], *, markdown: bool) -> None:
    """Print the table."""
    if markdown:
        print("| " + " | ".join(COLUMNS) + " |")
        print("|---|" + "---:|" * (len(COLUMNS) - 1))
        for row in rows:
            print("| " + " | ".join(row) + " |")
        return
    table = Table()
    for i, column in enumerate(COLUMNS):
        table.add_column(column, justify="right" if i else "left")
    for row in rows:
        table.add_row(*row)
    Console(width=None if sys.stdout.isatty() else 130).print(table)


def main(arguments: list[str] | None = None) -> int:
    """Run the count and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--md", action="store_true", help="print Markdown")
    parser.add_argument("--poses", type=int, help=f"poses for every arm (default {MANY:,}, general arms {FEW:,})")
    parser.add_argument("--processes", type=int, default=2, help="processes that share the work (default 2)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the poses (default 0)")
    parser.add_argument("--robot", nargs="*", choices=ARMS, metavar="NAME", help=f"only these: {', '.join(ARMS)}")
    options = parser.parse_args(arguments)
    if options.processes < 1 or options.seed < 0 or (options.poses is not None and options.poses < 1):
        parser.error("at least one pose and one process are needed, and a seed of zero or more")
    names = options.robot or list(ARMS)
    for name in names:  # compiles what is not compiled yet, before the processes would all do it
        measure((name, options.seed, 0, 1))
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
    )
    tallies: dict[str, Tally] = {}
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool, bar:
        for name in names:
            tallies[name] = _run(name, options.poses or ARMS[name][1], options.seed, pool, bar)
    _show([_cells(name, tally) for name, tally in tallies.items()], markdown=options.md)
    return 0 if all(tally.passed for tally in tallies.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
