"""The compiled core on every instruction set: the same solutions, no symbol shared, and the same inputs, same outputs.

Each instruction set runs in a process of its own, since it is chosen when the core is imported. Within one instruction
set the same pose has the same answer to the last bit, alone, anywhere in a batch, and on any number of threads;
between two, the last digits of an angle differ.
"""

import itertools
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from urdf_ik import _core
from urdf_ik.model import catalogue

LEVELS = _core.levels()
# What rounding moves a pose by, in shares of the arm's size and rad: joint values differ by as much over the Jacobian's
# smallest singular value.
ROUNDED = 2e-12
POSES = 100
HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Answers:
    """All solutions of the same poses by one instruction set.

    Attributes:
        q: (m, B, n) joint vectors [rad, m], NaN where there is none.
        flags: (m, B) what the solver says of each.
        weakest: (m, B) the Jacobian's smallest singular value at each.
        again: what differs between a batch, its poses one by one, and the batch on three threads; '' for nothing.
    """

    q: NDArray[np.float64]
    flags: NDArray[np.uint8]
    weakest: NDArray[np.float64]
    again: str


def run(code: str, *arguments: str, level: str) -> subprocess.CompletedProcess[str]:
    """Run Python code in a process whose core uses an instruction set."""
    env = os.environ | {"URDF_IK_ISA": level, "PYTHONPATH": os.pathsep.join([str(HERE), *sys.path])}
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, env=env, capture_output=True, text=True, timeout=600, check=False)


_SOLVE = """
import sys
from core_arms import solve_all
solve_all(*sys.argv[1:])
"""


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, dict[str, Answers]]]:
    """By instruction set and arm, what the core answers to the same random poses."""
    folder = tmp_path_factory.mktemp("levels")
    found: dict[str, dict[str, Answers]] = {}
    for level in LEVELS:
        done = run(_SOLVE, str(folder / f"{level}.npz"), str(folder / "targets.npz"), str(POSES), level=level)
        assert done.returncode == 0, done.stderr
        with np.load(folder / f"{level}.npz") as kept:
            names = {key.rpartition("/")[0] for key in kept.files}
            found[level] = {
                name: Answers(*(kept[f"{name}/{k}"] for k in ("q", "flags", "weakest")), str(kept[f"{name}/again"]))
                for name in names
            }
    yield found


def test_every_instruction_set_answers_alike(answers: dict[str, dict[str, Answers]]) -> None:
    """The same branches have a solution, marked alike, and the joints differ by what rounding does."""
    worse = []
    assert all(set(catalogue.BUNDLED) <= arms.keys() for arms in answers.values())
    assert all((a.flags & 1).any() for arms in answers.values() for a in arms.values())
    for one, other in itertools.pairwise(LEVELS):
        assert answers[one].keys() == answers[other].keys()
        for name, a in answers[one].items():
            b = answers[other][name]
            differ = int((a.flags != b.flags).any(axis=1).sum())
            if differ:
                worse.append(f"{name}: {one} and {other} differ in the flags of {differ} of {len(a.flags)} poses")
                continue
            apart = np.abs(np.remainder(a.q - b.q + np.pi, 2.0 * np.pi) - np.pi)
            apart /= np.fmax(1.0, np.abs(a.q) / np.pi)  # of slides far out, the share of their way
            rounded = apart * a.weakest[..., None]
            if not np.nanmax(rounded, initial=0.0) <= ROUNDED:
                worse.append(f"{name}: {one} and {other} are {np.nanmax(rounded):.1e} apart")
    assert not worse, "\n".join(worse)


def test_the_same_pose_has_the_same_answer_to_the_last_bit(answers: dict[str, dict[str, Answers]]) -> None:
    """Alone, anywhere in a batch, and on three threads."""
    worse = [f"{level}: {a.again}" for level, arms in answers.items() for a in arms.values() if a.again]
    assert not worse, "\n".join(worse)


@pytest.mark.parametrize("level", ["", *LEVELS])
def test_the_environment_chooses_the_instruction_set(level: str) -> None:
    """URDF_IK_ISA names the one that is used; without it the best one is."""
    done = run("from urdf_ik import _core; print(_core.isa())", level=level)
    assert (done.returncode, done.stdout.strip()) == (0, level or LEVELS[-1]), done.stderr


@pytest.mark.parametrize("level", ["v9", "V3"])
def test_an_unknown_instruction_set_is_an_error_in_words(level: str) -> None:
    """Import fails, and says what this processor runs."""
    done = run("import urdf_ik; urdf_ik.Arm", level=level)
    assert done.returncode != 0
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("ImportError: ") and f"'{level}'" in last and ", ".join(LEVELS) in last


def _symbols(file: Path) -> set[str]:
    """The symbols that an object file defines and a linker sees, but for pointers to the runtime's functions."""
    done = subprocess.run(
        ["nm", "--defined-only", "--extern-only", "--format=posix", str(file)],
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    names = {line.split()[0] for line in done.stdout.splitlines() if line.strip()}
    return {name for name in names if not name.startswith("DW.ref.")}  # data, the same at every level


def test_no_symbol_is_shared_between_instruction_sets() -> None:
    """No object file of one defines what another's, or the bindings', defines: a linker keeps one of two for all."""
    build = Path(str(_core.__file__)).parent
    # The programs and the module of the tests are linked without the core.
    apart = ("core_tests", "steps", "_core_steps")
    folders = {each.stem: each for each in build.glob("CMakeFiles/*.dir") if not each.stem.startswith(apart)}
    if shutil.which("nm") is None or not {f"core_{level}" for level in LEVELS} <= folders.keys():
        pytest.skip("nm, and the folder that the core was built in, are needed: an editable install")
    symbols = {name: set().union(*(_symbols(file) for file in folder.rglob("*.o"))) for name, folder in folders.items()}
    assert all(symbols[f"core_{level}"] for level in LEVELS)
    for level in LEVELS:
        for other in symbols.keys() - {f"core_{level}"}:
            shared = symbols[f"core_{level}"] & symbols[other]
            assert not shared, f"core_{level} and {other} both define {sorted(shared)[:5]}"
