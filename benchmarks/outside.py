"""Compiled arms without Python: C++ library, C interface and WebAssembly against Python pose by pose; batch times.

    [URDF_IK_ISA=v2] python benchmarks/outside.py [--poses 1000] [--timed] [FOLDER]

FOLDER holds URDFs, and may have an index.csv with the columns name, base_link and tip_link, and urdf/NAME.urdf;
default: the bundled arms and those of benchmarks/urdf. A third of the poses is random, a third round, a third singular.
The status is 1 where a bit of a solution, a flag, a status or a branch name differs. WebAssembly is compared at v2,
whose arithmetic it has, where `make wasm` built it and Node is there. --timed measures processor times of batches
instead: least of many, alternating.
It needs an editable install, whose build folder has the library.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import _core
from urdf_ik.errors import UrdfIkError

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

import native_arms  # noqa: E402
import web_arms  # noqa: E402
from arms_outside import arms_of, own_arms, poses_of  # noqa: E402

TIMED = ("planar_2r", "scara_rrpr", "zyyzyz_6r", "srs_7r", "kinova_j2n6s300")
REPEATS = 12
WITH_WEB = web_arms.NODE is not None and web_arms.NO_WASM is None and _core.isa() == "v2"


def compared(arm: urdf_ik.Arm, file: Path, many: int) -> tuple[int, list[str]]:
    """The number of solutions, and what differs."""
    T, n = poses_of(arm, many), arm.dof
    free: dict[str, NDArray[np.float64]] = {}
    values = None
    if arm.redundancy is not None:
        low, high = np.array([np.clip(each.range, -np.pi, np.pi) for each in arm.solver.parameters]).T
        values = np.random.default_rng(8).uniform(low, high, (many, len(low)))
        free = {"redundancy": values[:, 0] if values.shape[1] == 1 else values}
    expected = arm.ik(T, **free)
    valid = expected.valid
    native = native_arms.solved(file, T, values)
    given = np.array([many, values is not None], np.int64).tobytes() + np.ascontiguousarray(T).tobytes()
    given += b"" if values is None else values.tobytes()
    said = native_arms.run(str(native_arms.built("solve.c")), str(file), "1", given=given, URDF_IK_ISA=_core.isa())
    q = np.frombuffer(said.stdout, count=expected.q.size).reshape(expected.q.shape)
    flags = np.frombuffer(said.stdout, np.uint8, valid.size, q.nbytes).reshape(valid.shape)
    facts = {
        "solutions in C++": native.q[valid].tobytes() == expected.q[valid].tobytes(),
        "solutions in C": q[valid].tobytes() == expected.q[valid].tobytes(),
        "flags and status in C++": (native.flags == expected._info).all(),
        "flags and status in C": (flags == expected._info).all(),
        "branch names": said.stderr.decode().splitlines()[1:] == list(arm.solver.branches),
        "allocations": native.allocations == (0 if arm.chain.axes is arm.chain else 1),
    }
    if WITH_WEB:
        web = web_arms.answers(file, T, values)
        facts |= {
            "solutions in WebAssembly": web.q[valid].tobytes() == expected.q[valid].tobytes(),
            "flags and status in WebAssembly": (web.valid == valid).all()
            and (web.singular == (valid & (expected.singular != 0))).all()
            and web.status == expected.status.tolist(),
            "branch names in WebAssembly": web.branches == list(arm.solver.branches),
        }
    assert n == q.shape[-1]
    return int(valid.sum()), [fact for fact, holds in facts.items() if not holds]


def timed(arm: urdf_ik.Arm, file: Path, many: int) -> tuple[float, float]:
    """Least processor times of a batch [s]: of the C interface, and of Python with one thread."""
    T = np.ascontiguousarray(arm.fk(np.random.default_rng(9).uniform(-2.5, 2.5, (many, arm.dof))))
    given = np.array([many, 0], np.int64).tobytes() + T.tobytes()
    program = str(native_arms.built("solve.c"))
    out = arm.ik(T, threads=1)
    native = python = np.inf
    for _ in range(REPEATS):
        said = native_arms.run(program, str(file), "5", given=given, URDF_IK_ISA=_core.isa())
        native = min(native, float(said.stderr.split()[0]))
        for _ in range(5):
            start = time.process_time()
            out = arm.ik(T, threads=1, out=out)
            python = min(python, time.process_time() - start)
    return native, python


def main() -> None:
    """Print a line for each difference, and a count at the end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--timed", action="store_true")
    given = parser.parse_args()
    many = solutions = differ = refused = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, arm in own_arms() if given.folder is None else arms_of(given.folder):
            file = Path(folder) / "arm.json"
            try:
                file.write_text(urdf_ik.compile(arm))
            except UrdfIkError as error:
                print(f"{name}: not compiled: {error}", file=sys.stderr)
                refused += 1
                continue
            if given.timed:
                if given.folder is None and name not in TIMED:
                    continue
                native, python = timed(arm, file, 1000)
                ratio = native / python
                print(f"{name}: {1e3 * native:.3f} us a pose, Python {1e3 * python:.3f}, ratio {ratio:.3f}", flush=True)
                continue
            count, wrong = compared(arm, file, given.poses)
            many, solutions, differ = many + 1, solutions + count, differ + bool(wrong)
            if wrong:
                print(f"{name}: {', '.join(wrong)} differ", flush=True)
    if not given.timed:
        print(f"{many} arms, {given.poses} poses each, {solutions} solutions, at {_core.isa()},", end=" ")
        print("with WebAssembly:" if WITH_WEB else "without WebAssembly:", end=" ")
        print(f"{differ} arms differ, {refused} not compiled")
    sys.exit(differ > 0)


if __name__ == "__main__":
    main()
