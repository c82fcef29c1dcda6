"""With --degrees every command speaks of angles in degrees, in text and data, and takes back what it prints."""

import re
from pathlib import Path

import numpy as np
import pytest
from command import call, strict_json, succeed

import urdf_ik

SEVEN = "10,20,30,40,50,60,70"
SIX = "10,20,30,40,50,60"
COMMANDS = [
    "info srs_7r",
    "info puma_560 --lock joint_6=30deg",
    "info srs_7r --format json",
    f"fk puma_560 --q {SIX}",
    f"fk puma_560 --q {SIX} --format csv",
    f"ik srs_7r --q {SEVEN}",
    f"ik srs_7r --q {SEVEN} --format json",
    f"ik puma_560 --q {SIX} --within-limits --nearest 0,0,0,0,0,0 --max-step 5",
    "ik puma_560 --xyz 0.3,0.2,0.9 --rpy 170,10,20 --within-limits",
    "ik srs_7r --xyz 0.1,0,1.2 --rpy 180,0,0 --redundancy 60 --within-limits",
    "ik srs_7r --xyz 5,0,1.2 --rpy 180,0,0",
    "ik planar_2r --xyz 0.1,0.05,0 --rpy 20,0,0",
    "ik puma_560 --xyz 0.3,0.2,0.9 --rpy 170,10,20 --free-axis z",
    f"explain srs_7r --q {SEVEN}",
    f"explain srs_7r --q {SEVEN} --json",
    "explain puma_560 --xyz 0.3,0.2,0.9 --rpy 170,10,20",
    "explain puma_560 --xyz 0.3,0.2,0.9 --rpy 170,10,20 --free-axis z",
    "compare puma_560 zyyzyz_6r -n 3",
    "compare puma_560 zyyzyz_6r planar_2r -n 3",
    "dh puma_560",
    "dh puma_560 --format csv",
    "workspace planar_2r",
    "workspace planar_2r --json",
    "path zyyzyz_6r --q 0,40,50,0,50,0 --q 10,40,50,0,50,0 --no-collisions",
    "path zyyzyz_6r --q 0,40,50,0,50,0 --q 10,40,50,0,50,0 --no-collisions --json --alternatives",
    "path puma_560 --q 0,40,50,0,50,0 --q 150,-40,50,90,50,0 --no-collisions",
    "placement zyyzyz_6r --q 0,40,50,0,50,0 --bounds=0,0,0,0,0,0 --step 0.5 --mount 30,0,0",
]


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_prints_radians(command: str) -> None:
    """Neither in a table, nor in an explanation, nor as the unit of data."""
    result = call(*command.split(), "--degrees")
    assert result.exit_code in (0, 1), result.output
    assert not re.search(r"\brad(ians)?\b", result.output), result.output


def test_data_are_the_same_but_for_the_unit() -> None:
    """Ranges, defaults and locked joints of info, arcs of a workspace, rooms and costs of a plan: 180 / pi times."""
    for command, parts in (
        ("info srs_7r", lambda d: [*d["solver"]["redundancy"]["range"], d["joints"][0]["lower"]]),
        ("info puma_560 --lock joint_6=30deg", lambda d: list(d["locked"].values())),
        ("workspace planar_2r", lambda d: [a["start"] for a in d["regions"]["either elbow"]["arcs"]]),
        ("path zyyzyz_6r --q Q --q R --no-collisions --cost l1", lambda d: [d["cost"], *d["margins"]["limits"]]),
    ):
        q = np.array([[0, 40, 50, 0, 50, 0], [10, 40, 50, 0, 50, 0]], dtype=float)
        typed = [",".join(map(repr, row)) for row in (*np.deg2rad(q).tolist(), *q.tolist())]
        radians = strict_json(succeed(*command.replace("Q", typed[0]).replace("R", typed[1]).split(), "--json"))
        asked = command.replace("Q", typed[2]).replace("R", typed[3]).split()
        degrees = strict_json(succeed(*asked, "--json", "--degrees"))
        np.testing.assert_allclose(parts(degrees), np.rad2deg(parts(radians)), rtol=1e-6)


def test_an_interval_that_is_printed_can_be_typed_back(tmp_path: Path) -> None:
    """Of seven joints with no solution at the default: each offered interval's middle has one."""
    arm = urdf_ik.load("srs_7r").with_redundancy("joint_1")
    T = arm.fk(np.deg2rad([80.0, 80.0, 30.0, 15.0, 20.0, 60.0, 70.0]))  # nearly stretched: joint 1 has little choice
    x, y, z = T[:3, 3].tolist()
    rpy = ",".join(map(repr, np.rad2deg(urdf_ik.model.poses.to_rpy(T)).tolist()))
    ask = ["ik", "srs_7r", "--redundancy-joint", "joint_1", "--xyz", f"{x!r},{y!r},{z!r}", f"--rpy={rpy}", "--degrees"]
    first = call(*ask, "--redundancy=-20")
    found = re.findall(r"(-?[\d.]+) to (-?[\d.]+) deg", " ".join(first.output.split("there are solutions")[-1].split()))
    assert first.exit_code == 1 and found, first.output
    for low, high in found:
        middle = (float(low) + float(high)) / 2
        assert call(*ask, f"--redundancy={middle}").exit_code == 0


def test_a_pendant_measures_joint_3_against_the_horizon() -> None:
    """The hand keeps its orientation while joint 2 alone moves, and what ik shows is typed back."""
    vectors = [f"0.2,{second},0.4,0.3,0.5,0.1" for second in (-0.6, 0.2, 1.0)]
    typed = [f"--q={each}" for each in vectors]
    found = strict_json(succeed("fk", "puma_560", "--pendant", "--json", *typed))
    reference = urdf_ik.load("puma_560").cell.reference
    poses = [np.array(each["pose"]) for each in found["poses"]]
    np.testing.assert_allclose([each["q"][2] for each in found["poses"]], 0.4, atol=1e-15)
    for pose in poses:
        np.testing.assert_allclose(pose[:3, :3], poses[0][:3, :3], atol=1e-12)
    whole = np.array([0.2, 1.0, 0.4 - 1.0, 0.3, 0.5, 0.1])
    np.testing.assert_allclose(reference.pose(whole), poses[2], atol=1e-12)
    answer = strict_json(succeed("ik", "puma_560", "--pendant", "--json", f"--q={vectors[2]}"))
    shown = np.array([each["q"] for each in answer["poses"][0]["solutions"]])
    assert np.abs(shown - [0.2, 1.0, 0.4, 0.3, 0.5, 0.1]).max(axis=1).min() < 1e-9
