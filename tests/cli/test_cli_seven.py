"""The urdf-ik command where something is free in a pose: seven joints, a free axis; and joints that are held."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arms_seven import random_seven, skew, sliding
from command import call
from oracle import Oracle

import urdf_ik
from urdf_ik.model.poses import to_quat_wxyz

Q = (0.3, -0.5, 0.8, 0.4, 0.7, -0.2, 0.6)
TYPED = ",".join(map(str, Q))
LOCKED = "one behind wrist, 1x2"


@pytest.fixture
def swivel(tmp_path: Path) -> str:
    """Path of an S-R-S arm."""
    path = tmp_path / "swivel.urdf"
    path.write_text(random_seven("S-R-S", 1, orthogonal=True, aligned=True).urdf)
    return str(path)


@pytest.fixture
def ending(tmp_path: Path) -> str:
    """Path of an arm whose last joint is the parameter."""
    path = tmp_path / "ending.urdf"
    path.write_text(random_seven(LOCKED, 0).urdf)
    return str(path)


def data(*args: str) -> Any:
    """What a run that must succeed prints as JSON."""
    result = call(*args, "-f", "json")
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def test_a_planted_joint_vector_is_among_the_solutions(swivel: str, ending: str) -> None:
    """Without --redundancy a pose that was made of a joint vector is solved at that vector's own value."""
    for path in (swivel, ending):
        (pose,) = data("ik", path, "--base", "base", "--tip", "tool", "--q", TYPED)["poses"]
        found = np.array([one["q"] for one in pose["solutions"]])
        assert np.abs((found - Q + np.pi) % (2.0 * np.pi) - np.pi).max(axis=1).min() < 1e-6
        assert max(one["error"]["position"] for one in pose["solutions"]) < 1e-9
        summary = call("ik", path, "--base", "base", "--tip", "tool", "--random", "30").stdout
        assert "30 poses, 30 solved" in summary
    assert pose["redundancy"] == pytest.approx(Q[6])


def test_each_pose_at_each_value(ending: str) -> None:
    """--redundancy takes a list, in the unit that is asked for; every format tells the value."""
    arguments = ("ik", ending, "--base", "base", "--tip", "tool", "--degrees", "--no-check")
    q = ",".join(str(x) for x in np.rad2deg(Q))
    poses = data(*arguments, "--q", q, "--q", q.replace("17.", "18."), "--redundancy", "35,34")["poses"]
    assert [pose["redundancy"] for pose in poses] == pytest.approx([35.0, 34.0, 35.0, 34.0])
    assert poses[0]["pose"] == poses[1]["pose"] != poses[2]["pose"]
    for pose in poses:
        assert all(one["q"][6] == pytest.approx(pose["redundancy"]) for one in pose["solutions"])
    table = call(*arguments, "--q", q, "--redundancy", "35").stdout
    assert "joint_7 35.0000 deg" in table
    beyond = call("ik", "panda", "--q", q, "--degrees", "--redundancy", "9000,9170", "--no-check").stderr
    assert "--redundancy: 9170 deg is outside the value of joint 'panda_joint7'" in beyond
    text = call(*arguments, "--q", q, "--redundancy", "35", "-f", "csv").stdout
    rows = np.genfromtxt(io.StringIO(text), delimiter=",", names=True, usecols=range(10))
    np.testing.assert_allclose(np.atleast_1d(rows["redundancy"]), 35.0)


def test_info_tells_what_is_free(swivel: str, ending: str) -> None:
    """The parameter with its range and default, as text and as data; null for six joints."""
    ends = ("--base", "base", "--tip", "tool")
    assert "swivel angle" in " ".join(call("info", swivel, *ends).stdout.split())
    assert data("info", ending, *ends)["solver"]["redundancy"]["joint"] == "joint_7"
    assert data("info", "zyyzyz_6r")["solver"]["redundancy"] is None


@pytest.mark.parametrize(
    ("options", "status", "words"),
    [
        (("--redundancy", "much"), 2, ("--redundancy", "'much'")),
        (("--redundancy", ","), 2, ("--redundancy",)),
        (("--lock", "joint_1"), 2, ("--lock", "NAME=VALUE", "joint_1")),
        (("--lock", "joint_1=far"), 2, ("--lock", "joint_1=far")),
        (("--lock", "=3"), 2, ("--lock",)),
        (("--lock", "joint_9=0"), 3, ("joint_9", "joint_1, joint_2")),
        (("--lock", "joint_1=0", "--redundancy", "0.1"), 2, ("6 joints", "--redundancy")),
    ],
)
def test_mistakes_are_named(ending: str, options: tuple[str, ...], status: int, words: tuple[str, ...]) -> None:
    """One readable message and the status of its kind."""
    result = call("ik", ending, "--base", "base", "--tip", "tool", "--q", ",".join(["0.1"] * 7), *options)
    if options[0] == "--lock" and len(options) > 2:
        result = call("ik", ending, "--base", "base", "--tip", "tool", "--random", "1", *options)
    assert result.exit_code == status, result.output
    shown = " ".join(result.stderr.replace("│", " ").split())
    assert all(word in shown for word in words), shown


