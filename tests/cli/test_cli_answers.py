"""What urdf-ik ik answers: the same solutions in every format and notation, and what filters keep."""

import csv
import io
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from arms import industrial
from command import ARM, TYPED, Q, call, cell, comma, oracle, strict_json, succeed, target, vectors
from oracle import angle_distance

import urdf_ik
from urdf_ik import IKSolutions
from urdf_ik.model import catalogue


def test_the_example_shows_all_eight_solutions() -> None:
    """``urdf-ik ik zyyzyz_6r``, the job of ``make run``: eight named branches with limits, collision and error."""
    text = succeed("ik", ARM)
    assert "8 solutions" in text
    for word in ("front", "back", "up", "down", "noflip", "flip", "in limits", "collision", "singular", "error [m]"):
        assert word in text
    data = strict_json(succeed("ik", ARM, "-f", "json"))["poses"][0]
    assert len({one["branch"] for one in data["solutions"]}) == 8
    assert all(one["within_limits"] in (True, False) for one in data["solutions"])


def test_solutions_and_errors_are_pinocchios() -> None:
    """Every solution in the data reaches the pose under Pinocchio, and the error printed is the one it measures."""
    pose = strict_json(succeed("ik", ARM, "--q", TYPED, "-f", "json"))["poses"][0]
    assert np.abs(np.array(pose["pose"]) - target()).max() < 1e-12
    for one in pose["solutions"]:
        error = oracle().error(np.array(one["q"]), target())
        assert error < 1e-9
        assert abs(max(one["error"]["position"], one["error"]["rotation"]) - error) < 1e-14
    assert angle_distance(np.array([one["q"] for one in pose["solutions"]]), np.array(Q)).min() < 1e-9


def test_formats_hold_the_same_solutions() -> None:
    """JSON, CSV and npz of the same poses hold the same joint vectors, branches, flags and errors, to the last bit."""
    args = ("ik", ARM, "--random", "5", "--check")
    data = strict_json(succeed(*args, "-f", "json"))
    flat = [(i, one) for i, pose in enumerate(data["poses"]) for one in pose["solutions"]]
    rows = list(csv.DictReader(io.StringIO(succeed(*args, "-f", "csv"))))
    raw = call(*args, "-f", "npz").stdout_bytes
    with np.load(io.BytesIO(raw), allow_pickle=False) as arrays:
        valid = arrays["valid"]
        assert arrays["poses"].tolist() == [pose["pose"] for pose in data["poses"]]
        assert arrays["q"][valid].tolist() == [one["q"] for _, one in flat]
        assert arrays["branches"][valid].tolist() == [one["branch"] for _, one in flat]
        assert arrays["within_limits"][valid].tolist() == [one["within_limits"] for _, one in flat]
        assert arrays["collision_free"][valid].tolist() == [one["collision_free"] for _, one in flat]
        assert arrays["position_error"][valid].tolist() == [one["error"]["position"] for _, one in flat]
        assert np.isnan(arrays["q"][~valid]).all()
    assert len(rows) == len(flat)
    for row, (i, one) in zip(rows, flat, strict=True):
        assert (int(row["pose"]), row["branch"]) == (i, one["branch"])
        assert [float(row[name]) for name in data["joints"]] == one["q"]
        assert bool(int(row["within_limits"])) == one["within_limits"]
        assert bool(int(row["collision_free"])) == one["collision_free"]
        assert float(row["rotation_error"]) == one["error"]["rotation"]


def test_numpy_reads_the_csv() -> None:
    """The numbers come first in the CSV, so that NumPy reads them without knowing of the quoted branch names."""
    text = succeed("ik", ARM, "--q", TYPED, "-f", "csv")
    numbers = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1, usecols=range(1, 7), quotechar='"')
    assert numbers.tolist() == vectors(succeed("ik", ARM, "--q", TYPED, "-f", "json")).tolist()


