"""The urdf-ik command: the status it ends with, its messages and its help."""

import json
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from command import ARM, TWO_JOINTS, TYPED, call, cell, strict_json, succeed, target

from urdf_ik.model import catalogue
from urdf_ik.verify import crosscheck

COMMANDS = (
    "info",
    "fk",
    "ik",
    "explain",
    "check",
    "compare",
    "dh",
    "workspace",
    "path",
    "plot",
    "placement",
)


# Status and messages


@pytest.mark.parametrize(
    ("args", "given", "status", "words"),
    [
        (("ik", ARM, "--xyz", "9,0,0", "--rpy", "0,0,0", "-f", "csv"), None, 1, ("1 of 1 poses have no solution",)),
        (("ik", ARM, "--format", "xml"), None, 2, ("xml", "table", "json", "csv", "npz")),
        (("ik", ARM, "--random", "2", "--q", TYPED), None, 2, ("--q and --random",)),
        (("ik", ARM, "--xyz", "1,2,3"), None, 2, ("--quat-xyzw", "--rotvec", "none given")),
        (("ik", ARM, "--rpy", "0,0,0"), None, 2, ("--rpy", "--xyz")),
        (("ik", ARM, "--free-at", "0,0,0.1"), None, 2, ("--free-axis",)),
        (("ik", ARM, "--xyz", "1,2", "--rpy", "0,0,0"), None, 2, ("1,2", "3 are needed", "x,y,z")),
        (("ik", ARM, "--xyz", "1,2,up", "--rpy", "0,0,0"), None, 2, ("'up'",)),
        (("ik", ARM, "--xyz", "1,0,0", "--quat-wxyz", "0,0,0,0"), None, 2, ("zero",)),
        (("ik", ARM, "--q", "1,2,3"), None, 2, ("1,2,3", "joint_6")),
        (("ik", ARM, "--nearest", "1"), None, 2, ("--nearest", "joint_6")),
        (("ik", ARM, "--max-step", "1"), None, 2, ("--max-step", "--nearest")),
        (("ik", ARM, "--metric", "time"), None, 2, ("--metric", "--nearest")),
        (("ik", ARM, "--nearest", "0,0,0,0,0,0", "--max-step", "1,2"), None, 2, ("--max-step", "joint_6")),
        (("ik", ARM, "--nearest", "0,0,0,0,0,0", "--best", "limits"), None, 2, ("--best", "--nearest")),
        (("ik", ARM, "--nearest", "0,0,0,0,0,0", "--max-step", "-1"), None, 2, ("within", "zero or positive")),
        (("ik", ARM, "--poses", "no/such.csv"), None, 2, ("no/such.csv", "No such file")),
        (("ik", ARM, "--poses", "-"), "", 2, ("standard input is empty", "qx,qy,qz,qw")),
        (("ik", ARM, "--poses", "-"), "1,0,0,0,0,0,1\n1,0,0,0,0,east,1\n", 2, ("line 2, column qz", "'east'")),
        (("ik", "-", "--poses", "-"), "", 2, ("standard input",)),
        (("fk", ARM, "--q", "x.csv"), None, 2, ("x.csv", "No such file")),
        (("fk", ARM, "--q", "-"), "1,2\n", 2, ("(1, 2)", "joint_6")),
        (("fk", ARM, "--q", "-"), "[[1, 2, 3, 4, 5, true]]", 2, ("joint vector 0: true",)),
        (("fk", ARM, "--q", "-"), "joint_1,joint_2\n1,x\n", 2, ("line 2, column joint_2", "'x'")),
        (("fk", ARM, "--q", "-"), "[[1, 2, 3, 4, 5, NaN]]", 2, ("nan", "joint_6")),
        (("fk", ARM, "--q", TYPED, "-o", "no/such/folder.json"), None, 2, ("no/such/folder.json",)),
        (("info", "zyyzyz_7r"), None, 2, ("zyyzyz_7r", "zyyzyz_6r")),
        (("info", "no/such.urdf"), None, 3, ("no/such.urdf",)),
        (("info", "-"), "<robot name='x'><link", 3, (":1:", "XML")),
        (("info", ARM, "--tip", "hand"), None, 3, ("hand", "tool0")),
        (("info", ARM, "--base", "bse_link"), None, 3, ("'bse_link'", "did you mean 'base_link'")),
        (("info", "-"), bytes(range(256)), 3, ("not utf-8 text",)),
        (("info", str(Path(__file__).parent)), None, 3, ("a directory, not a file",)),
        (("info", ARM, "--mesh-root", "no/such"), None, 2, ("--mesh-root", "no/such", "does not exist")),
        (("ik", ARM, "--base", "tool0", "--tip", "tool0"), None, 4, ("no joint moves between 'tool0' and 'tool0'",)),
        (("compare", ARM, ARM, "--tip", "C=tool0"), None, 2, ("--tip", "no arm C, the last one is B")),
        (("compare", ARM, ARM, "--tip", "tool0", "--tip", "tool0"), None, 2, ("--tip", "2 times for arm A")),
        (("compare", ARM, ARM, "--srdf", "B=no.srdf"), None, 3, ("no.srdf",)),
        (("compare", "-", "-"), TWO_JOINTS, 2, ("only one arm", "standard input")),
        (("compare", ARM, ARM, "--tool-rpy", "B=0,0"), None, 2, ("--tool-rpy", "roll,pitch,yaw")),
        (("calibrate", ARM), None, 2, ("--measured",)),
        (("dh", "no/such.csv"), None, 2, ("cannot read no/such.csv", "No such file")),
        (
            ("plot", ARM, "branches", "--xyz", "1,2,3", "-o", "x.png"),
            None,
            2,
            ("--quat-wxyz", "--rotvec", "none given"),
        ),
        (
            ("plot", ARM, "branches", "--xyz", "9,0,0", "--rotvec", "0,0,0", "-o", "x.png"),
            None,
            2,
            ("no solution to draw", "reach 2.1 m"),
        ),
        (("workspace", "planar_2r", "-o", ""), None, 2, ("cannot write", "it is a folder")),
        (("ik", "-"), TWO_JOINTS, 4, ("planar",)),
    ],
)
def test_errors_have_a_status_and_one_readable_message(
    args: tuple[str, ...], given: str | bytes | None, status: int, words: tuple[str, ...]
) -> None:
    """Each kind of error has its status; stderr names what is wrong and what is valid; stdout holds no half answer."""
    result = call(*args, given=given)
    assert result.exit_code == status, result.output
    assert all(word in result.stderr for word in words), result.stderr
    assert sum(line.startswith("Error:") for line in result.stderr.splitlines()) == (status != 1)
    assert result.stdout.count("\n") <= (status == 1)


