"""One arm as one file: compiled with every warning, alone or beside other arms, it gives the bits of the package."""

import os
import shutil
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import NamedTuple

import arms_hollow
import core_arms
import native_arms
import numpy as np
import pytest
from command import call
from core_samples import fresh
from native_arms import PROGRAMS, WARNINGS, compiler, expected, targets
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import _core, export
from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.export.one_file import Node, node_of

Array = NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[2]
CLANG = os.environ.get("URDF_IK_CLANG", "clang++")
"""Another release: `URDF_IK_CLANG=clang++-19 pytest tests/export/test_one_file.py`."""
needs_clang = pytest.mark.skipif(shutil.which(CLANG) is None, reason=f"no {CLANG} is installed")
COMPILERS = [compiler("CXX"), pytest.param(CLANG, marks=needs_clang)]
ALL = os.environ.get("URDF_IK_FAMILIES") == "all"
FEW = {"rail_6r", "srs_7r", "mimic of one joint", "hollow wrist"}
# The flags of the library, without which GCC fuses other operations where the processor can.
FLAGS = ("-O3", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math", "-fno-exceptions")
FREESTANDING = ("-ffreestanding", "-fno-rtti", "-fno-stack-protector")
# What a controller has: the C library's own names, and the mathematics of large angles. Compilers call sincos where the
# C library has it.
ALLOWED = {"memcpy", "memset", "memmove", "sin", "cos", "sincos", "remainder"}

# Answers at the instruction set that a fresh process is told, which another compiler is compared with.
_EXPECTED = """
import sys, native_arms, numpy as np, test_one_file
for name, arm in test_one_file.CHOSEN:
    T, values = native_arms.targets(arm, 5, 60)
    s = native_arms.expected(arm, T, values)
    given = {} if values is None else {"values": values}
    place = f"{sys.argv[1]}/{test_one_file.place_of(name)}"
    np.savez(place, T=T, q=s.q, valid=s.valid, flags=native_arms.flags_of(s), **given)
"""


class Answers(NamedTuple):
    """What a unit answers for one of its arms.

    Attributes:
        q: (m, B, n) joint vectors.
        flags: (m, B).
        zero: (4, 4) the tip's pose at zero.
    """

    q: Array
    flags: NDArray[np.uint8]
    zero: Array


def place_of(name: str) -> str:
    """The name of a file for an arm."""
    return "".join(letter if letter.isalnum() else "_" for letter in name)


def level_flags(level: str) -> tuple[str, ...]:
    """The compiler's flag for an instruction set."""
    return (f"-march=x86-64-{level}",) if level.startswith("v") else ()


@cache
def main_program() -> str:
    """The object that reads poses and solves, which knows no arm."""
    out = Path(mkdtemp(prefix="urdf_ik_")) / "main.o"
    source = str(PROGRAMS / "one_file.cpp")
    native_arms.run(compiler("CXX"), "-std=c++20", "-O1", *WARNINGS, "-c", source, "-o", str(out))
    return str(out)


def unit_of(arms: list[urdf_ik.Arm], compile_with: str, flags: tuple[str, ...], place: Path) -> Path:
    """The object of one unit that holds the exported files of arms, compiled with every warning as an error."""
    included, listed = [], []
    for k, arm in enumerate(arms):
        # A header that says it is the system's hides its warnings.
        text = export.cpp(arm, f"arm_{k}").replace("#pragma GCC system_header", "")
        (place / f"arm_{k}.hpp").write_text(text)
        included.append(f'#include "arm_{k}.hpp"\n')
        listed.append(f"EXPORTED(arm_{k})")
    source, made = place / "unit.cpp", place / "unit.o"
    listing = f"extern const Exported exported[] = {{{', '.join(listed)}}};\n"
    source.write_text(f"{''.join(included)}#include <one_file.hpp>\n{listing}")
    command = [compile_with, "-std=c++20", *flags, *WARNINGS, f"-I{PROGRAMS}", "-c", str(source), "-o", str(made)]
    native_arms.run(*command)
    return made


def answers(unit: Path, arms: list[urdf_ik.Arm], asked: list[tuple[Array, Array | None]]) -> list[Answers]:
    """What the arms of a unit answer to targets; none of them allocates."""
    program, given = unit.with_name("program"), []
    native_arms.run(compiler("CXX"), main_program(), str(unit), "-o", str(program))
    for T, values in asked:
        given.append(np.array([len(T), values is not None], np.int64).tobytes() + T.tobytes())
        given.append(b"" if values is None else np.ascontiguousarray(values).tobytes())
    done = native_arms.run(str(program), given=b"".join(given))
    assert done.stderr == b"0 allocations\n"
    found, at = [], 0
    for arm, (T, _) in zip(arms, asked, strict=True):
        m, B, n = len(T), len(arm.solver.branches), arm.dof
        q = np.frombuffer(done.stdout, count=m * B * n, offset=at).reshape(m, B, n)
        flags = np.frombuffer(done.stdout, np.uint8, m * B, at + q.nbytes).reshape(m, B)
        at += q.nbytes + flags.nbytes + 128
        found.append(Answers(q, flags, np.frombuffer(done.stdout, count=16, offset=at - 128).reshape(4, 4)))
    assert at == len(done.stdout)
    return found


def needed_by(unit: Path) -> set[str]:
    """The names that a unit leaves to the linker."""
    listed = subprocess.run(["nm", "-u", str(unit)], capture_output=True, text=True, check=True).stdout.split()
    return {name for name in listed if name not in ("U", "w")}


def mimics() -> list[tuple[str, urdf_ik.Arm]]:
    """Arms whose joints drive several axes each: one joint that drives two, and a hollow wrist."""
    xml = urdf_ik.load("planar_2r").model.xml.decode()
    follower = '<child link="link_2"/><mimic joint="joint_1" multiplier="-1"/>'
    hollow = arms_hollow.hollow("mirrored")
    return [
        ("mimic of one joint", urdf_ik.load(xml.replace('<child link="link_2"/>', follower))),
        ("hollow wrist", urdf_ik.load(hollow, base="base", tip="tool")),
    ]


def two_of_each_family() -> Iterator[tuple[str, urdf_ik.Arm]]:
    """Two arms of each family at most."""
    seen: Counter[str] = Counter()
    for name, arm in [*core_arms.every_arm(), *mimics()]:
        family = arm.solver.require_member().name
        seen[family] += 1
        if seen[family] <= 2:
            yield name, arm


def solver_text(arm: urdf_ik.Arm) -> str:
    """The names of the solver's templates, which take most of the time of a unit."""
    node: Node | None = node_of(arm.solver.require_member().solver.arm, arm.name)
    texts = []
    while node is not None:
        texts.append(node.text)
        node = node.inner
    return "\n".join(texts)


# All where URDF_IK_FAMILIES=all, otherwise one of each way in which a solver is built.
CHOSEN = [(name, arm) for name, arm in two_of_each_family() if ALL or name in FEW]
# Arms that have a solver's templates in common share a unit.
UNITS: dict[str, list[tuple[str, urdf_ik.Arm]]] = defaultdict(list)
for each in CHOSEN:
    UNITS[solver_text(each[1])].append(each)
each_unit = pytest.mark.parametrize("named", UNITS.values(), ids=[named[0][0] for named in UNITS.values()])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "beside"), [("zyyzyz_6r", "planar_2r"), ("srs_7r", "positioning_3r")])
def test_arms_of_two_families_in_one_unit_give_the_same_bits(name: str, beside: str, tmp_path: Path) -> None:
    """With the library's flags answers are those of Python, and nothing is allocated."""
    arms = [urdf_ik.load(name), urdf_ik.load(beside)]
    unit = unit_of(arms, compiler("CXX"), (*FLAGS, *level_flags(_core.isa())), tmp_path)
    asked = [targets(arm, 5, 60) for arm in arms]
    for arm, given, found in zip(arms, asked, answers(unit, arms, asked), strict=True):
        same_bits(found, expected(arm, *given))