def test_orientations_in_any_notation_are_the_same_pose() -> None:
    """A pose typed with either quaternion, roll-pitch-yaw or a rotation vector, in rad or degrees, is the same pose."""
    T = target()
    quat = pin.Quaternion(T[:3, :3]).coeffs()
    notations = {
        "--quat-xyzw": quat,
        "--quat-wxyz": quat[[3, 0, 1, 2]],
        "--rpy": pin.rpy.matrixToRpy(T[:3, :3]),
        "--rotvec": pin.log3(T[:3, :3]),
    }
    for option, values in notations.items():
        for degrees in (False, True):
            shown = np.rad2deg(values) if degrees and len(values) == 3 else values
            more = ("--degrees",) if degrees else ()
            text = succeed("ik", ARM, "--xyz", comma(T[:3, 3]), option, comma(shown), "-f", "json", *more)
            assert np.abs(np.array(strict_json(text)["poses"][0]["pose"]) - T).max() < 1e-12, option


def test_degrees_typed_as_radians_are_said() -> None:
    """Angles of more than a turn are told with their unit and the option that reads degrees; others are not."""
    pose = ("ik", ARM, "--xyz", "0.4", "0", "0.3", "--rpy")
    assert "in rad, of which 90 are 14.3 turns" in " ".join(succeed(*pose, "0", "90", "0").split())
    assert "in rad, of which" not in " ".join(succeed(*pose, "0", "1.57", "0").split())


def test_degrees_are_the_same_answers() -> None:
    """--degrees turns every angle, in and out, and changes nothing else."""
    radians = strict_json(succeed("ik", ARM, "--q", TYPED, "-f", "json"))
    degrees = strict_json(succeed("ik", ARM, "--q", comma(np.rad2deg(Q)), "--degrees", "-f", "json"))
    assert (radians["units"]["angle"], degrees["units"]["angle"]) == ("rad", "deg")
    for one, other in zip(radians["poses"][0]["solutions"], degrees["poses"][0]["solutions"], strict=True):
        assert one["branch"] == other["branch"]
        assert np.abs(np.deg2rad(other["q"]) - one["q"]).max() < 1e-12
    fk = [succeed("fk", ARM, "--q", TYPED), succeed("fk", ARM, "--q", comma(np.rad2deg(Q)), "--degrees")]
    assert fk[0].splitlines()[:-1] == fk[1].splitlines()[:-1]


CHOICES: dict[str, Callable[[IKSolutions], IKSolutions]] = {
    "--collision-free": lambda s: s.collision_free(),
    "--within-limits": lambda s: s.within_limits(),
    f"--nearest {TYPED}": lambda s: s.nearest(Q),
    f"--nearest {TYPED} --metric max --max-step 2": lambda s: s.nearest(Q, metric="max", within=2),
    f"--nearest {TYPED} --metric time": lambda s: s.nearest(Q, metric="time"),
    "--best limits": lambda s: s.best("limits"),
    "--turns": lambda s: s.turns(),
}


@pytest.mark.parametrize("typed", CHOICES)
def test_filters_keep_what_the_library_keeps(typed: str) -> None:
    """Limits, collisions, nearest, best and turns: the library's solutions, and the motion of each joint to them."""
    count = "4" if typed == "--turns" else "20"  # each solution has dozens of images
    args = ("ik", "dh_6r", "--random", count, "--seed", "3", "-f", "json", *typed.split())
    poses = strict_json(call(*args).stdout)["poses"]
    s = urdf_ik.load("dh_6r").ik([pose["pose"] for pose in poses])
    kept = CHOICES[typed](s)
    assert not np.array_equal(kept.count, s.count)
    for k, pose in enumerate(poses):
        np.testing.assert_array_equal([one["q"] for one in pose["solutions"]] or np.empty((0, 6)), kept[k].to_array())
        for one in pose["solutions"]:
            assert "difference" not in one or np.abs(np.array(one["q"]) - one["difference"] - Q).max() < 1e-12


