"""A project outside the repository that is built against an installed urdf_ik, and its programs' answers."""

import sys
import sysconfig
from pathlib import Path

import native_arms
import numpy as np
from native_arms import PROGRAMS

import urdf_ik
from urdf_ik.model import catalogue

PROJECT = PROGRAMS.parent / "consumer"
ARM = "zyyzyz_6r"
# One instruction set, and few optimisations: what the library answers is tested elsewhere.
SETTINGS = ("-DURDF_IK_LEVELS=v2",) if sysconfig.get_platform().endswith("x86_64") else ()


def cmake(*arguments: str) -> None:
    """Run CMake, which must succeed."""
    native_arms.run("nice", "cmake", *arguments)


def build(folder: Path, *options: str) -> None:
    """Configure and build the project in a folder."""
    urdf = catalogue.resolve(ARM).path
    cmake("-S", str(PROJECT), "-B", str(folder), f"-DPROGRAMS={PROGRAMS}", f"-DURDF={urdf}", *SETTINGS, *options)
    cmake("--build", str(folder), "--parallel", "2")


def solves(folder: Path, compiled: Path) -> None:
    """Assert that the three programs give the answers of Python, to the rounding of another instruction set."""
    arm = urdf_ik.load(ARM)
    compiled.write_text(urdf_ik.compile(arm))
    T = arm.fk(np.random.default_rng(3).uniform(-3.0, 3.0, (50, arm.dof)))
    expected = arm.ik(T)
    for program, header, arguments in (("solve", [50, 0, 0], [str(compiled)]), ("one_file", [50, 0], [])):
        given = np.array(header, np.int64).tobytes() + T.tobytes()
        q = np.frombuffer(native_arms.run(str(folder / program), *arguments, given=given).stdout, count=expected.q.size)
        apart = np.abs(q.reshape(expected.q.shape) - expected.q)[expected.valid]
        assert apart.max() < 1e-9
    said = native_arms.run(str(folder / "c_interface"), str(compiled)).stdout.decode().splitlines()
    assert said[0] == f"{urdf_ik.__version__} {arm.base} {arm.tip} {arm.dof} {expected.q.shape[-2]}"
    assert all(any(line.startswith(f"{name} ") for line in said) for name in arm.joint_names)


def with_python() -> str:
    """Of urdf_ik_export: the Python that makes the header."""
    return f"-Durdf_ik_PYTHON={sys.executable}"