@pytest.mark.parametrize("name", ["zyyzyz_6r", "positioning_3r"])
def test_one_file_solves_as_python_does(name: str, tmp_path: Path) -> None:
    """Quickly compiled: as many solutions of 20 poses as Python has, the same but for rounding."""
    arm = urdf_ik.load(name)
    unit = unit_of([arm], compiler("CXX"), ("-O1", *FLAGS[1:], *FREESTANDING), tmp_path)
    assert needed_by(unit) <= ALLOWED
    T = targets(arm, 5, 20)[0]
    (found,) = answers(unit, [arm], [(T, None)])
    wanted = arm.ik(T)
    assert ((found.flags & 1).astype(bool) == wanted.valid).all()
    regular = wanted.valid & (wanted.singular == 0)
    apart = found.q[regular] - wanted.q[regular]
    assert regular.any() and np.abs(np.remainder(apart + np.pi, 2 * np.pi) - np.pi).max() < 1e-9


def same_bits(found: Answers, s: urdf_ik.IKSolutions) -> None:
    """Solutions and flags are equal to the last bit."""
    assert (found.flags == native_arms.flags_of(s)).all()
    assert found.q[s.valid].tobytes() == s.q[s.valid].tobytes()


@pytest.mark.slow
@pytest.mark.parametrize("compile_with", COMPILERS)
def test_files_of_all_families_stand_in_one_unit(compile_with: str, tmp_path: Path) -> None:
    """Two arms of each family compile side by side, without a warning."""
    arms = [arm for _, arm in two_of_each_family()]
    assert len(arms) > 100
    unit_of(arms, compile_with, ("-fsyntax-only", *FREESTANDING, *level_flags(_core.isa())), tmp_path)