def test_no_check_leaves_pinocchio_out() -> None:
    """With --no-check neither Pinocchio nor coal is brought in, and neither errors nor collisions are claimed."""
    code = "import sys; from urdf_ik.cli import app; app(sys.argv[1:], standalone_mode=False); print(*sys.modules)"
    command = [sys.executable, "-c", code, "ik", ARM, "--no-check", "-f", "csv"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    header, *_, modules = done.stdout.splitlines()
    assert not {"pinocchio", "coal"} & set(modules.split())
    assert "error" not in header
    assert "collision" not in header


def test_urdf_from_standard_input() -> None:
    """``-`` reads the URDF from stdin, with the same result as its file."""
    path = catalogue.resolve(ARM).path
    piped = strict_json(succeed("info", "-", "-f", "json", given=path.read_bytes()))
    named = strict_json(succeed("info", str(path), "-f", "json"))
    assert {**piped, "source": ""} == {**named, "source": ""}


def test_arm_without_collision_shapes_is_solved_and_says_so() -> None:
    """Where there is nothing to check for collision, solutions come all the same, and none is called free."""
    text = succeed("ik", "-", "--base", "base", "--tip", "tool", given=industrial().urdf)
    assert "self-collision was not checked" in text
    assert "free" not in text
    assert "error [m]" in text


def test_a_tool_at_the_tip() -> None:
    """Every command takes it: the pose is the tip's times the tool's, its solutions reach it, angles are as typed."""
    tool = ("--tool-xyz", "0.03,0,0.2", "--tool-rpy", "0.1,0.5,-0.3")
    arm = urdf_ik.load(ARM)
    T = arm.fk(Q) @ urdf_ik.pose([0.03, 0.0, 0.2], rpy=[0.1, 0.5, -0.3])
    (shown,) = strict_json(succeed("fk", ARM, "--q", TYPED, "-f", "json", *tool))["poses"]
    np.testing.assert_allclose(shown["pose"], T, atol=1e-12)
    degrees = ("--degrees", "--tool-xyz", "0.03,0,0.2", "--tool-rpy", comma(np.rad2deg([0.1, 0.5, -0.3])))
    (same,) = strict_json(succeed("fk", ARM, "--q", comma(np.rad2deg(Q)), "-f", "json", *degrees))["poses"]
    np.testing.assert_allclose(same["pose"], T, atol=1e-12)
    found = strict_json(succeed("ik", ARM, "--q", TYPED, "-f", "json", *tool))
    assert found["tip"] == "tool"
    assert all(max(one["error"].values()) < 1e-9 for one in found["poses"][0]["solutions"])
    assert angle_distance(vectors(succeed("ik", ARM, "--q", TYPED, "-f", "json", *tool)), Q).min() < 1e-9
    assert "tool" in succeed("info", ARM, "--tool-xyz", "0,0,0.1")
    succeed("check", ARM, "-n", "5", *tool)
    text = succeed("compare", ARM, ARM, "-n", "5", "--tool-xyz", "B=0,0,0.1")
    assert "base_link to tool " in text and "base_link to tool0 " in text


def test_obstacles_of_a_world_count_as_collisions(tmp_path: Path) -> None:
    """With --world the marks and what --collision-free keeps are those of the library among the same obstacles."""
    arm = urdf_ik.load(ARM)
    solutions = arm.ik(urdf_ik.pose([1.2, 0.4, 0.9], rpy=[0.0, 1.57, 0.3]))
    untouched = next(one for one in solutions if not arm.cell.collisions.in_collision(one.q))
    elbow = arm.link_poses(untouched.q)["link_3"][:3, 3]
    file = cell(tmp_path / "cell.urdf", 'box size="0.1 0.1 0.1"', elbow)
    typed = ("ik", ARM, "--xyz", "1.2,0.4,0.9", "--rpy", "0,1.57,0.3", "--world", file, "-f", "json")
    among = arm.cell.collisions.in_world(urdf_ik.World.from_urdf(file))
    free = [not among.in_collision(one.q) for one in solutions]
    assert free != [not arm.cell.collisions.in_collision(one.q) for one in solutions]
    told = strict_json(call(*typed).stdout)["poses"]
    assert [each["collision_free"] for each in told[0]["solutions"]] == free
    kept = strict_json(call(*typed, "--collision-free").stdout)["poses"]
    assert len(kept[0]["solutions"]) == sum(free)
