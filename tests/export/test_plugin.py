"""The MoveIt plugin, loaded by ROS's class_loader and called through the base class; MoveIt's headers are stand-ins."""

import subprocess
from pathlib import Path

import core_arms
import native_arms
import pytest
from core_steps import FOLDER
from native_arms import PROGRAMS, compiler

import urdf_ik
from urdf_ik.cmake import core

ROOT = Path(__file__).resolve().parents[2]
# Debian's libclass-loader-dev and what it includes.
LOADER = Path("/usr/include/class_loader")
INCLUDED = [LOADER, *(LOADER.with_name(name) for name in ("rcpputils", "rcutils"))]
ARMS = [(name, arm) for name, arm in core_arms.every_arm() if arm.dof in (6, 7)][1:41:8]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not LOADER.is_dir(), reason="libclass-loader-dev is not installed"),
]


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """The program that calls the plugin, and the plugin."""
    place = tmp_path_factory.mktemp("plugin")
    library, program = place / "liburdf_ik_moveit_plugin.so", place / "program"
    include = [f"-I{PROGRAMS.parent / 'moveit_stubs'}", f"-I{core() / 'library'}"]
    include += [f"-isystem{folder}" for folder in INCLUDED]
    common = ["-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", "-fPIC", *include]
    rest = [str(FOLDER / "liburdf_ik_library.a"), "-lclass_loader", "-lrcpputils", "-lconsole_bridge"]
    source = str(ROOT / "ros" / "urdf_ik_moveit" / "src" / "plugin.cpp")
    native_arms.run(compiler("CXX"), *common, "-shared", source, "-o", str(library), *rest)
    native_arms.run(compiler("CXX"), *common, str(PROGRAMS / "plugin.cpp"), "-o", str(program), *rest)
    return [str(program), str(library)]


def run(built: list[str], *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """The program with files and links."""
    command = [*built, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize("links", [(), ("stand-in table", "stand-in gripper")], ids=["own links", "fixed links"])
@pytest.mark.parametrize(("name", "arm"), ARMS, ids=[name for name, _ in ARMS])
def test_every_overload_does_as_moveit_says(
    built: list[str], name: str, arm: urdf_ik.Arm, links: tuple[str, ...], tmp_path: Path
) -> None:
    """Limits, order, callback, consistency, cost, timeout, wrong numbers of poses and joints: the program's checks."""
    file = tmp_path / "arm.json"
    file.write_text(urdf_ik.compile(arm))
    done = run(built, file, file, *links)
    assert done.returncode == 0, done.stderr


def test_a_wrong_tip_and_a_stale_file_are_refused(built: list[str], tmp_path: Path) -> None:
    """The plugin does not start; its message names the link, or says that the URDF changed."""
    arm, then = urdf_ik.load("zyyzyz_6r"), tmp_path / "then.json"
    now = tmp_path / "now.json"
    now.write_text(urdf_ik.compile(arm))
    text = arm.model.xml.decode().replace('xyz="0 0 0.1"', 'xyz="0 0 0.1001"')
    then.write_text(urdf_ik.compile(urdf_ik.load(text)))
    stale = run(built, then, now)
    assert stale.returncode == 2 and "group arm: the robot model puts tool0" in stale.stderr
    assert "urdf-ik compile writes it anew" in stale.stderr
    wrong = run(built, now, now, arm.base, "elsewhere")
    assert wrong.returncode == 2 and "no link elsewhere" in wrong.stderr