def test_held_joints(tmp_path: Path) -> None:
    """Eight joints are solved, and six when two are held, in degrees or metres; the check holds, info tells them."""
    text = sliding(skew(8), 2, 0.0, 1.0)
    path = tmp_path / "eight.urdf"
    path.write_text(text)
    whole = ("--base", "base", "--tip", "tool")
    held = (*whole, "--lock", "joint_2=0.3", "--lock", "joint_5=30deg")
    free = data("ik", str(path), *whole, "--random", "1")["poses"][0]
    assert len(free["redundancy"]) == 2
    assert free["solutions"]
    asked = data("ik", str(path), *whole, "--random", "1", "--redundancy", "0.1,0.2,0.3,0.4")["poses"]
    assert [one["redundancy"] for one in asked] == [[0.1, 0.2], [0.3, 0.4]]
    more = tmp_path / "ten.urdf"
    more.write_text(skew(10))
    refused = call("ik", str(more), *whole, "--random", "1")
    assert refused.exit_code == 4
    assert "locked={'joint_1': 0.0}" in refused.stderr
    full = np.array([0.1, 0.3, 0.2, -0.4, np.pi / 6, 0.5, -0.1, 0.7])
    q = ",".join(map(str, np.delete(full, [1, 4])))
    pose = np.array(data("fk", str(path), *held, "--q", q)["poses"][0]["pose"])
    np.testing.assert_allclose(pose, Oracle(text).pose(full), atol=1e-12)
    found = data("ik", str(path), *held, "--q", q, "--no-check")["poses"][0]["solutions"]
    assert found
    assert call("check", str(path), *held, "-n", "5", "--no-collisions").exit_code == 0
    shown = call("info", str(path), *held).stdout
    assert "joint_2 = 0.3, joint_5 = 0.523599" in shown
    assert data("info", str(path), *held)["locked"] == pytest.approx({"joint_2": 0.3, "joint_5": np.pi / 6})


def test_nearest_looks_over_all_values_of_the_parameter(swivel: str) -> None:
    """It is the solution that the library finds; typed values of the parameter stay."""
    arm = urdf_ik.load(swivel)
    target = arm.fk(np.array(Q) + 0.3)
    pose = ("--xyz", ",".join(map(repr, target[:3, 3].tolist())))
    pose += ("--quat-wxyz", ",".join(map(repr, to_quat_wxyz(target).tolist())))
    near = arm.ik_nearest(target, Q, within_limits=False)
    found = json.loads(call("ik", swivel, *pose, "--nearest", TYPED, "-f", "json").stdout)
    (solution,) = found["poses"][0]["solutions"]
    np.testing.assert_allclose(solution["q"], near.q[0], atol=1e-6)
    held = json.loads(call("ik", swivel, *pose, "--nearest", TYPED, "--redundancy", "0.2", "-f", "json").stdout)
    (other,) = held["poses"][0]["solutions"]
    assert np.linalg.norm(np.array(other["q"]) - Q) > np.linalg.norm(near.q[0] - Q)


def test_a_free_axis_turns_the_target() -> None:
    """The solutions are those of the library at the same value; in degrees where asked."""
    result = call(
        "ik", "puma_560", "--free-axis", "0,1,0", "--free-at", "0,0,0.1", "--redundancy", "30", "--degrees",
        "--q", "10,20,30,40,50,60", "-f", "json",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    (pose,) = json.loads(result.stdout)["poses"]
    arm = urdf_ik.load("puma_560").with_free_axis((0, 1, 0), (0, 0, 0.1))
    wanted = arm.ik(arm.fk(np.deg2rad([10, 20, 30, 40, 50, 60])), redundancy=np.deg2rad(30.0)).to_array()
    found = np.array([one["q"] for one in pose["solutions"]])
    np.testing.assert_allclose(found, np.rad2deg(wanted), atol=1e-9)
    assert pose["redundancy"] == pytest.approx(30.0)


def test_info_and_path_know_the_free_axis(tmp_path: Path) -> None:
    """What is free is named; a path turns about it."""
    printed = call("info", "puma_560", "--free-axis", "z").stdout
    assert "rotation about the tip's z axis" in printed
    arm = urdf_ik.load("puma_560")
    here = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
    turned = here @ urdf_ik.pose([0.0, 0.0, 0.0], rotvec=[0.0, 0.0, 1.0])
    np.save(tmp_path / "path.npy", urdf_ik.line(here, turned, 10))
    asked = ("path", "puma_560", "--poses", str(tmp_path / "path.npy"), "--no-collisions", "-f", "json")
    fixed, free = (json.loads(call(*asked, *more).stdout)["cost"] for more in ((), ("--free-axis", "z")))
    assert free < 1e-9 < fixed
