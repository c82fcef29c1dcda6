"""One arm as one file: compiled with every warning, alone or beside another arm, it gives the bits of the package."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import arms_hollow
import core_arms
import native_arms
import numpy as np
import pytest
from command import call
from native_arms import PROGRAMS, WARNINGS, compiler
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import _core, export
from urdf_ik.errors import ArgumentError, UnsupportedArm

Array = NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[2]
COMPILERS = [
    compiler("CXX"),
    pytest.param("clang++", marks=pytest.mark.skipif(shutil.which("clang++") is None, reason="no clang++ installed")),
]
ALL = os.environ.get("URDF_IK_FAMILIES") == "all"
FEW = {"rail_6r", "srs_7r", "mimic of one joint", "hollow wrist"}
# The flags of the library, without which the compiler fuses other operations.
FLAGS = ("-O3", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
LEVEL = {"v2": ("-march=x86-64-v2",), "v3": ("-march=x86-64-v3",), "v4": ("-march=x86-64-v4",)}.get(_core.isa(), ())
FREESTANDING = ("-ffreestanding", "-fno-exceptions", "-fno-rtti")
# What a controller's toolchain has: the C library's own names, and the mathematics.
ALLOWED = {"memcpy", "memset", "memmove", "sin", "cos"}


@pytest.mark.parametrize(("name", "beside"), [("zyyzyz_6r", "planar_2r"), ("srs_7r", "positioning_3r")])
def test_two_arms_in_one_unit_give_the_same_bits(name: str, beside: str, tmp_path: Path) -> None:
    """Two files in one unit compile without a warning; answers are those of Python, and nothing is allocated."""
    arm = urdf_ik.load(name)
    first, second, program = tmp_path / "arm.hpp", tmp_path / "other.hpp", tmp_path / "program"
    first.write_text(export.cpp(arm, "arm")), second.write_text(export.cpp(urdf_ik.load(beside), "other"))
    files = (f'-DARM_FILE="{first}"', f'-DOTHER_FILE="{second}"')
    source = str(PROGRAMS / "one_file.cpp")
    native_arms.run(compiler("CXX"), "-std=c++20", *FLAGS, *LEVEL, *WARNINGS, *files, source, "-o", str(program))
    q = np.random.default_rng(0).uniform(-3.0, 3.0, (200, arm.dof))
    q[:20] = np.round(q[:20] / (np.pi / 2)) * (np.pi / 2)
    T = arm.fk(q)
    done = native_arms.run(str(program), given=np.array([len(T), 0], np.int64).tobytes() + T.tobytes())
    expected = arm.ik(T)
    found = np.frombuffer(done.stdout, count=expected.q.size).reshape(expected.q.shape)
    flags = np.frombuffer(done.stdout, np.uint8, expected.valid.size, found.nbytes).reshape(expected.valid.shape)
    assert (flags == expected._info).all()
    assert found[expected.valid].tobytes() == expected.q[expected.valid].tobytes()
    assert done.stderr == b"0 allocations\n"


def targets(arm: urdf_ik.Arm) -> tuple[Array, Array | None]:
    """Poses (60, 4, 4), random and round, and values (60, p) of what they leave free."""
    rng = np.random.default_rng(5)
    q = rng.uniform(-3.0, 3.0, (60, arm.dof))
    q[:, [kind == "prismatic" for kind in arm.chain.joint_types]] *= 0.1
    q[::4] = np.round(q[::4] / (np.pi / 4)) * (np.pi / 4)
    T = arm.fk(q)
    return T, None if arm.redundancy is None else np.asarray(arm.solver.redundant_member.value_of(q, T))


def _chosen() -> list[tuple[str, urdf_ik.Arm]]:
    """Two arms of each family where URDF_IK_FAMILIES=all, otherwise one of each way in which a solver is built."""
    seen: Counter[str] = Counter()
    chosen = []
    for name, arm in [*core_arms.every_arm(), *mimics()]:
        family = arm.solver.require_member().name
        seen[family] += 1
        if seen[family] <= 2 and (ALL or name in FEW):
            chosen.append((name, arm))
    return chosen


def mimics() -> list[tuple[str, urdf_ik.Arm]]:
    """Arms whose joints drive several axes each: one joint that drives two, and a hollow wrist."""
    xml = urdf_ik.load("planar_2r").model.xml.decode()
    follower = '<child link="link_2"/><mimic joint="joint_1" multiplier="-1"/>'
    hollow = arms_hollow.hollow("mirrored")
    return [
        ("mimic of one joint", urdf_ik.load(xml.replace('<child link="link_2"/>', follower))),
        ("hollow wrist", urdf_ik.load(hollow, base="base", tip="tool")),
    ]


CHOSEN = _chosen()


@pytest.mark.parametrize(("name", "arm"), CHOSEN, ids=[name for name, _ in CHOSEN])
@pytest.mark.parametrize("compile_with", COMPILERS)
def test_each_family_gives_the_same_answers(compile_with: str, name: str, arm: urdf_ik.Arm, tmp_path: Path) -> None:
    """The library's compiler gives its bits without a warning, another one its counts; nothing is allocated."""
    header, program = tmp_path / "arm.hpp", tmp_path / "program"
    header.write_text(export.cpp(arm, "arm"))
    source, macro = str(PROGRAMS / "one_file.cpp"), f'-DARM_FILE="{header}"'
    command = (compile_with, "-std=c++20", *LEVEL, *WARNINGS, macro, source)
    native_arms.run(*command, *FREESTANDING, "-fsyntax-only")
    # Without exceptions GCC fuses other operations, so that the last digits differ at v3 and v4.
    level = FLAGS if compile_with == compiler("CXX") else (*FREESTANDING[1:], "-O1", *FLAGS[1:])
    native_arms.run(*command, *level, "-o", str(program))
    T, values = targets(arm)
    free_values = {} if values is None else {"redundancy": values[:, 0] if values.shape[1] == 1 else values}
    expected = arm.ik(T, **free_values)
    given = np.array([len(T), values is not None], np.int64).tobytes() + T.tobytes()
    given += b"" if values is None else np.ascontiguousarray(values).tobytes()
    done = native_arms.run(str(program), given=given)
    found = np.frombuffer(done.stdout, count=expected.q.size).reshape(expected.q.shape)
    flags = np.frombuffer(done.stdout, np.uint8, expected.valid.size, found.nbytes).reshape(expected.valid.shape)
    assert done.stderr == b"0 allocations\n"
    zero = np.frombuffer(done.stdout, count=16, offset=found.nbytes + flags.nbytes).reshape(4, 4)
    assert np.abs(zero - arm.fk(np.zeros(arm.dof))).max() < 1e-12
    if compile_with == compiler("CXX"):
        assert (flags == expected._info).all()
        assert found[expected.valid].tobytes() == expected.q[expected.valid].tobytes()
    else:
        valid = (flags & 1) > 0
        pose, _ = np.nonzero(valid)
        assert np.abs(arm.fk(found[valid]) - T[pose]).max() < 1e-9 * max(1.0, arm.chain.size)
        regular = ~expected.singular.any(axis=-1)
        assert (valid.sum(axis=-1) == expected.valid.sum(axis=-1))[regular].all()


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


