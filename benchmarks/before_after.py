#!/usr/bin/env python3
"""What takes time where people work, of two versions of this package in turn: round poses, seven joints, paths, starts.

    python benchmarks/before_after.py [--before PYTHON] [--arms FOLDER] [--rows WORD ...] [--repeats R] [--build]

``--before`` is the Python of an environment in which another version of this package is installed. Each version has one
process; they measure each row in turn, and the least of the repetitions counts. Times are processor time, so that other
work on the machine changes them little. ``--arms`` is a folder with URDFs of the arms that are not in this repository;
rows of arms that it lacks are left out, and named at the end. ``--rows`` takes only rows whose names hold one of the
words. ``--build`` measures the processor time of compiling the core for one instruction set instead.

A round pose is that of a joint vector whose joints all are multiples of 90 degrees. ``x needed``: the time of a plan
over that of the collision queries that every planner has to make; see ``paths.py``. ``asked`` is what this version is
to keep to; where that is so many times another row, its number is that row's times so many. ``over``: by how much it
misses that.
"""

import argparse
import importlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
# Files of arms in --arms, with base and tip.
OTHERS: dict[str, tuple[str, str, str]] = {
    "Puma 560": ("puma560_rtb.urdf", "link1", "link7"),
    "AIRBOT Play": ("airbot_play.urdf", "base_link", "link6"),
    "Gen3 lite": ("kinova_gen3_lite.urdf", "BASE", "END_EFFECTOR"),
    "FR3": ("franka_fr3.urdf", "fr3_link0", "fr3_link8"),
    "xArm7": ("ufactory_xarm7.urdf", "link_base", "link_eef"),
    "Gen3": ("kinova_gen3_7dof_2f85.urdf", "gen3_base_link", "gen3_end_effector_link"),
    "iiwa R820": ("kuka_lbr_iiwa_14_r820.urdf", "base_link", "tool0"),
    "Sawyer": ("rethink_sawyer.urdf", "base", "right_l6"),
}
# Arms of robots.py, by the names of its variables.
MADE = ("UR5E", "IRB2400", "ZYYZYZ", "CALIBRATED_UR10E", "CALIBRATED_UR5E", "CRX", "KINOVA")
SEVEN = ("FR3", "xArm7", "Gen3", "iiwa R820", "Sawyer")
LABELS = {
    "IRB2400": "IRB 2400",
    "ZYYZYZ": "z y y z y z",
    "CALIBRATED_UR10E": "calibrated UR10e",
    "CALIBRATED_UR5E": "calibrated UR5e",
    "UR5E": "UR5e",
    "CRX": "CRX-10iA/L",
    "KINOVA": "Kinova j2n6s300",
}


def least(work: Callable[[], Any], times: int, repeats: int) -> float:
    """Processor time of one call [us]: the best mean of several runs."""
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        for _ in range(times):
            work()
        best = min(best, (time.process_time() - start) / times)
    return 1e6 * best


def loaded(arm: list[str] | str) -> Any:
    """An arm from (file, base, tip), or by its catalogue name."""
    import urdf_ik

    return urdf_ik.load(arm) if isinstance(arm, str) else urdf_ik.load(arm[0], base=arm[1], tip=arm[2])


def random_vectors(arm: Any, count: int) -> np.ndarray:
    """Joint vectors (count, n) inside the limits."""
    low, high = np.clip(arm.limits.T, -2.0 * np.pi, 2.0 * np.pi)
    vectors: np.ndarray = np.random.default_rng(0).uniform(low, high, (count, arm.dof))
    return vectors


def poses(arm: list[str], count: int, is_round: bool) -> float:
    """Microseconds a pose of a batch."""
    solved = loaded(arm)
    q = random_vectors(solved, count)
    if is_round:
        q = np.random.default_rng(0).integers(-1, 3, (count, solved.dof)) * 0.5 * np.pi
    T = solved.fk(q)
    solved.ik(T)
    return least(lambda: solved.ik(T), 1, 5) / count


def intervals(arm: list[str], count: int) -> float:
    """Microseconds of ``intervals`` for one pose, the median of poses."""
    solved = loaded(arm)
    T = solved.fk(random_vectors(solved, count))
    return float(np.median([least(lambda X=X: solved.intervals(X), 1, 3) for X in T]))


def one_value(arm: list[str], count: int) -> float:
    """Microseconds a pose at one value of the redundancy parameter, of a batch."""
    solved = loaded(arm)
    T = solved.fk(random_vectors(solved, count))
    return least(lambda: solved.ik(T, redundancy=0.3), 1, 5) / count


