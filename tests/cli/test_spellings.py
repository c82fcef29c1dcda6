"""The command as one language: groups, one spelling for one thing, lists with spaces."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from command import ARM, TYPED, call, cell, strict_json, succeed

import urdf_ik
from urdf_ik.cli import app
from urdf_ik.cli.commands import COMMANDS

DRAWING = {"plot", "view", "compile", "export"}  # what they make is a picture or a file


def options() -> Iterator[tuple[str, Any]]:
    """Every option of every command, but --help."""
    group: Any = typer.main.get_command(app)
    for name in COMMANDS:
        for each in group.get_command(None, name).params:
            if each.param_type_name == "option":
                yield name, each


def test_every_command_that_prints_has_json() -> None:
    """--json is --format json, and not together with another format."""
    having = {name for name, option in options() if "--json" in option.opts}
    assert having == set(COMMANDS) - DRAWING
    assert succeed("fk", ARM, "--q", TYPED, "--json") == succeed("fk", ARM, "--q", TYPED, "-f", "json")
    assert call("fk", ARM, "--q", TYPED, "--json", "-f", "csv").exit_code == 2


@pytest.mark.parametrize(
    "typed",
    [
        ("--xyz", "0.4,-0.1,0.9", "--rpy", "0,1.57,0"),
        ("--xyz", "0.4", "-0.1", "0.9", "--rpy", "0", "1.57", "0"),
        ("--xyz=0.4", "-.1", "9e-1", "--rpy", "0,", "1.57,", "0"),
        ("--xyz", "0.4, -0.1, 0.9", "--rpy=0 1.57 0"),
        ("--xyz", "(0.4, -0.1, 0.9)", "--rpy", "[0,", "1.57,", "0]"),
    ],
)
def test_numbers_may_stand_with_commas_or_spaces(typed: tuple[str, ...]) -> None:
    """All these are one pose, also before the robot."""
    pose = urdf_ik.pose([0.4, -0.1, 0.9], rpy=[0.0, 1.57, 0.0])
    for args in ((ARM, *typed), (*typed, ARM)):
        np.testing.assert_allclose(strict_json(call("ik", *args, "--json").stdout)["poses"][0]["pose"], pose)


def test_several_poses_are_typed_in_turn() -> None:
    """Positions repeat, with an orientation for each or one for all."""
    typed = ("--xyz", "0.4", "-0.1", "0.9", "--xyz", "0.5,0,0.8", "--rpy", "0", "1.57", "0")
    poses = strict_json(call("ik", ARM, *typed, "--json").stdout)["poses"]
    expected = urdf_ik.pose([[0.4, -0.1, 0.9], [0.5, 0.0, 0.8]], rpy=[0.0, 1.57, 0.0])
    np.testing.assert_allclose([each["pose"] for each in poses], expected)
    result = call("ik", ARM, *typed, "--rpy", "0,0,0", "--rpy", "0,0,1")
    assert result.exit_code == 2 and "3 orientations for 2 positions" in result.stderr


def test_the_task_is_named_and_asked_for() -> None:
    """A position without an orientation says what a planar arm controls; with --task it is solved, and checked."""
    result = call("ik", "planar_2r", "--xyz", "0.1,0.05,0")
    assert result.exit_code == 2 and "--task planar-position" in result.stderr
    found = strict_json(succeed("ik", "planar_2r", "--xyz", "0.1", "0.05", "0", "--task", "planar-position", "--json"))
    arm = urdf_ik.load("planar_2r")
    for one in found["poses"][0]["solutions"]:
        np.testing.assert_allclose(arm.cell.reference.pose(one["q"])[:3, 3], [0.1, 0.05, 0.0], atol=1e-9)
        assert one["error"]["position"] <= 1e-9
    assert len(found["poses"][0]["solutions"]) == 2
    for robot, task in (("so101", "position"), ("planar_2r", "planar-position")):
        text = succeed("ik", robot, "--task", task, "--xyz", "0.1,0.05,0")
        assert "error [m]" in text and "error [rad]" not in text and "quaternion" not in text
    assert "are these mm?" in " ".join(
        succeed("ik", "so101", "--xyz", "200,100,50", "--rpy", "0,0,0", "--closest").split()
    )
    off = call("ik", "planar_2r", "--xyz", "0.1,0.05,0.2", "--task", "planar-position")
    assert off.exit_code == 2 and "0.2 m off the plane" in off.stderr


def test_explain_names_what_stands_in_the_way(tmp_path: Path) -> None:
    """Out of reach, out of limits and in contact are told apart, each with the part that is at fault."""
    assert "reach 2.1 m" in succeed("explain", ARM, "--xyz", "0,0,4", "--rpy", "0,0,0")
    world = cell(tmp_path / "cell.urdf", 'box size="9 9 9"')
    arm = urdf_ik.load(ARM)
    free = strict_json(succeed("explain", ARM, "--q", TYPED, "--json"))["poses"][0]
    inside = strict_json(succeed("explain", ARM, "--q", TYPED, "--world", world, "--json"))["poses"][0]
    assert free["of_use"] == len(arm.ik(arm.fk(np.array(TYPED.split(","), float))).within_limits().collision_free())
    assert inside["of_use"] == 0 and "touches post" in inside["each"][0] and "in collision" in inside["why"]
    limits = strict_json(succeed("explain", "panda", "--json"))["poses"][0]
    assert any("above its limits" in line for line in limits["each"]) and limits["intervals"]