def test_without_a_solution_the_table_says_why() -> None:
    """Out of reach: status 1, and the answer on stdout holds the explanation with the lengths."""
    result = call("ik", ARM, "--xyz", "9,0,0", "--rpy", "0,0,0")
    assert result.exit_code == 1 and " m" in result.stdout.split("no solution")[1]


def test_one_pose_of_a_batch_without_a_solution_is_status_1() -> None:
    """A batch that is solved in part ends with status 1, and its data hold the part that is solved."""
    poses = [target().tolist(), [[1, 0, 0, 9], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]]
    result = call("ik", ARM, "--poses", "-", "-f", "json", given=json.dumps(poses))
    assert result.exit_code == 1
    assert [pose["count"] for pose in strict_json(result.stdout)["poses"]] == [8, 0]
    assert result.stderr.endswith("1 of 2 poses have no solution\n")


def test_check_ends_with_the_reports_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    """A good arm passes its check with status 0; a report that failed ends with status 1 and is printed, too."""
    assert strict_json(succeed("check", ARM, "-n", "5", "-f", "json"))["passed"] is True
    assert "pass" in succeed("check", ARM, "-n", "5", "--no-collisions").lower()
    failed = SimpleNamespace(passed=False, to_json=lambda: '{"passed": false}')
    monkeypatch.setattr(crosscheck, "check", lambda *_, **__: failed)
    result = call("check", ARM, "-f", "json")
    assert result.exit_code == 1
    assert strict_json(result.stdout) == {"passed": False}


# Help


@pytest.mark.parametrize("command", COMMANDS)
def test_examples_in_the_help_work(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every command's help shows examples, unbroken, and each of them ends with status 0."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(catalogue.resolve(ARM).path, "my_arm.urdf")
    if command == "compare":
        model = pytest.importorskip("mujoco", reason="an example reads MJCF").MjSpec.from_file("my_arm.urdf")
        model.compile()
        Path("my_arm.xml").write_text(model.to_xml())
    Path("lab").mkdir()
    shutil.copy(catalogue.resolve("puma_560").path, "lab/arm.urdf")
    Path("vectors.csv").write_text("0,-60,60,0,60,0\n10,-60,60,0,60,0\n")
    succeed("fk", ARM, "--q", "0.5,-0.7,-1.4,-1.8,0.8,1.6", "--q", "0.6,-0.7,-1.4,-1.8,0.8,1.6", "-o", "seam.csv")
    shutil.copy("seam.csv", "stations.csv")
    cell(Path("cell.urdf"), 'cylinder radius="0.05" length="1"', (1.5, 1.5, 0.5))
    examples = [line.strip() for line in succeed(command, "--help").splitlines() if line.startswith("    urdf-ik ")]
    assert len(examples) >= 2
    for example in examples:
        piped: str | None = None
        for part in example.split(" | "):
            words = shlex.split(part)[1:]
            piped = succeed(*words, given=piped)


def test_help_and_version_are_light() -> None:
    """``--version`` prints the version and brings in neither Pinocchio nor yourdfpy nor rich."""
    code = "import sys; from urdf_ik.cli import app; app(['--version'], standalone_mode=False); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    version, modules = done.stdout.splitlines()
    assert version.split()[0] == "urdf-ik"
    assert version.split()[1][0].isdigit()
    assert not {"pinocchio", "coal", "yourdfpy", "rich"} & set(modules.split())