def no_way(free: bool, waypoints: int) -> float:
    """Seconds until ``follow`` says that there is no way: the tool dips into a table."""
    import urdf_ik

    arm = urdf_ik.load("ur5")
    first = np.eye(4)
    first[:3, :3], first[:3, 3] = np.diag([1.0, -1.0, -1.0]), (0.45, -0.3, 0.25)
    low, last = first.copy(), first.copy()
    low[:3, 3], last[:3, 3] = (0.45, 0.0, -0.02), (0.45, 0.3, 0.25)
    half = waypoints // 2
    T = np.concatenate([urdf_ik.line(first, low, half), urdf_ik.line(low, last, waypoints - half)])
    world = urdf_ik.World()
    world.add("table", urdf_ik.Box((1.2, 1.2, 0.1)), urdf_ik.pose([0.5, 0.0, -0.05]))
    arm = arm.with_free_axis("z") if free else arm
    arm.follow(T[:2], world=world)  # imports and reads what is read once
    start = time.process_time()
    assert not arm.follow(T, world=world).found
    return time.process_time() - start


def in_a_cell(arm: str, waypoints: int) -> float:
    """How many times the processor time that is needed, by the ``paths.py`` of the version that is measured."""
    import urdf_ik

    sys.path.insert(0, str(Path(urdf_ik.__file__).parents[2] / "benchmarks"))
    clock, time.perf_counter = time.perf_counter, time.process_time  # what paths.py looks at
    try:
        row = importlib.import_module("paths").in_a_cell(arm, waypoints, 20, 3, 0)
    finally:
        time.perf_counter = clock
    return float(row.split("|")[6])


def in_a_world(boxes: int, points: int) -> float:
    """Microseconds a joint vector of a collision check of the UR5 among boxes, or beside a cloud of points."""
    import urdf_ik

    arm, rng = urdf_ik.load("ur5"), np.random.default_rng(0)
    world = urdf_ik.World()
    for k in range(boxes):
        away = rng.normal(size=3)
        away *= rng.uniform(1.1, 1.8) / np.linalg.norm(away)
        world.add(f"box {k}", urdf_ik.Box((0.1, 0.1, 0.1)), urdf_ik.pose(away))
    if points:
        away = rng.normal(size=(points, 3))
        away *= rng.uniform(1.1, 1.8, (points, 1)) / np.linalg.norm(away, axis=1, keepdims=True)
        world.add("cloud", urdf_ik.Points(away, 0.005), np.eye(4))
    solved = arm.ik(arm.fk(random_vectors(arm, 200)))
    solved.collision_free(world)
    return least(lambda: solved.collision_free(world), 1, 5) / int(solved.valid.sum())