def test_no_operating_system_is_needed(tmp_path: Path) -> None:
    """Without a C++ library, exceptions and run-time types, only functions of C are left to the linker."""
    header, source, unit = tmp_path / "scara.hpp", tmp_path / "unit.cpp", tmp_path / "unit.o"
    header.write_text(export.cpp(urdf_ik.load("scara_rrpr"), "scara"))
    source.write_text(
        '#include "scara.hpp"\nextern "C" int solve(const double* T, double* q, uint8_t* flags) '
        "{ return scara::ik(T, q, flags); }\n"
    )
    free = (*FREESTANDING, "-fno-stack-protector", "-fno-math-errno", "-Os")
    native_arms.run(compiler("CXX"), "-std=c++20", *free, *WARNINGS, "-c", str(source), "-o", str(unit))
    listed = subprocess.run(["nm", "-u", str(unit)], capture_output=True, text=True, check=True).stdout.split()
    assert {name for name in listed if name not in ("U", "w")} <= ALLOWED


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
    native_arms.run(compiler("CXX"), "-std=c++20", *WARNINGS, "-c", str(unit), "-o", parts[1])
    native_arms.run(compiler("CXX"), *parts, "-o", str(tmp_path / "program"))
    arm = urdf_ik.load("planar_2r")
    count = len(arm.ik(arm.fk([0.3, 0.4])))
    assert native_arms.run(str(tmp_path / "program")).stdout.decode() == f"{count} joint_2\n"


def test_what_cannot_be_exported_is_refused() -> None:
    """A name that is none in C++, a task that is not of poses, and a command that asks for no file."""
    arm = urdf_ik.load("planar_2r")
    with pytest.raises(ArgumentError, match="name='2r' given"):
        export.cpp(arm, "2r")
    with pytest.raises(UnsupportedArm, match="the task"):
        export.cpp(arm.for_task("planar position"))
    assert call("export", "planar_2r").exit_code == 2
