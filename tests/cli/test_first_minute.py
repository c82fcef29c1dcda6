"""The first minute: the command alone, `robots`, `doctor`, formats and chains on the command line."""

import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from chains import joint, robot
from command import ARM, call, strict_json, succeed

from urdf_ik.cli.commands import installation
from urdf_ik.model import catalogue

TWO = robot(joint("l", "continuous", "base", "left"), joint("r", "continuous", "base", "right"))
XACRO = """<robot name="made" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="up" default="1"/>
<link name="base"/><link name="tip"/><joint name="j" type="continuous"><parent link="base"/><child link="tip"/>
<origin xyz="0 0 $(arg up)"/></joint></robot>"""


def test_the_command_alone_says_what_to_do_next(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without arguments the status is 0, and the commands that are shown exist and are about a URDF that is here."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "welder.urdf").write_text(TWO)
    text = succeed()
    shown = [line.split()[1] for line in text.splitlines() if line.startswith("  urdf-ik")]
    assert {"ik", "robots", "info", "check", "view", "doctor"} <= set(shown)
    assert "urdf-ik info welder.urdf" in text
    for command in set(shown):
        succeed(command, "--help")


def test_a_library_that_the_system_lacks_is_named(tmp_path: Path) -> None:
    """Where pin's libraries cannot be loaded the message says what to install, without a traceback."""
    lacking = "libgomp.so.1: cannot open shared object file: No such file or directory"
    (tmp_path / "pinocchio.py").write_text(f"raise ImportError({lacking!r})")
    done = subprocess.run(
        [sys.executable, "-c", "from urdf_ik.cli import app; app()", "ik", "zyyzyz_6r"],
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert lacking in done.stderr and "apt install libgomp1" in done.stderr and "Traceback" not in done.stderr


def test_robots_lists_every_name() -> None:
    """Each catalogue name stands there with the family and joints of its arm; those of other packages on demand."""
    robots = {robot["name"]: robot for robot in strict_json(succeed("robots", "-f", "json"))["robots"]}
    assert set(catalogue.names()) <= set(robots)
    assert (robots["ur5"]["joints"], robots["ur5"]["family"]) == (6, "6R 2||3||4 and 5x6")
    assert robots["zyyzyz_6r"]["here"] and robots["zyyzyz_6r"]["source"] == "bundled"
    table = succeed("robots", "puma")
    assert "puma_560" in table and "ur5" not in table


def test_the_doctor_finds_versions_and_a_working_solver() -> None:
    """It names what is installed, and finds all joint vectors that it made poses of."""
    found = strict_json(succeed("doctor", "--json"))
    assert found["passed"] and all(test["error"] < 1e-12 for test in found["tests"])
    assert found["versions"]["numpy"] and found["instruction_sets"]["used"] in found["instruction_sets"]["built"]
    assert "all is well" in succeed("doctor")


def test_the_doctor_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A package that is not there is named with its extra; a needed one ends with status 1."""
    found = metadata.version

    def version(package: str) -> str:
        if package == "viser":
            raise metadata.PackageNotFoundError
        return found(package)

    monkeypatch.setattr(metadata, "version", version)
    assert "without viser: pip install 'viser>=" in succeed("doctor")
    monkeypatch.setattr(installation, "NEEDED", ("numpy", "no-such-package"))
    result = call("doctor")
    assert result.exit_code == 1 and "something is wrong" in result.stdout


def test_chains_are_listed_and_chosen_by_name(tmp_path: Path) -> None:
    """Chains are listed by `info --chains`; --chain takes one; without it the doubt is an error that names both."""
    file = tmp_path / "two.urdf"
    file.write_text(TWO)
    chains = strict_json(succeed("info", str(file), "--chains", "-f", "json"))["chains"]
    assert [(each["name"], each["chosen"]) for each in chains] == [("left", False), ("right", False)]
    beside = strict_json(succeed("info", "ur5", "--base", "base", "--chains", "-f", "json"))
    assert [each["tip"] for each in beside["chains"]] == ["tool0"]
    assert "none is meant by itself: name one with --chain" in succeed("info", str(file), "--chains")
    assert strict_json(succeed("info", str(file), "--chain", "left", "-f", "json"))["tip"] == "left"
    result = call("info", str(file))
    assert result.exit_code == 3 and "'left': base to left" in result.stderr
    srdf = tmp_path / "two.srdf"
    srdf.write_text('<robot name="two"><group name="r"><chain base_link="base" tip_link="right"/></group></robot>')
    assert strict_json(succeed("info", str(file), "--srdf", str(srdf), "-f", "json"))["tip"] == "right"


def test_pairs_that_may_touch_are_listed_and_chosen(tmp_path: Path) -> None:
    """`info --pairs` lists them; --srdf and --allow take them from the check, of every command that reads an arm."""
    srdf = tmp_path / "arm.srdf"
    srdf.write_text('<robot name="r"><disable_collisions link1="link_4" link2="link_6"/></robot>')
    pair = ["link_4", "link_6"]
    assert pair in strict_json(succeed("info", ARM, "--pairs", "-f", "json"))["checked"]
    for options, why in ((("--srdf", str(srdf)), "srdf"), (("--allow", "link_4, link_6"), "allowed")):
        listed = strict_json(succeed("info", ARM, *options, "--pairs", "-f", "json"))
        assert [*pair, why] in listed["allowed"] and pair not in listed["checked"]
    assert "allowed: srdf" in succeed("info", ARM, "--srdf", str(srdf), "--pairs")
    assert "1 pair of links" in succeed("info", ARM, "--srdf", str(srdf))
    for wrong in ("link_4", "link_4,", "link_4,nothing"):
        result = call("info", ARM, "--allow", wrong)
        assert result.exit_code == 2 and "link" in result.stderr


def test_the_choice_is_said(tmp_path: Path) -> None:
    """A tip that was chosen among several links is named on standard error, with the others."""
    file = tmp_path / "one.urdf"
    camera = '<link name="camera"/><joint name="c" type="fixed"><parent link="tool0"/><child link="camera"/></joint>'
    file.write_text(catalogue.resolve(ARM).path.read_text().replace("</robot>", f"{camera}</robot>"))
    result = call("info", str(file))
    assert result.exit_code == 0
    assert "chain: base_link to tool0 (named as a tool frame)" in result.stderr and "camera" in result.stderr


def test_arguments_of_a_xacro(tmp_path: Path) -> None:
    """--xacro-arg sets one; what is no NAME:=VALUE, and what the xacro has not, is refused."""
    pytest.importorskip("xacro")
    file = tmp_path / "made.urdf.xacro"
    file.write_text(XACRO)
    assert "2.5" in succeed("fk", str(file), "--xacro-arg", "up:=2.5", "--q", "0", "-f", "csv")
    assert call("fk", str(file), "--xacro-arg", "up=2.5", "--q", "0").exit_code == 2
    result = call("fk", str(file), "--xacro-arg", "down:=2.5", "--q", "0")
    assert result.exit_code == 3 and "it has no argument 'down'" in result.stderr
