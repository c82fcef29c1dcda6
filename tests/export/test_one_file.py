"""One arm as one file: compiled with every warning, alone or beside another arm, it gives the bits of the package."""

from __future__ import annotations

import subprocess
from pathlib import Path

import native_arms
import numpy as np
import pytest
from command import call
from native_arms import PROGRAMS, WARNINGS, compiler

import urdf_ik
from urdf_ik import _core, export
from urdf_ik.errors import ArgumentError, UnsupportedArm

# The flags of the library, without which the compiler fuses other operations.
FLAGS = ("-O3", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
LEVEL = {"v2": ("-march=x86-64-v2",), "v3": ("-march=x86-64-v3",), "v4": ("-march=x86-64-v4",)}.get(_core.isa(), ())
# What a controller's toolchain has: the C library's own names, and the mathematics.
ALLOWED = {"memcpy", "memset", "memmove", "sin", "cos", "log"}


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


def test_no_operating_system_is_needed(tmp_path: Path) -> None:
    """Without a C++ library, exceptions and run-time types, only functions of C are left to the linker."""
    header, source, unit = tmp_path / "scara.hpp", tmp_path / "unit.cpp", tmp_path / "unit.o"
    header.write_text(export.cpp(urdf_ik.load("scara_rrpr"), "scara"))
    source.write_text(
        '#include "scara.hpp"\nextern "C" int solve(const double* T, double* q, uint8_t* flags) '
        "{ return scara::ik(T, q, flags); }\n"
    )
    free = ("-ffreestanding", "-fno-exceptions", "-fno-rtti", "-fno-stack-protector", "-fno-math-errno", "-Os")
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
    """A name that is none in C++, and joints that mimic others."""
    arm = urdf_ik.load("planar_2r")
    with pytest.raises(ArgumentError, match="name='2r' given"):
        export.cpp(arm, "2r")
    xml = arm.model.xml.decode().replace(
        '<child link="link_2"/>', '<child link="link_2"/><mimic joint="joint_1" multiplier="-1"/>'
    )
    with pytest.raises(UnsupportedArm, match="urdf-ik compile"):
        export.cpp(urdf_ik.load(xml))
    assert call("export", "planar_2r").exit_code == 2