@cache
def answered(level: str) -> Path:
    """The folder of Python's answers at an instruction set."""
    place, path = mkdtemp(prefix="urdf_ik_"), os.pathsep.join([str(Path(__file__).parent), *sys.path])
    fresh(_EXPECTED, place, URDF_IK_ISA=level, PYTHONPATH=path)
    return Path(place)


# At x86-64-v2, which has no operation to fuse, compilers agree to the last bit.
no_v2 = pytest.mark.skipif("v2" not in _core.levels(), reason="the core was built without x86-64-v2")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("compile_with", "level", "optimised"),
    [(compiler("CXX"), _core.isa(), "-O3"), pytest.param(CLANG, "v2", "-O1", marks=[needs_clang, no_v2])],
)
@each_unit
def test_each_family_gives_the_same_bits_freestanding(
    named: list[tuple[str, urdf_ik.Arm]], compile_with: str, level: str, optimised: str, tmp_path: Path
) -> None:
    """Without a C++ library, exceptions and run-time types: Python's bits, and only functions of C are left to link."""
    arms = [arm for _, arm in named]
    unit = unit_of(arms, compile_with, (optimised, *FLAGS[1:], *FREESTANDING, *level_flags(level)), tmp_path)
    assert needed_by(unit) <= ALLOWED
    wanted = [dict(np.load(answered(level) / f"{place_of(name)}.npz")) for name, _ in named]
    asked = [(each["T"], each.get("values")) for each in wanted]
    for (name, arm), each, found in zip(named, wanted, answers(unit, arms, asked), strict=True):
        assert (found.flags == each["flags"]).all(), name
        assert found.q[each["valid"]].tobytes() == each["q"][each["valid"]].tobytes(), name
        assert np.abs(found.zero - arm.fk(np.zeros(arm.dof))).max() < 1e-12, name


@pytest.mark.slow
@pytest.mark.skipif(
    any(shutil.which(program) is None for program in ("arm-none-eabi-g++", "qemu-system-arm")),
    reason="arm-none-eabi-g++ or qemu-system-arm is not installed",
)
def test_a_controller_counts_the_same() -> None:
    """On an emulated Cortex-M7 random, round and singular poses have as many solutions, in 64 kB of stack."""
    tool = str(ROOT / "tools" / "cortex_m7.py")
    row = native_arms.run(sys.executable, tool, "--poses", "30", "zyyzyz_6r").stdout.decode().splitlines()[-1]
    _, name, _, same, _, stack, _ = (word.strip() for word in row.split("|"))
    assert (name, same) == ("zyyzyz_6r", "30 of 30")
    assert float(stack) < 64.0


def test_a_c_program_solves(tmp_path: Path) -> None:
    """The header compiles as C11; its implementation, in one C++ unit, solves."""
    header, use, unit = tmp_path / "two.h", tmp_path / "use.c", tmp_path / "unit.cpp"
    assert call("export", "planar_2r", "--name", "two", "--c", str(header)).exit_code == 0
    use.write_text(
        '#include "two.h"\n#include <stdio.h>\nint main(void) { double zero[TWO_JOINTS] = {0.3, 0.4}, T[16];\n'
        "double q[TWO_COLUMNS * TWO_JOINTS]; uint8_t flags[TWO_COLUMNS]; two_fk(zero, T);\n"
        'printf("%d %s\\n", two_ik(T, q, flags, zero, NULL), two_joint_name(1)); return 0; }\n'
    )
    unit.write_text('#define TWO_IMPLEMENTATION\n#include "two.h"\n')
    parts = [str(tmp_path / "use.o"), str(tmp_path / "unit.o")]
    native_arms.run(compiler("CC"), "-std=c11", *WARNINGS, "-c", str(use), "-o", parts[0])
    native_arms.run(compiler("CXX"), "-std=c++20", "-O1", *WARNINGS, "-c", str(unit), "-o", parts[1])
    native_arms.run(compiler("CXX"), *parts, "-o", str(tmp_path / "program"))
    arm = urdf_ik.load("planar_2r")
    count = len(arm.ik(arm.fk([0.3, 0.4])))
    assert native_arms.run(str(tmp_path / "program")).stdout.decode() == f"{count} joint_2\n"


def test_what_cannot_be_exported_is_refused() -> None:
    """A name that is none in C++, a task that is not of poses, and a command that asks for no file."""
    arm = urdf_ik.load("planar_2r")
    with pytest.raises(ArgumentError, match="name='2r' given"):
        export.cpp(arm, "2r")
    with pytest.raises(ArgumentError, match="name='double' given, a word of the language"):
        export.c(arm, "double")
    with pytest.raises(UnsupportedArm, match="the task"):
        export.cpp(arm.for_task("planar position"))
    assert call("export", "planar_2r").exit_code == 2