def batch(count: int) -> float:
    """Microseconds a batch of so many poses; for zero, of a single pose and its ``q``."""
    import urdf_ik

    arm = urdf_ik.load("zyyzyz_6r")
    T = arm.fk(random_vectors(arm, max(count, 1)))
    one = T[0].copy()
    work = (lambda: arm.ik(T)) if count else (lambda: arm.ik(one).q)
    return least(work, max(1, 20_000 // max(count, 4)), 7)


_EAIK = "EAIK, a batch of 20,000 poses"


def eaik_batch(count: int) -> float:
    """Microseconds of EAIK's batch of the same poses."""
    import urdf_ik

    robots, peers = importlib.import_module("robots"), importlib.import_module("peers")
    arm = urdf_ik.load("zyyzyz_6r")
    bot = peers.Eaik(robots.ZYYZYZ)
    T = np.array(robots.ZYYZYZ.reference.poses(random_vectors(arm, count)))
    return least(lambda: bot.solve_batch(T, 1), 1, 3)


def process(*arguments: str) -> float:
    """Seconds of processor time of a process of this Python, beyond that of an empty one."""
    compiled = tempfile.TemporaryDirectory()
    env = {**os.environ, "PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": compiled.name}

    def spent(command: list[str]) -> float:
        before = os.times()
        subprocess.run([sys.executable, *command], check=True, capture_output=True, env=env)
        after = os.times()
        return after.children_user + after.children_system - before.children_user - before.children_system

    with compiled:
        spent(list(arguments))
        return min(spent(list(arguments)) for _ in range(5)) - min(spent(["-c", "pass"]) for _ in range(5))


def build() -> float:
    """Seconds of processor time of compiling the core for one instruction set, as for ``make run``."""
    import urdf_ik

    root = Path(urdf_ik.__file__).parents[2]
    with tempfile.TemporaryDirectory() as folder:
        configure = [
            "-G",
            "Ninja",
            "-DURDF_IK_LEVELS=v3",
            "-DURDF_IK_WERROR=OFF",
            f"-DPython_EXECUTABLE={sys.executable}",
        ]
        if "what tests use" in (root / "CMakeLists.txt").read_text() + (root / "tools/with_compiler.py").read_text():
            configure.append("-DURDF_IK_TESTS=OFF")
        quiet: dict[str, Any] = {"check": True, "capture_output": True}
        subprocess.run(["cmake", "-S", str(root), "-B", folder, *configure], **quiet)
        before = os.times()
        subprocess.run(["ninja", "-C", folder], env={**os.environ, "CCACHE_DISABLE": "1"}, **quiet)
        after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


Asked = tuple[float | tuple[str, float], ...]


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Attributes:
        name: what it shows.
        measure: the function that measures it, in a process of its own.
        arguments: of the function; the name of an arm stands for its file.
        unit: of its number.
        asked: numbers that it is to keep to, and pairs of another row's name and so many times its number.
    """

    name: str
    measure: Callable[..., float]
    arguments: tuple[Any, ...]
    unit: str
    asked: Asked = ()


_FIRST_ANSWER = (
    "import sys, urdf_ik; arm = urdf_ik.load(sys.argv[1]); arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])).q"
)
# Arms whose round poses are asked for, how many, and the number [us] that they are to keep to beside ten random poses.
_ROUND = (("CRX", 60, 150.0), ("Puma 560", 60, 150.0), ("AIRBOT Play", 60, 150.0), ("KINOVA", 60, 150.0),
          ("Gen3 lite", 60, 150.0), ("CALIBRATED_UR10E", 200, 150.0), ("CALIBRATED_UR5E", 200, 150.0),
          ("UR5E", 400, np.inf), ("IRB2400", 400, np.inf), ("ZYYZYZ", 400, np.inf))  # fmt: skip
_20_BOXES, _IMPORTS = "collisions, 20 boxes", "import yourdfpy, pinocchio"
ROWS = (
    *(
        row
        for name, count, most in _ROUND
        for random in [f"{name}, random poses"]
        for row in (
            Row(random, poses, (name, count, False), "us a pose"),
            Row(f"{name}, round poses", poses, (name, count, True), "us a pose", ((random, 10.0), most)),
        )
    ),
    *(Row(f"intervals, {name}", intervals, (name, 40), "us a pose", (300.0,)) for name in SEVEN),
    Row("one value, Sawyer", one_value, ("Sawyer", 200), "us a pose", (20.0,)),
    Row("one value, FR3", one_value, ("FR3", 200), "us a pose"),
    Row("follow, 300 waypoints, no way, free axis", no_way, (True, 300), "s", (3.0,)),
    Row("follow, 300 waypoints, no way, tool fixed", no_way, (False, 300), "s"),
    *(
        Row(f"follow in a cell, {name}", in_a_cell, (name, 300), "x needed", (1.5,))
        for name in ("ur5", "panda", "srs_7r")
    ),
    Row(_20_BOXES, in_a_world, (20, 0), "us a vector"),
    Row("collisions, 200 boxes", in_a_world, (200, 0), "us a vector", ((_20_BOXES, 2.0),)),
    Row("collisions, a cloud of 100,000 points", in_a_world, (0, 100_000), "us a vector", ((_20_BOXES, 2.0),)),
    Row("first answer, beyond the interpreter", process, ("-c", _FIRST_ANSWER, "URDF"), "s", (0.35,)),
    Row(_IMPORTS, process, ("-c", _IMPORTS), "s"),
    Row("urdf-ik ik zyyzyz_6r", process, ("-m", "urdf_ik.cli", "ik", "zyyzyz_6r"), "s", ((_IMPORTS, 1.2),)),
    Row("a batch of one pose", batch, (1,), "us", (5.0,)),
    Row(_EAIK, eaik_batch, (20_000,), "us"),
    Row("a batch of 20,000 poses", batch, (20_000,), "us", ((_EAIK, 1.0 / 60.0),)),
    Row("arm.ik(T).q", batch, (0,), "us", (1.0,)),
)
# Sixty seconds of two cores, less what installing what is needed takes.
BUILD = Row("compiling the core, one instruction set", build, (), "s", (100.0,))


def files(folder: Path, arms: Path | None) -> dict[str, list[str]]:
    """File, base and tip of every arm that there is a file of; those of robots.py are written to a folder."""
    robots = importlib.import_module("robots")
    found = {}
    for name in MADE:
        path = folder / f"{name}.urdf"
        path.write_text(getattr(robots, name).urdf)
        found[name] = [str(path), "base", "tool"]
    for name, (file, base, tip) in OTHERS.items():
        if arms is not None and (arms / file).is_file():
            found[name] = [str(arms / file), base, tip]
    return found


class Version:
    """A process of one version, which measures what it is asked to."""

    def __init__(self, python: str) -> None:
        """Start the process of this Python."""
        self._process = subprocess.Popen(
            [python, str(Path(__file__).resolve()), "--measure"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )  # fmt: skip

    def measured(self, row: Row, arguments: list[Any]) -> float | str:
        """The number of a row, or why there is none."""
        assert self._process.stdin is not None and self._process.stdout is not None  # both are pipes
        try:
            print(json.dumps([row.measure.__name__, arguments]), file=self._process.stdin, flush=True)
            answer: float | str = json.loads(self._process.stdout.readline())
        except (OSError, ValueError):
            return "the process has ended"
        return answer

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def answer_requests() -> None:
    """Measure what standard input asks for, a line each, and answer with a number or with what went wrong."""
    answers, sys.stdout = sys.stdout, sys.stderr
    for line in sys.stdin:
        name, given = json.loads(line)
        try:
            answer: float | str = float(globals()[name](*given))
        except Exception as error:  # a version may lack what a row measures
            answer = f"{type(error).__name__}: {error}"
        print(json.dumps(answer), file=answers, flush=True)


def limit(row: Row, now: dict[str, float]) -> float | None:
    """The number that a row is to keep to; None where nothing is asked, or a row that it stands on has no number."""
    numbers = [each if isinstance(each, float) else each[1] * now.get(each[0], np.inf) for each in row.asked]
    least_of = min(numbers, default=np.inf)
    return least_of if np.isfinite(least_of) else None


def shown(label: str) -> str:
    """A row's name with arms as people call them."""
    for name, called in LABELS.items():
        label = label.replace(name, called)
    return label


def table(rows: list[tuple[Row, list[Any]]], versions: dict[str, Version], repeats: int) -> None:
    """Measure rows with their arguments and print them; a row that others stand on comes before these."""
    columns = [*versions, *["times as fast"] * (len(versions) > 1), "asked", "over"]
    print(f"| what | unit | {' | '.join(columns)} |\n|---|---|{'---:|' * len(columns)}")
    numbers: dict[str, float] = {}
    for row, given in rows:
        runs = [[version.measured(row, given) for version in versions.values()] for _ in range(repeats)]
        best = [min((x for x in run if isinstance(x, float)), default=run[0]) for run in zip(*runs, strict=True)]
        if isinstance(best[-1], float):
            numbers[row.name] = best[-1]
        cells = [f"{x:.3g}" if isinstance(x, float) else str(x)[:60] for x in best]
        before, now = best[0], best[-1]
        if len(versions) > 1:
            cells.append(f"{before / now:.2f}" if isinstance(before, float) and isinstance(now, float) else "-")
        asked = limit(row, numbers)
        cells.append("-" if asked is None else f"{asked:.3g}")
        over = isinstance(now, float) and asked is not None and now > asked
        cells.append(f"{now / asked:.2f}" if over else "")  # type: ignore[operator]
        print(f"| {shown(row.name)} | {row.unit} | {' | '.join(cells)} |", flush=True)


def main(arguments: list[str] | None = None) -> int:
    """Measure and print the table, as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", help="the Python of an environment with the version to compare with")
    parser.add_argument(
        "--arms", type=Path, help="a folder of further arms: " + ", ".join(f for f, _, _ in OTHERS.values())
    )
    parser.add_argument("--rows", nargs="*", help="only rows whose names hold one of these words")
    parser.add_argument("--repeats", type=int, default=3, help="repetitions of each row and version (default 3)")
    parser.add_argument("--build", action="store_true", help="compile the core instead")
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.measure:
        answer_requests()
        return 0
    if options.repeats < 1:
        parser.error("at least one repetition")
    pythons = {"before": options.before, "now": sys.executable} if options.before else {"now": sys.executable}
    versions = {name: Version(python) for name, python in pythons.items()}
    missing = set()
    with tempfile.TemporaryDirectory() as folder:
        arms = files(Path(folder), options.arms)
        urdf = str(HERE.parent / "urdf" / "zyyzyz_6r.urdf")
        rows = []
        for row in (BUILD,) if options.build else ROWS:
            if options.rows and not any(word in shown(row.name) for word in options.rows):
                continue
            if lacking := [each for each in row.arguments if each in OTHERS and each not in arms]:
                missing.update(lacking)
                continue
            given = [urdf if each == "URDF" else arms.get(each, each) if isinstance(each, str) else each
                     for each in row.arguments]  # fmt: skip
            rows.append((row, given))
        table(rows, versions, options.repeats)
    for version in versions.values():
        version.close()
    if missing:
        print(f"\nleft out, no file of them in --arms: {', '.join(sorted(missing))}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
