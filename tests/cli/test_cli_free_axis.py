"""The urdf-ik command with a free axis of the tip."""

import json
from pathlib import Path

import numpy as np
import pytest
from command import call

import urdf_ik


def test_ik_solves_the_turned_target() -> None:
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


def test_info_and_path_know_the_axis(tmp_path: Path) -> None:
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


def test_a_point_without_an_axis_is_refused() -> None:
    """--free-at says which line only where --free-axis says which direction."""
    result = call("ik", "puma_560", "--free-at", "0,0,0.1")
    assert result.exit_code == 2
    assert "--free-axis" in result.output
