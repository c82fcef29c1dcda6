"""The library as a CMake project: installed, found by find_package and pkg-config, linked by C++ and C."""

import shutil
from pathlib import Path

import consumer
import native_arms
import pytest
from native_arms import PROGRAMS, WARNINGS, compiler

import urdf_ik
from urdf_ik.cmake import core

pytestmark = [
    pytest.mark.slow,  # compiles the whole core
    pytest.mark.skipif(shutil.which("cmake") is None, reason="cmake is not installed"),
]


@pytest.fixture(scope="module")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder into which `cmake --install` put the library, without Python's help."""
    place = tmp_path_factory.mktemp("library")
    prefix, build = place / "prefix", place / "build"
    consumer.cmake("-S", str(core()), "-B", str(build), f"-DCMAKE_INSTALL_PREFIX={prefix}", *consumer.SETTINGS)
    consumer.cmake("--build", str(build), "--parallel", "2")
    consumer.cmake("--install", str(build))
    return prefix


def test_a_project_finds_the_installed_library(prefix: Path, tmp_path: Path) -> None:
    """find_package gives the library and urdf_ik_export; programs in C++ and C solve."""
    consumer.build(tmp_path / "build", f"-DCMAKE_PREFIX_PATH={prefix}", consumer.with_python())
    consumer.solves(tmp_path / "build", tmp_path / "arm.json")


@pytest.mark.skipif(shutil.which("pkg-config") is None, reason="pkg-config is not installed")
def test_pkg_config_names_all_that_a_c_program_needs(prefix: Path, tmp_path: Path) -> None:
    """A C program is compiled and linked by a C compiler with what pkg-config says."""
    (folder,) = {file.parent for file in prefix.rglob("urdf_ik.pc")}
    said = native_arms.run("pkg-config", "--static", "--cflags", "--libs", "urdf_ik", PKG_CONFIG_PATH=str(folder))
    program, file = tmp_path / "program", tmp_path / "arm.json"
    source = str(PROGRAMS / "c_interface.c")
    flags = said.stdout.decode().split()
    native_arms.run(compiler("CC"), "-std=c11", *WARNINGS, source, *flags, "-o", str(program))
    arm = urdf_ik.load("puma_560")
    file.write_text(urdf_ik.compile(arm))
    assert f"{arm.base} {arm.tip} 6 8" in native_arms.run(str(program), str(file)).stdout.decode()
