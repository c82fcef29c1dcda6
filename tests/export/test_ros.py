"""The parts of the ROS 2 packages that know nothing of ROS: the launch helper, and the service's answer."""

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import urdf_ik

PACKAGE = Path(__file__).resolve().parents[2] / "ros" / "urdf_ik_ros"
HALF = np.sqrt(0.5)


@pytest.fixture
def launch(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The Python package of urdf_ik_ros."""
    monkeypatch.syspath_prepend(str(PACKAGE))
    yield importlib.import_module("urdf_ik_launch")
    for name in [name for name in sys.modules if name.startswith("urdf_ik_launch")]:
        del sys.modules[name]


def test_the_launch_helper_compiles_robot_description(launch: ModuleType) -> None:
    """MoveIt's parameters of a group name the plugin and hold an arm that solves as the URDF's does."""
    arm = urdf_ik.load("puma_560")
    parameters = launch.kinematics(arm.model.xml.decode(), "manipulator", arm.base, arm.tip)
    settings = parameters["robot_description_kinematics"]["manipulator"]
    assert settings["kinematics_solver"] == "urdf_ik_moveit/Plugin"
    T = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
    assert urdf_ik.load_compiled(settings["compiled_arm"]).ik(T).q.tobytes() == arm.ik(T).q.tobytes()


@pytest.mark.parametrize("name", ["puma_560", "srs_7r"])
def test_the_service_answers_with_every_solution(launch: ModuleType, name: str) -> None:
    """Rows, branches and flags are as many; each row reaches the pose that was asked."""
    node = importlib.import_module("urdf_ik_launch.node")
    arm = urdf_ik.load(name)
    # A quarter turn about y.
    T = urdf_ik.pose([0.4, 0.1, 0.3], quat_xyzw=[0.0, HALF, 0.0, HALF])
    free = [0.2] if arm.redundancy is not None else []
    said = node.answer(arm, (0.4, 0.1, 0.3), (0.0, HALF, 0.0, HALF), redundancy=free)
    rows = np.reshape(said["solutions"], (-1, arm.dof))
    assert said["error"] == "" and said["status"] == "complete"
    assert len(rows) == len(said["branches"]) == len(said["within_limits"]) == len(said["singular"]) > 1
    assert np.abs(arm.fk(rows) - T).max() < 1e-9
    refused = node.answer(arm, (0.4, 0.1, float("nan")), (0.0, HALF, 0.0, HALF))
    assert "nan" in refused["error"].lower() and refused["solutions"] == []
